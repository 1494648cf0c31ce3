"""Simulated depth cameras: rays cast at the profile of a terrain, and the noise that is published of them.

Kinect v1: C. V. Nguyen, S. Izadi, D. Lovell, "Modeling Kinect sensor noise for improved 3D reconstruction and
tracking", 3DIMPVT 2012. Kinect v2 (time of flight): P. Fankhauser and others, "Kinect v2 for mobile robot navigation:
evaluation and modeling", ICAR 2015. Both give the axial noise by distance and angle of the surface; the lateral one
lets edges be seen half a pixel or so off. At edges some pixels fly between front and back, some return nothing.

World frame of a scene: x forward, y up, z to the right; the camera's own: x right, y down, z along its axis.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ggo_factors import Terrain

Array = NDArray[np.float64]

ELEVATIONS: Array = np.linspace(-math.radians(89.9), math.radians(45.0), 40_001)
FARTHEST = 6.0


@dataclass(frozen=True)
class Camera:
    """A camera: pixels, focal length in pixels, which noise, shares of flying pixels at edges and of dropouts."""

    width: int = 512
    height: int = 424
    focal: float = 365.5
    noise: str = "fankhauser"
    louder: float = 1.0
    flying: float = 0.4
    dropouts: float = 0.05
    at: tuple[float, float, float] = (0.1, 1.1, 0.0)
    pitch: float = math.radians(40.0)
    roll: float = 0.0
    yaw: float = 0.0

    @property
    def axes(self) -> Array:
        """The camera's right, down and forward axis in the world, shape (3, 3), as rows."""
        c, s = math.cos(self.pitch), math.sin(self.pitch)
        right, down, ahead = np.array([0.0, 0.0, 1.0]), np.array([-s, -c, 0.0]), np.array([c, -s, 0.0])
        c, s = math.cos(self.roll), math.sin(self.roll)
        right, down = c * right + s * down, c * down - s * right
        c, s = math.cos(self.yaw), math.sin(self.yaw)
        turn = np.array([[c, 0.0, -s], [0.0, 1.0, 0.0], [s, 0.0, c]])
        return np.asarray(np.array([right, down, ahead]) @ turn.T)

    def into(self, direction: ArrayLike) -> Array:
        """A direction of the world in the camera's axes."""
        return np.asarray(self.axes @ np.asarray(direction, dtype=float))

    def place(self, point: ArrayLike) -> Array:
        """A point of the world in the camera's frame."""
        return np.asarray(self.axes @ (np.asarray(point, dtype=float) - self.at))

    def axial(self, z: Array, angle: Array) -> Array:
        """Standard deviation along the axis in [m] by depth in [m] and angle of the surface in [rad]."""
        steep = angle**2 / np.maximum(math.pi / 2.0 - angle, 0.05) ** 2
        if self.noise == "nguyen":
            std = 0.0012 + 0.0019 * (z - 0.4) ** 2 + 0.0001 / np.sqrt(z) * steep
        else:
            std = 1e-3 * (1.5 - 0.5 * z + 0.3 * z**2 + 0.1 * z**1.5 * steep)
        return np.asarray(np.minimum(self.louder * std, 0.05))

    def lateral(self, angle: float) -> float:
        """Standard deviation across in pixels."""
        return 0.8 + 0.035 * angle / max(math.pi / 2.0 - angle, 0.05) if self.noise == "nguyen" else 0.5


KINECT_1 = Camera(640, 480, 575.0, "nguyen")
KINECT_2 = Camera()


def outline(terrain: Terrain, depths: Sequence[float] = (), behind: float = 2.0) -> Array:
    """The profile as straight pieces, shape (n, 2, 2): ground, sides and tops of boxes, walls and bottoms of pits."""
    depths = tuple(depths) or (1.0,) * len(terrain.pits)
    edges = [x for box in terrain.boxes for x in (box.x_start, box.x_end)]
    edges += [x for pit in terrain.pits for x in (pit.x_start, pit.x_end)]
    low, high = terrain.x_start - behind, terrain.x_end
    places = sorted({low, high, *(s.x_start for s in terrain.surfaces[1:]), *edges})
    lines = list[tuple[tuple[float, float], tuple[float, float]]]()
    for start, end in pairwise(places):
        if end - start < 1e-9:
            continue
        middle = (start + end) / 2.0
        surface = terrain.surfaces[terrain.surface_at(middle)]
        left, right = (surface.height + math.tan(surface.slope) * (x - surface.x_start) for x in (start, end))
        for box, top in zip(terrain.boxes, terrain.tops, strict=True):
            if box.x_start < middle < box.x_end:
                left = right = top
        for pit, depth in zip(terrain.pits, depths, strict=True):
            if pit.x_start < middle < pit.x_end:
                left = right = float(terrain.height_at(pit.x_start)) - depth
        if lines and abs(lines[-1][1][1] - left) > 1e-12:
            lines.append(((start, lines[-1][1][1]), (start, left)))
        lines.append(((start, left), (end, right)))
    return np.array(lines)


