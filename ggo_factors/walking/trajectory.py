"""The joint angles of both legs over consecutive steps."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ggo_factors.check.report import Tolerances
from ggo_factors.errors import InputError
from ggo_factors.motion.gait import Gait, swap_roles
from ggo_factors.support.inputs import Array, as_array, as_tuple_of

STILL = 1e-12
"""Joints that turn by no more than this in [rad] from one frame to the next stand still: rounding leaves 1e-16."""


@dataclass(frozen=True, eq=False)
class JointTrajectory:
    """Joint angles of both legs over time: what an exoskeleton replays.

    Attributes:
        time: time in [s], shape (k,).
        left_hip: thigh from the vertical, forward positive, in [rad], shape (k,).
        left_knee: flexion in [rad], shape (k,).
        right_hip: as `left_hip`.
        right_knee: as `left_knee`.
        starts_at_rest: whether the walker stands still in the first frame.
        ends_at_rest: the same of the last.
    """

    time: Array
    left_hip: Array
    left_knee: Array
    right_hip: Array
    right_knee: Array
    starts_at_rest: bool = False
    ends_at_rest: bool = False

    @property
    def positions(self) -> Array:
        """All four angles in [rad], shape (k, 4), in the order of the attributes."""
        return np.stack([self.left_hip, self.left_knee, self.right_hip, self.right_knee], -1)

    @property
    def velocities(self) -> Array:
        """Their velocities in [rad/s], shape (k, 4): differences of second order, 0 where the walker stands."""
        positions = self.positions
        made = np.gradient(positions, self.time, axis=0, edge_order=2 if len(positions) > 2 else 1)
        for end, rests in ((0, self.starts_at_rest), (-1, self.ends_at_rest)):
            if rests:
                made[end] = 0.0
        return np.asarray(made)


def joint_trajectory(
    gaits: Sequence[Gait], first_swing: str = "right", *, starts_at_rest: bool = False, ends_at_rest: bool = False
) -> JointTrajectory:
    """The joint angles of both legs over steps on end; the frame at a role swap occurs once.

    Args:
        gaits: the steps, each starting in the last frame of the one before with the roles swapped.
        first_swing: the leg that swings first, ``"right"`` or ``"left"``.
        starts_at_rest: whether the walker stands still in the first frame; so it is too where its motion is none.
        ends_at_rest: the same of the last.

    Raises:
        InputError: where `first_swing` is neither, the time steps differ, or a step does not start where the one before
            ended (1e-9 rad).
    """
    if first_swing not in ("right", "left"):
        raise InputError(f"first_swing: {first_swing!r} is neither 'right' nor 'left'")
    gaits = as_tuple_of(gaits, "gaits", Gait)
    if not gaits:
        raise InputError("gaits: a trajectory needs at least one step")
    parts: list[Array] = []
    for number, gait in enumerate(gaits, start=1):
        if gait.dt != gaits[0].dt:
            raise InputError(f"step {number}: dt is {gait.dt:g} s, in step 1 {gaits[0].dt:g} s")
        swinging_left = (first_swing == "left") == (number % 2 == 1)
        # Columns: left hip, left knee, right hip, right knee.
        frames = swap_roles(gait.frames) if swinging_left else gait.frames
        if parts:
            jump = float(np.abs(frames[0] - parts[-1][-1]).max())
            if jump > Tolerances().start:
                raise InputError(f"step {number}: starts {jump:.3g} rad away from the end of step {number - 1}")
        parts.append(frames[1:] if parts else frames)
    joined = np.concatenate(parts)
    left_hip, left_knee, right_hip, right_knee = (as_array(column, "trajectory", (None,)) for column in joined.T)
    still = [float(np.abs(joined[k + 1] - joined[k]).max()) <= STILL for k in (0, len(joined) - 2)]
    time = as_array(np.arange(len(joined)) * gaits[0].dt, "time", (None,))
    return JointTrajectory(
        time=time,
        left_hip=left_hip,
        left_knee=left_knee,
        right_hip=right_hip,
        right_knee=right_knee,
        starts_at_rest=starts_at_rest or still[0],
        ends_at_rest=ends_at_rest or still[1],
    )
