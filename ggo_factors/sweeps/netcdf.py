"""A sweep: a grid of gaits in one netCDF file with named axes; a sweep that was stopped can be continued."""

from __future__ import annotations

import fcntl
import json
import os
from collections import Counter
from collections.abc import Iterator, Mapping
from contextlib import closing, contextmanager
from dataclasses import asdict
from hashlib import sha256
from importlib.metadata import version
from pathlib import Path
from typing import IO, TYPE_CHECKING, Any

import numpy as np

from ggo_factors.errors import InputError
from ggo_factors.evaluate.summary import JOINTS
from ggo_factors.motion.base_gaits import BaseGaits, both
from ggo_factors.motion.gait import Gait
from ggo_factors.motion.leg_model import LegModel
from ggo_factors.motion.style import Style
from ggo_factors.support.files import PathLike, replacing
from ggo_factors.support.inputs import as_instance, as_progress
from ggo_factors.sweeps.grid import Grid
from ggo_factors.sweeps.tasks import Progress, Row, frames_of, make_rows

if TYPE_CHECKING:
    from distributed import Client
    from xarray import Dataset

ENDING = ".nc"
PARTIAL = ".partial"
KIND = "ggo-sweep-partial 1"
MOST_BYTES = 2**31
"""Most bytes of frames in a file: half of what a variable of netCDF-3 can hold, so that readers have memory left."""

# Name in the file, what it is, and how it follows from a row.
_MEASURES: tuple[tuple[str, str, str, float], ...] = (
    ("milliseconds", "milliseconds", "time taken to make and check the gait, or to refuse it", 1.0),
    ("foothold_error_mm", "foothold_error", "distance of the landing from its foothold", 1e3),
    ("clearance_mm", "clearance", "least height over the obstacle; infinite where none is crossed", 1e3),
    ("ground_clearance_mm", "ground_clearance", "least height over the ground, away from the footholds", 1e3),
    ("knee_deg", "knee", "least knee angle", 180.0 / np.pi),
)


def sweep(
    grid: Grid,
    base: Gait | BaseGaits,
    path: PathLike,
    *,
    model: LegModel | None = None,
    workers: int | None = None,
    client: Client | None = None,
    progress: Progress | None = None,
    keep_frames: bool = False,
    style: Style | None = None,
) -> Dataset:
    """Make the gait of every point of a grid and write all results to one netCDF file.

    Each row is written to ``PATH.partial`` when it is finished; a sweep that was stopped and is called again makes only
    the missing rows.

    Args:
        grid: the values to combine.
        base: the base gait, or gaits for each leg and for stairs.
        path: file to write; ends in ``.nc``.
        model: the legs, where no axis gives their lengths; the base gait's own if None.
        workers: number of processes on this machine; one for each processor if None. See `generate_many`.
        client: a `dask.distributed.Client` of a cluster to use instead.
        progress: called with the fraction that is done, 0 to 1.
        keep_frames: whether the file holds the gaits themselves.
        style: how a person varies steps, see `step_over`.

    Returns:
        The contents of the file: `ok`, `error`, `reason`, `violations` (their kinds) and the numbers of `Row`, each
        over the axes of the grid.

    Raises:
        InputError: where an argument is unusable, a file cannot be written, or the partial file is of another sweep.
        GgoError: where workers cannot start, or the cluster refuses the work.
    """
    progress = as_progress(progress)
    _require_xarray()
    target = Path(path)
    if target.suffix.lower() != ENDING or target.is_dir():
        raise InputError(f"{path}: must be the name of a file and end in {ENDING}")
    as_instance(grid, "grid", Grid)
    bases = both(base)
    largest = grid.size * grid.steps_a_row * frames_of(bases) * bases.left.frames[0].nbytes
    if keep_frames and largest >= MOST_BYTES:
        raise InputError(f"keep_frames: {largest / 1e9:.1f} GB of frames, a file holds at most {MOST_BYTES / 1e9:.1f}")
    tasks = grid.tasks(base, model)
    identity = _identity(grid, bases, model, keep_frames, style)
    with _partial(target.with_name(target.name + PARTIAL), identity) as partial:
        rows = partial.rows(grid.size)
        left = [number for number in range(grid.size) if number not in rows]
        if progress is not None:
            progress(len(rows) / grid.size)
        todo = [tasks[number] for number in left]
        with closing(make_rows(todo, base, model, style, workers, client, keep_frames)) as batches:
            for batch in batches:
                made = {left[position]: row for position, row in batch}
                partial.append(made)
                rows |= made
                if progress is not None:
                    progress(len(rows) / grid.size)
        found = _dataset(grid, bases, model, [rows[number] for number in range(grid.size)], keep_frames)
        with replacing(target) as temporary:
            found.to_netcdf(temporary, engine="scipy", encoding={"iterations": {"dtype": "int32", "_FillValue": -1}})
        partial.remove()
    return found


