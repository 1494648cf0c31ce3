"""The benchmark of imports: what `import ggo_factors` takes beyond gtsam and numpy, which it cannot do without."""

from __future__ import annotations

import re
import statistics
import subprocess
import sys
import time
from pathlib import Path

import click
from machine import stated, tell
from rich.table import Table

NEEDED, OURS = "import gtsam, numpy", "import ggo_factors"
GOAL_S = 0.5
MOST_SHOWN = 12


@click.command()
@click.option("--repeats", type=click.IntRange(1), default=15, show_default=True, help="Interleaved, after a warm-up.")
@click.option("--json", "json_path", type=click.Path(path_type=Path), help="Write the numbers here too.")
def importing(repeats: int, json_path: Path | None) -> None:
    """Import the library in a new process, beside gtsam and numpy alone; and the modules that take longest."""
    machine = stated()
    times: dict[str, list[float]] = {code: [] for code in (NEEDED, OURS)}
    for turn in range(repeats + 1):
        for code, each in times.items():
            begin = time.perf_counter()
            subprocess.run([sys.executable, "-c", code], check=True)
            if turn:
                each.append(time.perf_counter() - begin)
    medians = {code: statistics.median(each) for code, each in times.items()}
    more = medians[OURS] - medians[NEEDED]
    slowest = _slowest()
    table = Table(title=f"{more:.2f} s more than gtsam and numpy (goal {GOAL_S:g} s)", title_justify="left")
    for heading in ("what", "ms"):
        table.add_column(heading, justify="left" if heading == "what" else "right")
    for code, seconds in medians.items():
        table.add_row(code, f"{seconds * 1e3:.0f}")
    table.add_section()
    for module, seconds in slowest.items():
        table.add_row(f"{module}, itself", f"{seconds * 1e3:.1f}")
    measured = {"median_s": medians, "more_s": more, "goal_s": GOAL_S, "met": more <= GOAL_S, "slowest_s": slowest}
    tell(table, machine, json_path, **measured)


def _slowest() -> dict[str, float]:
    """Modules that gtsam and numpy do not need, by the seconds that each takes itself, longest first."""
    code = f"{NEEDED}; import sys; print('MARK', file=sys.stderr); {OURS}"
    ran = subprocess.run([sys.executable, "-X", "importtime", "-c", code], check=True, capture_output=True, text=True)
    found = re.findall(r"import time:\s+(\d+) \|\s+\d+ \|\s+(\S+)", ran.stderr.partition("MARK")[2])
    longest = sorted(((int(microseconds), module) for microseconds, module in found), reverse=True)[:MOST_SHOWN]
    return {module: microseconds * 1e-6 for microseconds, module in longest}
