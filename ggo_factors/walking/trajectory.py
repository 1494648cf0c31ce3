"""The joint angles of both legs over consecutive steps."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ggo_factors.check.report import Tolerances
from ggo_factors.errors import InputError
from ggo_factors.motion.gait import Gait, swap_roles
from ggo_factors.support.inputs import Array, as_array, as_tuple_of


@dataclass(frozen=True, eq=False)
class JointTrajectory:
    """Joint angles of both legs over time: what an exoskeleton replays.

    Attributes:
        time: time in [s], shape (k,).
        left_hip: thigh from the vertical, forward positive, in [rad], shape (k,).
        left_knee: flexion in [rad], shape (k,).
        right_hip: as `left_hip`.
        right_knee: as `left_knee`.
    """

    time: Array
    left_hip: Array
    left_knee: Array
    right_hip: Array
    right_knee: Array


def joint_trajectory(gaits: Sequence[Gait], first_swing: str = "right") -> JointTrajectory:
    """The joint angles of both legs over consecutive steps; the frame at a role swap occurs once.

    Args:
        gaits: the steps, each starting in the last frame of the one before with the roles swapped.
        first_swing: the leg that swings first, ``"right"`` or ``"left"``.

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
    columns = [as_array(column, "trajectory", (None,)) for column in joined.T]
    return JointTrajectory(as_array(np.arange(len(joined)) * gaits[0].dt, "time", (None,)), *columns)
