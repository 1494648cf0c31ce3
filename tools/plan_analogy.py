"""Chapters (j) and (k) of `pgo_analogy.py`: data association in a pose graph, and the choice of footholds on a course.

    pose graph                                 plan of a walk
    ----------------------------------------   --------------------------------------------------------------------
    variable    d(k): which door stop k sees   f(n): which foothold step n takes
    candidate   every door: they look alike    every place where a sole fits and a leg reaches
    cost        error of the pose graph        error of the gait graph of the step, from how both feet stand before
                between two closures           it to how they stand after it
    factor      on d(k-1), d(k)                on f(n-2), f(n-1), f(n)
    optimum     elimination of a gtsam.DiscreteFactorGraph, the same function for both
    then        the pose graph is solved with  the footholds slide; the steps are made and checked; one that is refused
                the doors chosen               is banned, and the choice made again

Neither is a choice that the continuous graph can make: a door is this one or that one, a foot stands before the box or
beyond it. Between two sure closures a chain of motions has a cost of its own, whatever lies beyond them, so that the
cost of all is a sum over neighbours. A step is such a chain between two touchdown postures.
"""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from unittest.mock import patch

import click
import gtsam
import numpy as np
from chapters import OUT, tell_and_draw
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from pgo_analogy import (
    BASE,
    CLOSURE_NOISE,
    FAMILIES,
    MOTIONS,
    TRUE_MOTION,
    Edge,
    Numbers,
    dead_reckoning,
    distances,
    draw_path,
    finish_map,
    hard,
    pose_key,
    pose_path,
    show,
    solved,
)
from rival_footholds import Way, greedy

import ggo_factors as ggo
from ggo_factors.cli.console import console
from ggo_factors.planning import search as planner
from ggo_factors.planning.choice import chosen, cost_of, foothold_graph
from ggo_factors.plot import BASE_COLOUR, PATH_COLOUR, plot_plan
from ggo_factors.support.inputs import Array

STOPS = (4, 8, 12, 16)
"""Motions after which the robot sees a door."""
DOORS = 16
SPREAD = np.array([0.1, 0.1, 0.05])
"""Standard deviations of the odometer in each motion: x and y in [m], heading in [rad]."""
DRIVES, SHOWN = 100, 49
"""Drives with other noise, and the one in the picture: one by one, its doors are wrong."""
TRUTH = dead_reckoning([TRUE_MOTION] * MOTIONS)
TERRAIN = (ggo.Terrain.level(1.9) + ggo.Terrain.level(2.0, rise=0.12)).with_boxes(ggo.Obstacle(0.60, 0.66, 0.10))
COURSE = TERRAIN.with_pits(ggo.Gap(1.3, 1.6))
GOAL = 2.4
ONE_BY_ONE = FAMILIES["closure"][0]
"""Colour of what is chosen one by one."""


# -- choices ----------------------------------------------------------------------------------------------------------


@dataclass(frozen=True, eq=False)
class Choice:
    """A discrete problem, as `planning.choice` takes it.

    Attributes:
        places: where the candidates of each variable are in [m], for the picture.
        tables: costs, see `planning.choice.foothold_graph`.
    """

    places: Sequence[Array]
    tables: Sequence[Array]

    @property
    def counts(self) -> list[int]:
        """How many candidates each variable has."""
        return [len(places) for places in self.places]

    def one_by_one(self) -> list[int]:
        """The candidate of each variable that is cheapest after those before it."""
        taken: list[int] = []
        for table in self.tables:
            behind = taken[len(taken) - table.ndim + 1 :]
            taken.append(int(table[tuple(behind)].argmin()))
        return taken

    def every_cost(self) -> Array:
        """What every choice there is costs, one axis for each variable."""
        total = np.zeros(self.counts)
        for last, table in enumerate(self.tables):
            axes = range(last - table.ndim + 1, last + 1)
            total = total + table.reshape([n if axis in axes else 1 for axis, n in enumerate(self.counts)])
        return total

    def told(self, name: str, choice: Sequence[int], milliseconds: float) -> tuple[str, ...]:
        """A row of the table of both graphs."""
        graph = foothold_graph(self.tables, self.counts, cost_of(self.tables, choice))
        most = max(table.ndim for table in self.tables)
        every = self.every_cost()
        listed = f"{cost_of(self.tables, choice):.5g}", f"{every.min():.5g}"
        sizes = str(len(self.counts)), str(max(self.counts)), str(graph.size()), str(most)
        return (name, *sizes, f"{every.size:,}", *listed, f"{milliseconds:.1f}")


HEADINGS = ("graph", "variables", "candidates", "factors", "variables of one", "choices", "cost", "least of all", "ms")


