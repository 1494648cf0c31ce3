"""An animation: lines that move over a still picture, as a page that needs nothing from elsewhere, GIF or MP4."""

from __future__ import annotations

import re
from dataclasses import dataclass
from html import escape
from pathlib import Path

import numpy as np

from ggo_factors.errors import InputError
from ggo_factors.notebook.svg import Shape, element
from ggo_factors.support.files import PathLike, write_text
from ggo_factors.support.inputs import Array, short_text

RATE = 25.0
"""Pictures a second, those of film."""
MOST_NUMBERS = 8_000
"""Most coordinates of all pictures, 32 kB of a page; what is longer than 13 s has fewer pictures a second."""
VIEW = (2.6, 1.5)
"""Most that is seen at once, width and height in [m]; a longer way is followed."""
MARGIN = 0.04
"""Room around all that is drawn in [m], for the width of the lines."""
HIGH = 340
"""Height of the picture on a page in pixels."""
ENDINGS = (".html", ".gif", ".mp4")

_PAGE = Path(__file__).with_name("animation.html")


@dataclass(frozen=True, eq=False)
class Animation:
    """Lines that move over a still picture; shows itself in a notebook.

    Attributes:
        name: what it is of.
        still: what does not move.
        lines: the corners of each line in each picture in [m], shape (k, n, 2).
        colours: the colour of each line.
        duration: time from the first picture to the last in [s].
    """

    name: str
    still: tuple[Shape, ...]
    lines: tuple[Array, ...]
    colours: tuple[str, ...]
    duration: float

    def __repr__(self) -> str:
        return f"Animation({short_text(self.name)}, {len(self.lines[0])} pictures, {self.duration:.4g} s)"

    def _repr_html_(self) -> str:
        # In a frame of its own: no name on the page around it can clash, and its script runs there alone.
        return (
            f'<iframe srcdoc="{escape(self.html())}" sandbox="allow-scripts" title="{escape(self.name)}" '
            f'style="width:100%;max-width:760px;height:{HIGH + 60}px;border:0"></iframe>'
        )

    @property
    def corners(self) -> Array:
        """Left, bottom, right and top of all that is drawn in [m], shape (4,)."""
        points = np.concatenate([*(shape.points for shape in self.still), *(row.reshape(-1, 2) for row in self.lines)])
        return np.concatenate([points.min(axis=0) - MARGIN, points.max(axis=0) + MARGIN])

    @property
    def views(self) -> Array:
        """Left, bottom, right and top of what is seen in each picture in [m], shape (k, 4): around what moves."""
        corners = self.corners
        low, high = corners[:2], corners[2:]
        half = np.minimum(high - low, VIEW) / 2.0
        moving = np.concatenate(self.lines, axis=1)
        middle = np.clip((moving.min(axis=1) + moving.max(axis=1)) / 2.0, low + half, high - half)
        return np.hstack([middle - half, middle + half])

    def html(self) -> str:
        """The page."""
        millimetres = [np.rint(row * 1e3).astype(int) * [1, -1] for row in self.lines]
        numbers = np.hstack([row.reshape(len(row), -1) for row in millimetres])
        steps = np.diff(numbers, axis=0, prepend=0)
        left, bottom, right, top = np.rint(self.corners * 1e3).astype(int).tolist()
        wide, high = np.rint((self.views[0, 2:] - self.views[0, :2]) * 1e3).astype(int).tolist()
        given = {
            "NAME": escape(self.name),
            "HIGH": str(HIGH),
            "STILL": "".join(element(shape, np.rint(shape.points * [1e3, -1e3])) for shape in self.still),
            "LINES": "".join(f'<polyline class="moves" stroke="{hue}" stroke-width="3"/>' for hue in self.colours),
            "CORNERS": str([[row.shape[1] for row in self.lines], [left, -top, right, -bottom], [wide, high]]),
            "STEPS": str(steps.tolist()).replace(" ", ""),
            "DURATION": f"{self.duration:.6g}",
        }
        return re.sub(r"@([A-Z]+)@", lambda place: given[place[1]], _PAGE.read_text(encoding="utf-8"))

    def save(self, path: PathLike) -> None:
        """Write it as a page (`.html`), which needs nothing from elsewhere, as `.gif`, or as `.mp4` by ffmpeg.

        Raises:
            InputError: where the file cannot be written, its name ends otherwise, or ffmpeg is not there.
        """
        ending = Path(path).suffix.lower()
        if ending not in ENDINGS:
            raise InputError(f"{path}: must end in {', '.join(ENDINGS[:-1])} or {ENDINGS[-1]}")
        if ending == ".html":
            write_text(path, self.html())
            return
        from ggo_factors.notebook.movie import Film, write_gif, write_mp4  # here, since they bring matplotlib

        film = Film(self.still, self.lines, self.colours, self.views, self.duration)
        (write_gif if ending == ".gif" else write_mp4)(film, path)


def instants(duration: float, numbers: int) -> Array:
    """The times of the pictures in [s] of an animation with so many coordinates each, at least two."""
    most = max(MOST_NUMBERS // numbers, 2)
    return np.linspace(0.0, duration, min(max(round(duration * RATE) + 1, 2), most))
