"""A card: a title, a picture with its legend, and what is to be known in two columns, as HTML."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from html import escape

LONGEST = 240
"""Most characters of a line; what is longer is cut, as at a prompt."""
MOST_LINES = 8
"""Most lines of one list; the rest is counted."""


def card(
    title: str,
    facts: Mapping[str, str | Sequence[str]],
    picture: str = "",
    legend: Mapping[str, str] | None = None,
) -> str:
    """A card as an HTML element that needs nothing from elsewhere.

    Args:
        title: what it is of.
        facts: what is to be known, by what it is; several lines where there are several; what is empty is left out.
        picture: an SVG element.
        legend: colours of the picture by what they mean.
    """
    rows = "".join(_row(name, value) for name, value in facts.items() if value)
    keys = " &ensp; ".join(
        f'<span style="color:{colour}">&#9632;</span> {escape(name)}' for name, colour in (legend or {}).items()
    )
    shown = f'<div>{picture}<div style="font-size:85%">{keys}</div></div>' if picture else ""
    return (
        f'<div style="max-width:64em"><div style="font-weight:bold;margin:.3em 0">{_cut(title)}</div>'
        f'<div style="display:flex;flex-wrap:wrap;gap:1em;align-items:flex-start">{shown}'
        f'<table style="border-collapse:collapse;text-align:left;margin:0"><tbody>{rows}</tbody></table></div></div>'
    )


def _row(name: str, value: str | Sequence[str]) -> str:
    lines = [value] if isinstance(value, str) else list(value)
    told = [_cut(line) for line in lines[:MOST_LINES]]
    if lines[MOST_LINES:]:
        told.append(f"and {len(lines) - MOST_LINES} more")
    cell = "text-align:left;vertical-align:top;padding:.1em .6em .1em 0"
    return (
        f'<tr><th style="{cell};font-weight:normal;opacity:.7">{escape(name)}</th>'
        f'<td style="{cell}">{"<br>".join(told)}</td></tr>'
    )


def _cut(line: str) -> str:
    return escape(line if len(line) <= LONGEST else line[: LONGEST - 3] + "...")
