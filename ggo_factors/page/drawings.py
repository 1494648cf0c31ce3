"""Drawings of a report as SVG, made of its numbers: joint angles over time, and the strip of figures for print."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from html import escape
from typing import Any

WIDTH, HEIGHT = 360, 210
"""Size of a chart in its own units: pixels where it stands alone in the narrowest page."""
LEFT, RIGHT, TOP, BOTTOM = 40, 8, 8, 34
"""Margins of a chart for its labels."""
FIGURES = 8
"""Figures in the strip: two rows of four fill a page's width."""
MM = 1e3
"""Figures are drawn in millimetres."""

Points = Sequence[tuple[float, float]]
Place = Callable[[float, float], tuple[float, float]]


def angle_charts(numbers: dict[str, Any], names: dict[str, str]) -> dict[str, str]:
    """A chart for each joint, those of both hips and those of both knees on the same scale.

    Args:
        numbers: the report's JSON.
        names: what to call each joint.
    """
    begins, charts = [step["begins_s"] for step in numbers["steps"]], dict[str, str]()
    for joint, curves in numbers["angles"].items():
        alike = [other for key, other in numbers["angles"].items() if key.split()[1] == joint.split()[1]]
        ranges = [_range(other) for other in alike]
        low, high = min(least for least, _ in ranges), max(most for _, most in ranges)
        charts[joint] = _angle_chart(joint, names[joint], curves, begins, (low, high))
    return charts


def _range(curves: dict[str, Any]) -> tuple[float, float]:
    """Least and largest angle of a chart in [deg]."""
    base = curves.get("base_deg", curves["deg"])
    around = curves.get("base_sd_deg", [0.0] * len(base))
    low = min(at - sd for at, sd in zip(base, around, strict=True))
    high = max(at + sd for at, sd in zip(base, around, strict=True))
    return min(low, *curves["deg"]), max(high, *curves["deg"])


def _angle_chart(
    joint: str, name: str, curves: dict[str, Any], begins: Sequence[float], between: tuple[float, float]
) -> str:
    """One joint's angle over time, the base gait's dashed, with a band of its spread where that is known.

    Args:
        joint: which, for example `left hip`; its first word chooses the colour.
        name: what to call it.
        curves: times in [s] and angles in [deg] of the report's JSON.
        begins: times at which steps begin in [s].
        between: least and largest angle of the scale in [deg].
    """
    times, angles = curves["time_s"], curves["deg"]
    base, spread = curves.get("base_deg"), curves.get("base_sd_deg")
    ticks = _ticks(*between, 5)
    low, high = min(between[0], ticks[0]), max(between[1], ticks[-1])
    across = (WIDTH - LEFT - RIGHT) / (times[-1] - times[0])
    up = (HEIGHT - TOP - BOTTOM) / (high - low)

    def place(time: float, angle: float) -> tuple[float, float]:
        return LEFT + (time - times[0]) * across, HEIGHT - BOTTOM - (angle - low) * up

    parts = _axes(place, ticks, _ticks(times[0], times[-1], 6), low)
    for begin in begins[1:]:
        x, _ = place(begin, low)
        parts.append(f'<line class="swap" x1="{x:.1f}" y1="{TOP}" x2="{x:.1f}" y2="{HEIGHT - BOTTOM}"/>')
    if base is not None and spread is not None:
        upper = [place(t, b + s) for t, b, s in zip(times, base, spread, strict=True)]
        lower = [place(t, b - s) for t, b, s in zip(times, base, spread, strict=True)]
        parts.append(f'<polygon class="band" points="{_points([*upper, *reversed(lower)])}"/>')
    if base is not None:
        parts.append(f'<polyline class="base" points="{_points([place(*p) for p in zip(times, base, strict=True)])}"/>')
    leg = joint.partition(" ")[0]
    own = [place(*pair) for pair in zip(times, angles, strict=True)]
    parts.append(f'<polyline class="own {leg}" points="{_points(own)}"/>')
    parts.append(
        f'<line class="now" x1="{LEFT}" y1="{TOP}" x2="{LEFT}" y2="{HEIGHT - BOTTOM}" data-first="{LEFT}" '
        f'data-last="{WIDTH - RIGHT}"/>'
    )
    said = f"{name} over time: from {min(angles):.0f} to {max(angles):.0f} degrees"
    return (
        f'<svg class="chart" role="img" aria-label="{escape(said)}" viewBox="0 0 {WIDTH} {HEIGHT}">'
        + "".join(parts)
        + "</svg>"
    )


def _axes(place: Place, angles: Sequence[float], times: Sequence[float], low: float) -> list[str]:
    """Lines and labels of a chart's scales."""
    parts = list[str]()
    for tick in angles:
        _, y = place(times[0], tick)
        parts.append(f'<line class="grid" x1="{LEFT}" y1="{y:.1f}" x2="{WIDTH - RIGHT}" y2="{y:.1f}"/>')
        parts.append(f'<text x="{LEFT - 5}" y="{y + 4:.1f}" text-anchor="end">{_short(tick)}</text>')
    for tick in times:
        x, y = place(tick, low)
        parts.append(f'<line class="tick" x1="{x:.1f}" y1="{y:.1f}" x2="{x:.1f}" y2="{y + 4:.1f}"/>')
        parts.append(f'<text x="{x:.1f}" y="{y + 16:.1f}" text-anchor="middle">{_short(tick)}</text>')
    return [*parts, f'<text x="{WIDTH - RIGHT}" y="{HEIGHT - 4}" text-anchor="end">time [s]</text>']


