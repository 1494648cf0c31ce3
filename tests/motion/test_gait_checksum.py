"""The checksum of a gait file: what it tells, and what is free to edit."""

import hashlib
import re

import numpy as np
import pytest
from changed_rows import CHANGES

import ggo_factors as ggo

BASE = ggo.paper_base_gait()


@pytest.fixture
def path(tmp_path):
    BASE.save(tmp_path / "gait.csv")
    return tmp_path / "gait.csv"


@pytest.mark.parametrize("change", CHANGES)
def test_every_change_of_a_gait_is_told(tmp_path, change):
    path = tmp_path / "gait.csv"
    for seed in range(100):
        rng = np.random.default_rng(seed)
        ggo.paper_base_gait(int(rng.integers(20, 80))).save(path)
        assert ggo.load_gait(path).notes == ()
        text = path.read_text()
        path.write_text(CHANGES[change](text, rng))
        assert path.read_text() != text
        with pytest.raises(ggo.InputError, match=r"gait\.csv: .*changed since .*edited=True"):
            ggo.load_gait(path)
        (note,) = ggo.load_gait(path, edited=True).notes
        assert "gait.csv: taken as edited" in note


def test_the_checksum_is_what_its_docstring_says(path):
    text = path.read_text()
    rows = text[text.index("beta2_deg\n") + len("beta2_deg\n") :].rstrip("\n")
    stated = re.search(r"(?m)^# checksum: (\w+)$", text)
    assert stated is not None
    assert stated[1] == hashlib.sha256(f"# dt: {BASE.dt!r} s\n{rows}".encode()).hexdigest()[:16]


@pytest.mark.parametrize(
    "change",
    [
        lambda text: text.replace("# name: paper base gait", "# name: mine"),
        lambda text: text.replace("# thigh: 0.39 m", "# thigh: 0.41 m"),
        lambda text: text.replace("# units: deg", "# made by: hand\n# units: deg"),
        lambda text: text.replace("\n", "\r\n"),
        lambda text: re.sub(r"(?m)^(-?\d.*)$", lambda row: row[1].replace(",", ", "), text),
        lambda text: re.sub(r"0+(?=[,\n])", "", text),
    ],
    ids=["name", "thigh", "a line more", "line ends", "spaces", "zeros cut"],
)
def test_what_is_free_to_edit(path, change):
    text = path.read_text()
    path.write_bytes(change(text).encode())
    assert path.read_bytes() != text.encode()
    read = ggo.load_gait(path)
    np.testing.assert_allclose(read.frames, BASE.frames, rtol=0.0, atol=1e-13)
    assert read.notes == ()


def test_limits_in_the_header_are_under_the_checksum(path):
    path.write_text(path.read_text().replace("# units", "# limits: {}\n# units"))
    with pytest.raises(ggo.InputError, match="rows, dt or limits were changed"):
        ggo.load_gait(path)


def test_a_file_without_checksum_is_read_with_a_note(path):
    path.write_text(re.sub(r"(?m)^# checksum: .*\n", "", path.read_text()))
    gait = ggo.load_gait(path)
    assert gait.notes == (f"{path}: has no checksum, so changed numbers cannot be told",)
    gait.save(path)
    assert ggo.load_gait(path).notes == ()
