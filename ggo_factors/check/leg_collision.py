"""How far thighs, shanks and the swinging sole stay clear of obstacles and stairs.

Thighs and shanks are the axes that `LegModel.joints` gives, bare bones, and capsules around them where they have a
radius; the sole is a level line under the ankle. What they may hit are blocks: all that lies under a level top between
two upright sides. An obstacle is a block, since it stands on the ground; so is a tread together with the higher treads
beside it.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ggo_factors.errors import Violation
from ggo_factors.motion.leg_model import LegModel
from ggo_factors.motion.terrain import LEVEL, Ground, Obstacle
from ggo_factors.support.inputs import Array

SEGMENTS = ("support shank", "support thigh", "swing thigh", "swing shank", "swing sole")
FOOT_SPARE = 0.010
"""How far a shank's end stays above the sole on a tread in [m]: as far as a standing foot may be off the ground."""
BESIDE = 0.5
"""Share of the way from an ankle to a block beside it that its shank may lean over."""
FAR = 1e3
"""Where the ground ends ahead and behind, in [m]: beyond any step."""


def leg_clearance(
    model: LegModel, frames: ArrayLike, obstacles: Sequence[Obstacle] = (), ground: Ground | None = None
) -> Array:
    """Signed distance of each segment of the legs from each obstacle and each tread in [m], at the frames given.

    Below 0 the segment reaches in: by its radius and as deep as its axis lies in the block. Where bones are points, a
    thigh or shank of radius 0 is no body and infinitely far. Level ground is left out: only knees could touch it, and
    the swing ankle is checked against it anyway.

    A shank ends at the ankle, so where the ankle is lower above its sole than the shank is thick, the round end would
    lie in the ground the foot stands on. There the capsule ends early, `FOOT_SPARE` more than the radius above the
    sole; for a shank that leans further than 60 degrees no earlier than it does at 60. The bare axis ends early at
    treads alone, `FOOT_SPARE` above the sole: an ankle never stands on a box, so there it counts down to the ankle.

    Args:
        model: the legs.
        frames: frames in [rad], shape (m, 4).
        obstacles: boxes in the body frame of the step, their heights above the supporting sole.
        ground: height of the ground; its treads count where it has edges.

    Returns:
        Shape (m, 5, k): instants, `SEGMENTS`, then the obstacles followed by the treads.
    """
    joints, blocks = model.joints(frames), blocks_of(model, obstacles, ground)
    clear = _capsules(model, joints, blocks, range(len(SEGMENTS)))
    if model.bones == "lines":
        bare = _bare(model, joints, blocks, len(obstacles))
        clear[:, :4] = np.minimum(clear[:, :4], bare.transpose(2, 1, 0))
    return clear


def leg_faults(
    model: LegModel, joints: Array, times: Array, obstacles: Sequence[Obstacle], ground: Ground | None
) -> tuple[float, list[Violation]]:
    """Least clearance of thighs and shanks that have a radius in [m], and the worst hit of each on each, bones too.

    The clearance is infinite where nothing is near or nothing has a radius: `LegAxes` measures bare bones. The sole is
    covered by the path of the swing ankle, over what `Obstacle.for_ankle` and `Ground.for_ankle` give.

    Args:
        model: the legs.
        joints: what `LegModel.joints` gives of each frame in [m], shape (m, 5, 2).
        times: number of each frame, shape (m,).
        obstacles: boxes in the body frame of the step.
        ground: height of the ground, or None where it is not known.
    """
    if not model.has_bodies or not (obstacles or (ground and ground.edges)):
        return math.inf, []
    blocks, least = blocks_of(model, obstacles, ground), math.inf
    clear = np.full((len(joints), 4, len(blocks)), math.inf)
    if max(model.thigh_radius, model.shank_radius) > 0.0:
        clear = _capsules(model, joints, blocks, range(4))
        least = float(clear.min(initial=math.inf))
    if model.bones == "lines":
        # Few instants of a step have a bone beside or over a block, most steps have none.
        near = np.flatnonzero(bones_near(joints, blocks, 0.0).any(axis=(0, 1)))
        if len(near):
            bare = _bare(model, joints[near], blocks, len(obstacles))
            clear[near] = np.minimum(clear[near], bare.transpose(2, 1, 0))
    found: list[Violation] = []
    if not clear.min(initial=0.0) < 0.0:
        return least, found
    for number, segment in enumerate(SEGMENTS[:-1]):
        hits = [(f"{segment} in obstacle", clear[:, number, k], str(box)) for k, box in enumerate(obstacles)]
        stairs = clear[:, number, len(obstacles) :].min(axis=1, initial=math.inf)
        for kind, heights, note in [*hits, (f"{segment} in stairs", stairs, "")]:
            worst = int(heights.argmin())
            if heights[worst] < 0.0:
                found.append(Violation(kind, float(times[worst]), float(heights[worst]), 0.0, "m", note))
    return least, found


