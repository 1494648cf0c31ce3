"""What the command line and the tools show in a terminal: tables and a progress bar."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager

import numpy as np
from rich.console import Console
from rich.progress import Progress
from rich.table import Table
from rich.text import Text

from ggo_factors.evaluate.comfort import RATES, Comfort
from ggo_factors.evaluate.likeness import PARTS, STYLED, Comparison
from ggo_factors.evaluate.summary import JOINTS, StepSummary
from ggo_factors.recording.log.inspect import LogSummary
from ggo_factors.support.files import printable

PIPE_WIDTH = 140
"""Characters a line where the output is no terminal."""

ZMP_NOTE = """\
ZMP: where the ground's push acts, from the supporting ankle, by the paper's equation without a trunk. It is no check:
where the legs together fall nearly freely the point runs off by metres, and the mean with it. Balance edges (--balance)
hold it to the base gait's."""
"""What stands under the numbers of balance: metres beside a verdict of ok have startled users."""


def console() -> Console:
    """A console as wide as the terminal, or wide enough for every table where there is none."""
    return Console(width=None if sys.stdout.isatty() else PIPE_WIDTH, highlight=False)


@contextmanager
def progress_bar(what: str) -> Iterator[Callable[[float], None] | None]:
    """Hand out a function that takes the share done, 0 to 1; None where stderr is no terminal."""
    if not sys.stderr.isatty():
        yield None
        return
    with Progress(console=Console(stderr=True), transient=True) as progress:
        task = progress.add_task(what, total=1.0)
        yield lambda part: progress.update(task, completed=part)


def summary_table(rows: Iterable[StepSummary], title: str | None = None) -> Table:
    """The lines as a `rich` table.

    With the time of each step where one was slowed, the probability of a hit where an obstacle was measured with an
    error, and the ZMP's distance from the base gait's where balance was asked for.
    """
    rows, table = list(rows), _table(title)
    table.add_column("step", no_wrap=True)
    hits = ["hit\n "] if any(row.hit_probability for row in rows) else []
    balanced = ["ZMP off\nmm"] if any(row.zmp_off_mm is not None for row in rows) else []
    slow = ["time\ns"] if any((row.slowdown or 1.0) > 1.0 + 1e-9 for row in rows) else []
    headings = ("iter", "ms", *slow, "foot\nmm", "clear\nmm", *hits, "ground\nmm", "axes\nmm", "lands\nm/s", *balanced)
    for heading in (*headings, "knee\ndeg"):
        table.add_column(heading, justify="right", no_wrap=True)
    for joint in JOINTS:
        table.add_column(f"{joint}\ndeg", justify="right", no_wrap=True)
    table.add_column("verdict", overflow="fold")
    for row in rows:
        change = row.change_deg or (None,) * len(JOINTS)
        table.add_row(
            Text(row.name),
            "" if row.iterations is None else str(row.iterations),
            _cell(row.milliseconds, 0),
            *(_cell(row.duration_s, 3) for _ in slow),
            _cell(row.foothold_error_mm, 2),
            _cell(row.clearance_mm, 1),
            *("" if row.hit_probability is None else f"{row.hit_probability:.0e}" for _ in hits),
            _cell(row.ground_clearance_mm, 1),
            _cell(row.axis_clearance_mm, 0),
            _cell(row.landing_speed_m_s, 2),
            *(_cell(row.zmp_off_mm, 1) for _ in balanced),
            _cell(row.knee_deg, 2),
            *(_cell(value, 2) for value in change),
            Text("; ".join((row.verdict, *row.notes)), style="green" if row.ok else "red"),
        )
    return table


def comfort_tables(comforts: Iterable[Comfort]) -> Iterator[Table | Text]:
    """How the joints of several gaits move, one gait under the other, and their other comfort numbers."""
    rates = _table("comfort: peak and root mean square of each joint")
    for heading in ("gait", "joint"):
        rates.add_column(heading, no_wrap=True)
    for rate, unit in RATES.items():
        for kind in ("peak", "rms"):
            rates.add_column(f"{rate}\n{kind}\n{unit}", justify="right", no_wrap=True)
    others = _table(None)
    others.add_column("gait", no_wrap=True)
    zmp = ("mean |ZMP|\nmm", "ZMP off base\nmean mm", "ZMP off base\nlargest mm")
    for heading in (*zmp, "mean change\ndeg", "clear\nmm", "leg clear\nmm"):
        others.add_column(heading, justify="right", no_wrap=True)
    for made in comforts:
        for column, joint in enumerate(made.joints):
            pairs = zip(np.degrees(made.peaks[:, column]), np.degrees(made.rms[:, column]), strict=True)
            rates.add_row(Text(made.name), joint, *(_cell(value, 0) for pair in pairs for value in pair))
        others.add_row(Text(made.name), *(_cell(value, 1) for value in made.others().values()))
    yield rates
    yield others
    yield Text(ZMP_NOTE)