def outcome(found: Dataset) -> dict[str, Any]:
    """How many rows there are, how many are gaits, and how many failed by which error and which limits."""
    failed = ~found["ok"].values
    errors = found["error"].values[failed].tolist()
    kinds = [kind for kinds in found["violations"].values[failed].tolist() for kind in kinds.split(", ") if kind]
    return {
        "rows": int(failed.size),
        "ok": int(failed.size - failed.sum()),
        "errors": dict(Counter(errors).most_common()),
        "violations": dict(Counter(kinds).most_common()),
    }


def _require_xarray() -> None:
    try:
        import xarray  # noqa: F401
    except ImportError as error:
        raise InputError("sweep: needs xarray: pip install 'ggo-factors[cluster]'") from error


def _dataset(grid: Grid, base: BaseGaits, model: LegModel | None, rows: list[Row], keep_frames: bool) -> Dataset:
    from xarray import Dataset

    axes = tuple(grid.axes)

    def shaped(values: list[Any], kind: Any = np.float64) -> np.ndarray[Any, Any]:
        array = np.array(values, dtype=kind)
        return array.reshape(grid.shape + array.shape[1:])

    kinds = [", ".join(dict.fromkeys(violation.kind for violation in row.violations)) for row in rows]
    counts = [row.iterations if row.ok else np.nan for row in rows]
    variables: dict[str, Any] = {
        "ok": (axes, shaped([row.ok for row in rows], bool), {"long_name": "whether there is a gait"}),
        "error": (axes, shaped([row.error for row in rows], object), {"long_name": "class of the error"}),
        "reason": (axes, shaped([row.reason for row in rows], object), {"long_name": "what the error says"}),
        "violations": (axes, shaped(kinds, object), {"long_name": "kinds of limits that the best gait breaks"}),
        "iterations": (axes, shaped(counts), {"long_name": "iterations of the solver over all steps"}),
    }
    for name, attribute, what, scale in _MEASURES:
        unit = "ms" if name == "milliseconds" else name.rpartition("_")[2]
        values = shaped([getattr(row, attribute) for row in rows]) * scale
        variables[name] = (axes, values, {"long_name": what, "units": unit})
    change = np.degrees(shaped([row.change for row in rows]))
    what = "mean absolute change of each joint from the base gait"
    variables["change_deg"] = ((*axes, "joint"), change, {"long_name": what, "units": "deg"})
    coordinates: dict[str, Any] = {name: (name, list(grid.axes[name]), {"units": "m"}) for name in axes}
    if keep_frames:
        missing = np.full((grid.steps_a_row, frames_of(base), 4), np.nan)
        frames = np.degrees(shaped([missing if row.frames is None else row.frames for row in rows]))
        dims = (*axes, "step", "frame", "joint")
        variables["frames_deg"] = (dims, frames, {"long_name": "joint angles of the gait", "units": "deg"})
        coordinates["step"] = np.arange(1, grid.steps_a_row + 1, dtype=np.int32)
    coordinates["joint"] = list(JOINTS)
    said = {
        name: " and ".join(dict.fromkeys(getattr(gait, name) for gait in base.gaits)) for name in ("name", "origin")
    }
    about: dict[str, Any] = {
        "title": "sweep of gaits by ggo_factors",
        "base": said["name"],
        "base_origin": said["origin"],
    }
    about["dt_s"] = base.left.dt
    about |= {"steps": grid.steps_a_row, **_versions()}
    legs = base.model if model is None else model
    if legs is not None:
        about |= {f"{name}_m": getattr(legs, name) for name in ("thigh", "shank") if name not in axes}
    return Dataset(variables, coordinates, about)


# -- the partial file -----------------------------------------------------------------------------------------------


