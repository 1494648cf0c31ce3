"""The examples run as they stand, in any folder, without a screen, and write what they say."""

from __future__ import annotations

import ast
import re
import runpy
from pathlib import Path

import matplotlib.pyplot as plt
import pytest

EXAMPLES = sorted((Path(__file__).parents[2] / "examples").glob("*.py"))


def test_there_are_eight_numbered_from_one():
    assert [path.name[:3] for path in EXAMPLES] == [f"{number:02d}_" for number in range(1, 9)]


def test_the_page_of_examples_has_each_with_its_output_and_its_picture():
    page = (EXAMPLES[0].parents[1] / "docs" / "examples.md").read_text(encoding="utf-8")
    for path in EXAMPLES:
        shown = (f"../examples/{path.name}", f"_made/examples/{path.stem}.txt", f"_made/examples/{path.stem}.png")
        assert all(page.count(file) == 1 for file in shown), path.name


@pytest.mark.parametrize("path", EXAMPLES, ids=lambda path: path.stem)
def test_an_example_runs(path, tmp_path, monkeypatch, capsys):
    text = path.read_text(encoding="utf-8")
    assert 20 <= len(text.splitlines()) <= 40
    said = ast.get_docstring(ast.parse(text)) or ""
    monkeypatch.chdir(tmp_path)
    try:
        runpy.run_path(str(path), run_name="__main__")
    finally:
        plt.close("all")
    assert capsys.readouterr().out
    written = {file.name for file in tmp_path.iterdir()}
    assert written == set(re.findall(r"\d\d_\w+\.\w+", said))
    assert f"{path.stem}.png" in written
