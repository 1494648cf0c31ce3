"""What the pages show runs as it stands there, page by page, each in a folder of its own beside the data sets."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from doc_blocks import ROOT, blocks, run_page

from ggo_factors.recording.log.joint_map import load_joint_map, preset_map

DOCS = ROOT / "docs"
PAGES = sorted(path for path in DOCS.rglob("*.md") if not {"_made", "_build"} & set(path.relative_to(DOCS).parts))
WITH_BLOCKS = [page for page in PAGES if any(not block.language.startswith("{") for block in blocks(page))]


@pytest.mark.parametrize("page", WITH_BLOCKS, ids=lambda page: page.relative_to(DOCS).as_posix())
def test_every_block_runs(page, tmp_path, monkeypatch, capsys):
    (tmp_path / "datasets").symlink_to(ROOT / "datasets", target_is_directory=True)
    monkeypatch.chdir(tmp_path)
    ran = run_page(page, tmp_path, capsys)
    text = page.read_text(encoding="utf-8")
    for file in sorted(tmp_path.iterdir()):
        assert file.name == "datasets" or file.name in text, f"{file.name}: written, not said"
    assert len(ran) == text.count("```") // 2 - text.count("```{")


def test_the_joint_map_that_is_explained_says_what_the_preset_does(tmp_path):
    page = DOCS / "how_to" / "own_recording.md"
    (shown,) = (block.text for block in blocks(page) if block.language == "toml")
    path = tmp_path / "map.toml"
    path.write_text(shown, encoding="utf-8")
    joints = load_joint_map(path)
    # OpenSim's names, flexion counted negative.
    assert joints.terms == preset_map("opensim-knee-negative", joints.names, "a log").terms


def test_every_page_is_in_the_contents():
    index = (DOCS / "index.md").read_text(encoding="utf-8")
    named = {
        line.strip() for tree in re.findall(r"```{toctree}(.*?)```", index, re.DOTALL) for line in tree.split("\n")
    }
    for page in PAGES:
        name = page.relative_to(DOCS).with_suffix("").as_posix()
        assert name in named or name == "index" or name.startswith("api/"), f"{name} is in no contents"


def test_every_link_between_pages_leads_somewhere():
    count = 0
    for page in PAGES:
        for target in re.findall(r"\]\(([\w./-]+\.(?:md|png|ipynb))(?:#[\w-]+)?\)", page.read_text(encoding="utf-8")):
            made = target.replace("../_made/notebooks", "../../notebooks").replace("_made/notebooks", "../notebooks")
            if "_made/examples" not in made:
                assert (page.parent / Path(made)).exists(), f"{page.name}: {target}"
            count += 1
    assert count > 20