@dataclass(frozen=True, eq=False)
class LegAxes:
    """The axes of thighs and shanks over a step, and what they may hit.

    Attributes:
        model: the legs.
        joints: what `LegModel.joints` gives of each frame in [m], shape (m, 5, 2).
        obstacles: boxes in the body frame of the step.
        ground: height of the ground, or None where it is not known.
    """

    model: LegModel
    joints: Array
    obstacles: tuple[Obstacle, ...]
    ground: Ground | None

    def clearance(self) -> float:
        """Least signed distance of the bare axes from obstacles and treads in [m]; infinite where there is none."""
        blocks = blocks_of(self.model, self.obstacles, self.ground)
        return float(_bare(self.model, self.joints, blocks, len(self.obstacles)).min(initial=math.inf))


def shank_between(blocks: Array, ankle: tuple[float, float], shank: float) -> tuple[float, float]:
    """Least and largest angle from the vertical in [rad] at which a shank passes between blocks, knee back positive.

    Args:
        blocks: what `blocks_of` gives.
        ankle: where its ankle is in [m], shape (2,).
        shank: its length in [m].
    """
    least, most = -math.pi / 2.0, math.pi / 2.0
    for left, right, top in blocks.tolist():
        up = min(top - ankle[1], shank)
        if up > 0.0 and right < ankle[0]:
            most = min(most, math.atan(BESIDE * (ankle[0] - right) / up))
        elif up > 0.0 and left > ankle[0]:
            least = max(least, -math.atan(BESIDE * (left - ankle[0]) / up))
    return least, most


def bones_near(joints: Array, blocks: Array, within: float | Array) -> NDArray[np.bool_]:
    """Whether the box around each axis comes so near in [m] to a block, shape (k, 4, m): where not, it is clear.

    Args:
        joints: what `LegModel.joints` gives of each frame in [m], shape (m, 5, 2).
        blocks: what `blocks_of` gives.
        within: the distance.
    """
    points = joints.transpose(2, 1, 0)
    low, high = np.minimum(points[:, :-1], points[:, 1:]), np.maximum(points[0, :-1], points[0, 1:])
    left, right, top = blocks.T[:, :, None, None]
    return np.asarray((high > left - within) & (low[0] < right + within) & (low[1] < top + within))


def _capsules(model: LegModel, joints: Array, blocks: Array, segments: range) -> Array:
    """As `leg_clearance`, of some of the segments, without bare bones."""
    radii = np.array([model.shank_radius, model.thigh_radius, model.thigh_radius, model.shank_radius, 0.0])
    bodies = [number for number in segments if radii[number] > 0.0 or SEGMENTS[number] == "swing sole"]
    starts, ends = _axes(model, joints, left_out(model, model.shank_radius))
    clear = np.full((len(blocks), len(segments), len(joints)), math.inf)
    clear[:, bodies] = _distance(starts[:, bodies], ends[:, bodies], blocks) - radii[bodies, None]
    return clear.transpose(2, 1, 0)


def _bare(model: LegModel, joints: Array, blocks: Array, boxes: int) -> Array:
    """Signed distance of each axis in [m], shape (k, 4, m), from blocks (k, 3), the first of which are boxes."""
    found = []
    for some, low in ((blocks[:boxes], 0.0), (blocks[boxes:], left_out(model, 0.0))):
        starts, ends = _axes(model, joints, low)
        found.append(_distance(starts[:, :4], ends[:, :4], some))
    return np.concatenate(found)


def left_out(model: LegModel, radius: float) -> float:
    """Height over the ankle in [m] up to which the end of an upright shank does not count, see `leg_clearance`."""
    return max(0.0, radius + FOOT_SPARE - model.foot.ankle_height)