# -- doors ------------------------------------------------------------------------------------------------------------


@dataclass(frozen=True, eq=False)
class Drive:
    """Once around the ring.

    Attributes:
        odometry: the motions as they were measured.
        stops: where the robot stands at each stop, for each door that it may see.
        doors: which door it sees.
    """

    odometry: list[gtsam.Pose2]
    stops: list[list[gtsam.Pose2]]
    doors: list[int]


def on_ring(turn: float) -> gtsam.Pose2:
    """A pose on the ring after a share of the way around it."""
    return gtsam.Pose2.Expmap(turn * MOTIONS * gtsam.Pose2.Logmap(TRUE_MOTION))


def doors() -> Array:
    """Where the doors are, as shares of the way around, shape (DOORS,): no two gaps between them are alike."""
    gaps = np.random.default_rng(0).uniform(0.4, 1.6, DOORS)
    return np.asarray(np.cumsum(gaps) / gaps.sum())


def drive(seed: int) -> Drive:
    """A drive with the noise of a seed: at each stop the robot measures where it stands before the nearest door."""
    rng = np.random.default_rng(seed)
    odometry = [TRUE_MOTION.compose(gtsam.Pose2(*error)) for error in rng.normal(size=(MOTIONS, 3)) * SPREAD]
    places, stops, seen = [on_ring(turn) for turn in doors()], [], []
    for stop in STOPS:
        stands = TRUTH.atPose2(pose_key(stop))
        far = [float(np.linalg.norm(stands.between(place).translation())) for place in places]
        seen.append(int(np.argmin(far)))
        measured = stands.between(places[seen[-1]]).compose(gtsam.Pose2(*rng.normal(scale=0.01, size=3)))
        stops.append([place.compose(measured.inverse()) for place in places])
    return Drive(odometry, stops, seen)


def joined(motions: Sequence[gtsam.Pose2]) -> tuple[gtsam.Pose2, Array]:
    """Motions as one, with its covariance, shape (3, 3): preintegrated odometry."""
    pose, covariance = gtsam.Pose2(), np.zeros((3, 3))
    for motion in motions:
        adjoint = motion.inverse().AdjointMap()
        covariance = adjoint @ covariance @ adjoint.T + np.diag(SPREAD**2)
        pose = pose.compose(motion)
    return pose, covariance


def doors_of(drive: Drive) -> Choice:
    """Which doors they were: the cost of each pair of neighbours is that of the odometry between them."""
    tables, before = list[Array](), [gtsam.Pose2()]
    for number, (first, last) in enumerate(zip((0, *STOPS), STOPS, strict=False)):
        motion, covariance = joined(drive.odometry[first:last])
        weight = np.linalg.inv(covariance)
        errors = np.array([[motion.localCoordinates(a.between(b)) for b in drive.stops[number]] for a in before])
        cost = 0.5 * np.einsum("abi,ij,abj->ab", errors, weight, errors)
        tables.append(cost if number else cost[0])
        before = drive.stops[number]
    return Choice([2.0 * np.pi * radius() * doors()] * len(STOPS), tables)


def radius() -> float:
    """Of the ring in [m]."""
    return MOTIONS * float(np.linalg.norm(TRUE_MOTION.translation())) / (2.0 * np.pi)


def nearest(drive: Drive) -> list[int]:
    """The doors that are nearest by odometry alone."""
    path, found = dead_reckoning(drive.odometry), []
    for stop, stands in zip(STOPS, drive.stops, strict=True):
        pose = path.atPose2(pose_key(stop))
        found.append(int(np.argmin([np.linalg.norm(pose.between(place).translation()) for place in stands])))
    return found


def closed(drive: Drive, seen: Sequence[int]) -> tuple[Array, float]:
    """The pose graph solved with the doors that were chosen: its path in [m], shape (n, 2), and its error."""
    edges: list[Edge] = [("anchor", gtsam.PriorFactorPose2(pose_key(0), gtsam.Pose2(), hard(3)))]
    noise = gtsam.noiseModel.Diagonal.Sigmas(SPREAD)
    for n, motion in enumerate(drive.odometry):
        edges.append(("motion", gtsam.BetweenFactorPose2(pose_key(n), pose_key(n + 1), motion, noise)))
    for stop, stands, door in zip(STOPS, drive.stops, seen, strict=True):
        edges.append(("closure", gtsam.PriorFactorPose2(pose_key(stop), stands[door], CLOSURE_NOISE)))
    values = solved(edges, dead_reckoning(drive.odometry))
    return pose_path(values), sum(float(factor.error(values)) for _, factor in edges)


