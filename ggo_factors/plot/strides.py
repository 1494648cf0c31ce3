"""A picture of an import: the strides that a base gait was made of."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.axes import Axes

from ggo_factors.errors import InputError
from ggo_factors.plot.panels import (
    ANGLE_NAMES,
    ANGLE_TITLES,
    BASE_COLOUR,
    LEG_COLOURS,
    finish_panels,
    four_panels,
    lighter,
    name_figure,
    show_legend,
)
from ggo_factors.plot.titles import file_name
from ggo_factors.support.inputs import Array

if TYPE_CHECKING:
    from ggo_factors.recording.report import ImportReport


def plot_import(report: ImportReport, *, axes: Axes | Sequence[Axes] | None = None) -> tuple[Axes, ...]:
    """What a base gait was made of: every stride thin, their mean thick, one standard deviation shaded.

    Level strides in a panel for each joint and leg, from heel strike to heel strike; stair swings in a panel for each
    angle, both legs in it. Strides that were refused are dotted.

    Args:
        report: what the import found.
        axes: four axes to draw on; a new figure by default.

    Raises:
        InputError: where `axes` are not four.
    """
    panels = four_panels(axes)
    if len(panels) != 4:
        raise InputError(f"axes: expected four, got {len(panels)}")
    level = report.activity == "level"
    legs = [leg for leg in LEG_COLOURS if leg in report.mean_cycle]
    shown = [(leg,) for leg in LEG_COLOURS for _ in range(2)] if level else [tuple(legs)] * 4
    if level:
        titles = [f"{leg} {joint}" for leg in LEG_COLOURS for joint in ("thigh", "knee")]
    else:
        titles = [f"{title} {name}" for title, name in zip(ANGLE_TITLES, ANGLE_NAMES, strict=True)]
    for number, ax in enumerate(panels):
        # The mean first, as in the legend.
        for draw in (_draw_mean, _draw_strides):
            for leg in shown[number]:
                draw(ax, report, leg, number % 2 if level else number)
        ax.set_title(titles[number], fontsize="medium")
        ax.set_xlim(0.0, 100.0)
    finish_panels(panels, "stride [%]" if level else "step [%]", "angle [deg]")
    show_legend(panels)
    if axes is None:
        name_figure(panels, _title(report))
    return panels


def _draw_mean(ax: Axes, report: ImportReport, leg: str, column: int) -> None:
    """The mean of one angle of one leg with its band."""
    if leg not in report.mean_cycle:
        return
    level, colour = report.activity == "level", LEG_COLOURS[leg]
    mean, spread = (np.degrees(_closed(row[leg][:, column], level)) for row in (report.mean_cycle, report.spread))
    percent, called = np.linspace(0.0, 100.0, len(mean)), f"{leg} mean, {report.strides_used[leg]} used"
    ax.plot(percent, mean, color=colour, lw=2.2, zorder=3, gid="mean", label=called)
    style: dict[str, Any] = {"color": colour, "alpha": 0.45, "lw": 0.0, "zorder": 2.5, "gid": "spread"}
    ax.fill_between(percent, mean - spread, mean + spread, label="\u00b1 1 standard deviation", **style)


def _draw_strides(ax: Axes, report: ImportReport, leg: str, column: int) -> None:
    """One angle of one leg in its strides, and in those that were refused."""
    for item in (*report.refused, *report.used):
        curves = getattr(item, "angles" if report.activity == "level" else "frames", None)
        if item.leg != leg or curves is None:
            continue
        percent, degrees = np.linspace(0.0, 100.0, len(curves)), np.degrees(curves[:, column])
        if item.reason:
            called = f"{len(report.refused)} refused"
            ax.plot(percent, degrees, color=BASE_COLOUR, ls=":", lw=0.8, gid="refused", label=called)
        else:
            colour = lighter(LEG_COLOURS[leg], 0.35)
            ax.plot(percent, degrees, color=colour, lw=0.6, gid="stride", label="one stride")


def _title(report: ImportReport) -> str:
    """Which recording, what was walked, the strides in it."""
    used, refused = sum(report.strides_used.values()), len(report.refused)
    what = "level walk" if report.activity == "level" else report.activity.replace("-", " ")
    return f"Base gait from {file_name(report.source)}\n{what}, {used} strides used, {refused} refused"


def _closed(values: Array, cyclic: bool) -> Array:
    """A curve over a whole cycle, which stops short of its end, with its first value once more."""
    return np.append(values, values[0]) if cyclic else values
