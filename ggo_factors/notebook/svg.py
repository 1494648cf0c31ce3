"""Small pictures as SVG text, from lines and areas; no drawing library is loaded."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from html import escape

import numpy as np

from ggo_factors.support.inputs import Array

# The colours of Okabe and Ito, which colour-blind readers can tell apart; those of the figures.
SUPPORT, SWING, PATH = "#0072B2", "#D55E00", "#009E73"
RIGHT, LEFT = SWING, SUPPORT
BASE, GROUND, OBSTACLE = "#555555", "#DDD8CF", "#8C6D31"
INK = "currentColor"
"""Colour of what must be seen on light and on dark pages: that of the text around it."""

WIDTH, TALLEST = 420, 260
"""Width of a picture in pixels, and its largest height."""
WIDEST = 900
"""Width in pixels of a picture that would be flatter than `FLATTEST`: it shrinks to the page."""
FLATTEST = 90
"""Least height of a picture in pixels, where it can be had by more width."""


@dataclass(frozen=True, eq=False)
class Shape:
    """A line, or a filled area.

    Attributes:
        points: its corners, shape (n, 2), y upwards.
        colour: of the line or the area.
        width: of the line in pixels; 0 fills the area.
        opacity: from 0 to 1.
        dashed: whether the line is.
    """

    points: Array
    colour: str
    width: float = 1.6
    opacity: float = 1.0
    dashed: bool = False


@dataclass(frozen=True)
class Text:
    """A word in a picture.

    Attributes:
        x: where it stands, in the unit of the shapes.
        y: its foot.
        words: what it says.
        anchor: which part of it is at `x`: ``"start"``, ``"middle"`` or ``"end"``.
    """

    x: float
    y: float
    words: str
    anchor: str = "start"


def svg(
    shapes: Sequence[Shape],
    label: str,
    *,
    texts: Sequence[Text] = (),
    size: tuple[int, int] | None = None,
    frame: Array | None = None,
) -> str:
    """An SVG element of some shapes, the later ones over the earlier.

    Args:
        shapes: what to draw.
        label: what it shows, for those who do not see it.
        texts: words in it.
        size: width and height in pixels, x and y scaled each to fill it; by default one scale for both.
        frame: two corners that the picture reaches out to besides, shape (2, 2): room for words.
    """
    corners = np.concatenate([*(shape.points for shape in shapes), *([] if frame is None else [frame])])
    low, high = corners.min(axis=0), corners.max(axis=0)
    span = np.maximum(high - low, 1e-9)
    if size is None:
        wide = WIDTH if WIDTH * span[1] / span[0] >= FLATTEST else WIDEST
        scale = np.full(2, min(wide / span[0], TALLEST / span[1]))
    else:
        scale = np.array(size) / span
    width, height = np.ceil(scale * span).astype(int).tolist()

    def placed(points: Array) -> Array:
        return np.stack([(points[:, 0] - low[0]) * scale[0], (high[1] - points[:, 1]) * scale[1]], -1)

    drawn = [element(shape, placed(shape.points)) for shape in shapes]
    for text in texts:
        ((x, y),) = placed(np.array([[text.x, text.y]])).tolist()
        drawn.append(
            f'<text x="{x:.0f}" y="{y:.0f}" font-size="11" text-anchor="{text.anchor}" fill="{INK}">'
            f"{escape(text.words)}</text>"
        )
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" role="img" aria-label="{escape(label)}" width="{width}" '
        f'viewBox="-2 -2 {width + 4} {height + 4}" style="max-width:100%;height:auto" '
        f'fill="none" stroke-linejoin="round" stroke-linecap="round">{"".join(drawn)}</svg>'
    )


def element(shape: Shape, points: Array) -> str:
    """A shape as an SVG element, its corners at `points` of the page, shape (n, 2)."""
    places = " ".join(f"{x:.1f},{y:.1f}" for x, y in points.tolist())
    opacity = "" if shape.opacity == 1.0 else f' opacity="{shape.opacity:.2g}"'
    if not shape.width:
        return f'<polygon points="{places}" fill="{shape.colour}"{opacity}/>'
    dashed = ' stroke-dasharray="4 3"' if shape.dashed else ""
    return f'<polyline points="{places}" stroke="{shape.colour}" stroke-width="{shape.width:g}"{dashed}{opacity}/>'