def j_doors_that_look_alike(map_ax: Axes, ways_ax: Axes) -> Numbers:
    """(j) Pose graph: doors that look alike. Which one is it, at each of four stops?"""
    right = {"nearest by odometry alone": 0, "one by one": 0, "all together": 0}
    for seed in range(DRIVES):
        some = drive(seed)
        choice = doors_of(some)
        single = choice.one_by_one()
        for name, seen in zip(
            right, (nearest(some), single, chosen(choice.tables, choice.counts, single)), strict=True
        ):
            right[name] += seen == some.doors
    shown = drive(SHOWN)
    choice, single = doors_of(shown), doors_of(shown).one_by_one()
    began = time.perf_counter()
    together = chosen(choice.tables, choice.counts, single)
    spent = 1e3 * (time.perf_counter() - began)
    show(HEADINGS, [choice.told("doors", together, spent)], "Elimination finds the least of all choices there are.")
    true = pose_path(TRUTH)
    answers = {"nearest by odometry alone": nearest(shown), "one by one": single, "all together": together}
    solutions = {name: closed(shown, seen) for name, seen in answers.items()}
    rows = []
    for name, seen in answers.items():
        path, error = solutions[name]
        count = sum(a == b for a, b in zip(seen, shown.doors, strict=True))
        expected, off = cost_of(choice.tables, seen), distances(path, true).mean()
        rows.append((name, f"{right[name]} of {DRIVES}", f"{count} of {len(STOPS)}", *_numbers(expected, error, off)))
    show(
        ("doors chosen", "drives all right", "this drive", "cost by the tables", "error of the pose graph", "off by m"),
        rows,
        "Costs by the tables are of closures that are exact, and of motions joined to first order. One by one goes\n"
        "far here, since a door that was right is a sure place to go on from. All together is still wrong in\n"
        f"{DRIVES - right['all together']} drives of {DRIVES}: the noise made other doors the likelier ones there.",
    )
    draw_path(map_ax, true, "truth", BASE_COLOUR, "--")
    draw_path(map_ax, solutions["one by one"][0], "doors one by one", ONE_BY_ONE)
    draw_path(map_ax, solutions["all together"][0], "doors all together", PATH_COLOUR)
    places = np.stack([on_ring(turn).translation() for turn in doors()])
    map_ax.plot(*places.T, "ks", ms=6, mfc="w", ls="none", label="doors")
    finish_map(map_ax)
    draw_ways(ways_ax, choice, {"truth": shown.doors, "one by one": single, "all together": together})
    ways_ax.set(xlabel="stop", ylabel="door, way along the ring [m]")
    return {
        **right,
        "cost": cost_of(choice.tables, together),
        "least": float(choice.every_cost().min()),
        "error": solutions["all together"][1],
        "error_single": solutions["one by one"][1],
        "off": float(distances(solutions["all together"][0], true).mean()),
        "off_single": float(distances(solutions["one by one"][0], true).mean()),
    }


def _numbers(*values: float) -> tuple[str, ...]:
    return tuple(f"{value:.3f}" for value in values)


# -- footholds --------------------------------------------------------------------------------------------------------


def overheard() -> tuple[ggo.Plan, list[Choice]]:
    """A plan over the course, and the choices that were made for it, in their order."""
    heard: list[Choice] = []
    options: list[Sequence[Array]] = []
    original = planner.Search._chosen

    def asked(search: planner.Search, places: Sequence[Array], *given: Any) -> Any:
        options.append(places)
        return original(search, places, *given)

    def listens(tables: Sequence[Array], counts: Sequence[int], known: Sequence[int]) -> list[int]:
        heard.append(Choice(options[-1], tables))
        return chosen(tables, counts, known)

    with patch.object(planner.Search, "_chosen", asked), patch.object(planner, "chosen", listens):
        plan = ggo.plan_walk(BASE, COURSE, goal=GOAL)
    return plan, heard


