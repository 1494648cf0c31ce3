"""From the points of a depth camera to a `Terrain` with standard deviations."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike

from ggo_factors.errors import InputError
from ggo_factors.motion.world import Terrain
from ggo_factors.seeing.edges import Points
from ggo_factors.seeing.fusion import aligned
from ggo_factors.seeing.ground import LEAST_SLOPE, Scene
from ggo_factors.seeing.pieces import pieces_of, tilt_of
from ggo_factors.seeing.profile import profile_of, together
from ggo_factors.seeing.strip import Sighting, Strip, strip_of
from ggo_factors.support.inputs import as_number, as_tuple_of

STD = 0.003
"""What the points of one frame are off by in common, in [m]: the systematic error of a calibrated depth camera at 1 to
2 m, and of where the foot stands."""
NEAREST = 0.1
"""This share of the points, the nearest, are taken for ground where the foot's height is not told."""
LARGEST_COMMON = 0.05
"""A larger one in [m] is surely a mistake."""


def terrain_from_points(
    points: ArrayLike,
    *,
    up: ArrayLike,
    heading: ArrayLike,
    at: ArrayLike | None = None,
    std: float = STD,
    name: str = "seen",
) -> Terrain:
    """The ground ahead, from one frame of a depth camera.

    A strip along the heading, as wide as a walker needs, is looked at as a height profile; what is level, slopes,
    stands in the way or is a hole is told by the best division of it into straight pieces. Edges stand across the
    heading. Holes, what boxes hide and the ground between foot and first point are pits with ``unknown=True``: nobody
    saw them, and no foot may land there. Slopes below 1.5 degrees are taken for a wrong `up`, and made level. The
    walker's own legs must not be among the points.

    Args:
        points: in [m] in the camera's own frame (origin in the camera, axes of any direction), shape (n, 3) or
            (rows, columns, 3); NaN where nothing came back.
        up: against gravity, in the same frame, shape (3,), of any length.
        heading: where the walk goes, shape (3,); its level part counts.
        at: the ground under the supporting ankle in [m] in the same frame, shape (3,), the origin of the terrain; if
            None it is under the camera, on the nearest ground that is seen.
        std: standard deviation in [m] of what all points have in common, which their number does not mend: the
            camera's own error, and that of `at`. What single points are off is told by how they scatter.
        name: of the terrain.

    Returns:
        The terrain to where the ground was seen, each edge and height with its standard deviation.

    Raises:
        InputError: where an argument is of no use, or no ground is seen.
    """
    return terrain_from_sightings([Sighting(points, up, heading, at)], std=std, name=name)


def terrain_from_sightings(sightings: Iterable[Sighting], *, std: float = STD, name: str = "seen") -> Terrain:
    """The ground ahead, from several frames of a depth camera that was carried along.

    Where frames disagree as a whole, by what leg kinematics get wrong on the way, they are moved to agree on the edges
    and heights that they share (`seeing.fusion`); all points together are then looked at as those of one frame.

    Args:
        sightings: the frames, each with the same origin `at` in its own frame; one alone may leave it out.
        std: as for `terrain_from_points`; errors of different frames are taken as independent.
        name: of the terrain.

    Raises:
        InputError: as `terrain_from_points`.
    """
    seen = as_tuple_of(sightings, "sightings", Sighting)
    common = as_number(std, "std", at_least=0.0, at_most=LARGEST_COMMON, unit="m")
    if not seen:
        raise InputError("sightings: there are none")
    if len(seen) > 1 and any(one.at is None for one in seen):
        raise InputError("sightings: of several each needs its at, the same place for all")
    levelled = [_levelled(strip_of(one), one.at is not None) for one in seen]
    strips, tilt_std = [strip for strip, _ in levelled], max(std for _, std in levelled)
    off = common, common
    if len(strips) > 1:
        alone = [_scene([strip], off, tilt_std, False).terrain(name) for strip in strips]
        strips, off = aligned(strips, alone, common)
    return _scene(strips, off, tilt_std, seen[0].at is not None).terrain(name)


def _levelled(strip: Strip, stands: bool) -> tuple[Strip, float]:
    """A strip whose level ground is level, and what of that remains unknown, in [rad]."""
    if not stands:
        near = strip.y[strip.x <= np.quantile(strip.x, NEAREST)]
        strip = strip.shifted(0.0, -float(np.median(near)))
    profile = profile_of(strip)
    pieces = pieces_of(profile)
    if not stands and pieces:
        strip = strip.shifted(0.0, -pieces[0].at(pieces[0].x_start))
        profile = profile_of(strip)
        pieces = pieces_of(profile)
    tilt, tilt_std = tilt_of(profile, pieces, LEAST_SLOPE)
    return strip.turned(tilt), tilt_std


def _scene(strips: list[Strip], std: tuple[float, float], tilt_std: float, stands: bool) -> Scene:
    profiles = [profile_of(strip) for strip in strips]
    if len(profiles) > 1:
        # One frame is tilted a little against the other: the more so the farther away a cell is.
        both = zip(profiles, strips, strict=True)
        profiles = [replace(one, std=np.hypot(one.std, tilt_std * (one.x - strip.eye[0]))) for one, strip in both]
    return Scene(together(profiles), [Points(strip) for strip in strips], std, tilt_std, stands)
