"""CSV, OpenSim and C3D files that are not as they should be: one short line each, with the place."""

from __future__ import annotations

import os

import numpy as np
import pytest
from table_files import renamed, rows_of, write_c3d, write_csv, write_mot
from test_cut_strides import walk
from test_signals import MAP, NAMES

import ggo_factors as ggo
from ggo_factors.cli import main
from ggo_factors.recording.sources import extras

TIMES, VALUES, _ = walk(6)
DEGREES = np.degrees(VALUES)
ROWS = rows_of(TIMES, VALUES)
HEAD = ",".join(("time", *NAMES))


def refused(path, joints=MAP, **options):
    """The error of an import, one short line that begins with the file."""
    with pytest.raises(ggo.GgoError) as caught:
        ggo.import_base_gait(path, joints=joints, **{"unit": "rad"} | options)
    words = str(caught.value)
    assert words.startswith(str(path))
    assert "\n" not in words
    assert len(words) - len(str(path)) < 420
    return words.removeprefix(str(path))


def csv(tmp_path, *lines, encoding="utf-8"):
    path = tmp_path / "walk.csv"
    path.write_text("\n".join(lines), encoding=encoding)
    return path


def with_cell(row, column, cell, separator=","):
    """The rows with another cell."""
    rows = list(ROWS)
    cells = rows[row].split(",")
    cells[column] = cell
    rows[row] = ",".join(cells)
    return [line.replace(",", separator) for line in rows]


@pytest.mark.parametrize(
    ("lines", "words"),
    [
        ([""], ": the file is empty"),
        (["# a", "# b"], ": holds comments only"),
        ([HEAD], ": no row below the names time, hip_r"),
        ([HEAD, ROWS[0]], ": 1 rows; a walk has hundreds"),
        (ROWS, ", line 1: numbers where the columns' names should be: '0.0,"),
        ([HEAD.replace("time", "hour"), *ROWS], ": no time column (time, t, timestamp"),
        ([HEAD.replace("knee_l", "knee_r"), *ROWS], ", line 1: columns 3 and 5 are both named 'knee_r'"),
        ([HEAD.replace("knee_l", ""), *ROWS], ": no value named 'knee_l'; there are hip_r, knee_r, hip_l, column 5"),
        ([HEAD.replace("knee_l", "ankle_l"), *ROWS], ": no value named 'knee_l'"),
        ([HEAD, *with_cell(7, 2, "bent")], ", line 9: knee_r is 'bent', no number"),
        ([HEAD, *with_cell(7, 0, "")], ", line 9: time is missing or no finite number"),
        ([HEAD, *with_cell(7, 0, "0.05")], ", line 9: time 0.05 s is not after 0.06 s of line 8: times must rise"),
        ([HEAD, *with_cell(7, 4, "0.1,0.2")], ", line 9: 6 values, the header has 5 names; decimals need a point"),
        ([HEAD, *ROWS[:5], ROWS[5].rpartition(",")[0], *ROWS[6:]], ", line 7: 4 values, the header has 5 names"),
        ([HEAD, *ROWS[:5], "", *ROWS[5:]], ", line 7: the line is empty"),
        ([HEAD.replace("time", "time_deg"), *ROWS], ": the time column time_deg is in 'deg', not in s"),
        (
            [HEAD, *(f"2026-11-28T10:00:0{n}.{'x' if n == 2 else 0},1,1,1,1" for n in range(5))],
            ", line 4: time is '2026",
        ),
        (
            [HEAD, *(row.replace(row.split(",")[0], f"10:00:0{n}", 1) for n, row in enumerate(ROWS[:9]))],
            "neither a number",
        ),
        (
            [HEAD, *(f"{1790000000000 + 10 * n},1,1,1,1" for n in range(9))],
            ": time rises by 10 a row, in seconds 0.1 Hz",
        ),
        (["%time,a,b", *(f"{179 * 10**16 + 10**7 * n},1,1" for n in range(9))], ": %time rises by 1e+07 a row"),
        (["Model Outputs", "100", HEAD, *ROWS], ": a table of Vicon Nexus"),
        (["# ggo-gait 1", HEAD, *ROWS], ": is a gait or walk of this library"),
    ],
)
def test_csv_that_cannot_be_read(tmp_path, lines, words):
    assert words in refused(csv(tmp_path, *lines))


