"""A plan made by hand, in closed form: what a solver finds differs in its last digits from platform to platform."""

from __future__ import annotations

import math

import numpy as np
from test_plot import two_steps

from ggo_factors.motion.surface import Surface
from ggo_factors.motion.terrain import Gap, Obstacle
from ggo_factors.motion.world import Terrain
from ggo_factors.planning.plan import Plan
from ggo_factors.planning.whynot import Ban

AT = 1.0
SLOPE = 0.1
WORDS = "swing ankle 12.0 mm into obstacle [1.1, 1.16] m"


def made_terrain() -> Terrain:
    """Level, a kerb that was measured, a ramp; a box and two pits, one of each measured or on the ramp."""
    kerb = Surface(0.9, 2.0, 0.0, 0.0, 0.004, 0.003)
    up = (Surface(0.0, 0.9, -0.05), kerb, Surface(2.0, 3.0, 0.0, SLOPE), Surface(3.0, 3.4, math.tan(SLOPE)))
    boxes = Obstacle(1.1, 1.16, 0.08, edge_std=0.005, height_std=0.004), Obstacle(2.5, 2.6, 0.05)
    return Terrain(up, boxes, (Gap(1.5, 1.7, edge_std=0.006), Gap(2.2, 2.4)), name="made by hand")


def made_plan(**given: object) -> Plan:
    """Two steps of the base gait over that terrain, from `AT`."""
    walk = two_steps()
    places = AT + (walk.origins() + [gait.endpoints()[-1] for gait in walk.gaits])[:, 0]
    parts: dict[str, object] = {
        "terrain": made_terrain(),
        "at": AT,
        "footholds": tuple(places.tolist()),
        "costs": (0.004, 0.002),
        "expected": (0.003, 0.0025),
        "considered": tuple(np.round(np.arange(1.2, 1.45, 0.05), 2).tolist()),
        "banned": (Ban(0.6, 1.0, 1.25, WORDS), Ban(0.6, 1.0, 1.275, "too far"), Ban(1.0, 1.39, 1.9, "no gait")),
        "walk": walk,
        "goal": float(places[-1]),
        "to_standing": False,
        **given,
    }
    return Plan(**parts)  # type: ignore[arg-type]
