"""What the tests of many gaits share: a grid of tasks, its rows, and what to compare rows by."""

from __future__ import annotations

import json
from functools import cache

import ggo_factors as ggo
from ggo_factors.sweeps.grid import Grid
from ggo_factors.sweeps.tasks import Row, generate_many

BASE = ggo.paper_base_gait(frames=21)
GRID = Grid(obstacle_x=(0.15, 0.20), obstacle_height=(0.04, 0.08, 0.12), thigh=(0.39, 0.41))


def told(rows: list[Row]) -> list[str]:
    """All that rows say but how long they took, bit for bit."""
    return [json.dumps({**row.to_json(), "milliseconds": 0.0}) for row in rows]


@cache
def grid_rows() -> list[Row]:
    """The rows of the grid, made one after the other."""
    return generate_many(GRID.tasks(BASE), BASE, workers=1)
