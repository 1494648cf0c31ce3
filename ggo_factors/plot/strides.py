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
from ggo_factors.plot.titles import short_name
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
        for leg in shown[number]:
            _draw_leg(ax, report, leg, number % 2 if level else number)
        ax.set_title(titles[number], fontsize="medium")
        ax.set_xlim(0.0, 100.0)
    finish_panels(panels, "stride [%]" if level else "step [%]", "angle [deg]")
    show_legend(panels)
    if axes is None:
        name_figure(panels, _title(report))
    return panels


def _draw_leg(ax: Axes, report: ImportReport, leg: str, column: int) -> None:
    """One angle of one leg: its strides, those that were refused, and their mean with its band."""
    level, colour = report.activity == "level", LEG_COLOURS[leg]
    if leg in report.mean_cycle:
        mean, spread = (_closed(row[leg][:, column], level) for row in (report.mean_cycle, report.spread))
        percent, called = np.linspace(0.0, 100.0, len(mean)), f"{leg} mean, {report.strides_used[leg]} used"
        ax.plot(percent, np.degrees(mean), color=colour, lw=2.2, zorder=3, gid="mean", label=called)
    for item in (*report.refused, *report.used):
        curves = getattr(item, "angles", None) if level else getattr(item, "frames", None)
        if item.leg != leg or curves is None:
            continue
        percent, degrees = np.linspace(0.0, 100.0, len(curves)), np.degrees(curves[:, column])
        if item.reason:
            called = f"{len(report.refused)} refused"
            ax.plot(percent, degrees, color=BASE_COLOUR, ls=":", lw=0.8, gid="refused", label=called)
        else:
            ax.plot(percent, degrees, color=lighter(colour, 0.45), lw=0.6, gid="stride", label="one stride")
    if leg in report.mean_cycle:
        percent, low, high = np.linspace(0.0, 100.0, len(mean)), mean - spread, mean + spread
        style: dict[str, Any] = {"color": colour, "alpha": 0.3, "lw": 0.0, "zorder": 2.5, "gid": "spread"}
        ax.fill_between(percent, np.degrees(low), np.degrees(high), label="\u00b1 1 standard deviation", **style)


def _title(report: ImportReport) -> str:
    """Which recording, what was walked, the strides in it."""
    used, refused = sum(report.strides_used.values()), len(report.refused)
    what = "level walk" if report.activity == "level" else report.activity.replace("-", " ")
    return f"Base gait from {short_name(report.source)}\n{what}, {used} strides used, {refused} refused"


def _closed(values: Array, cyclic: bool) -> Array:
    """A curve over a whole cycle, which stops short of its end, with its first value once more."""
    return np.append(values, values[0]) if cyclic else values