def k_footholds(course_ax: Axes, ways_ax: Axes) -> Numbers:
    """(k) Plan of a walk: places where a foot may stand. Which one is it, for each of seven steps?"""
    plan, heard = overheard()
    rows, answers = [], list[list[int]]()
    for name, choice in zip(("footholds, around a way", "footholds, around these"), heard, strict=True):
        began = time.perf_counter()
        answers.append(chosen(choice.tables, choice.counts, _cheapest(choice)))
        rows.append(choice.told(name, answers[-1], 1e3 * (time.perf_counter() - began)))
    show(
        HEADINGS,
        rows,
        "How many steps there are, a pass through all pairs of places says first: there are as many doors as stops,\n"
        "but steps may be more or fewer. The factor graph then chooses among places around that way, twice.",
    )
    feet, arrived = greedy(Way(COURSE, BASE), GOAL)
    single = [*feet.footholds()]
    show(
        ("footholds chosen", "steps", "cost by the tables", "error of the gait graphs", "last foothold m"),
        [
            ("nearest to the own stride, one by one", str(len(single)), "", f"{feet.cost():.4f}", f"{single[-1]:.3f}"),
            (
                "all together",
                str(len(plan.footholds)),
                f"{sum(plan.expected):.4f}",
                f"{plan.cost:.4f}",
                f"{plan.footholds[-1]:.3f}",
            ),
        ],
        "One by one the walker comes to where no next step is possible, as a robot takes a door that no later one\n"
        "agrees with. But no foothold is the true one, as a door is: any that can be walked will do, and costs decide.",
    )
    plot_plan(plan, ax=course_ax)
    legend = course_ax.get_legend()
    if legend is not None:
        legend.remove()
    height = COURSE.height_at(single)
    course_ax.plot(single, height, "s", color="k", mfc="none", ms=9, ls="none", label="one by one")
    named = {label: handle for handle, label in zip(*course_ax.get_legend_handles_labels(), strict=True)}
    entries = ("one by one", "foothold chosen", "foothold considered")
    course_ax.legend([named[name] for name in entries], entries, fontsize=8, frameon=False, ncols=3, loc="upper left")
    draw_ways(ways_ax, heard[0], {"all together": answers[0]})
    ways_ax.set(xlabel="step", ylabel="foothold, x [m]")
    return {
        "cost": cost_of(heard[-1].tables, answers[-1]),
        "least": float(heard[-1].every_cost().min()),
        "cost_grid": cost_of(heard[0].tables, answers[0]),
        "least_grid": float(heard[0].every_cost().min()),
        "expected": float(sum(plan.expected)),
        "error": plan.cost,
        "arrived": float(arrived),
        "error_single": feet.cost(),
        "most": float(max(table.ndim for table in heard[0].tables)),
    }


def _cheapest(choice: Choice) -> list[int]:
    """A choice that is possible: the one in the middle, or else the one by one."""
    middle = [count // 2 for count in choice.counts]
    return middle if np.isfinite(cost_of(choice.tables, middle)) else choice.one_by_one()


# -- all of it --------------------------------------------------------------------------------------------------------


def draw_ways(ax: Axes, choice: Choice, answers: dict[str, Sequence[int]]) -> None:
    """Candidates of each variable, dark where some cheap choice takes them, and choices as lines through them."""
    every = choice.every_cost()
    least, columns = float(every.min()), np.arange(1, len(choice.counts) + 1)
    for axis, places in enumerate(choice.places):
        others = tuple(n for n in range(every.ndim) if n != axis)
        more = every.min(axis=others) - least
        # The scale is the graph's own: by as much as its cheapest choice costs, a candidate is grey.
        shade = np.exp(-np.minimum(more, 700.0 * least) / least)
        for place, dark, good in zip(places, shade, np.isfinite(more), strict=True):
            colour = str(0.9 * (1.0 - dark)) if good else "w"
            ax.plot(columns[axis], place, "o", color=colour, mec="0.7", ms=7, ls="none")
    looks = {"truth": (BASE_COLOUR, "--"), "one by one": (ONE_BY_ONE, "-"), "all together": (PATH_COLOUR, "-")}
    for name, taken in answers.items():
        colour, style = looks[name]
        line = [column[n] for column, n in zip(choice.places, taken, strict=True)]
        ax.plot(columns, line, style, color=colour, lw=2.0, label=name)
    ax.set_xticks(columns)
    ax.legend(fontsize=8, frameon=False, loc="upper left")


TITLES = (
    "(j) pose graph: doors that look alike",
    "(k) plan: footholds on a course",
    "(j) doors: dark where a cheap choice takes them",
    "(k) footholds on a grid: many are nearly as cheap",
)


def run(figure: Figure) -> dict[str, Numbers]:
    """Print both chapters, and draw the world above, the candidates below."""
    axes = figure.subplots(2, 2)
    numbers = {}
    for part, panels in ((j_doors_that_look_alike, axes[:, 0]), (k_footholds, axes[:, 1])):
        console().rule(f"[bold]{(part.__doc__ or '').splitlines()[0]}", align="left")
        numbers[part.__name__[0]] = part(*panels)
    for ax, title in zip(axes.flat, TITLES, strict=True):
        ax.set_title(title, loc="left", fontsize=10)
    return numbers


@click.command()
@OUT
def main(out: Path) -> None:
    """Data association and the choice of footholds: tables on the screen and one figure, plan_analogy.png."""
    tell_and_draw(__doc__, run, (13.0, 9.0), out / "plan_analogy.png")


if __name__ == "__main__":
    main()
