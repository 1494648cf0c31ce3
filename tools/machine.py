"""The machine that a benchmark ran on."""

from __future__ import annotations

import os
import platform
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path


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
