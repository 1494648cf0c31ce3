"""What the README shows runs as it stands there, and it stays short."""

from __future__ import annotations

import re

from doc_blocks import ROOT, run_page

README = ROOT / "README.md"


def test_every_block_runs(tmp_path, monkeypatch, capsys):
    (tmp_path / "datasets").symlink_to(ROOT / "datasets", target_is_directory=True)
    monkeypatch.chdir(tmp_path)
    ran = run_page(README, tmp_path, capsys)
    assert ran == ["console", "python", "console"]
    assert sorted(path.name for path in tmp_path.iterdir()) == [
        "base.csv",
        "datasets",
        "stairs.mcap",
        "walk.csv",
        "walk.mcap",
    ]


def test_it_is_short_and_its_links_lead_somewhere():
    text = README.read_text(encoding="utf-8")
    assert len(text.splitlines()) < 100
    links = [link for link in re.findall(r"\]\(([^)]+)\)", text) if "://" not in link]
    assert len(links) > 20
    for link in links:
        assert (ROOT / link).exists(), link