def first_hits(lines: Array, eye: Array, elevations: Array = ELEVATIONS) -> NDArray[np.int64]:
    """Which piece each ray from `eye` meets first, or -1; by elevation in [rad]."""
    dx, dy = np.cos(elevations)[:, None], np.sin(elevations)[:, None]
    (ax, ay), (bx, by) = (lines[:, 0] - eye).T, (lines[:, 1] - eye).T
    cross = dx * (by - ay) - dy * (bx - ax)
    with np.errstate(divide="ignore", invalid="ignore"):
        t = (ax * (by - ay) - ay * (bx - ax)) / cross
        u = (ax * dy - ay * dx) / cross
    t = np.where((t > 0.0) & (u >= 0.0) & (u <= 1.0), t, np.inf)
    return np.asarray(np.where(np.isfinite(t.min(axis=1)), t.argmin(axis=1), -1), dtype=np.int64)


def look(
    terrain: Terrain,
    camera: Camera,
    rng: np.random.Generator,
    depths: Sequence[float] = (),
    clutter: Sequence[Sequence[float]] = (),
    noisy: bool = True,
) -> NDArray[np.float32]:
    """One frame of a camera: points in its frame in [m], shape (height, width, 3), NaN where nothing came back.

    Args:
        terrain: the ground; everything reaches across without end.
        camera: the camera.
        rng: for the noise.
        depths: depth of each pit in [m].
        clutter: boxes beside the strip: x from, to, z from, to, y from, to.
        noisy: without, the points lie on the ground exactly.
    """
    v, u = np.mgrid[: camera.height, : camera.width]
    pixel = np.stack([(u - (camera.width - 1) / 2.0), (v - (camera.height - 1) / 2.0)], axis=-1) / camera.focal
    rays = np.concatenate([pixel, np.ones((*pixel.shape[:2], 1))], axis=-1) @ camera.axes
    lines = outline(terrain, depths)
    eye = np.array(camera.at[:2])
    hits = first_hits(lines, eye)
    elevation = np.arctan2(rays[..., 1], rays[..., 0])
    seen = elevation + (rng.normal(0.0, camera.lateral(0.8) / camera.focal, elevation.shape) if noisy else 0.0)
    step = ELEVATIONS[1] - ELEVATIONS[0]
    piece = hits[np.clip(np.rint((seen - ELEVATIONS[0]) / step).astype(int), 0, len(ELEVATIONS) - 1)]
    ends = lines[piece] - eye
    along = ends[..., 1, :] - ends[..., 0, :]
    cross = rays[..., 0] * along[..., 1] - rays[..., 1] * along[..., 0]
    with np.errstate(divide="ignore", invalid="ignore"):
        depth = (ends[..., 0, 0] * along[..., 1] - ends[..., 0, 1] * along[..., 0]) / cross
    depth[(piece < 0) | (depth <= 0.0) | (seen > ELEVATIONS[-1])] = np.inf
    lengths = np.linalg.norm(rays, axis=-1)
    angle = np.arccos(np.clip(np.abs(cross) / (np.hypot(along[..., 0], along[..., 1]) * lengths), 0.0, 1.0))
    for low_x, high_x, low_z, high_z, low_y, high_y in clutter:
        low, high = (np.array(c) - camera.at for c in ((low_x, low_y, low_z), (high_x, high_y, high_z)))
        with np.errstate(divide="ignore", invalid="ignore"):
            one, other = low / rays, high / rays
        near, far = np.minimum(one, other).max(axis=-1), np.maximum(one, other).min(axis=-1)
        hit = (near < far) & (near > 0.0) & (near < depth)
        depth, angle = np.where(hit, near, depth), np.where(hit, 0.5, angle)
    depth[depth * lengths > FARTHEST] = np.inf
    if noisy:
        depth = spoil(depth, angle, camera, rng)
    depth[~np.isfinite(depth)] = np.nan
    return np.concatenate([pixel * depth[..., None], depth[..., None]], axis=-1).astype(np.float32)


def spoil(depth: Array, angle: Array, camera: Camera, rng: np.random.Generator) -> Array:
    """A depth image with axial noise, flying pixels and dropouts."""
    finite = np.where(np.isfinite(depth), depth, FARTHEST)
    low, high = finite.copy(), finite.copy()
    for axis in (0, 1):
        for way in (-1, 1):
            beside = np.roll(finite, way, axis=axis)
            low, high = np.minimum(low, beside), np.maximum(high, beside)
    edge = (high - low > 0.05) & (rng.random(depth.shape) < camera.flying)
    depth = np.where(edge, low + (high - low) * rng.random(depth.shape), depth)
    known = np.isfinite(depth)
    std = camera.axial(np.where(known, depth, 1.0), angle)
    depth = depth + np.where(known, std, 0.0) * rng.standard_normal(depth.shape)
    depth[rng.random(depth.shape) < camera.dropouts] = np.inf
    return depth
