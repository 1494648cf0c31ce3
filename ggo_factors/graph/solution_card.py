"""What a notebook shows of a graph and of its solution: the legs over what they must clear, and the graph's frames."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence

import numpy as np

from ggo_factors.graph.problem import Problem
from ggo_factors.motion.gait import Gait
from ggo_factors.motion.picture import STEP_LEGEND, Place, steps_picture
from ggo_factors.motion.terrain import LEVEL
from ggo_factors.notebook.card import card
from ggo_factors.notebook.svg import BASE, INK, PATH, SWING, Shape, Text, svg

STRIP, HIGH = 420, 46
"""Size of the picture of a graph's frames in pixels."""


def place_of(problem: Problem, gait: Gait) -> Place:
    """A gait on what a graph was asked to clear."""
    return Place(
        problem.model.joints(gait.frames),
        problem.model.foot,
        np.zeros(2),
        obstacles=[request.obstacle for request in problem.obstacles],
        ground=LEVEL if problem.ground is None else problem.ground.ground,
        foothold=next((end.foothold for end in problem.ends if end.foothold is not None), None),
    )


def solution_card(title: str, place: Place, problem: Problem, facts: Mapping[str, str | Sequence[str]]) -> str:
    """A card of a solution on its place, the base gait's path dashed."""
    picture = steps_picture([place], "the legs at some frames", problem.model.endpoint(problem.base.frames))
    return card(title, facts, picture, STEP_LEGEND | {"base gait": BASE})


def graph_card(title: str, problem: Problem, variables: Collection[int], costs: Mapping[str, float]) -> str:
    """A card of a graph: the base gait on what is asked for, and which frames are variables."""
    legs = steps_picture([place_of(problem, problem.base)], "the base gait at some frames")
    facts = {
        "variables": f"{len(variables)} of {len(problem.base)} frames",
        "anchored": ", ".join(f"frame {n}" for n in sorted(problem.anchors)),
        "boxes": [str(request.obstacle) for request in problem.obstacles],
        "ends": [_end(end.frame, end.foothold) for end in problem.ends],
        "smoothness": f"{problem.smoothness:g}",
        "constraints": "hard" if problem.hard else "edges that give way",
        "factors of your own": str(len(problem.own)) if problem.own else "",
        "cost": [f"{family} {cost:.4g}" for family, cost in costs.items() if cost],
    }
    legend = STEP_LEGEND | {"variable": PATH, "anchored": INK, "end": SWING}
    return card(title, facts, f"{legs}<br>{_strip(problem, variables)}", legend)


def _end(frame: int, foothold: tuple[float, float] | None) -> str:
    return f"frame {frame}" + ("" if foothold is None else f", foothold ({foothold[0]:.3f}, {foothold[1]:.3f}) m")


def _strip(problem: Problem, variables: Collection[int]) -> str:
    """The frames of a graph in a row: variables as dots, anchors and ends as bars, the rest on the line."""
    last = len(problem.base) - 1
    shapes = [Shape(np.array([[0.0, 0.0], [last, 0.0]]), INK, 1.0, 0.5)]
    marks = [(frame, PATH, 0.5, 6.0) for frame in sorted(variables)]
    marks += [(frame, INK, 1.0, 3.0) for frame in sorted(problem.anchors)]
    marks += [(end.frame, SWING, 1.0, 3.0) for end in problem.ends]
    for at, colour, high, width in marks:
        shapes.append(Shape(np.array([[at, -high], [at, high]]), colour, width))
    frame = np.array([[0.0, -2.5], [last, 1.2]])
    texts = [Text(0.0, -2.4, "frame 0"), Text(last, -2.4, f"frame {last}", "end")]
    label = f"{len(variables)} variables among {last + 1} frames"
    return svg(shapes, label, texts=texts, size=(STRIP, HIGH), frame=frame)