@pytest.mark.parametrize("separator", [";", "\t"])
def test_decimal_commas_are_told(tmp_path, separator):
    rows = [row.replace(",", separator).replace(".", ",") for row in ROWS]
    text = refused(csv(tmp_path, HEAD.replace(",", separator), *rows))
    assert ", line 2: " in text
    assert "'0,0': write decimals with a point" in text


def test_csv_of_any_kind_is_read(tmp_path):
    want = ggo.import_base_gait(ggo.JointLog(TIMES, VALUES, NAMES, "rad"), joints=MAP).gait.frames
    spaced = [row.replace(",", "  ") for row in ROWS]
    for lines in (
        ["# recorded on Monday", HEAD, *ROWS],
        [f"# {HEAD}", *ROWS],  # as numpy.savetxt writes it
        [HEAD.replace("hip_r", '"hip_r"'), *ROWS, "", ""],
        [f"{HEAD},trial", *(f'{row},"a, b"' for row in ROWS)],
        [HEAD.replace(",", " "), *spaced],
        [HEAD.replace("time", "Time (s)"), *ROWS],
        ["\ufeff" + HEAD, *ROWS],
    ):
        assert np.array_equal(ggo.import_base_gait(csv(tmp_path, *lines), joints=MAP, unit="rad").gait.frames, want)
    path = csv(tmp_path, HEAD, *ROWS)
    for ending in (".tsv", ".txt"):
        other = path.with_suffix(ending)
        other.write_text(path.read_text().replace(",", "\t"))
        assert np.array_equal(ggo.import_base_gait(other, joints=MAP, unit="rad").gait.frames, want)


def test_a_last_line_that_is_cut_is_left_out(tmp_path):
    report = ggo.import_base_gait(csv(tmp_path, HEAD, *ROWS, ROWS[-1][:12]), joints=MAP, unit="rad")
    assert f"line {len(ROWS) + 2}, the last one, is cut: left out" in report.notes
    assert report.messages_read == len(ROWS)


def test_gaps_in_a_csv_are_missing_values(tmp_path):
    rows = list(ROWS)
    for number, cell in zip(range(200, 206), ("", "NaN", "nan", "NA", "null", "inf"), strict=True):
        rows[number] = with_cell(number, 2, cell)[number]
    report = ggo.import_base_gait(csv(tmp_path, HEAD, *rows), joints=MAP, unit="rad")
    assert any("knee_r: 6 of" in note and "missing" in note for note in report.notes)
    assert report.signal_counts["gaps bridged"] == {"knee_r": 1}


def test_a_file_that_is_no_text_or_too_large(tmp_path):
    path = csv(tmp_path, HEAD, *ROWS, encoding="utf-16")
    assert "is not a text file" in refused(path)
    os.truncate(path, 2**31)  # a hole: no disk is used
    assert ": 2.1 GB of text (limit 1.1 GB): cut out the walk" in refused(path)
    assert "cannot be read: No such file" in refused(tmp_path / "none.csv")


def test_presets_of_columns_with_units(tmp_path):
    path = write_csv(tmp_path / "walk.csv", TIMES, DEGREES, [f"{name} (deg)" for name in NAMES])
    assert ggo.import_base_gait(path, joints="direct").unit == "deg"


OPENSIM = ("hip_flexion_r", "knee_angle_r", "hip_flexion_l", "knee_angle_l")


def mot(tmp_path, degrees=DEGREES, names=OPENSIM, header=("inDegrees=yes",)):
    return write_mot(tmp_path / "walk.mot", TIMES, degrees, names, header)


def test_opensim_names_are_found_by_the_preset_of_their_sign(tmp_path):
    want = ggo.import_base_gait(ggo.JointLog(TIMES, VALUES, NAMES, "rad"), joints=MAP).gait.frames
    backward = DEGREES * [1.0, -1.0, 1.0, -1.0]
    for names in (OPENSIM, [f"/jointset/{'hip' if 'hip' in n else 'walker_knee'}_{n[-1]}/{n}/value" for n in OPENSIM]):
        for degrees, preset in ((DEGREES, "opensim"), (backward, "opensim-knee-negative")):
            gait = ggo.import_base_gait(mot(tmp_path, degrees, names), joints=preset).gait
            np.testing.assert_allclose(gait.frames, want, rtol=0.0, atol=1e-12)
    assert "(the knees are negative in the middle)" in refused(mot(tmp_path, backward), None)
    assert "(the knees are positive in the middle)" in refused(mot(tmp_path), None)
    # with the wrong sign the knees bend forward, which no gait does
    assert "knee" in refused(mot(tmp_path, backward), "opensim", unit=None)


