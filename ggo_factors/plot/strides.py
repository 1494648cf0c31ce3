"""A picture of an import: the strides that a base gait was made of."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.axes import Axes
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from ggo_factors.errors import InputError
from ggo_factors.plot.panels import (
    ANGLE_NAMES,
    ANGLE_TITLES,
    BASE_COLOUR,
    LEG_COLOURS,
    finish_panels,
    four_panels,
    legend_above_figure,
    lighter,
)
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
        column = number % 2 if level else number
        for leg in shown[number]:
            colour = LEG_COLOURS[leg]
            for item in (*report.refused, *report.used):
                curves = getattr(item, "angles", None) if level else getattr(item, "frames", None)
                if item.leg != leg or curves is None:
                    continue
                style = {"color": BASE_COLOUR, "ls": ":"} if item.reason else {"color": lighter(colour, 0.45)}
                percent = np.linspace(0.0, 100.0, len(curves))
                ax.plot(
                    percent, np.degrees(curves[:, column]), lw=0.6, gid="refused" if item.reason else "stride", **style
                )
            if leg in report.mean_cycle:
                mean, spread = (_closed(row[leg][:, column], level) for row in (report.mean_cycle, report.spread))
                percent = np.linspace(0.0, 100.0, len(mean))
                low, high = np.degrees(mean - spread), np.degrees(mean + spread)
                ax.fill_between(percent, low, high, color=colour, alpha=0.3, lw=0.0, zorder=2.5)
                ax.plot(percent, np.degrees(mean), color=colour, lw=2.2, zorder=3, gid="mean")
        ax.set_title(titles[number], fontsize="medium")
        ax.set_xlim(0.0, 100.0)
    finish_panels(panels, "stride [%]" if level else "step [%]", "angle [deg]")
    counts = report.strides_used
    handles: list[Line2D | Patch] = [
        Line2D([], [], color=LEG_COLOURS[leg], lw=2.2, label=f"{leg} mean, {counts[leg]} used") for leg in legs
    ]
    handles.append(Patch(facecolor="0.8", label="\u00b1 1 standard deviation"))
    if report.refused:
        handles.append(Line2D([], [], color=BASE_COLOUR, ls=":", lw=1.0, label=f"{len(report.refused)} refused"))
    legend_above_figure(panels, handles)
    return panels


def _closed(values: Array, cyclic: bool) -> Array:
    """A curve over a whole cycle, which stops short of its end, with its first value once more."""
    return np.append(values, values[0]) if cyclic else values