def blocks_of(model: LegModel, obstacles: Sequence[Obstacle], ground: Ground | None) -> Array:
    """Near side, far side and top of each obstacle, then of each tread, in the body frame in [m], shape (k, 3)."""
    blocks = np.array([*_boxes(obstacles), *_treads(ground)]).reshape(-1, 3)
    # Heights count from the ground under the supporting ankle, the body frame from the ankle above it.
    return np.asarray(blocks - [0.0, 0.0, (ground or LEVEL).ankle_over(model.foot)])


def _axes(model: LegModel, joints: Array, low: float) -> tuple[Array, Array]:
    """Both ends of the axis of each of the `SEGMENTS` in [m], shape (2, 5, m), of joints, shape (m, 5, 2).

    Upright shanks end `low` above the ankle in [m].
    """
    foot, points = model.foot, np.ascontiguousarray(joints.T)
    heel, toe = (points[:, 4:] + [[[x]], [[-foot.ankle_height]]] for x in (-foot.heel, foot.toe))
    starts, ends = np.concatenate([points[:, :4], heel], axis=1), np.concatenate([points[:, 1:], toe], axis=1)
    for ankles, knees in ((starts[:, 0], ends[:, 0]), (ends[:, 3], starts[:, 3])):
        up = knees - ankles
        ankles += np.minimum(low / np.maximum(up[1], model.shank / 2.0), 1.0) * up
    return starts, ends


def _boxes(obstacles: Sequence[Obstacle]) -> Iterator[tuple[float, float, float]]:
    for box in obstacles:
        yield box.x_start, box.x_end, box.height


def _treads(ground: Ground | None) -> Iterator[tuple[float, float, float]]:
    """Each tread as far as the ground is at least as high: the sides of a block are risers, not seams.

    A ramp counts as high as its lower end: between an ankle that is over it and the edges beside it no bone gets in.
    """
    if ground is None or not ground.edges:
        return
    bounds, heights = (-FAR, *ground.edges, FAR), list(ground.heights)
    for piece, slope in enumerate(ground.slopes):
        low, high = bounds[piece], bounds[piece + 1]
        heights[piece] += min(0.0, math.tan(slope) * (high - low) * (1.0 if piece else -1.0))
    for first, height in enumerate(heights):
        low, high = first, first + 1
        while low > 0 and heights[low - 1] >= height:
            low -= 1
        while high < len(heights) and heights[high] >= height:
            high += 1
        yield bounds[low], bounds[high], height


def _distance(start: Array, end: Array, blocks: Array) -> Array:
    """Signed distance in [m], shape (k, ...), of straight pieces, ends (2, ...), from blocks (k, 3).

    How far a point lies outside the nearest of a block's three faces, the largest of three linear functions, is convex:
    along a piece it is least at an end or where two of the three are equal. Where that is above 0 the piece lies
    outside, and the corners of the block and the ends of the piece are what can be nearest.
    """
    x, y = start
    run, rise = end - start
    left, right, top = blocks.T.reshape(3, -1, *(1,) * x.ndim)

    def beyond(share: ArrayLike) -> tuple[Array, Array]:
        """How far the point at `share` of the piece lies beside the block's nearer side, and above its top."""
        at = x + share * run
        return np.maximum(left - at, at - right), y + share * rise - top

    with np.errstate(divide="ignore", invalid="ignore"):
        equal = [(left + right - 2.0 * x) / (2.0 * run), (top - y + left - x) / (rise + run)]
        equal += [(top - y - right + x) / (rise - run)]
    # Where two faces stay equal all along, 0 / 0, an end will do: fmax takes the number, not the NaN.
    points = [beyond(0.0), beyond(1.0), *(beyond(np.fmin(np.fmax(share, 0.0), 1.0)) for share in equal)]
    inside = np.minimum.reduce([np.maximum(*point) for point in points])
    squares = [np.maximum(beside, 0.0) ** 2 + np.maximum(above, 0.0) ** 2 for beside, above in points[:2]]
    length = np.maximum(run**2 + rise**2, np.finfo(np.float64).tiny)
    for side in (left, right):
        share = np.fmin(np.fmax(((side - x) * run + (top - y) * rise) / length, 0.0), 1.0)
        squares.append((x + share * run - side) ** 2 + (y + share * rise - top) ** 2)
    return np.asarray(np.where(inside > 0.0, np.sqrt(np.minimum.reduce(squares)), inside), dtype=np.float64)
