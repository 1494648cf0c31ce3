"""What a notebook shows of a dense check: what was seen, in numbers, and lengths as bars."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import numpy as np

from ggo_factors.errors import Violation
from ggo_factors.notebook.card import card
from ggo_factors.notebook.svg import INK, SUPPORT, SWING, Shape, Text, svg

WIDE, ROW = 420, 20
"""Width of the picture and height of a bar with its room in pixels."""
NAMES, NUMBERS = 0.45, 0.16
"""Shares of the width that the names and the numbers of the bars take."""


def seen(numbers: Mapping[str, float], speed: float, knee: float) -> dict[str, str]:
    """Rows of a card: lengths in [m] in millimetres, landing speed in [m/s], least knee angle in [rad] in degrees."""
    rows = {name: f"{value * 1e3:.1f} mm" for name, value in numbers.items() if math.isfinite(value)}
    rows |= {} if math.isnan(speed) else {"landing speed": f"{speed:.2f} m/s"}
    return rows | {"least knee angle": f"{math.degrees(knee):.1f} degrees"}


def verdict(violations: Sequence[Violation]) -> str:
    """What the check says, in words."""
    return (
        f"✗ {len(violations)} limit{'s' if len(violations) > 1 else ''} broken" if violations else "✓ no limit broken"
    )


def report_card(
    violations: Sequence[Violation], numbers: Mapping[str, float], rows: Mapping[str, str], notes: Sequence[str]
) -> str:
    """A card of a check.

    Args:
        violations: the limits that are broken.
        numbers: lengths in [m] by name; those that are not finite do not apply.
        rows: what else to tell, by name.
        notes: what should be known though it breaks no limit.
    """
    facts = {"broken": list(map(str, violations)), **rows, "notes": notes}
    return card(f"Check: {verdict(violations)}", facts, _bars(numbers))


def _bars(numbers: Mapping[str, float]) -> str:
    """Lengths as bars, each with its number in mm; below 0 to the left."""
    known = {name: value * 1e3 for name, value in numbers.items() if math.isfinite(value)}
    if not known:
        return ""
    low, high = min(0.0, *known.values()), max(0.0, *known.values())
    unit = max(high - low, 1e-9) / (WIDE * (1.0 - NAMES - NUMBERS))
    left, right = low - WIDE * NAMES * unit, high + WIDE * NUMBERS * unit
    frame = np.array([[left, -len(known)], [right, 0.0]])
    shapes, texts = [], []
    for row, (name, value) in enumerate(known.items()):
        bar = np.array([[0.0, 0.2], [value, 0.2], [value, 0.8], [0.0, 0.8]]) - [0.0, row + 1.0]
        shapes.append(Shape(bar, SWING if value < 0.0 else SUPPORT, 0.0))
        texts.append(Text(left, -row - 0.7, name))
        texts.append(Text(max(value, 0.0) + 4.0 * unit, -row - 0.7, f"{value:.1f} mm"))
    shapes.append(Shape(np.array([[0.0, -len(known)], [0.0, 0.0]]), INK, 1.0))
    return svg(shapes, "lengths in mm", texts=texts, size=(WIDE, ROW * len(known)), frame=frame)
