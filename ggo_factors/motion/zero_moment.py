"""How the ground pushes a walker, of the paper's four links, and where: the zero moment point (ZMP).

Four links, each a point mass at its middle, no trunk; accelerations by central second differences of three neighbouring
frames. The point is where the push acts on the level plane through the supporting ankle, on stairs too: until the
swinging foot lands nothing but the supporting foot is pushed, however high the other one is.

A middle is a sum of links, each of which turns by one angle to the vertical. With s = l sin and q = -l cos of those
angles, middles C s and C q, masses M and b for the sum of the frames before and after, the ground carries
w (q_b - 2 q) / dt^2 + g sum(M), w = sum(M C), with the moment (s K q_b - q K s_b) / dt^2 + g w s, K = C' M C.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from ggo_factors.motion.leg_model import UP_AND_DOWN, LegModel
from ggo_factors.support.inputs import Array

GRAVITY = 9.81
"""Acceleration of gravity in [m/s^2]."""
LEAST_CARRIED = 0.1
"""A frame in which the ground carries less than this share of the weight has no ZMP worth holding: it is far off. The
paper's base gait carries 0.19 and more in 0.5 s, 0.80 and more in 1 s."""
_MIDDLES = np.tri(4, k=-1) + np.eye(4) / 2.0  # C: all of the links before, half of its own


def link_masses(model: LegModel) -> Array:
    """Masses of the links in [kg], shape (4,), in the order of the joints: up the supporting leg, down the other."""
    return np.array([model.shank_mass, model.thigh_mass, model.thigh_mass, model.shank_mass])


def weight(model: LegModel) -> float:
    """Weight of the links in [N]."""
    return float(link_masses(model).sum()) * GRAVITY


def triples(frames: Array) -> Array:
    """Each inner frame between its neighbours, shape (m - 2, 3, 4), of frames (m, 4)."""
    return np.stack([frames[:-2], frames[1:-1], frames[2:]], axis=1)


def push(model: LegModel, frames: Array, dt: float) -> tuple[Array, Array]:
    """Moment of the ground's push about the supporting ankle in [N m], and its upward force in [N], shapes (k,).

    The zero moment point's x is the moment over the force: the paper's equation.

    Args:
        model: the legs.
        frames: k times three neighbouring frames in [rad], shape (k, 3, 4).
        dt: time between two frames in [s].
    """
    lengths, coupled, carried = _constants(model)
    angles = frames @ UP_AND_DOWN.T
    s, q = lengths * np.sin(angles), -lengths * np.cos(angles)
    s_beside, q_beside = s[:, 0] + s[:, 2], q[:, 0] + q[:, 2]
    turned = (s[:, 1] * (q_beside @ coupled) - q[:, 1] * (s_beside @ coupled)).sum(axis=1)
    moment = turned / dt**2 + GRAVITY * (s[:, 1] @ carried)
    return moment, (q_beside - 2.0 * q[:, 1]) @ carried / dt**2 + weight(model)


def zero_moment_points(model: LegModel, frames: Array, dt: float) -> Array:
    """The ZMP's x in each inner frame of frames (m, 4) in [m], shape (m - 2,); NaN where the links nearly fall."""
    moment, force = push(model, triples(frames), dt)
    return np.where(force >= LEAST_CARRIED * weight(model), moment / force, np.nan)


def start_shift(model: LegModel, base: Array, dt: float, start: Array) -> float:
    """How much further forward the ZMP is where the base gait's first motions are made from another frame, in [m].

    Args:
        model: the legs.
        base: base frames in [rad], shape (m, 4).
        dt: time between two frames in [s].
        start: the frame that the walker starts in, shape (4,) in [rad].

    Returns:
        The shift; 0 where one of the two nearly falls, or has no three frames.
    """
    if len(base) < 3:
        return 0.0
    own = zero_moment_points(model, base[:3], dt)
    moved = zero_moment_points(model, base[:3] + (start - base[0]), dt)
    return float(np.nan_to_num(moved - own)[0])


def held_points(model: LegModel, base: Array, dt: float, shift: float, since: float = 0.0) -> Array:
    """Where the push is to act in each inner frame: the base gait's own ZMP, from where the walker's start puts it.

    The shift of the start fades out as a pendulum of the leg's length falls, by exp(-t / sqrt(L / g)): it cannot be
    taken back faster without joints that accelerate much more.

    Args:
        model: the legs.
        base: base frames from there on in [rad], shape (m, 4).
        dt: time between two frames in [s].
        shift: see `start_shift`, in [m].
        since: time since the start in [s].

    Returns:
        x from the supporting ankle in [m], shape (m - 2,); NaN where the base gait nearly falls.
    """
    times = since + dt * np.arange(len(base) - 2)
    fading = np.exp(-times / np.sqrt(model.reach / GRAVITY))
    return np.asarray(zero_moment_points(model, base, dt) + shift * fading)


def push_jacobians(model: LegModel, frames: Array, dt: float) -> tuple[Array, Array]:
    """Derivatives of moment and force of `push` by the frames, shapes (k, 3, 4)."""
    lengths, coupled, carried = _constants(model)
    angles = frames @ UP_AND_DOWN.T
    s, q = lengths * np.sin(angles), -lengths * np.cos(angles)  # ds = -q, dq = s by the angles
    s_coupled, q_coupled = s @ coupled, q @ coupled
    moment = s * s_coupled[:, 1:2] + q * q_coupled[:, 1:2]
    moment[:, 1] = -q[:, 1] * (q_coupled[:, 0] + q_coupled[:, 2] + GRAVITY * dt**2 * carried)
    moment[:, 1] -= s[:, 1] * (s_coupled[:, 0] + s_coupled[:, 2])
    force = s * (np.array([[1.0], [-2.0], [1.0]]) * carried)
    return moment @ UP_AND_DOWN / dt**2, force @ UP_AND_DOWN / dt**2


@lru_cache(maxsize=8)
def _constants(model: LegModel) -> tuple[Array, Array, Array]:
    """Lengths of the links in [m], their signs those of the way from the supporting ankle, K in [kg], w in [kg]."""
    lengths = np.array([-model.shank, -model.thigh, model.thigh, model.shank])
    masses = link_masses(model)
    return lengths, _MIDDLES.T @ (masses[:, None] * _MIDDLES), masses @ _MIDDLES