def test_lengths_of_a_motion_are_no_angles(tmp_path):
    """Beside angles in degrees `pelvis_tx` is in metres: it neither makes the values degrees nor is made radians."""
    names = ("pelvis_tilt", "pelvis_tx", *OPENSIM)
    forward = np.column_stack([0.0 * TIMES, 1.2 * TIMES, DEGREES])
    path = mot(tmp_path, forward, names)
    assert ggo.import_base_gait(path, joints="opensim").unit == "deg"
    written = ggo.convert_log(path, tmp_path / "out.mcap")
    np.testing.assert_array_equal(written.values[:, 1], forward[:, 1])
    np.testing.assert_allclose(written.values[:, 2:], VALUES, rtol=0.0, atol=1e-12)
    joints = ggo.JointMap(
        {**renamed(MAP, dict(zip(NAMES, OPENSIM, strict=True)).get).terms, "alpha_left": {"pelvis_tx": 1}}
    )
    assert ": pelvis_tx is no angle (it is in 'm')" in refused(path, joints, unit=None)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (lambda text: "", ": the file is empty"),
        (lambda text: text.replace("endheader", "end"), "no line 'endheader' in its first"),
        (lambda text: text.partition("endheader")[0] + "endheader\n", ": nothing below its header: the file is cut"),
        (lambda text: text[: len(text) // 2].rpartition("\n")[0], "rows, its header says 1260: cut or changed"),
        (lambda text: text.replace("nColumns=5", "nColumns=6"), ": 5 columns, its header says 6"),
        (lambda text: text.replace("time", "hour"), ": no time column"),
        (lambda text: text.replace("knee_angle_l", "knee_angle_r"), ", line 7: columns 3 and 5 are both named"),
        (
            lambda text: text.replace("hip_flexion", "ground_force_v").replace("knee_angle", "ground_torque_x"),
            ": forces",
        ),
        (lambda text: text.replace("inDegrees=yes", "inDegrees=no"), "over a turn (limit 6.283 rad)"),
        (lambda text: text.replace("inDegrees=yes\n", ""), "unit='rad' or unit='deg'"),
        (lambda text: text.replace("\t0.0\n", "\tx\n", 1).replace("0.01\t", "0.01\tx", 1), ", line 9: "),
    ],
)
def test_motions_that_cannot_be_read(tmp_path, change, words):
    path = mot(tmp_path)
    path.write_text(change(path.read_text()))
    assert words in refused(path, "opensim", unit=None)


def test_radians_in_a_file_that_says_degrees(tmp_path):
    path = mot(tmp_path, VALUES)
    assert "nobody walks with so few degrees; if these are radians, give unit='rad'" in refused(
        path, "opensim", unit=None
    )
    report = ggo.import_base_gait(path, joints="opensim", unit="rad")
    assert any("the source states deg, unit= says rad" in note for note in report.notes)


def test_an_old_header_of_simm(tmp_path):
    path = mot(tmp_path)
    rows = path.read_text().partition("endheader\n")[2]
    path.write_text(f"name walk\ndatacolumns 5\ndatarows {len(TIMES)}\nrange 0 10\nendheader\n\n{rows}")
    assert ggo.import_base_gait(path, joints="opensim", unit="deg").messages_read == len(TIMES)
    path.write_text(path.read_text().replace("datacolumns 5", "datacolumns 7"))
    assert ": 5 columns, its header says 7" in refused(path, "opensim")


PLUG_IN = ("RHipAngles", "RKneeAngles", "LHipAngles", "LKneeAngles")


@pytest.fixture
def ezc3d():
    return pytest.importorskip("ezc3d")


def test_vicon_names_are_found_by_their_preset(ezc3d, tmp_path):
    path = write_c3d(ezc3d, tmp_path / "walk.c3d", 100.0, DEGREES, PLUG_IN)
    want = ggo.import_base_gait(ggo.JointLog(TIMES, VALUES, NAMES, "rad"), joints=MAP).gait.frames
    report = ggo.import_base_gait(path, joints="plug-in-gait")
    np.testing.assert_allclose(report.gait.frames, want, rtol=0.0, atol=1e-6)
    assert (report.unit, report.time_source) == ("deg", "rate 100 Hz")
    assert any("no pelvis tilt" in note for note in report.notes)


