"""ARCHITECTURE.md names every module of the package, nothing that does not exist, and the rooms in their order."""

from __future__ import annotations

import re
from pathlib import Path

from test_rooms import MODULES, PACKAGE, ROOMS

ROOT = Path(__file__).parents[1]
PAGE = (ROOT / "ARCHITECTURE.md").read_text(encoding="utf-8")
LINE = re.compile(r"^( *)([\w.]+(?:\.py|/)) {2,}\S")


def tree() -> list[str]:
    """The modules that the page's tree has a line for, as they are imported, in its order."""
    _, block, _ = PAGE.split("```")
    named, folders = list[str](), list[str]()
    for line in block.strip("\n").splitlines():
        match = LINE.match(line)
        assert match, f"no name and description: {line!r}"
        depth, name = len(match[1]) // 2, match[2]
        assert depth <= len(folders)
        del folders[depth:]
        if name.endswith("/"):
            folders.append(name.removesuffix("/"))
            named.append(".".join([*folders, "__init__"]))
        else:
            named.append(".".join([*folders, name.removesuffix(".py")]))
    return named


def test_the_tree_has_a_line_for_each_module():
    named = tree()
    assert sorted(named) == sorted(MODULES)


def test_the_rooms_stand_in_the_order_of_imports():
    inside = [name.removeprefix("ggo_factors.") for name in tree()]
    firsts = [next(n for n, name in enumerate(inside) if f"{name}.".startswith(f"{room}.")) for room in ROOMS]
    assert firsts == sorted(firsts)


def test_every_path_of_the_text_is_there():
    text = PAGE.split("```")[2]
    paths = re.findall(r"`([\w/]+(?:\.py|/))`", text)
    assert len(paths) > 30
    for path in paths:
        assert (PACKAGE / path).exists() or (ROOT / path).exists(), path
