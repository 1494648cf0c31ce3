"""A joint trajectory in the names, signs, offsets and units of a robot: the joint map of an import, inverted."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ggo_factors.errors import InputError
from ggo_factors.recording.log.joint_map import ANGLES, JointMap, listed, read_map
from ggo_factors.recording.log.presets import PRESETS
from ggo_factors.support.files import PathLike
from ggo_factors.support.inputs import Array
from ggo_factors.walking.trajectory import JOINT_NAMES, JointTrajectory

SINGULAR = 1e6
"""Maps whose condition number is larger cannot be inverted to 1e-9: two angles are made of the same values."""
_COLUMNS = [JOINT_NAMES.index(f"{side}_{joint}") for side in ("right", "left") for joint in ("hip", "knee")]
"""Column of a trajectory for each of `ANGLES`."""


@dataclass(frozen=True, eq=False)
class RobotMotion:
    """What the joints of a robot do over time.

    Attributes:
        time: time in [s], shape (k,).
        names: the robot's joints, in its order.
        positions: in `unit`, shape (k, len(names)).
        velocities: in `unit` per s, same shape.
        accelerations: in `unit` per s^2, same shape.
        unit: ``"rad"`` or ``"deg"``.
    """

    time: Array
    names: tuple[str, ...]
    positions: Array
    velocities: Array
    accelerations: Array
    unit: str = "rad"


def as_map(joints: PathLike | JointMap | None) -> JointMap | None:
    """A joint map, read where it is a file.

    Raises:
        InputError: where the file is no map, or a preset is named.
    """
    if str(joints) in PRESETS and not Path(str(joints)).exists():
        raise InputError(f"joints: {joints!s} is a preset of many spellings; an export needs the robot's: a MAP.toml")
    return joints if joints is None or isinstance(joints, JointMap) else read_map(joints)


def robot_motion(trajectory: JointTrajectory, joints: JointMap | None, pelvis_tilt: float = 0.0) -> RobotMotion:
    """A trajectory as a robot moves.

    Args:
        trajectory: joint angles over time.
        joints: the map by which an import would read what the robot logs; if None `JOINT_NAMES` in [rad].
        pelvis_tilt: in [rad], taken from the hips before the map.

    Raises:
        InputError: where the map cannot be inverted.
    """
    angles = trajectory.positions - [pelvis_tilt, 0.0, pelvis_tilt, 0.0]
    rates = trajectory.velocities, trajectory.accelerations
    if joints is None:
        return RobotMotion(trajectory.time, JOINT_NAMES, angles, *rates)
    free = _free_names(joints)
    factors = np.array([[joints.terms[angle].get(name, 0.0) for name in free] for angle in ANGLES])
    if np.linalg.cond(factors) > SINGULAR:
        raise InputError(f"{joints.origin}: {listed(free)}: two angles are made of the same values; cannot be inverted")
    inverse = np.linalg.inv(factors)
    still = [
        sum(f * (joints.fixed[n] - joints.offsets.get(n, 0.0)) for n, f in joints.terms[a].items() if n in joints.fixed)
        for a in ANGLES
    ]
    scale = 180.0 / math.pi if joints.units == "deg" else 1.0
    place = [joints.order.index(name) for name in free]

    def placed(values: Array, base: Array) -> Array:
        out = np.tile(base, (len(values), 1))
        out[:, place] += values[:, _COLUMNS] @ inverse.T
        return out * scale

    zeros = np.zeros(len(joints.order))
    base = np.array([joints.fixed.get(name, joints.offsets.get(name, 0.0)) for name in joints.order])
    base[place] -= inverse @ still
    positions = placed(angles, base)
    velocities, accelerations = (placed(rate, zeros) for rate in rates)
    unit = joints.units or "rad"
    return RobotMotion(trajectory.time, joints.order, positions, velocities, accelerations, unit)


@dataclass(frozen=True)
class Hinge:
    """A joint of the legs as a robot turns it: its angle is `sign` times the robot's value, and `at_zero` more.

    Attributes:
        name: the robot's name of it.
        sign: 1 or -1.
        at_zero: angle in [rad] where the robot's value is 0.
    """

    name: str
    sign: float = 1.0
    at_zero: float = 0.0


def hinges(joints: JointMap | None) -> tuple[Hinge, ...] | None:
    """The joints of the legs in the order of `JOINT_NAMES` as a robot turns them, one value each.

    None where a robot's values are no such joints: degrees, gears, or angles that several moving values make.
    """
    if joints is None:
        return tuple(map(Hinge, JOINT_NAMES))
    found = dict[str, Hinge]()
    for column, angle in zip(_COLUMNS, ANGLES, strict=True):
        terms = joints.terms[angle]
        free = [name for name in terms if name not in joints.fixed]
        if joints.units == "deg" or len(free) != 1 or abs(terms[free[0]]) != 1.0:
            return None
        at_zero = sum(factor * (joints.fixed.get(n, 0.0) - joints.offsets.get(n, 0.0)) for n, factor in terms.items())
        found[JOINT_NAMES[column]] = Hinge(free[0], terms[free[0]], at_zero)
    made = tuple(found[name] for name in JOINT_NAMES)
    return made if len({hinge.name for hinge in made}) == len(made) else None


def _free_names(joints: JointMap) -> tuple[str, ...]:
    """The values that move: as many as there are angles."""
    free = tuple(name for name in joints.names if name not in joints.fixed)
    if len(free) != len(ANGLES):
        what = "put those that stay as they are under [fixed]" if len(free) > len(ANGLES) else "too few stay free"
        raise InputError(f"{joints.origin}: {len(free)} values make {len(ANGLES)} angles ({listed(free)}): {what}")
    return free
