"""`ggo convert`: any recording as a clean MCAP log, whole or not at all."""

from __future__ import annotations

import numpy as np
import pytest
from mcap.reader import make_reader
from mcap_ros2.decoder import DecoderFactory
from table_files import write_csv
from test_cut_strides import walk
from test_signals import MAP, NAMES

import ggo_factors as ggo
from ggo_factors.cli import main
from ggo_factors.recording.log.read_log import read_log

TIMES, VALUES, _ = walk(6)


@pytest.fixture
def csv(tmp_path):
    return write_csv(tmp_path / "walk.csv", TIMES + 100.0, np.degrees(VALUES), [f"{name}_deg" for name in NAMES])


def test_what_is_written_is_read_by_others(tmp_path, csv, capsys):
    output = tmp_path / "out.mcap"
    assert main(["convert", str(csv), "-o", str(output)]) == 0
    assert capsys.readouterr().out == f"wrote {output}\n"
    with output.open("rb") as stream:
        reader = make_reader(stream, decoder_factories=[DecoderFactory()])
        read = [(message, state) for _, _, message, state in reader.iter_decoded_messages()]
        assert [record.metadata["time_source"] for record in reader.iter_metadata()] == ["column time"]
    assert all(state.name == [f"{name}_deg" for name in NAMES] for _, state in read)
    np.testing.assert_allclose([state.position for _, state in read], VALUES, rtol=0.0, atol=1e-14)
    stamps = np.array([state.header.stamp.sec + 1e-9 * state.header.stamp.nanosec for _, state in read])
    np.testing.assert_allclose(stamps, TIMES, rtol=0.0, atol=1e-9)
    assert [message.log_time for message, _ in read] == [round(t * 1e9) for t in TIMES]


def test_missing_values_and_other_units(tmp_path):
    values = VALUES.copy()
    values[10:20, 2] = np.nan
    columns = dict(zip(NAMES, values.T, strict=True))
    log = {"t": TIMES} | columns | {"force [N]": TIMES, "x [m]": TIMES}
    written = ggo.convert_log(log, tmp_path / "out.mcap", unit="rad")
    assert written.names == (*NAMES, "x [m]")
    assert any("force [N]: neither angles nor lengths" in note for note in written.notes)
    read = read_log(tmp_path / "out.mcap")
    np.testing.assert_array_equal(read.values, np.column_stack([values, TIMES]))


def test_where_the_clock_stepped_nothing_is_bridged(tmp_path):
    half = len(TIMES) // 2
    log = ggo.JointLog(TIMES, VALUES, NAMES, "rad", segments=((0, half), (half, len(TIMES))))
    ggo.convert_log(log, tmp_path / "out.mcap")
    read = read_log(tmp_path / "out.mcap")
    assert np.diff(read.times)[half - 1] == pytest.approx(2.01)
    want = ggo.import_base_gait(log, joints=MAP, min_strides=1)
    again = ggo.import_base_gait(tmp_path / "out.mcap", joints=MAP, min_strides=1)
    assert again.strides_used == want.strides_used
    np.testing.assert_allclose(again.gait.frames, want.gait.frames, rtol=0.0, atol=1e-6)


def test_a_damaged_log_becomes_a_whole_one(tmp_path, recordings, capsys):
    path = recordings / "hostile" / "h_cut_50pct.mcap"
    assert main(["convert", str(path), "-o", str(tmp_path / "out.mcap")]) == 0
    assert capsys.readouterr().err.startswith("ggo: ")
    damaged, whole = read_log(path), read_log(tmp_path / "out.mcap")
    assert damaged.losses
    assert whole.losses == ()
    np.testing.assert_array_equal(whole.values, damaged.values)
    np.testing.assert_allclose(whole.times, damaged.times, rtol=0.0, atol=1e-9)


def test_every_log_in_every_form_is_written(tmp_path, recordings):
    """What the reader reads it writes so that it reads the same; JSON in degrees and the like are told their unit."""
    known = 0
    for path in sorted((recordings / "formats").glob("*.mcap")):
        try:
            log = read_log(path)
        except ggo.LogError:
            continue
        unit = log.unit or "deg"
        ggo.convert_log(path, tmp_path / "out.mcap", unit=None if log.unit else unit)
        again = read_log(tmp_path / "out.mcap")
        scale = 1.0 if unit == "rad" else np.pi / 180.0
        assert (again.names, again.unit, again.losses) == (log.names, "rad", ())
        np.testing.assert_allclose(again.values, log.values * scale, rtol=0.0, atol=1e-14)
        known += 1
    assert known > 12


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("walk.csv", "-o", "out.csv"), "out.csv: must end in .mcap"),
        (
            ("bare.csv", "-o", "out.mcap"),
            "the unit of hip_r, knee_r, hip_l, knee_l is not known; give --unit rad or --unit",
        ),
        (("bare.csv", "--unit", "rad", "-o", "out.mcap"), "looks like degrees; --unit deg if so"),
        (("forces.csv", "-o", "out.mcap"), "no angle among f [N]"),
        (("none.csv", "-o", "out.mcap"), "none.csv: cannot be read"),
        (("walk.csv", "-o", "no/such/folder/out.mcap"), "cannot be written"),
        (("paper", "-o", "out.mcap"), "that is the base gait of the paper"),
        (("walk.csv",), "Missing option '-o'"),
    ],
)
def test_nothing_is_written_where_something_is_wrong(tmp_path, monkeypatch, capsys, csv, arguments, words):
    monkeypatch.chdir(tmp_path)
    write_csv(tmp_path / "bare.csv", TIMES, np.degrees(VALUES), NAMES)
    write_csv(tmp_path / "forces.csv", TIMES, VALUES[:, :1], ["f [N]"])
    before = sorted(path.name for path in tmp_path.iterdir())
    assert main(["convert", *arguments]) == 2
    assert words in capsys.readouterr().err
    assert sorted(path.name for path in tmp_path.iterdir()) == before
    with pytest.raises(ggo.InputError, match="unit: expected 'rad' or 'deg', got 'gon'"):
        ggo.convert_log(csv, tmp_path / "out.mcap", unit="gon")


def test_inspect_says_what_a_table_holds(tmp_path, csv, capsys):
    summary = ggo.inspect_log(csv)
    assert (summary.topic, summary.unit_guess, summary.unit_why) == ("columns", "deg", "stated by the source")
    assert (summary.size_bytes, summary.files) == (csv.stat().st_size, 1)
    assert [joint.looks_like for joint in summary.joints] == ["right_hip", "right_knee", "left_hip", "left_knee"]
    assert main(["inspect", str(csv)]) == 0
    out = capsys.readouterr().out
    assert "import takes columns" in out
    assert "unit deg: stated by the source" in out
    assert main(["inspect", str(csv), "--json"]) == 0
    memory = ggo.inspect_log(ggo.JointLog(TIMES, VALUES, NAMES))
    assert (memory.files, memory.unit_guess) == (0, "rad")
    mixed = ggo.inspect_log({"t": TIMES, "hip_l_deg": TIMES, "hip_r_rad": TIMES})
    assert mixed.unit_guess is None
