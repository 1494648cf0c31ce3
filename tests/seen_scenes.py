"""Scenes for the tests of `ggo_factors.seeing`: random ground before a random depth camera."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
from depth_camera import KINECT_1, KINECT_2, Camera, first_hits, look, outline

from ggo_factors import Gap, Obstacle, Terrain

COMMON_STD = 0.003


@dataclass(frozen=True)
class Scene:
    """Ground, the depth of its pits, clutter beside it, a camera, and what its user is told wrongly.

    Attributes:
        tilt: error of the `up` that is told, in [rad].
        offset: error of the `at` that is told, forward and up, in [m].
    """

    terrain: Terrain
    depths: tuple[float, ...]
    clutter: tuple[tuple[float, ...], ...]
    camera: Camera
    seed: int
    tilt: float = 0.0
    offset: tuple[float, float] = (0.0, 0.0)

    def points(self, noisy=True):
        return look(self.terrain, self.camera, np.random.default_rng(self.seed), self.depths, self.clutter, noisy)

    def told(self):
        """What the user tells of the frame: up, heading, at."""
        up = np.array([math.sin(self.tilt), math.cos(self.tilt), 0.0])
        at = np.array([self.offset[0], float(self.terrain.height_at(0.0)) + self.offset[1], 0.0])
        return {
            "up": self.camera.into(up),
            "heading": self.camera.into([1.0, 0.0, 0.0]),
            "at": self.camera.place(at),
        }

    def visible(self, step=0.002):
        """Whether the camera sees the ground, tops and bottoms at each x of a grid: x and truth, shape (n,)."""
        lines = outline(self.terrain, self.depths)
        eye = np.array(self.camera.at[:2])
        half = math.atan(self.camera.height / 2.0 / self.camera.focal)
        rays = np.linspace(-self.camera.pitch - half, -self.camera.pitch + half, 8001)
        piece = first_hits(lines, eye, rays)
        good = piece >= 0
        ends = lines[piece[good]] - eye
        along = ends[:, 1] - ends[:, 0]
        dx, dy = np.cos(rays[good]), np.sin(rays[good])
        t = (ends[:, 0, 0] * along[:, 1] - ends[:, 0, 1] * along[:, 0]) / (dx * along[:, 1] - dy * along[:, 0])
        x = eye[0] + t * dx
        flat = np.abs(along[:, 0]) > 1e-9
        grid = np.arange(0.0, 3.5, step)
        seen = np.zeros(len(grid), bool)
        cells = np.rint(x[flat] / step).astype(int)
        seen[cells[(cells >= 0) & (cells < len(grid))]] = True
        # Rays are dense near and sparse far: a grid place between two seen ones within 10 mm is seen.
        places = np.flatnonzero(seen)
        for a, b in pairwise(places):
            if (b - a) * step <= 0.01:
                seen[a:b] = True
        return grid, seen


def random_scene(seed, *, common=COMMON_STD):
    """A random scene: stairs, kerbs, boxes, pits, ramps between 0.5 and 2.5 m, clutter beside them."""
    rng = np.random.default_rng(seed)
    base = KINECT_2 if rng.random() < 0.6 else KINECT_1
    camera = replace(
        base,
        louder=float(rng.uniform(1.0, 2.5)),
        flying=float(rng.uniform(0.2, 0.6)),
        dropouts=float(rng.uniform(0.02, 0.10)),
        at=(float(rng.uniform(0.0, 0.15)), float(rng.uniform(0.9, 1.35)), float(rng.uniform(-0.05, 0.05))),
        pitch=math.radians(rng.uniform(30.0, 50.0)),
        roll=math.radians(rng.normal(0.0, 1.0)),
        yaw=math.radians(rng.normal(0.0, 2.0)),
    )
    terrain, depths = random_ground(rng)
    clutter = []
    for _ in range(rng.integers(0, 4)):
        side = 1.0 if rng.random() < 0.5 else -1.0
        inner, x = rng.uniform(0.25, 0.5), rng.uniform(0.5, 2.5)
        across = sorted((side * inner, side * (inner + rng.uniform(0.1, 0.5))))
        clutter.append((x, x + rng.uniform(0.1, 0.6), *across, -0.2, rng.uniform(0.2, 0.9)))
    offset = tuple(float(error) for error in rng.normal(0.0, common, 2))
    return Scene(terrain, depths, tuple(clutter), camera, seed, math.radians(rng.normal(0.0, 0.3)), offset)


def random_ground(rng):
    """Random ground of 6 m, and the depth of each pit."""
    ground, depths = Terrain.level(float(rng.uniform(0.6, 1.2))), []
    boxes, pits = [], []
    while ground.x_end < 2.6:
        kind = rng.choice(["up", "down", "box", "pit", "ramp", "kerb", "drop"])
        x, room = ground.x_end, float(rng.uniform(0.5, 0.9))
        if kind in ("up", "down"):
            sign = 1.0 if kind == "up" else -1.0
            rise, tread = sign * float(rng.uniform(0.08, 0.19)), float(rng.uniform(0.25, 0.34))
            ground = ground + Terrain.stairs(int(rng.integers(2, 5)), riser=rise, tread=tread) + Terrain.level(0.3)
        elif kind in ("kerb", "drop"):
            rise = float(rng.uniform(0.02, 0.18)) * (1.0 if kind == "kerb" else -1.0)
            ground = ground + Terrain.level(room, rise=rise)
        elif kind == "box":
            length, height = float(rng.uniform(0.04, 0.30)), float(rng.uniform(0.03, 0.25))
            boxes.append(Obstacle(x, x + length, height))
            ground = ground + Terrain.level(length + room)
        elif kind == "pit":
            length = float(rng.uniform(0.08, 0.38))
            pits.append(Gap(x, x + length))
            depths.append(float(rng.uniform(0.05, 1.0)))
            ground = ground + Terrain.level(length + room)
        else:
            slope = math.radians(rng.uniform(4.0, 12.0)) * rng.choice([-1.0, 1.0])
            ground = ground + Terrain.ramp(float(rng.uniform(0.6, 1.2)), float(slope)) + Terrain.level(room)
    ground = ground + Terrain.level(6.0 - min(ground.x_end, 5.0))
    return ground.with_boxes(*boxes).with_pits(*pits), tuple(depths)


@dataclass(frozen=True)
class Edge:
    """A true edge beside what was seen of it; `off` is None where it was missed."""

    kind: str
    x: float
    rise: float
    off: float | None = None
    std: float = 0.0
    rise_off: float | None = None


@dataclass(frozen=True)
class Judged:
    """What of a scene was seen how well.

    Attributes:
        edges: true edges that the camera sees.
        heights: error and stated standard deviation of each height in [m]: of surfaces and boxes.
        fallen: true pits of which a part counts as ground.
        invented: boxes, pits and risers above 15 mm that are not there.
    """

    edges: tuple[Edge, ...]
    heights: tuple[tuple[float, float], ...]
    fallen: tuple[str, ...]
    invented: tuple[str, ...]


NEAR_ENOUGH = 0.06
LEAST_RISER = 0.015


def judge(scene, seen):
    """Compare a terrain that was seen with the true one."""
    truth, low = scene.terrain, float(scene.terrain.height_at(0.0))
    grid, visible = scene.visible()

    def sees(start, end, share=0.8):
        inside = (grid >= start) & (grid <= end)
        return bool(inside.any() and visible[inside].mean() >= share)

    wanted = []
    for surface, rise in zip(truth.surfaces[1:], truth.rises, strict=True):
        x = surface.x_start
        upper = sees(x + 0.005, x + 0.06) if rise > 0.0 else sees(x - 0.06, x - 0.005)
        lower = sees(x - 0.04, x - 0.005) if rise > 0.0 else sees(x, x + 0.5, 0.2)
        if abs(rise) > LEAST_RISER and upper and lower:
            wanted.append(("up" if rise > 0.0 else "down", x, rise))
    for box, top in zip(truth.boxes, truth.tops, strict=True):
        rear = box.x_end + box.height * (box.x_end - scene.camera.at[0]) / (scene.camera.at[1] - top)
        if sees(box.x_start - 0.04, box.x_start - 0.005) and sees(box.x_start, box.x_end) and sees(rear, rear + 0.1):
            wanted += [("box near", box.x_start, box.height), ("box far", box.x_end, -box.height)]
    for pit in truth.pits:
        if sees(pit.x_start - 0.06, pit.x_start - 0.005) and sees(pit.x_end + 0.005, pit.x_end + 0.06):
            wanted += [("pit near", pit.x_start, 0.0), ("pit far", pit.x_end, 0.0)]
    found = [("riser", s.x_start, r, s.edge_std) for s, r in zip(seen.surfaces[1:], seen.rises, strict=True)]
    for box in seen.boxes:
        found += [
            ("box near", box.x_start, box.height, box.edge_std),
            ("box far", box.x_end, -box.height, box.edge_std),
        ]
    for pit in seen.pits:
        kind = "unknown" if pit.unknown else "pit"
        found += [(f"{kind} near", pit.x_start, 0.0, pit.edge_std), (f"{kind} far", pit.x_end, 0.0, pit.edge_std)]
    edges, used = [], set()
    for kind, x, rise in wanted:
        if not 0.5 <= x <= 2.5:
            continue
        alike = [n for n, other in enumerate(found) if _alike(kind, rise, other) and abs(other[1] - x) < NEAR_ENOUGH]
        if not alike:
            edges.append(Edge(kind, x, rise))
            continue
        best = min(
            alike, key=lambda n: (found[n][0] == "riser" or found[n][0].startswith("unknown"), abs(found[n][1] - x))
        )
        used.add(best)
        off = found[best][1] - x
        edges.append(Edge(kind, x, rise, off, found[best][3], found[best][2] - rise if rise else None))
    heights = []
    for surface in seen.surfaces:
        middle = (max(surface.x_start, 0.0) + surface.x_end) / 2.0
        if not 0.3 < middle < 2.5:
            continue
        true = truth.surfaces[truth.surface_at(middle)]
        if true.x_start - NEAR_ENOUGH < surface.x_start and abs(true.slope - surface.slope) < 0.03:
            start = max(surface.x_start, 0.0)
            at = true.height + math.tan(true.slope) * (start - true.x_start) - low
            heights.append(
                (surface.height + math.tan(surface.slope) * (start - surface.x_start) - at, surface.height_std)
            )
    for edge in edges:
        for box in seen.boxes:
            if edge.kind == "box near" and abs(box.x_start - edge.x) < NEAR_ENOUGH:
                heights.append((box.height - edge.rise, box.height_std))
    fallen = [str(pit) for pit in truth.pits if pit.x_end < 2.6 and not _kept_from(seen, pit)]
    invented = []
    for kind, x, rise, _ in found:
        if kind.startswith("unknown") or x > 2.5 or (kind == "riser" and abs(rise) < LEAST_RISER):
            continue
        if x < grid[visible][0] + NEAR_ENOUGH:
            continue  # an edge before the first ground that is seen is told, and its place is unknown
        true = [s.x_start for s in truth.surfaces] + [
            e for s in (*truth.boxes, *truth.pits) for e in (s.x_start, s.x_end)
        ]
        if min(abs(t - x) for t in true) > NEAR_ENOUGH:
            invented.append(f"{kind} at {x:.3f} ({rise:.3f})")
    return Judged(tuple(edges), tuple(heights), tuple(fallen), tuple(invented))


def _alike(kind, rise, other):
    name, _, other_rise, _ = other
    if kind.startswith("pit"):
        return (name.endswith(kind[4:]) and not name.startswith("box")) or name == "riser"
    return rise * other_rise > 0.0


def _kept_from(seen, pit):
    """Whether no place of a pit, 20 mm off its edges, counts as ground."""
    for x in np.arange(pit.x_start + 0.02, pit.x_end - 0.019, 0.005):
        kept = any(p.x_start <= x <= p.x_end for p in (*seen.pits, *seen.boxes)) or x > seen.x_end
        if not kept:
            return False
    return True


def frames_of(scene, places, *, common):
    """The scene seen from where a walker is at each of `places` in [m], each frame told with an error of its own.

    Returns scenes that differ in camera, seed and errors; their origin stays that of the first.
    """
    rng = np.random.default_rng([scene.seed, 1])
    found = []
    for number, x in enumerate(places):
        ahead, up, across = scene.camera.at
        place = (ahead + x, up + float(scene.terrain.height_at(x)), across)
        offset = tuple(float(error) for error in rng.normal(0.0, common, 2))
        tilt = math.radians(rng.normal(0.0, 0.3))
        camera = replace(scene.camera, at=place)
        found.append(replace(scene, camera=camera, seed=scene.seed + 10_000 * (number + 1), tilt=tilt, offset=offset))
    return found
