"""How fast the library is, beside what a user would do without it: in one run, medians of interleaved repeats.

Machines are shared and noisy: read the ratios, and the CPU times. See `--help`.
"""

from __future__ import annotations

from importlib import import_module
from typing import Any

import click

NAMES = ("balance", "importing", "pace", "planning", "reading", "refusals", "replanning", "solving", "sweeping")


class _Benchmarks(click.Group):
    """Each command in a module of its own, loaded when it is asked for: worker processes load this file too."""

    def list_commands(self, _: click.Context) -> list[str]:
        return list(NAMES)

    def get_command(self, _: click.Context, name: str) -> click.Command | None:
        if name not in NAMES:
            return None
        command: Any = getattr(import_module(f"benchmark_{name}"), name)
        return command  # type: ignore[no-any-return]


@click.command(cls=_Benchmarks)
def cli() -> None:
    """Benchmarks, each a table on the screen and JSON on request."""


if __name__ == "__main__":
    cli()
