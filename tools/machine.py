"""The machine that a benchmark ran on, told beside what it measured."""

from __future__ import annotations

import json
import os
import platform
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

from rich.table import Table

from ggo_factors.cli.console import console
from ggo_factors.support.files import write_text


def stated() -> dict[str, str]:
    """Machine, load and software, in words."""
    try:
        cpu = next(line for line in Path("/proc/cpuinfo").read_text().splitlines() if line.startswith("model name"))
        processor = cpu.partition(":")[2].strip()
    except (OSError, StopIteration):
        processor = platform.processor()
    packages = []
    for package in ("ggo-factors", "gtsam", "numpy", "scipy", "pyceres"):
        try:
            packages.append(f"{package} {version(package)}")
        except PackageNotFoundError:
            packages.append(f"no {package}")
    load = f"{os.getloadavg()[0]:.1f} of {os.cpu_count()} cores" if hasattr(os, "getloadavg") else "unknown"
    return {
        "machine": f"{platform.platform()}, {processor}",
        "load at the start": load,
        "software": ", ".join([f"Python {platform.python_version()}", *packages]),
    }


def tell(table: Table, machine: dict[str, str], json_path: str | Path | None, **measured: Any) -> None:
    """Print a table and, below it, the machine; write both to a JSON file if there is to be one.

    Args:
        table: what was measured.
        machine: of `stated`.
        json_path: the file, or None.
        measured: the same for the file.
    """
    console().print(table)
    for key, value in machine.items():
        console().print(f"{key}: {value}", markup=False)
    if json_path:
        content = {"format_version": 1, "machine": machine, **measured}
        write_text(json_path, json.dumps(content, indent=1) + "\n")
