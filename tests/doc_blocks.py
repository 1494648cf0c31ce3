"""Runs the code blocks of a page of Markdown in their order, as a reader would who copies one after another."""

from __future__ import annotations

import re
import shlex
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

import matplotlib.pyplot as plt
import pytest

from ggo_factors.cli import main
from ggo_factors.recording.log.joint_map import load_joint_map

ROOT = Path(__file__).parents[1]
FENCE = re.compile(r"^```([^\n`]*)\n(.*?)^```$", re.MULTILINE | re.DOTALL)
MAKE_TARGETS = set(re.findall(r"^([a-z]+):", (ROOT / "Makefile").read_text(encoding="utf-8"), re.MULTILINE))
NOT_RUN = ("pip install ", "ros2 action send_goal ", ". .venv/bin/activate", "pre-commit install")
"""How shell lines begin that need the net or a robot: they are shown and not run."""


class Block(NamedTuple):
    """A fenced block.

    Attributes:
        language: what stands behind the fence; directives of the pages stand in braces.
        text: its lines.
        line: line of the page that it starts on.
    """

    language: str
    text: str
    line: int


def blocks(page: Path) -> list[Block]:
    """All fenced blocks of a page."""
    text = page.read_text(encoding="utf-8")
    return [Block(found[1], found[2], text.count("\n", 0, found.start()) + 2) for found in FENCE.finditer(text)]


def run_page(page: Path, folder: Path, capsys: pytest.CaptureFixture[str]) -> list[str]:
    """Run each block of a page in a folder, Python blocks in one session; returns the languages of what was run.

    TOML is written to the file that its first line names, `# NAME.toml`. Text is what the block before printed.
    """
    session: dict[str, Any] = {"__name__": "__main__"}
    ran = list[str]()
    for block in blocks(page):
        if block.language.startswith("{"):
            continue
        where = f"{page.name}, line {block.line}"
        if block.language == "python":
            # The line numbers of a traceback are those of the page.
            source = "\n" * (block.line - 1) + block.text
            try:
                exec(compile(source, str(page), "exec"), session)
            finally:
                plt.close("all")
            # What the text says to be so is printed as True.
            assert "False" not in capsys.readouterr().out, where
        elif block.language == "toml":
            first = block.text.splitlines()[0]
            assert re.fullmatch(r"# \w+\.toml", first), f"{where}: its first line must name a file"
            (folder / first.removeprefix("# ")).write_text(block.text, encoding="utf-8")
            if "[alpha_left]" in block.text:
                load_joint_map(folder / first.removeprefix("# "))
        else:
            assert block.language == "console", f"{where}: nobody runs a block in {block.language!r}"
            for line in commands(block):
                run_line(line, where, capsys)
        ran.append(block.language)
    return ran


def commands(block: Block) -> Iterator[str]:
    """The lines of a console block that are not empty."""
    return (line for line in block.text.splitlines() if line.strip())


def run_line(line: str, where: str, capsys: pytest.CaptureFixture[str]) -> None:
    """One shell line: `ggo` is run; of `make` the target, of `python` the script must be there; others are known."""
    command, _, comment = line.partition("  #")
    words = shlex.split(command)
    if words[0] == "make":
        assert words[1] in MAKE_TARGETS, f"{where}: no target {words[1]}"
    elif words[0] == "python":
        assert (ROOT / words[1]).is_file(), f"{where}: no script {words[1]}"
    elif words[0] == "ggo":
        refused = comment.strip().startswith("refused")
        capsys.readouterr()
        code = main(words[1:])
        captured = capsys.readouterr()
        assert code == (2 if refused else 0), f"{where}: {line}\n{captured.err}"
        # A refusal is one line, and says nothing on standard output.
        assert not refused or (captured.out.strip() == "" and len(captured.err.splitlines()) == 1), where
    else:
        assert line.startswith(NOT_RUN), f"{where}: nobody runs {line!r}"
