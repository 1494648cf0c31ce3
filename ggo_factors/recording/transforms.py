"""Where the frames of a log are to each other over time: its transforms, as /tf and /tf_static tell them."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Mapping
from typing import Any

import numpy as np

from ggo_factors.errors import LogError
from ggo_factors.recording.log.joint_map import listed
from ggo_factors.support.inputs import Array

DEEPEST = 100
"""A longer chain of frames is a circle."""


class Transforms:
    """The tree of frames, each with its parent and its poses in it over time."""

    def __init__(self) -> None:
        self._parents: dict[str, str] = {}
        self._times: dict[str, list[int]] = {}
        self._poses: dict[str, list[Array]] = {}

    def add(self, time_ns: int, parent: str, child: str, place: Array, turn: Array) -> None:
        """Add a pose.

        Args:
            time_ns: when, in [ns]; those of one frame in any order.
            parent: the frame that it is given in.
            child: the frame that it is of.
            place: of its origin in [m], shape (3,).
            turn: its quaternion x, y, z, w, shape (4,); what has no length is no pose.
        """
        length = float(np.linalg.norm(turn))
        if not (np.isfinite(place).all() and 1e-6 < length < np.inf):
            return
        x, y, z, w = turn / length
        pose = np.eye(4)
        pose[:3, :3] = [
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
        ]
        pose[:3, 3] = place
        parent, child = parent.lstrip("/"), child.lstrip("/")
        self._parents[child] = parent
        times, poses = self._times.setdefault(child, []), self._poses.setdefault(child, [])
        at = bisect_right(times, time_ns)
        times.insert(at, time_ns)
        poses.insert(at, pose)

    @property
    def names(self) -> tuple[str, ...]:
        """All frames."""
        return tuple(dict.fromkeys([*self._parents.values(), *self._parents]))

    def between(self, frame: str, into: str, time_ns: int) -> Array:
        """What takes points of `frame` into frame `into` at a time in [ns], shape (4, 4).

        Each pose is the last one before that time, or the first one after it.

        Raises:
            LogError: where no transforms join the two.
        """
        one, other = (self._to_root(name.lstrip("/"), time_ns) for name in (frame, into))
        if one[0] != other[0]:
            known = f"the log's frames are {listed(self.names)}" if self.names else "the log has no transforms (/tf)"
            raise LogError(f"frame {into!r} is not joined to {frame!r}, the frame of the points; {known}")
        return np.asarray(np.linalg.inv(other[1]) @ one[1])

    def _to_root(self, frame: str, time_ns: int) -> tuple[str, Array]:
        pose = np.eye(4)
        for _ in range(DEEPEST):
            if frame not in self._parents:
                return frame, pose
            at = max(bisect_right(self._times[frame], time_ns) - 1, 0)
            pose = self._poses[frame][at] @ pose
            frame = self._parents[frame]
        raise LogError(f"the transforms of frame {frame!r} go round in a circle")


def add_message(transforms: Transforms, data: bytes, tree: Mapping[str, Any], number: Any) -> None:
    """Add what one `tf2_msgs/TFMessage` tells.

    Args:
        transforms: what is known so far.
        data: the message.
        tree: the message walked.
        number: a function from a place in the message to its number.
    """
    for one in tree.get("transforms") or ():
        moved, stamp = one["transform"], one["header"]["stamp"]
        time = int(number(stamp["sec"])) * 10**9 + int(number(stamp["nanosec"]))
        place = np.array([number(moved["translation"][axis]) for axis in "xyz"])
        turn = np.array([number(moved["rotation"][axis]) for axis in "xyzw"])
        transforms.add(time, one["header"]["frame_id"], one["child_frame_id"], place, turn)
