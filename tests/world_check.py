"""A walk checked in world coordinates: both feet, soles and all bones against all of a course. No code of the library.

What is given: frames and times of each step, lengths of the legs, and the course as plain numbers. Joint angles are
linear between frames. The supporting foot stands still by construction of the frames, so that what can go wrong is told
where the legs change roles: the foot that swings next must leave from where it stood.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import shapely

DEEP = 1.0
"""How far down the ground reaches below its lowest place, in [m]."""
GROUND = 1e-3
"""A foot may be so far over or under the ground where it lands, or dip in on its way, in [m]."""
BEGINS = 10e-3
"""The same where the walk begins, since the paper's base gait begins 9.7 mm off."""
GRAZE = 1e-4
"""A line reaches into a box where it reaches in by more than this, in [m]: what rounding may do, and no more."""
KNEE, THIGH = (math.radians(-0.5), math.radians(150.0)), (math.radians(-50.0), math.radians(130.0))
FASTEST = 20.0
"""No joint turns faster, in [rad/s], at the pace that is walked."""
CROUCH = 0.5
"""The hip stays over the supporting ankle, or over where the foot lands if that is lower, by this share of the leg."""
JUMP, BEND = 2.0, 2.0
"""A joint's speed changes by no more than 2 rad/s where the legs change roles, or twice what it does elsewhere."""


@dataclass(frozen=True)
class Legs:
    """Lengths in [m]: thigh, shank, ankle over the sole, heel behind it, toe before it."""

    thigh: float = 0.39
    shank: float = 0.39
    ankle: float = 0.0
    heel: float = 0.0
    toe: float = 0.0


def legs_of(model):
    """The lengths of a library's model, without its methods."""
    return Legs(model.thigh, model.shank, model.foot.ankle_height, model.foot.heel, model.foot.toe)


def leg_points(legs, thigh, knee):
    """Knee and ankle seen from the hip, complex numbers, of thigh angles and knee flexions in [rad]."""
    at_knee = -1j * legs.thigh * np.exp(1j * thigh)
    return at_knee, at_knee - 1j * legs.shank * np.exp(1j * (thigh - knee))


def joints_of(frames, legs):
    """Supporting knee, hip, swinging knee, swinging ankle seen from the supporting ankle, complex, each (n,)."""
    a1, b1, a2, b2 = np.asarray(frames).T
    (knee, ankle), (other_knee, other_ankle) = leg_points(legs, a1, b1), leg_points(legs, a2, b2)
    return knee - ankle, -ankle, other_knee - ankle, other_ankle - ankle


def between(frames, times, instants):
    """Frames at so many evenly spread instants and at the given ones, angles linear in time."""
    at = np.unique(np.concatenate([np.linspace(times[0], times[-1], instants), times]))
    return np.stack([np.interp(at, times, column) for column in np.asarray(frames).T], -1)


def ankle_on(course, legs, x):
    """Where an ankle is whose foot stands on a course at `x`, complex."""
    return complex(x, course.height_at(x) + legs.ankle / math.cos(course.piece_at(x)[3]))


def sole_of(legs, ankle, tilt):
    """Heel and toe of soles, complex, of ankles (n,) and tilts (n,) in [rad]."""
    along = np.exp(1j * tilt)
    under = ankle - 1j * legs.ankle * along
    return under - legs.heel * along, under + legs.toe * along


def solids(course, ground, graze):
    """Ground lowered by `ground`, then each box smaller by `graze`, as polygons with names."""
    low = min(min(y, course.height_at(x1 - 1e-9)) for _, x1, y, _ in course.pieces) - DEEP
    first, last = course.pieces[0], course.pieces[-1]
    outline = [(first[0] - 3.0, first[2] - math.tan(first[3]) * 3.0)]
    for x0, x1, y, slope in course.pieces:
        outline += [(x0, y), (x1, y + math.tan(slope) * (x1 - x0))]
    outline.append((last[1] + 3.0, outline[-1][1]))
    lowered = [(x, y - ground) for x, y in outline]
    named = [("ground", shapely.Polygon([*lowered, (outline[-1][0], low - 3.0), (outline[0][0], low - 3.0)]))]
    for number, box in enumerate(course.boxes, start=1):
        name = f"box {number} ({box[0]:.3f} to {box[1]:.3f}, {box[2]:.3f} high)"
        inside = shapely.box(box[0] + graze, low, box[1] - graze, course.top_of(box) - graze)
        named.append((name, inside))
    return named


