"""How the chapters of the analogy with SLAM are shown: tables on the screen, and one figure in a file."""

from __future__ import annotations

import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import click
from matplotlib.figure import Figure

from ggo_factors.cli.console import console
from ggo_factors.support.files import replacing

OUT = click.option(
    "--out", type=click.Path(path_type=Path), default=Path("out"), show_default=True, help="Folder to write to."
)


def tell_and_draw(text: str | None, run: Callable[[Figure], Any], size: tuple[float, float], path: Path) -> None:
    """Print what the chapters are about, run them, and write what they draw.

    Args:
        text: what they are about.
        run: prints their tables, and draws on the figure that it is given.
        size: width and height of the figure in [inch].
        path: its file; its folder is made.
    """
    began = time.perf_counter()
    console().print(text, markup=False)
    path.parent.mkdir(parents=True, exist_ok=True)
    figure = Figure(figsize=size, layout="constrained")
    run(figure)
    with replacing(path) as temporary:
        figure.savefig(temporary, dpi=110)
    console().print(f"figure in {path}; {time.perf_counter() - began:.1f} s", markup=False)