def comparison_lines(made: Comparison) -> Iterator[Table | Text]:
    """How far each method's gaits are from the person's steps, and what should be known about the numbers."""
    every, counted = len(made.steps), len(made.counted)
    table = _table(
        f"{made.source}, {made.activity}: {counted} of {every} steps; base gait {made.base or 'without a name'}; "
        "RMSE in degrees"
    )
    table.add_column("method", no_wrap=True)
    headings = ("refused\n ", "all\n ", "by no\nchange", *(f"{joint}\n " for joint in JOINTS))
    for heading in (*headings, *(part.replace("_", "\n") for part in PARTS), "foot\nmm"):
        table.add_column(heading, justify="right", no_wrap=True)
    for method in made.methods:
        refused = sum(made.refusals(method).values())
        numbers = (*made.by_joint_deg(method).tolist(), *made.by_part_deg(method).tolist())
        table.add_row(
            method.replace("_", " "),
            str(refused) if refused else "",
            _cell(made.rmse_deg(method), 2),
            _cell(made.ratio(method), 3),
            *(_cell(number, 2) for number in numbers),
            _cell(made.foothold_off(method) * 1e3, 1),
        )
    yield table
    lines = [
        f"{method.replace('_', ' ')}: {number} refused: {reason}"
        for method in made.methods
        for reason, number in made.refusals(method).items()
    ]
    if made.style is not None:
        lines.append(f"{STYLED.replace('_', ' ')}: with a style of {made.style.steps} steps")
    elif made.why_no_style:
        lines.append(f"{STYLED.replace('_', ' ')}: not there: {made.why_no_style}")
    if made.from_ground:
        lines.append(f"not compared, as they start from the ground: {made.from_ground} stair swings")
    if made.knees_raised:
        raised = np.degrees(made.knees_raised)
        lines.append(
            f"all knees, the person's and the base gait's, are raised by {raised:.1f} degrees: some bent backwards"
        )
    if lines:
        yield Text("\n".join(printable(line) for line in lines))


def log_tables(summary: LogSummary) -> Iterator[Table | Text]:
    """What a log holds: its topics, the joints in them, and what was decided or lost."""
    topics = _table(f"{summary.source}: {summary.size_bytes / 1e6:.2f} MB, {summary.duration_s:.2f} s")
    for heading in ("topic", "type", "encoding"):
        topics.add_column(heading, overflow="fold")
    for heading in ("messages", "Hz", "s"):
        topics.add_column(heading, justify="right", no_wrap=True)
    topics.add_column("problem", overflow="fold")
    for t in summary.topics:
        count = f"{t.count}" if t.expected in (None, t.count) else f"{t.count} of {t.expected}"
        numbers = (count, f"{t.rate_hz:.4g}", f"{t.duration_s:.2f}")
        topics.add_row(
            *(Text(printable(word)) for word in (t.topic, t.message_type or "-", t.encoding, *numbers, t.problem))
        )
    yield topics
    joints = _table(None)
    for heading in ("joint", "topic", "looks like"):
        joints.add_column(heading, overflow="fold")
    for heading in ("1 %", "99 %", "missing"):
        joints.add_column(heading, justify="right", no_wrap=True)
    for j in summary.joints:
        numbers = (_cell(j.low, 3), _cell(j.high, 3), str(j.missing) if j.missing else "")
        joints.add_row(*(Text(printable(word)) for word in (j.name, j.topic, j.looks_like, *numbers)))
    if summary.joints:
        yield joints
    lines = [f"import takes {summary.topic or 'no topic: it has to be told'}"]
    lines.append(f"unit {summary.unit_guess or 'not known'}: {summary.unit_why}")
    lines += [f"lost: {loss}" for loss in summary.losses]
    yield Text("\n".join(printable(line) for line in [*lines, *summary.notes]))


def _table(title: str | None) -> Table:
    return Table(
        title=None if title is None else Text(title, "bold"),
        title_justify="left",
        header_style="bold",
        pad_edge=False,
        box=None,
    )


def _cell(value: float | None, digits: int) -> str:
    return "" if value is None else f"{round(value, digits) + 0.0:.{digits}f}"
