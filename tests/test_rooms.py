"""The rooms of the package: imports point one way, without a circle."""

from __future__ import annotations

import ast
from graphlib import TopologicalSorter
from pathlib import Path

import pytest

import ggo_factors

PACKAGE = Path(ggo_factors.__file__).parent
ROOMS = (
    *("errors", "support", "datasets", "notebook", "motion", "seeing", "factors", "check", "graph", "walking"),
    *("procedures", "planning", "evaluate", "sweeps"),
    *(
        "recording.log",
        "recording.sources",
        "recording.strides",
        "recording.transforms",
        "recording.clouds",
        "recording.played_log",
        "recording.each_leg",
        "recording.import_card",
        "recording.report",
        "recording.report_file",
        "recording.flight_ends",
        "recording.plausible",
        "recording.base_gait",
        "recording.learning",
        "recording.compare",
    ),
    *("recording.export", "plot", "page", "cli"),
)
MODULES = {
    ".".join(path.relative_to(PACKAGE.parent).with_suffix("").parts): path for path in sorted(PACKAGE.rglob("*.py"))
}


def imported_by(module: str) -> set[str]:
    """Modules of this package that a module imports, also inside its functions."""
    found = set()
    for node in ast.walk(ast.parse(MODULES[module].read_text())):
        if isinstance(node, ast.Import):
            found |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{module}: a relative import"
            parts = {f"{node.module}.{alias.name}" for alias in node.names}
            found |= {part if part in MODULES or f"{part}.__init__" in MODULES else str(node.module) for part in parts}
    names = {name if name in MODULES else f"{name}.__init__" for name in found}
    return {name for name in names if name in MODULES}


def room_of(module: str) -> int:
    """The place of a module's room in their order."""
    inside = module.removeprefix("ggo_factors.").removesuffix(".__init__")
    return max((n for n, room in enumerate(ROOMS) if f"{inside}.".startswith(f"{room}.")), default=-1)


@pytest.mark.parametrize("module", [name for name in MODULES if name != "ggo_factors.__init__"])
def test_imports_point_up_the_list_of_rooms(module):
    own = room_of(module)
    assert own >= 0 or module == "ggo_factors.recording.__init__", f"{module} is in no room"
    for other in imported_by(module):
        if other == "ggo_factors.__init__":
            assert ROOMS[own] == "cli", f"{module} imports the whole package"
        else:
            assert room_of(other) <= own, f"{module} imports {other}"


def test_there_is_no_circle_of_imports():
    graph = {module: imported_by(module) - {"ggo_factors.__init__"} for module in MODULES}
    assert len(tuple(TopologicalSorter(graph).static_order())) == len(MODULES)


def test_few_files_stand_at_the_root():
    assert len(list(PACKAGE.glob("*.py"))) <= 6
