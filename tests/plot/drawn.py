"""What is drawn in a figure, line by line: type, data, colour and label of every artist; and its hash.

Data are rounded and nothing depends on pixels, fonts or the order in which a version of matplotlib makes vertices, so
that the hash is the same on every platform. The gaits that are drawn must be closed forms: what a solver found differs
in the last digits.
"""

from __future__ import annotations

import hashlib
from collections.abc import Iterator, Sequence

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.collections import Collection, LineCollection
from matplotlib.colors import to_hex
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

DIGITS = 4
OFF_TIES = 3.1e-7
"""Added before rounding, so that no round number lies on the edge between two."""


def digest(figure: Figure) -> str:
    """The hash of what is drawn in a figure."""
    return hashlib.sha256("\n".join(drawn(figure)).encode()).hexdigest()[:16]


def drawn(figure: Figure) -> list[str]:
    """A line for each artist of a figure, with its panels, insets and legends."""
    said = [f"title {figure.get_suptitle()!r}"]
    for legend in figure.legends:
        said.append(f"legend {[text.get_text() for text in legend.get_texts()]}")
    for ax in figure.axes:
        said += _of_axes(ax)
    return said


def _of_axes(ax: Axes) -> Iterator[str]:
    limits = numbers([*ax.get_xlim(), *ax.get_ylim()])
    yield f"axes {ax.get_title()!r} {ax.get_xlabel()!r} {ax.get_ylabel()!r} {limits} {ax.get_aspect()}"
    if ax.get_legend() is not None:
        yield f"legend {[text.get_text() for text in ax.get_legend().get_texts()]}"
    for artist in (*ax.lines, *ax.patches, *ax.collections):
        label = artist.get_label()
        name = "" if label.startswith("_") else label
        yield f"{kind(artist)} {artist.get_gid() or ''} {name!r} {colours(artist)} {numbers(data(artist))}"
    for text in ax.texts:
        yield f"text {text.get_text()!r} {numbers(text.get_position())}"
    for inset in ax.child_axes:
        yield from _of_axes(inset)


def kind(artist: Artist) -> str:
    """What an artist is, whatever a version of matplotlib calls its class."""
    if isinstance(artist, Line2D):
        return f"line {artist.get_linestyle()} {artist.get_marker()}"
    return "lines" if isinstance(artist, LineCollection) else "area" if isinstance(artist, Collection) else "patch"


def data(artist: Artist) -> np.ndarray:
    """The points of an artist in the data of its axes, shape (n, 2)."""
    if isinstance(artist, Line2D):
        return np.asarray(artist.get_xydata())
    if isinstance(artist, LineCollection):
        return np.concatenate(artist.get_segments())
    if isinstance(artist, Patch):
        path = artist.get_patch_transform().transform_path(artist.get_path())
        return np.unique(np.round(path.vertices, 9), axis=0)
    assert isinstance(artist, Collection), artist
    return np.unique(np.round(artist.get_paths()[0].vertices, 9), axis=0)


def colours(artist: Artist) -> str:
    """Face and edge of an artist, or the colour of a line."""
    if isinstance(artist, Line2D):
        return to_hex(artist.get_color())
    faces, edges = artist.get_facecolor(), artist.get_edgecolor()
    several = [np.reshape(found, (-1, 4)) for found in (faces, edges)]
    return "/".join(to_hex(found[0], keep_alpha=True) if len(found) else "none" for found in several)


def numbers(values: Sequence[float] | np.ndarray) -> str:
    """Numbers, rounded."""
    rounded = np.round(np.asarray(values, dtype=float).ravel() + OFF_TIES, DIGITS) + 0.0
    return " ".join(f"{value:g}" for value in rounded)
