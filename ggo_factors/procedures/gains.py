"""Gains and margins of the attempts at a step: the first ones, then stiffer where the check found a violation."""

from __future__ import annotations

from dataclasses import dataclass

from ggo_factors.check.leg_collision import SEGMENTS
from ggo_factors.check.verify import DRAGS
from ggo_factors.graph.requests import LEG_GAIN, LIMIT_GAIN

END_GAIN = 5.0
"""Gain of the end edge per frame without second-order and landing edges: the paper's 5 m for m frames."""
SMOOTH_END_GAIN = 10.0
"""The same with second-order edges, which pull against the end edge too."""
LANDING_END_GAIN = 20.0
"""The same with landing edges, which pull as well: with 10 a quarter of the first attempts miss the foothold."""
STIFFER = 10.0
"""Factor on the gain of an edge whose limit was broken."""
STEEPER = 2.0
"""Factor on gamma where a path was too low; smaller, since the error of an obstacle edge grows exponentially."""
BALANCED_HOLD = 0.5
"""Hold of the first attempt at a balanced step of up to 50 motions, half of that at others: a foot that is held in the
air cannot go where balance needs it. At 1 the ZMP is 1.5 times as far off and joints change by 16 % more; at 0.3 two of
100 boxes take four attempts and three to four times the change. With more motions more frames are held."""
HELD_FASTER = 3.0
"""Factor on the hold of lifted frames where the hip sank: a hold keeps them from swinging on."""
HELD_AWAY = 1.5
"""The same where a path was too low over the ground: held frames keep away from the riser behind them. With 2 and 3
more flights down stairs end in a limp."""
SOFTER = 0.1
"""By so many times the landing edges are softer where joint limits are broken: the two pull against each other. Of 87
random boxes within the default limits 80 are made so, 6 of them without landing edges; 79 and 16 were without this."""
HIGHER = 0.01
"""Added to the margins in [m] where a path was too low or a leg hit: half the paper's delta."""
INSIDE = 0.02
"""Share by which speeds and accelerations of a gait to be upsampled stay inside their limits: a spline swings beyond
its frames."""
SAFER = 1.2
"""Where that is not enough, the share grows by this factor times what the spline still swings beyond the limits."""
RATE_KINDS = {f"{joint} {kind}" for joint in ("hip", "knee") for kind in ("speed", "acceleration")}
"""Kinds of violations of speed and acceleration limits."""
LIMIT_KINDS = RATE_KINDS | {"hip angle", "knee angle"}
"""Kinds of violations of all joint limits."""


@dataclass(frozen=True)
class Gains:
    """Gains of one attempt at a step.

    Attributes:
        end: of the end edge.
        knee: of the knee edges, the paper's lambda.
        limits: of the edges on joint limits.
        legs: of the leg edges in [1/m^2].
        gamma: steepness of the obstacle edges in [1/m].
        hold: pull of a lifted frame towards its place in [1/m].
        spare: height in [m] added to the margins.
        inside: share by which speeds and accelerations are to stay inside their limits.
        landing: by how many times the gains of the landing edges are smaller or larger.
    """

    end: float
    knee: float = 5.0
    limits: float = LIMIT_GAIN
    legs: float = LEG_GAIN
    gamma: float = 4.0
    hold: float = 1.0
    spare: float = 0.0
    inside: float = 0.0
    landing: float = 1.0


def stiffer(gains: Gains, kinds: set[str], end_given: bool, between: float) -> Gains:
    """Stiffer gains where a limit was broken.

    Args:
        gains: those of the attempt before.
        kinds: kinds of its violations.
        end_given: whether the user chose the gain of the end edge, which then stays.
        between: share by which joints go beyond their limits between the frames that were solved for, where stiffer
            edges do not help.
    """
    low = bool(kinds & {"obstacle", "ground", "hit probability", DRAGS})
    hit = any(kind.startswith(SEGMENTS) for kind in kinds)
    return Gains(
        gains.end * (STIFFER if kinds & {"foothold", "shank"} and not end_given else 1.0),
        gains.knee * (STIFFER if "knee" in kinds else 1.0),
        gains.limits * (STIFFER if kinds & LIMIT_KINDS and not between else 1.0),
        gains.legs * (STIFFER if hit else 1.0),
        gains.gamma * (STEEPER if low else 1.0),
        gains.hold * (HELD_FASTER if "hip drop" in kinds else HELD_AWAY if kinds & {"ground", DRAGS} else 1.0),
        gains.spare + (HIGHER if low or hit else 0.0),
        gains.inside + SAFER * between,
        gains.landing * (SOFTER if kinds & LIMIT_KINDS and not between else 1.0),
    )
