"""From the points of a depth camera to a `Terrain` with standard deviations."""

from __future__ import annotations

from numpy.typing import ArrayLike

from ggo_factors.motion.world import Terrain
from ggo_factors.seeing.edges import Points
from ggo_factors.seeing.ground import LEAST_SLOPE, Scene
from ggo_factors.seeing.pieces import pieces_of, tilt_of
from ggo_factors.seeing.profile import profile_of
from ggo_factors.seeing.strip import strip_of
from ggo_factors.support.inputs import as_number

STD = 0.003
"""What neighbouring points have in common, in [m]: the systematic error of a calibrated depth camera at 1 to 2 m, and
of where the foot stands."""


def terrain_from_points(
    points: ArrayLike,
    *,
    up: ArrayLike,
    heading: ArrayLike,
    at: ArrayLike | None = None,
    std: float = STD,
    name: str = "seen",
) -> Terrain:
    common = as_number(std, "std", at_least=0.0, at_most=0.05, unit="m")
    strip = strip_of(points, up, heading, at)
    if at is None:
        profile = profile_of(strip)
        strip = strip.raised(-pieces_of(profile)[0].height)
    profile = profile_of(strip)
    tilt, tilt_std = tilt_of(profile, pieces_of(profile), LEAST_SLOPE)
    strip = strip.turned(tilt)
    return Scene(profile_of(strip), Points(strip), common, tilt_std, at is not None).terrain(name)
