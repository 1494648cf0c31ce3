"""The notebooks run from first to last cell, and are stored without what they print and draw.

Cells run here in the tests' own process, in a fifth of a kernel's time; building the pages runs them in a kernel.
"""

from __future__ import annotations

import ast
import json
from pathlib import Path
from typing import Any

import matplotlib.pyplot as plt
import pytest
from doc_blocks import ROOT

NOTEBOOKS = sorted((ROOT / "notebooks").glob("*.ipynb"))


def test_there_are_two():
    assert [path.stem for path in NOTEBOOKS] == ["a_gait_graph_taken_apart", "from_a_log_to_a_walk"]


def run_cell(source: str, name: str, session: dict[str, Any]) -> Any:
    """Run a cell; what its last line is worth, where that is an expression that a notebook would show."""
    tree, shown = ast.parse(source), None
    if isinstance(tree.body[-1], ast.Expr) and not source.rstrip().endswith(";"):
        shown = ast.Expression(tree.body.pop().value)  # type: ignore[attr-defined]
    exec(compile(tree, name, "exec"), session)
    return None if shown is None else eval(compile(shown, name, "eval"), session)


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_a_notebook_runs(path: Path, tmp_path: Path, monkeypatch, capsys):
    cells = [cell for cell in json.loads(path.read_text(encoding="utf-8"))["cells"] if cell["cell_type"] == "code"]
    assert len(cells) > 5
    assert all(not cell["outputs"] and cell["execution_count"] is None for cell in cells), "stored with outputs"
    monkeypatch.chdir(tmp_path)
    session: dict[str, Any] = {"__name__": "__main__"}
    try:
        shown = [run_cell("".join(cell["source"]), f"{path.name}, cell {n}", session) for n, cell in enumerate(cells)]
        assert len(plt.get_fignums()) > 2
    finally:
        plt.close("all")
    for value in shown:
        if hasattr(value, "_repr_html_"):
            assert len(value._repr_html_()) < 60_000
    captured = capsys.readouterr()
    assert captured.out
    assert not captured.err
    assert not list(tmp_path.iterdir())
