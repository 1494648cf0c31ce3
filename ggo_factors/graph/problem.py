"""The one description of a gait graph: plain data, nothing assembled or solved yet."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Literal, NamedTuple

import gtsam
import numpy as np

from ggo_factors.errors import InputError
from ggo_factors.factors import frames_of
from ggo_factors.graph.requests import (
    BalanceRequest,
    EndRequest,
    GroundRequest,
    JointLimitRequest,
    LandingRequest,
    LegRequest,
    ObstacleRequest,
    StartRequest,
    StyleRequest,
)
from ggo_factors.motion.gait import Gait
from ggo_factors.motion.leg_model import LegModel
from ggo_factors.support.inputs import Array, as_tuple_of


class EdgeKey(NamedTuple):
    """What tells an edge of the library's from all others, from round to round.

    Attributes:
        family: family that its cost counts to.
        name: what it is called.
        frames: numbers of the frames that it connects.
        number: how many edges before it have the same of these.
    """

    family: str
    name: str
    frames: tuple[int, ...]
    number: int


@dataclass(frozen=True, eq=False)
class Problem:
    """A gait graph, as the user or a procedure gave it.

    Attributes:
        base: the base gait, m frames.
        fine: the same at a higher sampling rate, where the rounds look at the path of the swing ankle and lift it; the
            base gait itself where there is none.
        model: the legs.
        knee_gain: gain of the knee edges, which are on every keyframe.
        hard: whether knees, obstacles and joint limits are constraints.
        smoothness: gain of the second-order residual edges.
        always: frames that are keyframes in any case.
        full: whether those are all frames.
        anchors: anchored frames in [rad], by number.
        start: the motion to begin with, or None.
        rests: first frames of the motions out of rest and into it, of a chain that stands for one at a higher rate: a
            joint that comes to rest within a motion accelerates twice as much as the frames tell.
        obstacles: boxes to clear.
        ground: the ground to stay above, or None.
        ends: footholds and other targets of single frames.
        landing: the landing edges, or None.
        balance: the balance edges, which make every frame a keyframe, or None.
        style: how the base gait varies from step to step, or None.
        least_hips: least heights of the hip over the supporting ankle in [m].
        legs: obstacles and stairs that thighs and shanks stay clear of.
        joints: limits of the joints.
        own: factors of the user's own.
        own_frames: the frames that those connect.
        removed: the edges that the user took out.
    """

    base: Gait
    fine: Gait
    model: LegModel
    knee_gain: float = 5.0
    hard: bool = False
    smoothness: float = 0.0
    always: frozenset[int] = frozenset()
    full: bool = False
    anchors: Mapping[int, Array] = field(default_factory=dict)
    start: StartRequest | None = None
    rests: tuple[int, ...] = ()
    obstacles: tuple[ObstacleRequest, ...] = ()
    ground: GroundRequest | None = None
    ends: tuple[EndRequest, ...] = ()
    landing: LandingRequest | None = None
    balance: BalanceRequest | None = None
    style: StyleRequest | None = None
    least_hips: tuple[float, ...] = ()
    legs: tuple[LegRequest, ...] = ()
    joints: tuple[JointLimitRequest, ...] = ()
    own: tuple[gtsam.NonlinearFactor, ...] = ()
    own_frames: frozenset[int] = frozenset()
    removed: frozenset[EdgeKey] = frozenset()


def keyframe_numbers(asked: Literal["auto", "all"] | Sequence[int], count: int) -> frozenset[int]:
    """The frames that are keyframes in any case, of a gait of `count` frames.

    Raises:
        InputError: where a frame is not one of the gait.
    """
    if not isinstance(asked, str):
        return frozenset(frame_number(n, "keyframes", count) for n in as_tuple_of(asked, "keyframes", object))
    if asked not in ("auto", "all"):
        raise InputError(f"keyframes: {asked!r} is not known; 'auto', 'all' or a list of frames")
    return frozenset(range(count) if asked == "all" else ())


def frame_number(number: object, name: str, count: int) -> int:
    """A frame number of a gait of `count` frames; negative ones count from the end, as in Python.

    Raises:
        InputError: where it is not one of the gait.
    """
    if isinstance(number, bool) or not isinstance(number, (int, np.integer)) or not -count <= number < count:
        raise InputError(f"{name}: frame {number!r:.40} is not in this gait of frames 0 to {count - 1}")
    return int(number) % count


def factor_frames(factor: gtsam.NonlinearFactor, count: int, name: str = "factor") -> frozenset[int]:
    """The frames that a user's factor connects, of a gait of `count` frames.

    Raises:
        InputError: where a key is not a frame of the gait.
    """
    return frozenset(frame_number(number, name, count) for number in frames_of(factor, name))