def _identity(
    grid: Grid, base: BaseGaits, model: LegModel | None, keep_frames: bool, style: Style | None
) -> dict[str, Any]:
    """What two sweeps must have in common for the rows of one to be those of the other."""
    legs = base.model if model is None else model
    told = [f"{gait.name}, {len(gait)} frames, {sha256(gait.frames.tobytes()).hexdigest()[:16]}" for gait in base.gaits]
    return {
        "kind": KIND,
        **{name: list(values) for name, values in grid.axes.items()},
        "steps": grid.steps_a_row,
        "base gait": told[0] if len(set(told)) == 1 else " and ".join(told),
        "dt": base.left.dt,
        "legs": None if legs is None else asdict(legs),
        "keep_frames": keep_frames,
        "style": None if style is None else f"{style.fingerprint}, variance {style.variance!r} rad^2",
        **_versions(),
    }


def _versions() -> dict[str, str]:
    return {package: version(package) for package in ("ggo-factors", "gtsam", "numpy")}


class _Partial:
    """A file of JSON lines: what is swept, then a row each as they come, NaN and infinity as Python writes them."""

    def __init__(self, path: Path, stream: IO[bytes], identity: Mapping[str, Any]) -> None:
        self._path, self._stream, self._identity = path, stream, identity

    def rows(self, size: int) -> dict[int, Row]:
        """The rows that are in the file, by number; what is written next follows them.

        Raises:
            InputError: where the file is of another sweep, or holds a line that is not one of its rows.
        """
        first = self._stream.readline()
        wanted = _line(self._identity)
        if not first.endswith(b"\n"):  # a new file, or one that was cut short in its first line
            if not wanted.startswith(first):
                raise InputError(f"{self._path}: is no partial file of a sweep; move it away")
            self._stream.seek(0)
            self._stream.truncate()
            self._stream.write(wanted)
            self._flush()
            return {}
        self._require_same(first)
        rows: dict[int, Row] = {}
        for number, line in enumerate(self._stream, start=2):
            if not line.endswith(b"\n"):  # cut short: that row is made again
                self._stream.seek(-len(line), os.SEEK_END)
                self._stream.truncate()
                break
            try:
                given = json.loads(line)
                at = given["row"]
                if not isinstance(at, int) or not 0 <= at < size:
                    raise InputError(f"row {at!r} is not in the grid")
                rows[at] = Row.from_json(given)
            except (ValueError, KeyError, TypeError) as error:
                raise InputError(
                    f"{self._path}, line {number}: is no row of this sweep; remove the file to begin anew"
                ) from error
        self._stream.seek(0, os.SEEK_END)
        return rows

    def append(self, rows: Mapping[int, Row]) -> None:
        """Add rows and wait until they are on the disk."""
        try:
            self._stream.write(b"".join(_line({"row": number, **row.to_json()}) for number, row in rows.items()))
            self._flush()
        except OSError as error:
            raise InputError(f"{self._path}: cannot be written: {error.strerror}") from error

    def remove(self) -> None:
        """Remove the file: all rows are in the file of results."""
        self._path.unlink(missing_ok=True)

    def _flush(self) -> None:
        self._stream.flush()
        os.fsync(self._stream.fileno())

    def _require_same(self, first: bytes) -> None:
        try:
            found = json.loads(first)
        except ValueError:
            found = None
        if not isinstance(found, dict) or found.get("kind") != KIND:
            raise InputError(f"{self._path}: is no partial file of a sweep; move it away")
        wanted = json.loads(_line(self._identity))
        other = [key for key in {**wanted, **found} if found.get(key) != wanted.get(key)]
        if other:
            raise InputError(
                f"{self._path}: is of another sweep, {', '.join(other)} {'differ' if other[1:] else 'differs'}; "
                "finish that one, or remove the file to begin anew"
            )


def _line(content: Mapping[str, Any]) -> bytes:
    return json.dumps(content).encode() + b"\n"


@contextmanager
def _partial(path: Path, identity: Mapping[str, Any]) -> Iterator[_Partial]:
    """The partial file, created if missing, and locked against other sweeps.

    Raises:
        InputError: where it cannot be written, or another process has it.
    """
    try:
        handle = os.open(path, os.O_RDWR | os.O_CREAT, 0o666)
    except OSError as error:
        raise InputError(f"{path}: cannot be written: {error.strerror}") from error
    with os.fdopen(handle, "r+b") as stream:
        try:
            fcntl.flock(stream, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError as error:
            raise InputError(f"{path}: another sweep is writing it") from error
        yield _Partial(path, stream, identity)
