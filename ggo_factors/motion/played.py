"""The trajectory that joints play between frames: a cubic spline, whose speed and acceleration are known everywhere.

Its acceleration is linear between two frames, so that the largest one is at a frame; its speed is largest at a frame,
or where the acceleration passes 0. Limits on rates are therefore checked at every instant, exactly.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ggo_factors.support.inputs import Array


@dataclass(frozen=True, eq=False)
class Played:
    """Joint angles over time between frames at given times: a cubic spline with continuous acceleration.

    At an end where the joints rest their speed is 0; at any other their acceleration is that of the frame beside it.

    Attributes:
        times: time of each frame in [s], growing, shape (k,), k >= 2; two are joined by a line.
        positions: joint angles in [rad], shape (k, n).
        starts_at_rest: whether the joints stand still in the first frame.
        ends_at_rest: the same of the last.
    """

    times: Array
    positions: Array
    starts_at_rest: bool = False
    ends_at_rest: bool = False

    @cached_property
    def accelerations(self) -> Array:
        """Acceleration at each frame in [rad/s^2], shape (k, n)."""
        if len(self.times) < 3:
            return np.zeros_like(self.positions)
        from scipy.linalg import solve_banded  # here, since it takes longer to import than all the rest

        lengths = np.diff(self.times)
        slopes = np.diff(self.positions, axis=0) / lengths[:, None]
        bands, right = np.zeros((3, len(self.times))), np.zeros_like(self.positions)
        bands[0, 2:], bands[2, :-2] = lengths[1:], lengths[:-1]
        bands[1, 1:-1] = 2.0 * (lengths[:-1] + lengths[1:])
        right[1:-1] = 6.0 * np.diff(slopes, axis=0)
        bands[1, [0, -1]] = 1.0
        bands[0, 1] = 0.5 if self.starts_at_rest else -1.0
        bands[2, -2] = 0.5 if self.ends_at_rest else -1.0
        if self.starts_at_rest:
            right[0] = 3.0 * slopes[0] / lengths[0]
        if self.ends_at_rest:
            right[-1] = -3.0 * slopes[-1] / lengths[-1]
        return np.asarray(solve_banded((1, 1), bands, right))

    @cached_property
    def velocities(self) -> Array:
        """Speed at each frame in [rad/s], shape (k, n)."""
        lengths, bends = np.diff(self.times)[:, None], self.accelerations
        slopes = np.diff(self.positions, axis=0) / lengths
        made = np.empty_like(self.positions)
        made[:-1] = slopes - lengths * (2.0 * bends[:-1] + bends[1:]) / 6.0
        made[-1] = slopes[-1] + lengths[-1] * (bends[-2] + 2.0 * bends[-1]) / 6.0
        for end, rests in ((0, self.starts_at_rest), (-1, self.ends_at_rest)):
            if rests and len(made) > 2:
                made[end] = 0.0  # to the last digit
        return made

    @cached_property
    def fastest(self) -> Array:
        """Largest speed of each joint between each frame and the next in [rad/s], with its sign, shape (k - 1, n)."""
        speeds, bends, lengths = self.velocities, self.accelerations, np.diff(self.times)[:, None]
        first, last = speeds[:-1], speeds[1:]
        most = np.where(np.abs(first) >= np.abs(last), first, last)
        turns = bends[:-1] * bends[1:] < 0.0
        share = np.divide(bends[:-1], bends[:-1] - bends[1:], out=np.zeros_like(most), where=turns)
        between = first + 0.5 * bends[:-1] * share * lengths
        return np.where(np.abs(between) > np.abs(most), between, most)

    def at(self, times: Array) -> tuple[Array, Array, Array]:
        """Positions, velocities and accelerations at times (m,) within those of the frames in [s], each (m, n)."""
        before = np.clip(np.searchsorted(self.times, times, side="right") - 1, 0, len(self.times) - 2)
        length = np.diff(self.times)[before][:, None]
        on = (times - self.times[before])[:, None]
        start, bend = self.accelerations[before], (np.diff(self.accelerations, axis=0)[before]) / length
        speed = self.velocities[before]
        accelerations = start + bend * on
        velocities = speed + on * (start + 0.5 * bend * on)
        velocities[times == self.times[-1]] = self.velocities[-1]  # 0 at rest, to the last digit
        positions = self.positions[before] + on * (speed + on * (0.5 * start + bend * on / 6.0))
        return positions, velocities, accelerations
