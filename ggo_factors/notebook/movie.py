"""An animation as GIF, by Pillow, or as MP4, by ffmpeg; matplotlib draws its pictures."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import chain
from subprocess import CalledProcessError

import numpy as np
from matplotlib.animation import FFMpegWriter
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from PIL import Image

from ggo_factors.errors import InputError
from ggo_factors.notebook.svg import INK, Shape
from ggo_factors.support.files import PathLike, replacing
from ggo_factors.support.inputs import Array

WIDTH, DPI = 640, 100
"""Width of a picture in pixels, and its dots an inch."""
COLOURS = 64
"""Colours of a GIF: those of the lines and what lies between them and the ground."""


@dataclass(frozen=True, eq=False)
class Film:
    """What a film shows: of an `Animation` its shapes, lines, colours, views and duration."""

    still: tuple[Shape, ...]
    lines: tuple[Array, ...]
    colours: tuple[str, ...]
    views: Array
    duration: float

    @property
    def interval(self) -> float:
        """Time from one picture to the next in [s]."""
        return self.duration / (len(self.views) - 1)


def write_gif(film: Film, path: PathLike) -> None:
    """Write an animation that repeats itself.

    Raises:
        InputError: where the file cannot be written.
    """
    figure, canvas = _figure(film)
    shown = (_image(canvas) for _ in _pictures(film, figure))
    first = next(shown)
    # Times of a GIF are in hundredths of a second; the last picture stays for half a second.
    each = 10 * max(2, round(1e2 * film.interval))
    times = [each] * (len(film.views) - 1) + [500]
    with replacing(path) as temporary:
        first.save(temporary, save_all=True, append_images=chain(shown), duration=times, loop=0)


def write_mp4(film: Film, path: PathLike) -> None:
    """Write an animation as a film.

    Raises:
        InputError: where the file cannot be written, or ffmpeg is not there.
    """
    if not FFMpegWriter.isAvailable():
        raise InputError(f"{path}: needs the program ffmpeg, which is not installed; .html and .gif need nothing more")
    figure, _ = _figure(film)
    writer = FFMpegWriter(fps=1.0 / film.interval)  # type: ignore[arg-type]
    try:
        with replacing(path) as temporary, writer.saving(figure, str(temporary), DPI):
            for _ in _pictures(film, figure):
                writer.grab_frame()
    except CalledProcessError as error:
        raise InputError(f"{path}: ffmpeg could not write it: {error}") from error


def _figure(film: Film) -> tuple[Figure, FigureCanvasAgg]:
    """A figure in the proportions of what is seen, an even number of pixels high, as films need."""
    left, bottom, right, top = film.views[0].tolist()
    high = 2 * round(WIDTH * (top - bottom) / (right - left) / 2.0)
    figure = Figure(figsize=(WIDTH / DPI, high / DPI), dpi=DPI)
    return figure, FigureCanvasAgg(figure)


def _pictures(film: Film, figure: Figure) -> Iterator[None]:
    """Put the lines where they are in each picture in turn."""
    axes = figure.add_axes((0.0, 0.0, 1.0, 1.0))
    axes.set_axis_off()
    for shape in film.still:
        colour = "k" if shape.colour == INK else shape.colour
        if shape.width:
            style = "--" if shape.dashed else "-"
            axes.plot(*shape.points.T, color=colour, lw=shape.width, ls=style, alpha=shape.opacity)
        else:
            axes.fill(*shape.points.T, color=colour, lw=0.0, alpha=shape.opacity)
    drawn = [
        axes.plot([], [], color=colour, lw=2.5, solid_capstyle="round", solid_joinstyle="round", zorder=3.0)[0]
        for colour in film.colours
    ]
    for number, (left, bottom, right, top) in enumerate(film.views.tolist()):
        for line, places in zip(drawn, film.lines, strict=True):
            line.set_data(*places[number].T)
        axes.set_xlim(left, right)
        axes.set_ylim(bottom, top)
        yield


def _image(canvas: FigureCanvasAgg) -> Image.Image:
    canvas.draw()  # type: ignore[no-untyped-call]
    seen = np.asarray(canvas.buffer_rgba())  # type: ignore[no-untyped-call]
    return Image.fromarray(seen[..., :3]).quantize(COLOURS)