def strip(numbers: dict[str, Any]) -> str:
    """Figures of the legs at instants over the walk, for print and where no script runs.

    They are evenly apart, but the one nearest to the least clearance over an obstacle is moved there.
    """
    motion, scene = numbers["motion"], numbers["scene"]
    return "".join(_figure(numbers, motion, scene, at) for at in _pictured(motion))


def scene_parts(scene: dict[str, Any]) -> str:
    """Ground, obstacles, gaps and footholds in [mm], y down."""
    (left, _), *_, (right, _) = scene["ground"]
    line = [(x * MM, -y * MM) for x, y in scene["ground"]]
    bottom = max(y for _, y in line) + 2.0 * MM
    parts = [
        "".join(_box("cautious", box["cautious"]) for box in scene["boxes"] if "cautious" in box),
        "".join(_box("obstacle", box) for box in scene["boxes"]),
        f'<polygon class="ground" points="{_points([*line, (right * MM, bottom), (left * MM, bottom)])}"/>',
        f'<polyline class="ground-line" points="{_points(line)}"/>',
        "".join(_box("unknown" if pit["unknown"] else "gap", pit) for pit in scene["pits"]),
        "".join(_cross(x * MM, -y * MM) for x, y in scene["footholds"]),
    ]
    return "".join(parts)


def _box(kind: str, box: dict[str, Any]) -> str:
    x, y = box["x_start"] * MM, -box["top"] * MM
    width, height = (box["x_end"] - box["x_start"]) * MM, (box["top"] - box["low"]) * MM
    return f'<rect class="{kind}" x="{x:.1f}" y="{y:.1f}" width="{width:.1f}" height="{max(height, 1.0):.1f}"/>'


def _cross(x: float, y: float) -> str:
    return f'<path class="foothold" d="M{x - 15:.1f} {y - 15:.1f}l30 30m0 -30l-30 30"/>'


def _pictured(motion: dict[str, Any]) -> list[int]:
    """Which instants the strip shows."""
    last = len(motion["time_s"]) - 1
    chosen = sorted({round(last * k / (FIGURES - 1)) for k in range(FIGURES)})
    over = [(clear, at) for at, clear in enumerate(motion["clearance_mm"]) if clear is not None]
    if over:
        _, lowest = min(over)
        nearest = min(range(len(chosen)), key=lambda k: abs(chosen[k] - lowest))
        chosen[nearest] = lowest
    return sorted(set(chosen))


def _figure(numbers: dict[str, Any], motion: dict[str, Any], scene: dict[str, Any], at: int) -> str:
    """The legs at one instant, with what is near them, and what is said of it."""
    places = motion["joints_m"][at]
    model = numbers["source"]["model"]
    reach = model["thigh_m"] + model["shank_m"]
    x, y = places[4] * MM, -places[5] * MM
    size = 1.5 * reach * MM
    view = f"{x - size / 2:.1f} {y - 0.15 * size:.1f} {size:.1f} {size:.1f}"
    legs = "".join(leg_parts(motion, at, leg, model) for leg in ("left", "right"))
    said = f"{motion['time_s'][at]:.2f} s, step {motion['step'][at]}"
    clear = motion["clearance_mm"][at]
    if clear is not None:
        said += f"<br>clears by {clear:.1f} mm".replace("-", "\u2212")
    return (
        f'<figure><svg role="img" aria-label="legs at {motion["time_s"][at]:.2f} s" viewBox="{view}">'
        f"{scene_parts(scene)}{legs}</svg><figcaption>{said}</figcaption></figure>"
    )


def leg_parts(motion: dict[str, Any], at: int, leg: str, model: dict[str, float]) -> str:
    """One leg as a line from the hip to the ankle, its joints, and its sole if it has one, in [mm], y down."""
    places, tilt = motion["joints_m"][at], motion["tilt_rad"][at][0 if leg == "left" else 1]
    order = (2, 1, 0) if leg == "left" else (2, 3, 4)
    points = [(places[2 * k] * MM, -places[2 * k + 1] * MM) for k in order]
    parts = [f'<polyline class="leg {leg}" points="{_points(points)}"/>']
    if model["heel_m"] + model["toe_m"] > 0.0:
        (x, y), along, down = points[-1], math.cos(tilt) * MM, math.sin(tilt) * MM
        under = (x + model["ankle_m"] * down, y + model["ankle_m"] * along)
        ends = [(under[0] + length * along, under[1] - length * down) for length in (-model["heel_m"], model["toe_m"])]
        parts.append(f'<polygon class="foot {leg}" points="{_points([*ends, (x, y)])}"/>')
    for x, y in points[1:]:
        if leg == "left":
            parts.append(f'<circle class="joint left" cx="{x:.1f}" cy="{y:.1f}" r="17"/>')
        else:
            parts.append(f'<rect class="joint right" x="{x - 15:.1f}" y="{y - 15:.1f}" width="30" height="30"/>')
    return "".join(parts)


def _points(points: Points) -> str:
    return " ".join(f"{x:.1f},{y:.1f}" for x, y in points)


def _ticks(low: float, high: float, most: int) -> list[float]:
    """Round numbers between two, at most so many; the two around a value that hardly changes."""
    span = max(high - low, 1e-6)
    raw = span / most
    step = 10.0 ** math.floor(math.log10(raw))
    step *= next(factor for factor in (1, 2, 5, 10) if factor * step >= raw)
    first, last = math.ceil(low / step - 1e-9), math.floor(high / step + 1e-9)
    ticks = [k * step for k in range(first, last + 1)]
    return ticks if len(ticks) > 1 else [math.floor(low / step) * step, (math.floor(high / step) + 1) * step]


def _short(value: float) -> str:
    return f"{value:.3g}".replace("-", "\u2212")
