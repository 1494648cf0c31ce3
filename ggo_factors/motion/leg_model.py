"""The five-link walker of the paper: two legs of thigh and shank, joined at the hip."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from functools import cached_property
from typing import Literal, get_args

import numpy as np
from numpy.typing import ArrayLike

from ggo_factors.errors import InputError, UnreachableFootholdError
from ggo_factors.support.inputs import Array, as_angles, as_array, as_instance, as_number

Row = tuple[float, float, float, float]
Bones = Literal["lines", "points"]

LONGEST = 2.0
"""No segment is longer, in [m]; a larger number is surely in centimetres."""

# Which links, of the angles a1, a1 - b1, a2, a2 - b2, carry each joint, from the supporting ankle to the swinging one.
_CARRIED = np.array([[0.0, 0, 0, 0], [0, 1, 0, 0], [1, 1, 0, 0], [1, 1, 1, 0], [1, 1, 1, 1]])
_LINKS = np.array([[1.0, 0.0, 0.0, 0.0], [1.0, -1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0], [0.0, 0.0, 1.0, -1.0]])
UP_AND_DOWN = _LINKS[[1, 0, 2, 3]]
"""Angles of the links to the vertical by those of a frame, from the supporting ankle to the swinging one."""


@dataclass(frozen=True)
class Foot:
    """A foot whose sole stays parallel to the ground, as in the paper's experiment.

    Attributes:
        ankle_height: height of the ankle above the sole in [m].
        heel: length of the sole behind the ankle in [m].
        toe: length of the sole before the ankle in [m].

    Raises:
        InputError: where a length is negative or not finite.
    """

    ankle_height: float = 0.0
    heel: float = 0.0
    toe: float = 0.0

    def __post_init__(self) -> None:
        for name in ("ankle_height", "heel", "toe"):
            object.__setattr__(
                self, name, as_number(getattr(self, name), name, at_least=0.0, at_most=LONGEST, unit="m")
            )


@dataclass(frozen=True)
class LegModel:
    """Lengths and masses of the legs; kinematics of the swing ankle, the paper's endpoint P.

    A frame is ``[alpha1, beta1, alpha2, beta2]`` in [rad]: thigh from the vertical, forward positive,
    and knee flexion, of the supporting leg (1) and the swinging leg (2). The origin is the ankle of the
    supporting leg, x forward, y up (paper, section III-A).

    Attributes:
        thigh: length of the thigh, L1 of the paper, in [m].
        shank: length of the shank, L2 of the paper, in [m].
        thigh_mass: mass of one thigh in [kg].
        shank_mass: mass of one shank in [kg].
        foot: the foot; by default a point at the ankle.
        thigh_radius: how far the thigh reaches out around its axis, hip to knee, in [m].
        shank_radius: the same of the shank, knee to ankle.
        bones: ``"lines"``: the axes of thighs and shanks, bare bones, stay clear of obstacles and stairs whatever the
            radii. ``"points"``: the paper's model, in which the swing ankle alone hits anything; a thigh or shank is a
            body only where it has a radius.

    Raises:
        InputError: where a length or a mass is not above 0, a radius is negative, a length or a radius is above 2 m, or
            `bones` is neither.
    """

    thigh: float
    shank: float
    thigh_mass: float = 7.0
    shank_mass: float = 7.0
    foot: Foot = field(default_factory=Foot)
    thigh_radius: float = 0.0
    shank_radius: float = 0.0
    bones: Bones = "lines"

    def __post_init__(self) -> None:
        for name, unit in (("thigh", "m"), ("shank", "m"), ("thigh_mass", "kg"), ("shank_mass", "kg")):
            most = LONGEST if unit == "m" else None
            object.__setattr__(self, name, as_number(getattr(self, name), name, above=0.0, at_most=most, unit=unit))
        for name in ("thigh_radius", "shank_radius"):
            radius = as_number(getattr(self, name), name, at_least=0.0, at_most=LONGEST, unit="m")
            object.__setattr__(self, name, radius)
        as_instance(self.foot, "foot", Foot)
        if self.bones not in get_args(Bones):
            raise InputError(f"bones: {self.bones!r:.40} is not known; 'lines' or 'points'")

    def lengths(self) -> str:
        """The lengths of thigh and shank, as a line at a prompt states them."""
        return f"thigh {self.thigh:.4g} m, shank {self.shank:.4g} m"

    @cached_property
    def reach(self) -> float:
        """Length of the stretched leg, hip to ankle, in [m]."""
        return self.thigh + self.shank

    @cached_property
    def has_bodies(self) -> bool:
        """Whether a thigh or a shank can hit something: bones that are lines, or a radius."""
        return self.bones == "lines" or self.thigh_radius > 0.0 or self.shank_radius > 0.0

    def require_reach(self, x: float, y: float, name: str = "", step: int | None = None) -> None:
        """Refuse a foothold that no two legs reach.

        Args:
            x: place of the swing ankle in the body frame in [m].
            y: the same, upwards.
            name: what the error begins with.
            step: number of the step in its walk, if it is one of a walk.

        Raises:
            UnreachableFootholdError: where the foothold is further from the supporting foot than two legs reach.
        """
        distance, reach = math.hypot(x, y), 2.0 * self.reach
        if distance > reach:
            raise UnreachableFootholdError(
                f"{name}foothold ({x:g}, {y:g}) is {distance:.3f} m from the supporting foot, "
                f"two legs reach {reach:.3f} m",
                distance,
                reach,
                step,
            )

    def endpoint(self, frames: ArrayLike) -> Array:
        """Swing ankle of each frame in [m], shape (..., 2), of frames in [rad], shape (..., 4): Eq. 1 of the paper."""
        angles = np.asarray(frames, dtype=np.float64) @ _LINKS.T
        links = np.array([-self.thigh, -self.shank, self.thigh, self.shank])
        point = np.empty((*angles.shape[:-1], 2))
        point[..., 0], point[..., 1] = np.sin(angles) @ links, -(np.cos(angles) @ links)
        return point

    def hip_height(self, frames: ArrayLike) -> Array:
        """Height of the hip over the supporting ankle in [m], shape (...), of frames in [rad], shape (..., 4)."""
        angles = np.asarray(frames, dtype=np.float64)
        thigh, knee = angles[..., 0], angles[..., 1]
        return np.asarray(self.shank * np.cos(thigh - knee) + self.thigh * np.cos(thigh))

    def joints(self, frames: ArrayLike) -> Array:
        """Support ankle, support knee, hip, swing knee and swing ankle in [m], shape (..., 5, 2)."""
        # Up the supporting leg, down the swinging one.
        angles = np.asarray(frames, dtype=np.float64) @ UP_AND_DOWN.T
        links = np.array([-self.shank, -self.thigh, self.thigh, self.shank])
        joints = np.zeros((*angles.shape[:-1], 5, 2))
        np.cumsum(np.sin(angles) * links, axis=-1, out=joints[..., 1:, 0])
        np.cumsum(np.cos(angles) * -links, axis=-1, out=joints[..., 1:, 1])
        return joints

    def endpoint_jacobian(self, frames: ArrayLike) -> Array:
        """Derivative of the swing ankle in [m/rad], shape (..., 2, 4), by frames in [rad], shape (..., 4)."""
        return self.endpoint_and_jacobian(np.asarray(frames, dtype=np.float64))[1]

    def endpoint_and_jacobian(self, frames: Array) -> tuple[Array, Array]:
        """`endpoint` and `endpoint_jacobian` at once."""
        # The swing ankle is a sum of links; each turns by one angle to the vertical, and a frame has their differences.
        angles = frames @ _LINKS.T
        turned = np.empty((*angles.shape[:-1], 2, 4))
        np.cos(angles, out=turned[..., 0, :])
        np.sin(angles, out=turned[..., 1, :])
        turned *= (-self.thigh, -self.shank, self.thigh, self.shank)
        point = turned.sum(axis=-1)[..., ::-1] * (1.0, -1.0)
        return point, turned @ _LINKS

    def joints_and_jacobian(self, frames: Array) -> tuple[Array, Array]:
        """`joints`, and their derivative by the frame in [m/rad], shapes (k, 5, 2) and (k, 5, 2, 4)."""
        angles = frames @ _LINKS.T
        links = np.array([-self.thigh, -self.shank, self.thigh, self.shank])
        turned = np.stack([links * np.cos(angles), links * np.sin(angles)], -2)
        moves = turned[:, None] * _CARRIED[:, None]
        points = moves.sum(axis=-1)[..., ::-1] * (1.0, -1.0)
        return points, moves @ _LINKS

    def endpoint_hessian(self, frame: Array, by_x: float, by_y: float) -> Array:
        """Second derivative of `by_x * Px + by_y * Py` by the frame, shape (4, 4), of a frame (4,) in [rad].

        The swing ankle, (Px, Py), is a sum of links, each of which turns by one angle to the vertical: by those angles
        the derivative is diagonal.
        """
        a1, b1, a2, b2 = frame.tolist()
        u1, u2 = a1 - b1, a2 - b2
        thigh1 = self.thigh * (by_x * math.sin(a1) - by_y * math.cos(a1))
        shank1 = self.shank * (by_x * math.sin(u1) - by_y * math.cos(u1))
        thigh2 = self.thigh * (by_y * math.cos(a2) - by_x * math.sin(a2))
        shank2 = self.shank * (by_y * math.cos(u2) - by_x * math.sin(u2))
        return np.array(
            [
                [thigh1 + shank1, -shank1, 0.0, 0.0],
                [-shank1, shank1, 0.0, 0.0],
                [0.0, 0.0, thigh2 + shank2, -shank2],
                [0.0, 0.0, -shank2, shank2],
            ]
        )

    def endpoint_rows(self, frame: Array) -> tuple[float, float, Row, Row]:
        """Px, Py and the two rows of the Jacobian at one frame, in plain floats.

        The same as `endpoint` and `endpoint_jacobian`, several times faster for a single frame: the
        factors call it in the inner loop of the solver.
        """
        a1, b1, a2, b2 = frame.tolist()
        u1, u2 = a1 - b1, a2 - b2
        t_sin1, t_cos1 = self.thigh * math.sin(a1), self.thigh * math.cos(a1)
        t_sin2, t_cos2 = self.thigh * math.sin(a2), self.thigh * math.cos(a2)
        s_sin1, s_cos1 = self.shank * math.sin(u1), self.shank * math.cos(u1)
        s_sin2, s_cos2 = self.shank * math.sin(u2), self.shank * math.cos(u2)
        return (
            t_sin2 - t_sin1 + s_sin2 - s_sin1,
            t_cos1 - t_cos2 + s_cos1 - s_cos2,
            (-t_cos1 - s_cos1, s_cos1, t_cos2 + s_cos2, -s_cos2),
            (-t_sin1 - s_sin1, s_sin1, t_sin2 + s_sin2, -s_sin2),
        )

    def inverse_kinematics(self, target: ArrayLike, support: ArrayLike) -> Array:
        """Swing-leg angles that bring the swing ankle to a target, with the knee flexed as a person's.

        Args:
            target: wanted place of the swing ankle in [m], shape (..., 2).
            support: ``[alpha1, beta1]`` of the supporting leg in [rad], shape (..., 2).

        Returns:
            ``[alpha2, beta2]`` in [rad], shape (..., 2), with beta2 in [0, pi].

        Raises:
            InputError: where an argument is not finite or has a wrong shape.
            UnreachableFootholdError: where the target is further from the hip than the leg is long, or
                nearer than thigh and shank differ.
        """
        pairs = (*(None,) * (np.asarray(target, dtype=object).ndim - 1), 2)
        point, angles = as_array(target, "target", pairs), as_angles(support, "support", pairs)
        if point.shape != angles.shape:
            raise InputError(f"support: shape {angles.shape}, target has {point.shape}")
        a1, u1 = angles[..., 0], angles[..., 0] - angles[..., 1]
        x = point[..., 0] + self.thigh * np.sin(a1) + self.shank * np.sin(u1)
        y = point[..., 1] - self.thigh * np.cos(a1) - self.shank * np.cos(u1)
        distance = np.hypot(x, y)
        shortest = abs(self.thigh - self.shank)
        # A target on the very edge of the reach must not fail for the last bit of a sum.
        far, near = distance.max(initial=0.0), distance.min(initial=np.inf)
        if far > self.reach * (1.0 + 1e-12):
            raise UnreachableFootholdError(
                f"target is {far:.4f} m from the hip, the leg reaches {self.reach:.4f} m", float(far), self.reach
            )
        if near < shortest * (1.0 - 1e-12):
            raise UnreachableFootholdError(
                f"target is {near:.4f} m from the hip, the folded leg reaches no nearer than {shortest:.4f} m",
                float(near),
                shortest,
            )
        cosine = (distance**2 - self.thigh**2 - self.shank**2) / (2.0 * self.thigh * self.shank)
        knee = np.arccos(np.clip(cosine, -1.0, 1.0))
        inner = np.arctan2(self.shank * np.sin(knee), self.thigh + self.shank * np.cos(knee))
        return np.stack([np.arctan2(x, -y) + inner, knee], -1)
