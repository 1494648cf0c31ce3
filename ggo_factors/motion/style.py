"""Style: how a person varies a step from one time to the next, learned from recorded steps; in memory and as a file."""

from __future__ import annotations

import math
import zipfile
from dataclasses import dataclass, fields
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ggo_factors.errors import InputError
from ggo_factors.motion.recorded import fingerprint_of
from ggo_factors.support.files import PathLike, replacing
from ggo_factors.support.inputs import Array, as_angles, as_array, as_bool, as_count, as_number

KIND = "ggo-style"
"""What a style file says that it is."""
FORMAT_VERSION = 3
"""Version of the style file that is written: with `lands` and `start_variance`. Version 2, without them, and 1, without
the kind of ground too, are read."""
GROUNDS = ("", "level", "up", "down")
"""Kinds of ground that a style may be learned on; "" where it is not known, or made of several."""
FRAMES = 51
"""Frames at which styles are learned: a step of 50 motions, as the paper's."""
LEAST_STEPS = 12
"""Steps that a style is learned from at least: with 6 it misleads on half of the recordings tried, with 12 on none."""
MOST_DIRECTIONS = 40
"""More numbers for a step than any style has."""
LARGEST_FILE = 10_000_000
"""A style file that holds more bytes is refused; one has some 30,000."""


@dataclass(frozen=True, eq=False)
class Style:
    """How a person's steps vary about the base gait: z + W c for a step, c a vector of k standard normal numbers.

    Attributes:
        directions: W over the phase of the step, evenly from start to landing, in [rad] for a standard deviation of c,
            shape (frames, 4, k); the columns are the principal deviations, the largest first. W W' is what they explain
            of the covariance of the steps over time.
        variance: variance in [rad^2] of what c leaves of a motion from frame to frame in a step of 50, as the second
            and first-order residual edges count it: what a residual edge of gain 1 stands for.
        steps: how many steps it was learned from.
        people: how many people's.
        explained: share of the variance of the steps that the directions explain, 0 to 1.
        likelihood: mean logarithm of the likelihood of held-out steps for each angle, in nats, with c and without.
        error_deg: RMSE in [deg] over frames and joints of held-out steps given their start and foothold, with c and
            without.
        ground: what the steps were walked on: ``"level"``, ``"up"`` or ``"down"`` stairs; "" where it is not known.
        lands: whether landing edges, too, hold a step to the base gait as varied by c; else to the base gait as it is.
        start_variance: variance in [rad^2] of what c leaves of each angle of a step's first frame; infinite where the
            first frame is not asked for c.

    Raises:
        InputError: where a shape is wrong, or a number is not finite or out of its range.
    """

    directions: Array
    variance: float
    steps: int
    people: int
    explained: float
    likelihood: tuple[float, float]
    error_deg: tuple[float, float]
    ground: str = ""
    lands: bool = False
    start_variance: float = math.inf

    def __post_init__(self) -> None:
        directions = as_angles(self.directions, "directions", (None, 4, None))
        frames, _, size = directions.shape
        if frames < 4 or not 1 <= size <= MOST_DIRECTIONS:
            raise InputError(f"directions: {frames} frames and {size} numbers; 4 or more, and 1 to {MOST_DIRECTIONS}")
        object.__setattr__(self, "directions", directions)
        object.__setattr__(self, "variance", as_number(self.variance, "variance", above=0.0, unit="rad^2"))
        object.__setattr__(self, "steps", as_count(self.steps, "steps", 1))
        object.__setattr__(self, "people", as_count(self.people, "people", 1, self.steps))
        object.__setattr__(self, "explained", as_number(self.explained, "explained", at_least=0.0, at_most=1.0))
        for name in ("likelihood", "error_deg"):
            first, second = as_array(getattr(self, name), name, (2,)).tolist()
            object.__setattr__(self, name, (first, second))
        if self.ground not in GROUNDS:
            raise InputError(f"ground: {self.ground!r:.40} is none of {', '.join(map(repr, GROUNDS))}")
        object.__setattr__(self, "lands", as_bool(self.lands, "lands"))
        if not (isinstance(self.start_variance, float) and self.start_variance == math.inf):
            variance = as_number(self.start_variance, "start_variance", above=0.0, unit="rad^2")
            object.__setattr__(self, "start_variance", variance)

    def __repr__(self) -> str:
        size = self.directions.shape[2]
        return f"Style({size} numbers, {self.steps} steps, {'helps' if self.helps else 'does not help'})"

    def _repr_html_(self) -> str:
        from ggo_factors.notebook.card import card  # only here: nothing but a notebook needs it

        facts = {
            "learned from": f"{self.steps} steps of {self.people} {'people' if self.people > 1 else 'person'}",
            "ground": self.ground,
            "numbers for a step": f"{self.directions.shape[2]}, {self.explained:.0%} of the variance",
            "held-out steps": "RMS error {:.2f} degrees with it, {:.2f} without".format(*self.error_deg),
            "helps": self.why_not or "yes",
        }
        return card("Style", facts)

    @cached_property
    def fingerprint(self) -> str:
        """Digits that tell its directions from others; a file keeps them."""
        return fingerprint_of(self.directions)

    @property
    def why_not(self) -> str:
        """Why steps are not bent with it; "" where they are."""
        if self.steps < LEAST_STEPS:
            return f"learned from {self.steps} steps, fewer than {LEAST_STEPS}"
        if self.likelihood[0] <= self.likelihood[1]:
            return "held-out steps are no likelier with it than without"
        if self.error_deg[0] >= self.error_deg[1]:
            return "held-out steps are no nearer with it than without"
        return ""

    @property
    def helps(self) -> bool:
        """Whether it was learned from enough steps, and held-out ones were likelier and nearer with it."""
        return not self.why_not

    def at(self, frames: int, first: float = 0.0) -> Array:
        """The directions at another number of frames, evenly from a phase to the landing, shape (frames, 4, k).

        Args:
            frames: how many, 2 or more.
            first: phase of the first frame, from 0 to below 1.
        """
        from scipy.interpolate import CubicSpline  # here, since it takes longer to import than all the rest

        phases = np.linspace(0.0, 1.0, len(self.directions))
        spline = CubicSpline(phases, self.directions)
        return np.asarray(spline(np.linspace(first, 1.0, as_count(frames, "frames", 2))))

    def save(self, path: PathLike) -> None:
        """Write the style as a NumPy archive (`.npz`), whole or not at all.

        Raises:
            InputError: where the name does not end in .npz, or the file cannot be written.
        """
        if Path(path).suffix.lower() != ".npz":
            raise InputError(f"{path}: a style file ends in .npz")
        numbers = {field.name: getattr(self, field.name) for field in fields(self)}
        with replacing(path) as temporary, temporary.open("wb") as file:
            np.savez_compressed(file, kind=KIND, format_version=FORMAT_VERSION, **numbers)