def lines(starts, ends):
    """Line strings from complex starts to complex ends."""
    return shapely.linestrings(np.stack([[starts.real, starts.imag], [ends.real, ends.imag]]).transpose(2, 0, 1))


def standing_faults(course, legs, ankle, name, begins=False):
    """What is wrong with where a foot stands, its ankle at `ankle`, complex."""
    x, found = ankle.real, []
    off = ankle.imag - ankle_on(course, legs, x).imag
    if abs(off) > (BEGINS if begins else GROUND) + 1e-9:
        found.append(f"{name} at x = {x:.3f}: ankle {off * 1e3:+.2f} mm off the ground")
    tilt = course.piece_at(x)[3]
    heel, toe = (float(end[0].real) for end in sole_of(legs, np.array([ankle]), np.array([tilt])))
    for x0, *_ in course.pieces[1:]:
        # Where there is no riser a sole hangs over by a thousandth of what it reaches beyond: the landing's own error.
        spare = 1e-9 if abs(course.height_at(x0) - course.height_at(x0 - 1e-9)) > 1e-6 else GROUND
        if heel < x0 - spare and toe > x0 + spare:
            found.append(f"{name} at x = {x:.3f}: an edge at {x0:.3f} under its sole, {heel:.3f} to {toe:.3f}")
    for what, shapes in (("pit", course.pits), ("box", [box[:2] for box in course.boxes])):
        for x0, x1 in shapes:
            if heel < x1 and toe > x0:
                found.append(f"{name} at x = {x:.3f}: in a {what} from {x0:.3f} to {x1:.3f}")
    if toe > course.pieces[-1][1]:
        found.append(f"{name} at x = {x:.3f}: beyond the end of the ground")
    return found


def faults_of_walk(course, steps, legs, *, start=None, end=None, footholds=None, instants=400, speeds=True):
    """Everything that is wrong with a walk, in words.

    Args:
        course: as in `courses`.
        steps: frames (m, 4) in [rad] and times (m,) in [s] of each step, the first standing at x = 0.
        legs: `Legs`.
        start: frame that the first must be, or None.
        end: frame that the last must be, or None.
        footholds: where the feet must land, x in the world frame, or None.
        instants: so many are looked at in each step.
        speeds: whether joints' speeds are looked at.
    """
    found, at, before, lifted = [], ankle_on(course, legs, 0.0), None, None
    bodies = solids(course, GROUND, GRAZE)
    for _, body in bodies:
        shapely.prepare(body)
    if start is not None and np.abs(steps[0][0][0] - start).max() > 1e-6:
        found.append("first frame: not the one asked for")
    if end is not None and np.abs(steps[-1][0][-1] - end).max() > 1e-6:
        found.append("last frame: not the one asked for")
    for number, (frames, times) in enumerate(steps, start=1):
        name = f"step {number}"
        swing = joints_of(frames, legs)[3]
        leaves, lands = at + complex(swing[0]), at + complex(swing[-1])
        found += standing_faults(course, legs, at, f"{name}, supporting foot")
        if number == 1:
            found += standing_faults(course, legs, leaves, f"{name}, foot that leaves", begins=True)
        elif abs(leaves - lifted) > 1e-6:
            found.append(f"{name}: the foot that stood moves by {abs(leaves - lifted) * 1e3:.3f} mm as it is to leave")
        found += standing_faults(course, legs, lands, f"{name}, landing")
        if footholds is not None and abs(lands.real - footholds[number - 1]) > 1e-3 + 1e-9:
            off = lands.real - footholds[number - 1]
            found.append(f"{name}: lands {off * 1e3:+.2f} mm off its foothold at {footholds[number - 1]:.3f}")
        found += _touches(course, legs, bodies, between(frames, times, instants), at, (leaves, lands), name)
        found += _ranges(frames, times, before, legs, name, speeds)
        lifted, at, before = at, lands, (frames, times)
    return found


