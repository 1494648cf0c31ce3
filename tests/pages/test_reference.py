"""The reference has every public name, and the tables of the pages have every parameter as it is."""

from __future__ import annotations

import inspect
import math
import re
from dataclasses import fields
from typing import Any

import pytest
from doc_blocks import ROOT

import ggo_factors as ggo
from ggo_factors import plot

API = "\n".join(path.read_text(encoding="utf-8") for path in sorted((ROOT / "docs" / "api").glob("*.md")))
NAMED = re.findall(r"^\.\. (?:auto\w+:: ggo_factors\.|py:data:: )([\w.]+)$", API, re.MULTILINE)
ITEM = re.compile(r"^    (\w+): (.*(?:\n        .*)*)", re.MULTILINE)
NUMERIC = re.compile(r"\bfloat\b|\bArray\b|\bArrayLike\b")
UNIT = re.compile(r"\[[^\]]+\]|\bseconds\b|\ba second\b|in degrees|in the unit of|the same (?:of|as)|the same,|`\w+`")
NO_UNIT = re.compile(
    r"\b(?:gain|omega|share|part|phase|probab\w+|steepness|nats|frames?)\b"
    r"|was wrong|error at|base gait's|value found|limit that"
)
"""Words of what has no unit, or of what is told with its own (`Violation.unit`)."""


def documented() -> list[tuple[str, Any]]:
    """Each public function and class, and each method that a class defines itself."""
    found = list[tuple[str, Any]]()
    for name in ggo.__all__:
        thing = getattr(ggo, name)
        if callable(thing):
            found.append((name, thing))
        if isinstance(thing, type):
            methods = ((key, getattr(value, "__func__", value)) for key, value in vars(thing).items())
            found += [(f"{name}.{key}", m) for key, m in methods if inspect.isfunction(m) and not key.startswith("_")]
    return found


def test_every_public_name_is_in_the_reference_once():
    figures = [f"plot.{name}" for name in plot.__all__ if name.startswith("plot_")]
    assert sorted(NAMED) == sorted([*ggo.__all__, *figures])


def test_every_number_states_its_unit():
    """Each argument and attribute that is a number says its unit in brackets, or in its name, or that it has none."""
    looked_at = 0
    for name, thing in documented():
        text = inspect.getdoc(thing) or ""
        assert text, f"{name} has no docstring"
        annotated = dict(getattr(thing, "__annotations__", {}))
        if isinstance(thing, type):
            annotated |= getattr(thing.__init__, "__annotations__", {})
        head = text.split("\n\n")[0]
        for item, words in ITEM.findall(text):
            if not NUMERIC.search(str(annotated.get(item, ""))) or item.endswith(("_deg", "_hz", "milliseconds")):
                continue
            looked_at += 1
            assert any(rule.search(words) for rule in (UNIT, NO_UNIT)) or UNIT.search(head), f"{name}: {item}: {words}"
    assert looked_at > 150


def test_the_table_of_tolerances_has_each_as_it_is():
    page = (ROOT / "docs" / "safety.md").read_text(encoding="utf-8")
    rows = dict(re.findall(r"^\| `(\w+)` \| (\S+) \|.*$", page, re.MULTILINE))
    units = dict(re.findall(r"^\| `(\w+)` \| \S+ \| (\S+) \|.*$", page, re.MULTILINE))
    assert list(rows) == [field.name for field in fields(ggo.Tolerances)]
    for name, shown in rows.items():
        value = getattr(ggo.Tolerances(), name)
        if value is None:
            assert shown == "none"
        else:
            assert float(shown) == pytest.approx(math.degrees(value) if units[name] == "deg" else value), name


def test_the_table_of_parameters_has_each_parameter_of_a_step():
    page = (ROOT / "docs" / "parameters.md").read_text(encoding="utf-8")
    taken = set(inspect.signature(ggo.step_over).parameters) | set(inspect.signature(ggo.GaitGraph).parameters)
    asked = {"base", "obstacles", "foothold", "gaps", "model", "first_swing", "style"}  # what to do, not how
    assert taken - asked <= set(re.findall(r"`(\w+)`", page))