def load_style(path: PathLike) -> Style:
    """Read a style that `Style.save` wrote.

    Raises:
        InputError: naming the file, where it is no style file, of another version, or holds what no style can.
    """
    place = Path(path)
    try:
        with zipfile.ZipFile(place) as parts:
            if (size := sum(part.file_size for part in parts.infolist())) > LARGEST_FILE:
                raise InputError(f"{path}: is no style file: it holds {size} bytes")
        with np.load(place, allow_pickle=False) as archive:
            found = {name: archive[name] for name in archive.files}
    except InputError:
        raise
    except OSError as error:
        raise InputError(f"{path}: cannot be read: {error.strerror or 'it is no style file'}") from error
    except (ValueError, EOFError, zipfile.BadZipFile, AttributeError, MemoryError, KeyError) as error:
        raise InputError(f"{path}: is no style file (.npz)") from error
    version = found.pop("format_version", None)
    if str(found.pop("kind", "")) != KIND or version is None:
        raise InputError(f"{path}: is no style file: the mark {KIND} is missing")
    if version.shape != () or version.dtype.kind != "i" or not 1 <= int(version) <= FORMAT_VERSION:
        raise InputError(
            f"{path}: format version {version!s:.20} is not known; this release knows 1 to {FORMAT_VERSION}"
        )
    if int(version) == 1:
        found["ground"] = np.array("")
    if int(version) <= 2:
        found |= {"lands": np.array(False), "start_variance": np.array(math.inf)}
    names = [field.name for field in fields(Style)]
    if lacking := [name for name in names if name not in found]:
        raise InputError(f"{path}: {', '.join(lacking)} missing")
    try:
        numbers: dict[str, Any] = {name: _plain(found[name], name) for name in names}
        return Style(**numbers)
    except InputError as error:
        raise InputError(f"{path}: {error}") from error


def _plain(value: NDArray[Any], name: str) -> object:
    """A number or text of a file as Python's own, an array of numbers as it is."""
    if name == "ground" and value.dtype.kind == "U" and value.shape == ():
        return str(value)
    if name == "lands" and value.dtype.kind == "b" and value.shape == ():
        return bool(value)
    if value.dtype.kind not in "if" or name in ("ground", "lands"):
        expected = {"ground": "a text", "lands": "True or False"}.get(name, "numbers")
        raise InputError(f"{name}: expected {expected}, got {value.dtype}")
    return value.item() if value.shape == () else value