def _touches(course, legs, bodies, dense, at, ends, name):
    """Soles and bones in the ground or in a box, the worst of each."""
    knee, hip, other_knee, ankle = (at + points for points in joints_of(dense, legs))
    share = np.clip((ankle.real - ends[0].real) / ((ends[1] - ends[0]).real or 1.0), 0.0, 1.0)
    tilts = [course.piece_at(end.real)[3] for end in ends]
    heel, toe = sole_of(legs, ankle, tilts[0] + share * (tilts[1] - tilts[0]))
    standing = np.full_like(knee, at)
    # A foot that is a point is a line too short to see.
    parts = [
        ("swinging sole", heel, toe + 1e-9),
        ("supporting shank", standing, knee),
        ("supporting thigh", knee, hip),
        ("swinging thigh", hip, other_knee),
        ("swinging shank", other_knee, ankle),
    ]
    found = []
    for part, one, other in parts:
        pieces = lines(one, other)
        for what, body in bodies:
            hits = shapely.intersects(body, pieces)
            if what == "ground" and name == "step 1":
                # The base gait may begin a little under the ground.
                hits &= np.abs(ankle - ends[0]) > BEGINS
            if hits.any():
                first = int(np.flatnonzero(hits)[0])
                inside = shapely.intersection(body, pieces[hits])
                depth = max(
                    float(shapely.distance(body.boundary, shapely.points(shapely.get_coordinates(piece))).max())
                    for piece in inside
                )
                x = float(one[first].real)
                found.append(
                    f"{name}: {part} in {what}, {depth * 1e3:.2f} mm, {hits.sum()} of {len(hits)} instants from "
                    f"{first / len(hits):.2f}, x = {x:.3f}"
                )
    return found


def _ranges(frames, times, before, legs, name, speeds):
    """Joints beyond a person's range, a leg that gives way, joints too fast, or that jump at the change of legs."""
    found = []
    for column, (what, (low, high)) in enumerate((("hip", THIGH), ("knee", KNEE)) * 2):
        angles = frames[:, column]
        if angles.min() < low or angles.max() > high:
            found.append(
                f"{name}: {what} from {math.degrees(angles.min()):.1f} to {math.degrees(angles.max()):.1f} deg"
            )
    _, hip, _, ankle = joints_of(frames, legs)
    least = hip.imag.min() - min(0.0, ankle[-1].imag)
    if least < CROUCH * (legs.thigh + legs.shank):
        found.append(f"{name}: hip down to {least:.3f} m over the lower foot")
    rates = np.diff(frames, axis=0) / np.diff(times)[:, None]
    if speeds and np.abs(rates).max() > FASTEST:
        found.append(f"{name}: a joint turns at {np.abs(rates).max():.1f} rad/s")
    if before is None:
        return found
    turned = before[0][:, [2, 3, 0, 1]]
    if np.abs(turned[-1] - frames[0]).max() > 1e-9:
        found.append(
            f"{name}: begins {np.degrees(np.abs(turned[-1] - frames[0]).max()):.4f} deg off where the last ended"
        )
    earlier = np.diff(turned, axis=0) / np.diff(before[1])[:, None]
    jump = np.abs(rates[0] - earlier[-1]).max()
    bends = max(np.abs(np.diff(each, axis=0)).max() for each in (rates, earlier))
    if jump > max(JUMP, BEND * bends):
        found.append(f"{name}: a joint's speed jumps by {jump:.2f} rad/s as the legs change roles")
    return found


def faults_of(course, walk, **asked):
    """As `faults_of_walk`, of a walk of the library: what its files hold and no more."""
    steps = [(gait.frames, gait.times) for gait in walk.gaits]
    return faults_of_walk(course, steps, legs_of(walk.model), **asked)