def test_frames_that_were_not_seen_are_missing(ezc3d, tmp_path):
    degrees = DEGREES.copy()
    degrees[300:310] = 0.0
    degrees[400:405] = np.nan
    path = write_c3d(ezc3d, tmp_path / "walk.c3d", 100.0, degrees, PLUG_IN)
    report = ggo.import_base_gait(path, joints="plug-in-gait")
    assert any("RKneeAngles: 15 of" in note for note in report.notes)
    assert report.signal_counts["gaps bridged"]["RKneeAngles"] == 2


def test_more_labels_than_one_parameter_holds(ezc3d, tmp_path):
    labels = [f"marker{number}" for number in range(300)] + list(PLUG_IN)
    degrees = np.hstack([np.full((len(TIMES), 300), 7.0), DEGREES])
    path = write_c3d(ezc3d, tmp_path / "walk.c3d", 100.0, degrees, labels)
    assert ggo.import_base_gait(path, joints="plug-in-gait").messages_read == len(TIMES)


def test_files_that_are_not_there(ezc3d, tmp_path):
    for ending in (".c3d", ".bag", ".db3", ".mcap.zstd", ".mot", ".csv", ".mcap"):
        assert ": cannot be read: No such file" in refused(tmp_path / f"none{ending}")


@pytest.mark.parametrize(
    ("labels", "change", "words"),
    [
        (("LASI", "RASI", "LKNE", "RKNE"), None, ": no joint angles (LHipAngles, LKneeAngles, ...) among LASI"),
        (("A:LHipAngles", "B:LHipAngles", "A:LKneeAngles", "B:LKneeAngles"), None, "preset 'plug-in-gait' finds no"),
        (("LHipAngles", "LHipAngles", "LKneeAngles", "RKneeAngles"), None, ": two trajectories are named 'LHipAngles'"),
        (PLUG_IN, lambda data: b"", ": the file is empty"),
        (PLUG_IN, lambda data: data[: len(data) * 2 // 3], "frames that its header states: the file is cut"),
        (PLUG_IN, lambda data: b"no C3D at all, a text\n" * 100, ": not a C3D file (its second byte is not 50 hex)"),
        (PLUG_IN, lambda data: data[:300], ": 300 bytes, its header or its parameters are cut"),
        (PLUG_IN, lambda data: data[:514], ": 514 bytes, its header or its parameters are cut"),
        (PLUG_IN, lambda data: data[:700], ": 0 of the 1260 frames that its header states: the file is cut"),
        (PLUG_IN, lambda data: data[:512] + bytes(len(data)), ": "),
    ],
)
def test_c3d_that_cannot_be_read(ezc3d, tmp_path, labels, change, words):
    path = write_c3d(ezc3d, tmp_path / "walk.c3d", 100.0, DEGREES, labels)
    if change is not None:
        path.write_bytes(change(path.read_bytes()))
    assert words in refused(path, "plug-in-gait", unit=None)


def test_a_missing_extra_is_told_with_the_command_that_brings_it(tmp_path, monkeypatch):
    def without(name, *_):
        raise ModuleNotFoundError(name)

    monkeypatch.setattr(extras, "import_module", without)
    for name, extra in (("walk.c3d", "c3d"), ("walk.bag", "rosbags"), ("walk.db3", "rosbags")):
        path = tmp_path / name
        path.write_bytes(b"x")
        assert f"needs the extra {extra}: pip install 'ggo-factors[{extra}]'" in refused(path)


def test_a_table_of_nothing_but_memory(tmp_path, monkeypatch):
    def full(*_, **__):
        raise MemoryError

    path = csv(tmp_path, HEAD, *ROWS)
    monkeypatch.setattr(np, "loadtxt", full)
    assert refused(path) == ": does not fit into memory"


def test_the_command_line_takes_any_of_them(tmp_path, capsys):
    output = tmp_path / "base.csv"
    assert main(["import", str(mot(tmp_path)), "--joints", "opensim", "-o", str(output)]) == 0
    out = capsys.readouterr().out
    assert "columns (mot)" in out
    assert "unit: deg" in out
    want = ggo.import_base_gait(ggo.JointLog(TIMES, VALUES, NAMES, "rad"), joints=MAP).gait
    np.testing.assert_allclose(ggo.load_gait(output).frames, want.frames, rtol=0.0, atol=1e-12)
