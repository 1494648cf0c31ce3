"""Joint values in a message, found by its shape and not by its type.

A message is a tree of dict, list, str and numbers (real ones, or places of numbers in a CDR message). Shapes that are
known, best first: names beside positions, at any depth (JointState, controller states, JointTrajectory); a list of
{name, position}; any other numbers, each by its path.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from ggo_factors.recording.log.walk_cdr import IDS, Slot

NAMES = ("name", "names", "joint_names", "joint_name", "joints")
"""Fields that hold a list of joint names."""
POSITIONS = ("position", "positions", "angle", "angles", "pos", "q")
"""Fields that hold the angles which belong to the names."""
_MEASURED = ("feedback", "actual", "measured", "state", "current")
_NOT_MEASURED = ("desired", "reference", "command", "target", "goal", "error", "output", "header", "layout")
_CLOCK = re.compile(
    r"(?:ts|time_?stamp|stamp|time|t|seconds|secs|sec|elapsed(?:_?time)?)"
    r"(?:_?(?P<unit>s|sec|seconds|ms|millis|us|micros|ns|nanos|nsec))?",
    re.IGNORECASE,
)
_UNITS = {
    "s": 1e9, "sec": 1e9, "seconds": 1e9, "ms": 1e6, "millis": 1e6, "us": 1e3, "micros": 1e3, "ns": 1.0, "nanos": 1.0,
    "nsec": 1.0,
}  # fmt: skip
_NANOS = ("nanosec", "nsec", "nanos", "nsecs", "nanoseconds")
_SECONDS = ("sec", "secs", "seconds")
_MANY = 4096
"""Most values taken from one message without a list of names."""
_DEEP = 16
"""Deepest nesting of fields that is searched for values."""


@dataclass(frozen=True)
class Stamp:
    """A message's own time.

    Attributes:
        path: the field, for example ``"header.stamp"``.
        parts: (seconds, nanoseconds), or one number.
        scale: [ns] in one unit of that number; None where it must be told from the data.
    """

    path: str
    parts: tuple[Any, ...]
    scale: float | None


@dataclass(frozen=True)
class Reading:
    """What a message says.

    Attributes:
        shape: "state", "list", "dynamic", "controller", "trajectory", "values", or "" where nothing was found.
        names: what the values are called.
        rows: the values; one row, or one for each point of a trajectory.
        offsets: (seconds, nanoseconds) from the start for each row of a trajectory.
        stamp: the message's own time, or None.
        problem: why the message cannot be used, or "".
        inherited: whether the names are those of an earlier message.
        frame: the frame of its header, or "".
    """

    shape: str
    names: tuple[str, ...] = ()
    rows: tuple[list[Any], ...] = ()
    offsets: tuple[tuple[Any, Any], ...] = ()
    stamp: Stamp | None = None
    problem: str = ""
    inherited: bool = False
    frame: str = ""


Lists = Mapping[int, tuple[str, ...] | None]
"""Lists of names of earlier messages by their length; None where there were two of a length."""


def read_shape(tree: Any, lists: Lists | None = None) -> Reading:
    """Find names, values and time in a message; names that it lacks are taken from `lists`."""
    if not isinstance(tree, dict):
        tree = {"data": tree}
    stamp = _stamp(tree)
    header = tree.get("header")
    frame = header.get("frame_id") if isinstance(header, dict) else ""
    frame = frame if isinstance(frame, str) else ""
    found: list[tuple[str, Reading]] = []
    _search(tree, "", found, 0, lists or {})
    found = [f for f in found if not f[1].problem] or found[:1]
    if found:
        first = found[0][1]
        names: tuple[str, ...] = first.names
        rows = first.rows
        if len(found) > 1 and all(len(r.rows) == 1 for _, r in found):
            names = tuple(f"{path}{name}" for path, r in found for name in r.names)
            rows = ([value for _, r in found for value in r.rows[0]],)
        problem = first.problem
        if not problem and len(set(names)) < len(names):
            twice = next(name for name in names if names.count(name) > 1)
            problem = f"name {twice!r} twice"
        inherited = any(r.inherited for _, r in found)
        return Reading(first.shape, names, rows, first.offsets, stamp, problem, inherited, frame)
    values: dict[str, Any] = {}
    _numbers(tree, "", values, stamp.path if stamp else "", 0)
    if not values:
        return Reading("", stamp=stamp, problem="no numbers")
    return Reading("values", tuple(values), (list(values.values()),), (), stamp, frame=frame)


def is_number(value: Any) -> bool:
    """Whether a leaf of a tree is a number, or the place of one."""
    if isinstance(value, Slot):
        return not value.code.endswith("b1")
    return isinstance(value, (int, float)) and not isinstance(value, bool)


def _search(node: Any, path: str, found: list[tuple[str, Reading]], depth: int, lists: Lists) -> None:
    if depth > _DEEP:
        return
    if isinstance(node, dict):
        reading = _beside(node) or _unnamed(node, lists)
        if reading is not None:
            found.append((path, reading))
            return
        for key, child in node.items():
            if key in _NOT_MEASURED or not isinstance(child, (dict, list)):
                continue
            pairs = _pairs(child) if isinstance(child, list) else None
            if pairs is not None:
                found.append((f"{path}{key}.", pairs))
            else:
                _search(child, f"{path}{key}.", found, depth + 1, lists)
    elif isinstance(node, list) and len(node) <= 64 and node and isinstance(node[0], dict):
        for i, child in enumerate(node):
            _search(child, f"{path[:-1]}[{i}].", found, depth + 1, lists)


def _beside(node: dict[str, Any]) -> Reading | None:
    names = next((node[key] for key in NAMES if key in node and _texts(node[key])), None)
    if names is None:
        return None
    names = tuple(names)
    points = node.get("points")
    if isinstance(points, list) and points and all(isinstance(point, dict) for point in points):
        rows = tuple(_positions(point) or [] for point in points)
        offsets = tuple(_pair(point.get("time_from_start")) or (None, None) for point in points)
        return _checked("trajectory", names, rows, offsets)
    row = _positions(node)
    if row:
        return _checked("state", names, (row,))
    if "points" in node:
        return Reading("trajectory", names, problem="no points")
    for key in _MEASURED:
        child = node.get(key)
        if isinstance(child, dict) and (row := _positions(child)):
            return _checked("controller", names, (row,))
    for child in node.values():
        if isinstance(child, list) and child and all(isinstance(c, dict) and "interface_names" in c for c in child):
            return _checked("dynamic", names, ([_interface(c) for c in child],))
    return Reading("state", names, problem="no positions") if row is not None else None


def _unnamed(node: dict[str, Any], lists: Lists) -> Reading | None:
    # positions whose names stood in an earlier message only
    if not lists or any(node.get(key) for key in NAMES):
        return None
    measured = (_positions(node[key]) for key in _MEASURED if isinstance(node.get(key), dict))
    row = _positions(node) or next((row for row in measured if row), None)
    if not row or len(row) not in lists:
        return None
    names = lists[len(row)]
    if names is None:
        return Reading("state", problem=f"{len(row)} positions without names, and two lists of names came before")
    return Reading("state" if _positions(node) else "controller", names, (row,), inherited=True)


def _checked(shape: str, names: tuple[str, ...], rows: tuple[list[Any], ...], offsets: Any = ()) -> Reading:
    wrong = next((row for row in rows if len(row) != len(names)), None)
    problem = "" if wrong is None else f"{len(names)} names, {len(wrong)} positions"
    return Reading(shape, names, rows, offsets, problem=problem)


def _positions(node: dict[str, Any]) -> list[Any] | None:
    for key in POSITIONS:
        value = node.get(key)
        if isinstance(value, list) and all(v is None or is_number(v) for v in value):
            return value
    return None


def _interface(node: dict[str, Any]) -> Any:
    names, values = node.get("interface_names"), node.get("values")
    if not isinstance(names, list) or not isinstance(values, list) or "position" not in names:
        return None
    at = names.index("position")
    return values[at] if at < len(values) else None


def _pairs(items: list[Any]) -> Reading | None:
    # a list of {name, position}; the name may be called an id, where it is a text
    if not items or not all(isinstance(item, dict) for item in items):
        return None
    names, row = [], []
    for item in items:
        name = next((item[k] for k in ("name", "joint", "joint_name", *IDS) if isinstance(item.get(k), str)), None)
        value = next((item[k] for k in (*POSITIONS, "value") if k in item), None)
        if not name or not (value is None or is_number(value)):
            return None
        names.append(name)
        row.append(value)
    return Reading("list", tuple(names), (row,)) if any(value is not None for value in row) else None


def _numbers(node: Any, path: str, values: dict[str, Any], stamp: str, depth: int) -> None:
    if len(values) >= _MANY or depth > _DEEP:
        return
    if is_number(node):
        values[path] = node
    elif isinstance(node, dict):
        for key, child in node.items():
            inner = f"{path}.{key}" if path else str(key)
            if inner != stamp and inner not in ("header", "layout"):
                _numbers(child, inner, values, stamp, depth + 1)
    elif isinstance(node, list):
        key, labels = _labels(node[:_MANY])
        for label, child in zip(labels, node, strict=False):
            inside = {k: v for k, v in child.items() if k != key} if key else child
            _numbers(inside, f"{path}[{label}]", values, stamp, depth + 1)


def _labels(items: list[Any]) -> tuple[str, list[str]]:
    # what tells the objects of a list apart: an id that each has, and none twice; else their places
    if items and all(isinstance(item, dict) for item in items):
        for key in IDS:
            ids = [item.get(key) for item in items]
            if all(isinstance(i, (int, str)) and not isinstance(i, bool) for i in ids) and len(set(ids)) == len(ids):
                return key, [f"{key}={i}" for i in ids]
    return "", [str(i) for i in range(len(items))]


def _stamp(tree: dict[str, Any]) -> Stamp | None:
    for prefix, node in (("header.", tree.get("header")), ("", tree)):
        if not isinstance(node, dict):
            continue
        if not prefix and any(key in node for key in _NANOS) and (pair := _pair(node)):
            return Stamp("sec", pair, None)
        for key, value in node.items():
            match = _CLOCK.fullmatch(str(key))
            if match is None:
                continue
            pair = _pair(value)
            if pair is not None:
                return Stamp(prefix + key, pair, None)
            if is_number(value) and not (isinstance(value, Slot) and prefix):
                unit = match.group("unit")
                return Stamp(prefix + key, (value,), _UNITS[unit.lower()] if unit else None)
            if isinstance(value, str) and (moment := _moment(value)):
                return Stamp(prefix + key, moment, None)
    return None


def _pair(node: Any) -> tuple[Any, Any] | None:
    if not isinstance(node, dict):
        return None
    seconds = next((node[key] for key in _SECONDS if is_number(node.get(key))), None)
    nanos = next((node[key] for key in _NANOS if is_number(node.get(key))), None)
    return None if seconds is None or nanos is None else (seconds, nanos)


def _moment(text: str) -> tuple[int, int] | None:
    # a time in ISO 8601, as protobuf's JSON has it
    from datetime import UTC, datetime

    match = re.fullmatch(r"(\d{4}-\d\d-\d\d[T ]\d\d:\d\d:\d\d)(\.\d{1,9})?(Z|[+-]\d\d:?\d\d)?", text)
    if match is None:
        return None
    try:
        moment = datetime.fromisoformat(match.group(1) + (match.group(3) or "Z"))
    except ValueError:
        return None
    nanos = int((match.group(2) or ".0")[1:].ljust(9, "0"))
    return int((moment - datetime(1970, 1, 1, tzinfo=UTC)).total_seconds()), nanos


def _texts(value: Any) -> bool:
    return isinstance(value, list) and bool(value) and all(isinstance(v, str) for v in value)
