"""The points of a depth camera in the strip that is walked on, in the walker's world frame."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ggo_factors.errors import InputError
from ggo_factors.support.inputs import Array, as_array

WIDTH = 0.4
"""Width of the strip in [m]: both feet of a walker, 0.2 m apart, with a hand's breadth beside each."""
BEHIND, AHEAD = -0.3, 3.1
"""Where the strip begins and ends in [m] from under the camera: further ahead a row of pixels is 20 mm long."""
LOWEST, HIGHEST = -1.5, 2.0
"""Lowest and highest point in [m] that is looked at: below lies no step, above nothing in a walker's way."""
LEAST_ANGLE = np.sin(np.deg2rad(10.0))
"""Sine of the least angle between `heading` and `up`."""
FEWEST = 200
"""Fewer points in the strip are no ground."""


@dataclass(frozen=True, eq=False)
class Strip:
    """Points of one frame in the strip.

    Attributes:
        x: forward of the foot in [m], shape (n,).
        y: above it in [m], shape (n,).
        eye: where the camera is, forward and up in [m].
    """

    x: Array
    y: Array
    eye: tuple[float, float]

    def turned(self, tilt: float) -> Strip:
        """The strip turned about the foot so that ground rising by `tilt` [rad] becomes level."""
        c, s = np.cos(tilt), np.sin(tilt)
        x, y = self.eye
        return Strip(c * self.x + s * self.y, c * self.y - s * self.x, (c * x + s * y, c * y - s * x))

    def shifted(self, x: float, y: float) -> Strip:
        """The strip `x` further on and `y` higher, both in [m]."""
        return Strip(self.x + x, self.y + y, (self.eye[0] + x, self.eye[1] + y))


@dataclass(frozen=True, eq=False)
class Sighting:
    """What a depth camera saw at one instant, and where it was then.

    Attributes:
        points: in [m] in the camera's own frame (origin in the camera, axes of any direction), shape (n, 3) or
            (rows, columns, 3); NaN where nothing came back.
        up: against gravity, in the same frame, shape (3,), of any length.
        heading: where the walk goes, shape (3,); its level part counts.
        at: the origin of the world in [m] in the same frame, shape (3,): the ground under the supporting ankle of the
            walk's start. If None it is under the camera, on the nearest ground that is seen.

    Raises:
        InputError: where the numbers are of no use.
    """

    points: ArrayLike
    up: ArrayLike
    heading: ArrayLike
    at: ArrayLike | None = None

    def __post_init__(self) -> None:
        object.__setattr__(self, "points", cloud_of(self.points))
        axes_of(self.up, self.heading)
        if self.at is not None:
            object.__setattr__(self, "at", as_array(self.at, "at", (3,)))

    def __repr__(self) -> str:
        return (
            f"Sighting({len(np.asarray(self.points))} points, up={self.up!r}, heading={self.heading!r}, at={self.at!r})"
        )


def strip_of(sighting: Sighting) -> Strip:
    """The points of one frame that lie in the strip that is walked on.

    Raises:
        InputError: where hardly a point does.
    """
    cloud, at = np.asarray(sighting.points), sighting.at
    forward, upward, right = axes_of(sighting.up, sighting.heading)
    origin = np.zeros(3) if at is None else np.asarray(at)
    eye = float(-forward @ origin)
    with np.errstate(invalid="ignore", over="ignore"):
        across = cloud @ right.astype(cloud.dtype) - right @ origin
        near = cloud[np.abs(across) <= WIDTH / 2.0].astype(np.float64)
        x, y = near @ forward - forward @ origin, near @ upward - upward @ origin
        # Without `at` heights count from the camera.
        low, high = (LOWEST, HIGHEST) if at is not None else (2.0 * LOWEST, 0.0)
        inside = (x >= eye + BEHIND) & (x <= eye + AHEAD) & (y >= low) & (y <= high)
    x, y = x[inside], y[inside]
    if len(x) < FEWEST:
        known = cloud[np.isfinite(cloud).all(axis=1)].astype(np.float64)
        usual = float(np.median(np.linalg.norm(known, axis=1)))
        raise InputError(
            f"points: {len(x)} of {len(known)} points, at a median distance of {usual:.3g} m, lie in the strip that is "
            f"walked on ({WIDTH:g} m wide, {BEHIND:g} to {AHEAD:g} m ahead, {low:g} to {high:g} m high), at least "
            f"{FEWEST} are needed; check up, heading and at"
        )
    return Strip(x, y, (eye, float(-upward @ origin)))


def axes_of(up: ArrayLike, heading: ArrayLike) -> tuple[Array, Array, Array]:
    """The walker's forward, up and right in the frame of `up` and `heading`, each of length 1, shape (3,).

    Raises:
        InputError: where one has no length, or both point the same way.
    """
    upward, ahead = as_array(up, "up", (3,)), as_array(heading, "heading", (3,))
    for name, given in (("up", upward), ("heading", ahead)):
        if not np.linalg.norm(given) > 1e-9:
            raise InputError(f"{name}: {given.tolist()} has no direction")
    upward = upward / np.linalg.norm(upward)
    level = ahead / np.linalg.norm(ahead)
    level = level - (level @ upward) * upward
    if not np.linalg.norm(level) > LEAST_ANGLE:
        raise InputError(f"heading: {ahead.tolist()} points along up {upward.round(3).tolist()}")
    forward = level / np.linalg.norm(level)
    return forward, upward, np.cross(forward, upward)


def cloud_of(points: ArrayLike) -> NDArray[Any]:
    """Points as an array of floats, shape (n, 3), NaN where there are none.

    Raises:
        InputError: where they are none, have another shape, or hold no finite point.
    """
    try:
        if isinstance(points, (str, bytes, Mapping)) or np.ma.isMaskedArray(points):
            raise TypeError
        cloud = np.asarray(points)
        if cloud.dtype.kind not in "fiu":
            raise TypeError
    except (TypeError, ValueError) as error:
        raise InputError(f"points: expected numbers of shape (n, 3), got {points!r:.80}") from error
    if cloud.ndim not in (2, 3) or cloud.shape[-1] != 3:
        raise InputError(f"points: expected shape (n, 3) or (rows, columns, 3), got {cloud.shape}")
    cloud = cloud.reshape(-1, 3)
    if cloud.dtype not in (np.float32, np.float64):
        cloud = cloud.astype(np.float64)
    if not len(cloud):
        raise InputError("points: there are none")
    if not np.isfinite(cloud).all(axis=1).any():
        raise InputError(f"points: none of {len(cloud)} is finite")
    return cloud
