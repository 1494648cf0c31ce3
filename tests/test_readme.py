"""What the README shows runs as it stands there."""

from __future__ import annotations

import re
import shlex
from pathlib import Path

import matplotlib.pyplot as plt
import pytest

from ggo_factors.cli import main
from ggo_factors.recording.log.joint_map import load_joint_map, preset_map

ROOT = Path(__file__).parents[1]
README = (ROOT / "README.md").read_text(encoding="utf-8")
BLOCK = re.compile(r"^```(\w+)\n(.*?)^```$", re.MULTILINE | re.DOTALL)


def blocks(language: str) -> list[object]:
    """The code blocks in a language, each named by the line of the README that it starts on."""
    found = [match for match in BLOCK.finditer(README) if match[1] == language]
    assert found, f"README.md has no block in {language}"
    return [pytest.param(match[2], id=f"line {README.count(chr(10), 0, match.start()) + 2}") for match in found]


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """An empty folder to work in, with the data sets where the README has them."""
    (tmp_path / "datasets").symlink_to(ROOT / "datasets", target_is_directory=True)
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.mark.parametrize("block", blocks("python"))
def test_python_blocks_run(block, folder, capsys):
    try:
        exec(compile(block, "README.md", "exec"), {"__name__": "__main__"})
    finally:
        plt.close("all")
    # What the text says to be so is printed as True.
    assert "False" not in capsys.readouterr().out
    named = set(re.findall(r'"([\w-]+\.(?:mcap|png))"', block))
    assert sorted(path.name for path in folder.iterdir() if path.is_file()) == sorted(named)


@pytest.mark.parametrize("block", blocks("toml"))
def test_toml_blocks_are_joint_maps(block, folder):
    path = folder / "map.toml"
    path.write_text(block, encoding="utf-8")
    joints = load_joint_map(path)
    assert joints.units == "rad"
    # OpenSim's names, flexion counted negative: the map says what the preset of that name does.
    assert joints.terms == preset_map("opensim-knee-negative", joints.names, "a log").terms


def test_commands_run_in_order(capsys):
    """Each `ggo` line of the console blocks in one folder; a line whose comment says "refused" is bad input."""
    lines = [line for param in blocks("console") for line in param.values[0].splitlines() if line.startswith("ggo ")]
    assert lines
    for line in lines:
        command, _, comment = line.partition("#")
        code = main(shlex.split(command)[1:])
        captured = capsys.readouterr()
        refused = comment.strip().startswith("refused")
        assert code == (2 if refused else 0), f"{line}\n{captured.err}"
        assert (captured.out.strip() == "") == refused
        assert len(captured.err.splitlines()) == int(refused)
