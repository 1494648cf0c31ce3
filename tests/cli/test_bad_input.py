"""Input that cannot be used: one clear line and an exit code, or an error that names the field; no partial file."""

from __future__ import annotations

import errno
import json
import os
import re
import subprocess
import sys
import tempfile
from pathlib import Path

import gtsam
import numpy as np
import pytest

import ggo_factors as ggo
from ggo_factors.cli import main
from ggo_factors.support.inputs import as_bool

BASE = ggo.paper_base_gait()
FRAMES = BASE.frames
NAN, INF = float("nan"), float("inf")


@pytest.fixture(scope="module")
def gait_text(tmp_path_factory: pytest.TempPathFactory) -> str:
    path = tmp_path_factory.mktemp("good") / "base.csv"
    BASE.save(path)
    return path.read_text()


@pytest.fixture(scope="module")
def walk_text(tmp_path_factory: pytest.TempPathFactory) -> str:
    path = tmp_path_factory.mktemp("good") / "walk.csv"
    ggo.adjust_stride(BASE, stride=0.8).save(path)
    return path.read_text()


def everything_in(folder: Path) -> dict[str, bytes | None]:
    """Each file's content, hidden ones too, so that nothing new and nothing changed goes unseen."""
    return {str(path): path.read_bytes() if path.is_file() else None for path in folder.rglob("*")}


def refused(capsys: pytest.CaptureFixture[str], folder: Path, code: int, *arguments: object) -> str:
    """What the command says on stderr, once it has been seen to refuse as it should."""
    before = everything_in(folder)
    got = main([str(argument) for argument in arguments])
    captured = capsys.readouterr()
    assert got == code, captured.err
    assert captured.err.count("\n") == 1
    assert captured.err.startswith("ggo: ")
    assert "Traceback" not in captured.err
    assert "GGO_DEBUG" not in captured.err
    assert captured.out == ""
    assert everything_in(folder) == before
    return captured.err


# -- command line: flags --------------------------------------------------------------------------------------------

FLAGS = [
    # which flag, exit code, command, words of the message
    ("no command", 2, "nothing-like-this", "No such command 'nothing-like-this'"),
    ("no base", 2, "stride", "Missing argument 'BASE'"),
    ("unknown option", 2, "stride paper --strid 0.8", "No such option"),
    ("option of another command", 2, "stride paper --riser 0.1", "No such option"),
    ("stride no number", 2, "stride paper --stride long", "'--stride': 'long'"),
    ("stride 0", 2, "stride paper --stride 0", "stride: 0 m must be above 0 m"),
    ("stride negative", 2, "stride paper --stride -0.5", "stride: -0.5 m must be above 0 m"),
    ("stride NaN", 2, "stride paper --stride nan", "stride: nan m is not finite"),
    ("stride inf", 2, "stride paper --stride inf", "stride: inf m is not finite"),
    ("stride out of reach", 3, "stride paper --stride 5", "is 2.500 m from the supporting foot"),
    ("stride in millimetres", 3, "stride paper --stride 975", "two legs reach 1.560 m"),
    ("steps 0", 2, "stride paper --steps 0", "steps: 0 must be at least 1"),
    ("steps no whole number", 2, "stride paper --steps 1.5", "'--steps': '1.5'"),
    ("frames 0", 2, "stride paper --frames 0", "frames: 0 must be at least 2"),
    ("frames 1", 2, "stride paper --frames 1", "frames: 1 must be at least 2"),
    ("frames negative", 2, "stride paper --frames -3", "frames: -3 must be at least 2"),
    ("frames too few to step", 3, "stride paper --frames 2", "ground at frame"),
    ("thigh negative", 2, "stride paper --thigh -0.4", "thigh: -0.4 m must be above 0 m"),
    ("shank NaN", 2, "stride paper --shank nan", "shank: nan m is not finite"),
    ("thigh inf", 2, "stride paper --thigh inf", "thigh: inf m is not finite"),
    ("gap of one number", 2, "stride paper --gap 0.3", "'0.3' has 1 numbers, expected XS,XE"),
    ("gap in millimetres", 2, "stride paper --gap 360,450", "x_start: 360 m is more than 100 m ahead; looks like mill"),
    ("base is a log", 2, "stride walk.mcap", "walk.mcap: is a log; gaits and walks are CSV files, and `ggo import`"),
    ("gap reversed", 2, "stride paper --gap 0.5,0.3", "x_end: 0.3 m must be above x_start 0.5 m"),
    (
        "foothold in a gap",
        3,
        "stride paper --stride 0.8 --gap 0.3,0.5",
        "foothold in a gap (gap from 0.3 to 0.5 m): 0.4 m",
    ),
    ("obstacle of two numbers", 2, "step-over paper --obstacle 0.2,0.25", "has 2 numbers, expected XS,XE,H"),
    ("obstacle in words", 2, "step-over paper --obstacle a,b,c", "'a,b,c' is not XS,XE,H[,SE,SH] in numbers"),
    ("obstacle reversed", 2, "step-over paper --obstacle 0.25,0.2,0.08", "x_end: 0.2 m must be above x_start 0.25 m"),
    ("obstacle of no width", 2, "step-over paper --obstacle 0.2,0.2,0.08", "x_end: 0.2 m must be above x_start 0.2 m"),
    ("obstacle below ground", 2, "step-over paper --obstacle 0.2,0.25,-1", "height: -1 m must be at least 0 m"),
    ("obstacle NaN", 2, "step-over paper --obstacle nan,0.25,0.1", "x_start: nan m is not finite"),
    ("obstacle inf", 2, "step-over paper --obstacle 0.2,0.25,inf", "height: inf m is not finite"),
    ("obstacle in the support foot", 3, "step-over paper --obstacle -0.02,0.02,0.05", "in the supporting foot"),
    ("obstacle in the start", 3, "step-over paper --obstacle -0.41,-0.37,0.05", "in the swinging foot's start"),
    ("obstacle on the foothold", 3, "step-over paper --obstacle 0.37,0.41,0.05", "obstacle in the foothold"),
    (
        "obstacle wider than the stride",
        3,
        "step-over paper --obstacle -0.5,0.5,0.05",
        "obstacle in the supporting foot",
    ),
    ("foothold of one number", 2, "step-over paper --foothold 0.39", "'0.39' has 1 numbers, expected X,Y"),
    ("foothold of three numbers", 2, "step-over paper --foothold 0.39,0,0", "has 3 numbers, expected X,Y"),
    ("foothold NaN", 2, "step-over paper --foothold nan,0", "foothold: value nan at [0] is not finite"),
    ("foothold in the air", 3, "step-over paper --foothold 0.39,0.1", "foothold off the ground: 0.1 m (limit 0 m)"),
    ("foothold out of reach", 3, "step-over paper --foothold 2,0", "2.000 m from the supporting foot"),
    ("no direction", 2, "stairs paper", "Missing argument"),
    ("another direction", 2, "stairs paper sideways", "'sideways' is not one of 'up', 'down'"),
    ("riser negative", 2, "stairs paper up --riser -0.1", "riser: -0.1 m must be above 0 m"),
    ("riser 0", 2, "stairs paper down --riser 0", "riser: 0 m must be above 0 m"),
    ("one riser negative", 2, "stairs paper up --riser 0.1,-0.1", "riser: -0.1 m must be above 0 m"),
    ("riser NaN", 2, "stairs paper up --riser nan", "riser: nan m is not finite"),
    ("riser in words", 2, "stairs paper up --riser low", "'low' is not a number or a list of numbers"),
    ("risers and steps differ", 2, "stairs paper up --riser 0.1,0.1 --steps 3", "riser: 2 risers for 3 steps"),
    ("riser too high", 3, "stairs paper up --riser 2", "two legs reach 1.560 m"),
    ("stairs steps 0", 2, "stairs paper up --steps 0", "steps: 0 must be at least 1"),
    ("tread 0", 2, "stairs paper up --tread 0", "tread: 0 m must be above 0 m"),
    ("tread negative", 2, "stairs paper up --tread -0.3", "tread: -0.3 m must be above 0 m"),
    ("tread in centimetres", 3, "stairs paper up --tread 39", "two legs reach 1.560 m"),
    (
        "first edge beyond the tread",
        2,
        "stairs paper up --first-edge 0.5",
        "--first-edge: 0.5 m must be below the tread 0.39",
    ),
    ("first edge negative", 2, "stairs paper up --first-edge -0.1", "--first-edge: -0.1 m must be above 0 m"),
    ("first edge at the foot", 3, "stairs paper up --first-edge 0.005", "obstacle in the supporting foot"),
    ("walk without steps", 2, "walk paper", "a walk needs at least one step"),
    (
        "second step out of reach",
        3,
        "walk paper --foothold 0.39,0 --foothold 3,0",
        "is 3.000 m from the supporting foot",
    ),
]


@pytest.mark.parametrize(("code", "command", "words"), [case[1:] for case in FLAGS], ids=[case[0] for case in FLAGS])
def test_flags_that_cannot_be_used(capsys, tmp_path, code, command, words):
    name, *rest = command.split()
    generates = "paper" in rest
    said = refused(capsys, tmp_path, code, name, *rest, *(("-o", tmp_path / "out.csv") if generates else ()))
    assert words in said


def test_nothing_is_printed_as_json_for_bad_input(capsys, tmp_path):
    refused(capsys, tmp_path, 3, "stride", "paper", "--stride", "5", "--json")


def test_as_a_program(tmp_path):
    command = [sys.executable, "-m", "ggo_factors.cli", "step-over", str(tmp_path / "none.csv"), "-o", "out.csv"]
    done = subprocess.run(command, cwd=tmp_path, check=False, capture_output=True, text=True, timeout=60)
    assert (done.returncode, done.stdout) == (2, "")
    assert done.stderr == f"ggo: {tmp_path / 'none.csv'}: cannot be read: No such file or directory\n"
    assert list(tmp_path.iterdir()) == []


# -- command line: files --------------------------------------------------------------------------------------------


def without(text: str, start: str) -> str:
    """Without the lines that start so."""
    return "".join(line for line in text.splitlines(True) if not line.startswith(start))


def header(text: str, key: str, value: str) -> str:
    """With another value in a header line."""
    changed, count = re.subn(rf"(?m)^# {key}: .*$", lambda _: f"# {key}: {value}", text)
    assert count == 1
    return changed


def cell(text: str, row: int, column: int, value: str) -> str:
    """With another value in one place of the table; row 0 is the first frame."""
    lines = text.splitlines()
    at = next(i for i, line in enumerate(lines) if not line.startswith("#")) + 1 + row
    cells = lines[at].split(",")
    cells[column] = value
    lines[at] = ",".join(cells)
    return "\n".join(lines) + "\n"


DAMAGED_GAITS = [
    ("empty", lambda text: "", "the file is empty"),
    ("binary", lambda text: bytes(range(256)) * 8, "is not a text file|line 1: expected '# ggo-gait 1'"),
    ("UTF-16", lambda text: text.encode("utf-16"), "is not a text file"),
    (
        "another kind",
        lambda text: "time,angle\n0,1\n",
        "line 1: expected '# ggo-gait 1' or '# ggo-gait 2' or '# ggo-gait 3' or '# ggo-gait 4', found 'time,angle'",
    ),
    ("another version", lambda text: text.replace("# ggo-gait 1", "# ggo-gait 9"), "line 1: .* found '# ggo-gait 9'"),
    ("cut in the header", lambda text: text[:60], "expected|found"),
    (
        "cut before the frames",
        lambda text: text[: text.index("\n", text.index("alpha1_deg")) + 1],
        "0 frames, its header says 51",
    ),
    ("cut in a row", lambda text: text[:-45], r"line 6\d: expected 4 values, found [123]|not a finite number"),
    ("a word", lambda text: cell(text, 3, 1, "hello"), r"line \d+: beta1_deg is 'hello', not a finite number"),
    ("a gap", lambda text: cell(text, 3, 2, ""), r"line \d+: alpha2_deg is '', not a finite number"),
    ("NaN", lambda text: cell(text, 3, 3, "nan"), r"line \d+: beta2_deg is 'nan', not a finite number"),
    ("infinity", lambda text: cell(text, 0, 0, "-inf"), r"line \d+: alpha1_deg is '-inf', not a finite number"),
    ("angle 4000", lambda text: cell(text, 50, 0, "4000"), r"line \d+: alpha1_deg is 4000, not below 360 degrees"),
    ("one value more", lambda text: cell(text, 3, 3, "1,2"), r"line \d+: expected 4 values, found 5"),
    ("an empty line", lambda text: text.replace("\n", "\n\n"), "line 2: expected the columns"),
    ("semicolons", lambda text: text.replace(",", ";"), r"line \d+: expected the columns"),
    ("a column missing", lambda text: text.replace(",beta2_deg", ""), r"line \d+: expected the columns"),
    (
        "columns swapped",
        lambda text: text.replace("alpha1_deg,beta1_deg", "beta1_deg,alpha1_deg"),
        "expected the columns",
    ),
    ("radians", lambda text: header(text, "units", "rad"), "header 'units' is 'rad'; this format knows 'deg'"),
    ("no dt", lambda text: without(text, "# dt"), "the header has no line '# dt: ...'"),
    ("dt negative", lambda text: header(text, "dt", "-0.01 s"), "dt: -0.01 s must be above 0 s"),
    ("dt 0", lambda text: header(text, "dt", "0 s"), "dt: 0 s must be above 0 s"),
    ("dt too short", lambda text: header(text, "dt", "1e-4 s"), "dt: 0.0001 s makes 51 frames last 0.005 s"),
    ("dt changed", lambda text: header(text, "dt", "0.1 s"), "rows, dt or limits were changed since it was written"),
    ("an angle changed", lambda text: cell(text, 3, 1, "20"), "changed since .*: --edited"),
    ("dt NaN", lambda text: header(text, "dt", "nan s"), "header 'dt' is 'nan', not a finite number"),
    ("dt in milliseconds", lambda text: header(text, "dt", "10 ms"), "header 'dt' is in 'ms', expected 's'"),
    ("dt twice", lambda text: text.replace("# units", "# dt: 1 s\n# units"), r"line \d+: 'dt' stands twice"),
    ("thigh in centimetres", lambda text: header(text, "thigh", "39 cm"), "header 'thigh' is in 'cm', expected 'm'"),
    ("thigh negative", lambda text: header(text, "thigh", "-0.39 m"), "thigh: -0.39 m must be above 0 m"),
    ("no shank", lambda text: without(text, "# shank:"), "the header has no line '# shank: ...'"),
    ("no legs", lambda text: without(without(text, "# shank:"), "# thigh:"), "states no leg lengths; give --thigh and"),
    ("heel negative", lambda text: header(text, "heel", "-0.1 m"), "heel: -0.1 m must be at least 0 m"),
]


@pytest.mark.parametrize(
    ("damage", "words"), [case[1:] for case in DAMAGED_GAITS], ids=[case[0] for case in DAMAGED_GAITS]
)
def test_damaged_gait_files(capsys, tmp_path, gait_text, damage, words):
    path, made = tmp_path / "damaged.csv", damage(gait_text)
    path.write_bytes(made if isinstance(made, bytes) else made.encode())
    assert path.read_bytes() != gait_text.encode()
    for command in ("stride", "verify", "export"):
        output = () if command == "verify" else ("-o", tmp_path / "out.mcap")
        said = refused(capsys, tmp_path, 2, command, path, *output)
        assert said.startswith(f"ggo: {path}")
        assert re.search(words, said)


def step_header(text: str, **changes: object) -> str:
    """With other values in what step 1 had to do."""
    found = re.search(r"(?m)^# step 1: (.*)$", text)
    assert found is not None
    return header(text, "step 1", json.dumps(json.loads(found[1]) | changes))


DAMAGED_WALKS = [
    ("another version", lambda text: text.replace("# ggo-walk 1", "# ggo-walk 9"), "line 1: .* found '# ggo-walk 9'"),
    ("cut", lambda text: "".join(text.splitlines(True)[:21]), "3 frames, its header says 102"),
    ("cut in a row", lambda text: text[:-45], r"line \d+: expected 5 values|not a finite number"),
    ("no plan", lambda text: without(text, "# step"), r"line \d+: step 1 does not follow the header's steps"),
    ("no plan of step 2", lambda text: without(text, "# step 2"), r"line \d+: step 2 does not follow"),
    ("no plan of step 1", lambda text: without(text, "# step 1"), "no line '# step 1: ...'"),
    ("plan no JSON", lambda text: header(text, "step 1", "{"), "'step 1' does not describe a step"),
    ("plan empty", lambda text: header(text, "step 1", "{}"), "'step 1' lacks 'shank_angle_deg'"),
    ("plan a list", lambda text: header(text, "step 1", "[]"), "header 'step 1'"),
    ("foothold NaN", lambda text: step_header(text, foothold_m=[NAN, 0]), "'step 1': foothold: value nan"),
    (
        "foothold missing",
        lambda text: step_header(text, foothold_m=None),
        "'step 1': foothold: a step needs a foothold",
    ),
    (
        "obstacle of two numbers",
        lambda text: step_header(text, obstacles_m=[[0.2, 0.3]]),
        "'step 1' does not describe a step",
    ),
    ("obstacle reversed", lambda text: step_header(text, obstacles_m=[[0.3, 0.2, 0.1]]), "x_end: 0.2 m must be above"),
    ("ground without height", lambda text: step_header(text, ground_edges_m=[0.1]), "heights: 1 edges need 2 heights"),
    ("end frame short", lambda text: step_header(text, end_frame_deg=[1, 2]), r"end_frame_deg: expected shape \(4,\)"),
    ("end frame 4000", lambda text: step_header(text, end_frame_deg=[4000, 0, 0, 0]), "is not below 2 pi"),
    ("shank a word", lambda text: step_header(text, shank_angle_deg="up"), "header 'step 1'"),
    ("step 1.5", lambda text: cell(text, 3, 0, "1.5"), r"line \d+: step 1.5 does not follow"),
    ("step 0", lambda text: cell(text, 0, 0, "0"), r"line \d+: step 0 does not follow"),
    ("steps mixed", lambda text: cell(text, 3, 0, "2"), r"line \d+: step 1 does not follow"),
    (
        "one frame of step 2",
        lambda text: header("".join(text.splitlines(True)[:-51]), "frames", "52") + text.splitlines(True)[-1],
        "step 2 has 1 frames, expected at least 2",
    ),
    ("a step too many", lambda text: cell(text, 101, 0, "3"), r"line \d+: step 3 does not follow"),
    ("angle 4000", lambda text: cell(text, 3, 1, "4000"), r"line \d+: alpha1_deg is 4000"),
    ("dt negative", lambda text: header(text, "dt", "-1 s"), "dt: -1 s must be above 0 s"),
    ("an angle changed", lambda text: cell(text, 3, 1, "20"), "changed since .*: --edited"),
]


@pytest.mark.parametrize(
    ("damage", "words"), [case[1:] for case in DAMAGED_WALKS], ids=[case[0] for case in DAMAGED_WALKS]
)
def test_damaged_walk_files(capsys, tmp_path, walk_text, damage, words):
    path, made = tmp_path / "damaged.csv", damage(walk_text)
    path.write_text(made)
    assert made != walk_text
    for command in ("verify", "export", "plot"):
        output = () if command == "verify" else ("-o", tmp_path / ("out.mcap" if command == "export" else "out.png"))
        said = refused(capsys, tmp_path, 2, command, path, *output)
        assert said.startswith(f"ggo: {path}")
        assert re.search(words, said)


@pytest.mark.parametrize("command", ["stride", "step-over", "walk", "verify", "plot", "export", "import", "inspect"])
def test_a_file_that_is_missing_or_a_folder(capsys, tmp_path, command):
    output = (
        ("-o", tmp_path / ("out.mcap" if command == "export" else "out.png"))
        if command not in ("verify", "inspect")
        else ()
    )
    said = refused(capsys, tmp_path, 2, command, tmp_path / "none", *output)
    assert f"{tmp_path / 'none'}: cannot be read: No such file or directory" in said
    (tmp_path / "folder").mkdir()
    assert str(tmp_path / "folder") in refused(capsys, tmp_path, 2, command, tmp_path / "folder", *output)


@pytest.mark.parametrize(
    "command",
    [f"{made} -o out{ending}" for made in ("stride paper", "stairs paper up") for ending in (".csv", ".mcap")]
    + ["step-over paper -o out.csv", "walk paper --foothold 0.39,0 -o out.csv"]
    + ["plot paper -o out.png", "plot paper -o out.svg", "export paper -o out.mcap"],
)
def test_an_output_that_cannot_be_written(capsys, tmp_path, command):
    *start, name = command.split()
    missing = tmp_path / "none" / name
    assert f"{missing}: cannot be written: No such file" in refused(capsys, tmp_path, 2, *start, missing)
    folder = tmp_path / name
    folder.mkdir()
    assert "cannot be written: Is a directory" in refused(capsys, tmp_path, 2, *start, folder)
    blocked = tmp_path / "file"
    blocked.write_text("")
    assert "cannot be written: Not a directory" in refused(capsys, tmp_path, 2, *start, blocked / name)


@pytest.mark.parametrize("command", ["stride paper -o out.csv", "export paper -o out.mcap", "plot paper -o out.png"])
def test_a_folder_that_must_not_be_written_to(capsys, tmp_path, monkeypatch, command):
    def deny(*_: object, **__: object) -> None:
        raise PermissionError(errno.EACCES, os.strerror(errno.EACCES))

    # A closed folder would not stop the superuser, as whom tests may run.
    monkeypatch.setattr(tempfile, "mkstemp", deny)
    *start, name = command.split()
    assert "cannot be written: Permission denied" in refused(capsys, tmp_path, 2, *start, tmp_path / name)


@pytest.mark.parametrize("command", ["stride paper -o out.csv", "plot paper -o out.png"])
def test_a_disk_that_is_full(capsys, tmp_path, monkeypatch, command):
    def fill(self: Path, *_: object, **__: object) -> None:
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    monkeypatch.setattr(Path, "replace", fill)
    *start, name = command.split()
    assert "cannot be written: No space left on device" in refused(capsys, tmp_path, 2, *start, tmp_path / name)


def test_an_unsafe_step_leaves_the_old_file_as_it_was(capsys, tmp_path):
    output = tmp_path / "out.csv"
    output.write_text("old")
    refused(capsys, tmp_path, 3, "stride", "paper", "--stride", "5", "-o", output)
    assert output.read_text() == "old"


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("plot", "paper", "-o", "out.xyz"), "out.xyz: must end in .png"),
        (("plot", "paper"), "Missing option '-o'"),
        (("plot", "paper", "--what", "nothing", "-o", "out.png"), "'nothing' is not one of"),
        (("plot", "paper", "--what", "residual", "-o", "out.png"), "--base: the residual is the difference"),
        (("plot", "paper", "--base", "none.csv", "-o", "out.png"), "none.csv: cannot be read"),
        (("export", "paper"), "Missing option '-o'"),
        (("export", "paper", "--pelvis-tilt", "nan", "-o", "out.mcap"), "--pelvis-tilt: nan rad is not finite"),
        (("export", "paper", "--first-swing", "both", "-o", "out.mcap"), "'both' is not one of 'right', 'left'"),
        (("verify", "paper", "--foothold", "nan,0"), "foothold: value nan at [0] is not finite"),
        (("verify", "walk.csv", "--foothold", "0.4,0"), "a walk states its own ground"),
        (("verify", "walk.csv", "--gap", "0.4,0.5"), "a walk states its own ground"),
        (("import", "walk.csv"), "walk.csv"),
        (("import", "{log}", "--joints", "nothing-like-this"), "nothing-like-this: cannot be read"),
        (("import", "{log}", "--joints", "{map}", "--frames", "1"), "frames: 1 must be at least"),
        (("import", "{log}", "--joints", "{map}", "--min-strides", "1000"), "min-strides"),
        (("import", "{log}", "--joints", "{map}", "--topic", "/nothing"), "/nothing"),
        (("import", "{log}", "--joints", "{map}", "--thigh", "0.4"), "--thigh and --shank: give both"),
        (("import", "{log}", "--joints", "{map}", "--unit", "gon"), "'gon' is not one of 'rad', 'deg'"),
        (("import", "{log}", "--joints", "unknown.toml"), "nothing_like_this"),
        (("import", "{log}", "--joints", "broken.toml"), "broken.toml"),
        (("inspect", "walk.csv"), "walk.csv"),
    ],
)
def test_other_commands(capsys, tmp_path, monkeypatch, walk_text, arguments, words):
    monkeypatch.chdir(tmp_path)
    datasets = Path(__file__).parents[2] / "datasets"
    Path("walk.csv").write_text(walk_text)
    known = (datasets / "children_walk.toml").read_text()
    Path("unknown.toml").write_text(known.replace("right_knee_flexion", "nothing_like_this"))
    Path("broken.toml").write_text(known + "[alpha_left\n")
    places = {"log": datasets / "children_walk.mcap", "map": datasets / "children_walk.toml"}
    filled = [argument.format(**places) for argument in arguments]
    output = ("-o", "out.csv") if filled[0] == "import" else ()
    assert words in refused(capsys, tmp_path, 2, *filled, *output)


# -- library --------------------------------------------------------------------------------------------------------


def gait(frames: object, dt: object = 0.01) -> ggo.Gait:
    return ggo.Gait(frames, dt)  # type: ignore[arg-type]


def anchored() -> ggo.GaitGraph:
    graph = ggo.GaitGraph(BASE)
    graph.anchor(FRAMES[0])
    return graph


SPOILED = FRAMES.copy()
SPOILED[7, 2] = NAN
BOX = ggo.Obstacle(0.20, 0.25, 0.08)

CALLS = [
    ("frames of three columns", lambda: gait(FRAMES[:, :3]), r"frames: expected shape \(m, 4\), got \(51, 3\)"),
    ("one frame as a vector", lambda: gait(FRAMES[0]), r"frames: expected shape \(m, 4\), got \(4,\)"),
    ("a single frame", lambda: gait(FRAMES[:1]), "frames: a gait needs at least 2 frames, got 1"),
    ("no frames", lambda: gait(np.zeros((0, 4))), "frames: a gait needs at least 2 frames, got 0"),
    ("frames None", lambda: gait(None), "frames: expected numbers of shape"),
    ("frames text", lambda: gait("abc"), "frames: expected numbers of shape .*'abc'"),
    ("frames ragged", lambda: gait([[1, 2, 3, 4], [1, 2]]), "frames: expected numbers of shape"),
    ("frames a generator of text", lambda: gait(row for row in "ab"), "frames: expected numbers of shape"),
    (
        "frames in degrees",
        lambda: gait(np.degrees(FRAMES)),
        r"frames: angle 13.9739 rad at \[0, 0\] .*looks like degrees",
    ),
    ("frames NaN", lambda: gait(SPOILED), r"frames: value nan at \[7, 2\] is not finite"),
    ("frames with None", lambda: gait([[0, 0, 0, None]] * 2), "frames: expected numbers of shape"),
    ("dt 0", lambda: gait(FRAMES, 0.0), "dt: 0 s must be above 0 s"),
    ("dt NaN", lambda: gait(FRAMES, np.float64(NAN)), "dt: nan s is not finite"),
    ("dt None", lambda: gait(FRAMES, None), "dt: expected a number, got None"),
    ("frames 1", lambda: ggo.paper_base_gait(1), "frames: 1 must be at least 2"),
    ("frames 51.0", lambda: ggo.paper_base_gait(51.0), "frames: expected a whole number, got 51.0"),
    ("frames True", lambda: BASE.resampled(True), "frames: expected a whole number, got True"),
    ("no legs", lambda: gait(FRAMES).endpoints(), "model: gait '' states no leg lengths"),
    ("thigh 0", lambda: ggo.LegModel(0.0, 0.39), "thigh: 0 m must be above 0 m"),
    ("shank negative", lambda: ggo.LegModel(0.39, -0.39), "shank: -0.39 m must be above 0 m"),
    ("thigh inf", lambda: ggo.LegModel(INF, 0.39), "thigh: inf m is not finite"),
    ("thigh complex", lambda: ggo.LegModel(1j, 0.39), "thigh: expected a number, got 1j"),
    ("mass 0", lambda: ggo.LegModel(0.39, 0.39, thigh_mass=0), "thigh_mass: 0 kg must be above 0 kg"),
    ("foot a number", lambda: ggo.LegModel(0.39, 0.39, foot=0.2), "foot: expected a Foot, got 0.2"),
    ("toe negative", lambda: ggo.Foot(toe=-0.1), "toe: -0.1 m must be at least 0 m"),
    ("obstacle reversed", lambda: ggo.Obstacle(0.25, 0.20, 0.08), "x_end: 0.2 m must be above x_start 0.25 m"),
    ("obstacle height negative", lambda: ggo.Obstacle(0.2, 0.25, -0.1), "height: -0.1 m must be at least 0 m"),
    ("obstacle NaN", lambda: ggo.Obstacle(np.float32(NAN), 0.25, 0.1), "x_start: nan m is not finite"),
    ("gap of no width", lambda: ggo.Gap(0.2, 0.2), "x_end: 0.2 m must be above x_start 0.2 m"),
    ("ground heights", lambda: ggo.Ground((0.3,), (0.0,)), "heights: 1 edges need 2 heights, got 1"),
    ("ground edges", lambda: ggo.Ground((0.3, 0.2), (0, 1, 2)), r"edges: \[0.3, 0.2\] must ascend"),
    ("step without foothold", ggo.Step, "foothold: a step needs a foothold"),
    ("step of three numbers", lambda: ggo.Step((0.39, 0, 0)), r"foothold: expected shape \(2,\), got \(3,\)"),
    ("step obstacle a tuple", lambda: ggo.Step((0.39, 0), [(0.2, 0.25, 0.1)]), "obstacles: expected Obstacles, got"),
    ("step gap an obstacle", lambda: ggo.Step((0.39, 0), gaps=[BOX]), "gaps: expected Gaps, got a Obstacle"),
    ("step ground None", lambda: ggo.Step((0.39, 0), ground=None), "ground: expected a Ground, got None"),
    (
        "end frame in degrees",
        lambda: ggo.Step(end_frame=(20, 5, -10, 3)),
        "end_frame: angle 20 rad .*looks like degrees",
    ),
    ("shank NaN", lambda: ggo.Step((0.39, 0), shank_angle=NAN), "shank_angle: value nan"),
    ("foothold NaN", lambda: ggo.step_over(BASE, [], foothold=(NAN, 0)), r"foothold: value nan at \[0\] is not finite"),
    ("foothold text", lambda: ggo.step_over(BASE, [], foothold="ab"), r"foothold: expected numbers of shape \(2,\)"),
    ("obstacles tuples", lambda: ggo.step_over(BASE, [(0.2, 0.25, 0.08)]), "obstacles: expected Obstacles, got"),
    ("gain 0", lambda: ggo.step_over(BASE, [], gain=0), "gain: 0 must be above 0"),
    ("gain NaN", lambda: ggo.step_over(BASE, [], gain=NAN), "gain: nan is not finite"),
    ("start short", lambda: ggo.step_over(BASE, [], start=[0, 0, 0]), r"start: expected shape \(4,\), got \(3,\)"),
    ("start in degrees", lambda: ggo.step_over(BASE, [], start=[20, 5, -10, 3]), "start: angle 20 rad .*looks like"),
    ("no steps", lambda: ggo.walk(BASE, []), "steps: a walk needs at least one step"),
    ("steps text", lambda: ggo.walk(BASE, "ab"), "steps: expected a list of Steps, got 'ab'"),
    ("steps empty text", lambda: ggo.walk(BASE, ""), "steps: expected a list of Steps, got ''"),
    ("steps {}", lambda: ggo.walk(BASE, {}), "steps: expected a list of Steps, got {}"),
    ("obstacles {}", lambda: ggo.step_over(BASE, {}), "obstacles: expected a list of Obstacles, got {}"),
    ("obstacles ''", lambda: ggo.verify(BASE, obstacles=""), "obstacles: expected a list of Obstacles, got ''"),
    ("gaps {}", lambda: ggo.Step((0.39, 0.0), gaps={}), "gaps: expected a list of Gaps, got {}"),
    ("gaits ''", lambda: ggo.joint_trajectory(""), "gaits: expected a list of Gaits, got ''"),
    (
        "foothold {}",
        lambda: ggo.step_over(BASE, [], foothold={}),
        r"foothold: expected numbers of shape \(2,\), got {}",
    ),
    ("risers ''", lambda: ggo.stair_ground(0.3, 0.3, ""), r"rises: expected numbers of shape \(m,\), got ''"),
    ("frames {}", lambda: gait({}), r"frames: expected numbers of shape \(m, 4\), got {}"),
    ("endpoint text", lambda: ggo.paper_base_gait(endpoint="no"), "endpoint: expected True or False, got 'no'"),
    ("keyframes {}", lambda: ggo.GaitGraph(BASE, keyframes={}), "keyframes: expected a list of objects, got {}"),
    ("steps footholds", lambda: ggo.walk(BASE, [(0.39, 0.0)]), r"steps: expected Steps, got \(0.39, 0.0\)"),
    ("stride negative", lambda: ggo.adjust_stride(BASE, -0.9), "stride: -0.9 m must be above 0 m"),
    ("stride text", lambda: ggo.adjust_stride(BASE, "long"), "stride: expected a number, got 'long'"),
    ("steps 1.0", lambda: ggo.adjust_stride(BASE, steps=1.0), "steps: expected a whole number, got 1.0"),
    ("riser nested", lambda: ggo.climb_stairs(BASE, [[0.1]]), r"riser: expected shape \(m,\), got \(1, 1\)"),
    ("no risers", lambda: ggo.climb_stairs(BASE, []), "riser: 0 risers for at least 1 steps"),
    ("riser negative", lambda: ggo.descend_stairs(BASE, [0.1, -0.1]), "riser: -0.1 m must be above 0 m"),
    ("tread inf", lambda: ggo.climb_stairs(BASE, 0.1, tread=INF), "tread: inf m is not finite"),
    ("tolerance NaN", lambda: ggo.Tolerances(knee=NAN), "knee: nan is not finite"),
    ("verify foothold", lambda: ggo.verify(BASE, foothold=(1, 2, 3)), r"foothold: expected shape \(2,\), got \(3,\)"),
    ("verify start", lambda: ggo.verify(BASE, start=np.degrees(FRAMES[0])), "start: angle .*looks like degrees"),
    (
        "verify shank",
        lambda: ggo.verify(BASE, shank_angle="up"),
        "shank_angle: expected numbers of shape \\(\\), got 'up'",
    ),
    ("verify without legs", lambda: ggo.verify(gait(FRAMES)), "states no leg lengths"),
    (
        "first swing",
        lambda: ggo.joint_trajectory([BASE], "Right"),
        "first_swing: 'Right' is neither 'right' nor 'left'",
    ),
    ("no gaits", lambda: ggo.joint_trajectory([]), "gaits: a trajectory needs at least one step"),
    ("gaits apart", lambda: ggo.joint_trajectory([BASE, BASE.swapped()]), "step 2: starts .* rad away from the end"),
    ("gaits of other dt", lambda: ggo.joint_trajectory([BASE, BASE.resampled(26)]), "step 2: dt is 0.02 s"),
    ("no walk", lambda: ggo.Walk((), ()), "walk: 0 gaits for 0 planned steps"),
    ("plan too short", lambda: ggo.Walk((BASE, BASE), (ggo.Step((0.39, 0)),)), "walk: 2 gaits for 1 planned steps"),
    (
        "ik target",
        lambda: BASE.legs().inverse_kinematics([1, 2, 3], [0, 0]),
        r"target: expected shape \(2,\), got \(3,\)",
    ),
    ("ik NaN", lambda: BASE.legs().inverse_kinematics([NAN, 0], [0, 0]), r"target: value nan at \[0\] is not finite"),
    ("keyframes", lambda: ggo.GaitGraph(BASE, keyframes="most"), "keyframes: 'most' is not known"),
    ("keyframe out of range", lambda: ggo.GaitGraph(BASE, keyframes=[51]), "keyframes: frame 51 is not in this gait"),
    ("keyframe 1.0", lambda: ggo.GaitGraph(BASE, keyframes=[1.0]), "keyframes: frame 1.0 is not in this gait"),
    ("knee gain 0", lambda: ggo.GaitGraph(BASE, knee_gain=0), "knee_gain: 0 must be above 0"),
    ("anchor twice", lambda: anchored().anchor(FRAMES[0]), "frame 0 is anchored already"),
    ("anchor NaN", lambda: anchored().anchor([NAN] * 4, 3), r"frame0: value nan at \[0\] is not finite"),
    ("anchor out of range", lambda: anchored().anchor(FRAMES[0], 51), "frame: frame 51 is not in this gait"),
    ("obstacle frames", lambda: anchored().add_obstacle(BOX, frames=[99]), "frames: frame 99 is not in this gait"),
    ("hold negative", lambda: anchored().add_obstacle(BOX, hold=-1), "hold: -1 1/m must be at least 0 1/m"),
    ("gamma 0", lambda: anchored().add_obstacle(BOX, gamma=0), "gamma: 0 1/m must be above 0 1/m"),
    ("margin negative", lambda: anchored().add_obstacle(BOX, margin=-0.1), "margin: -0.1 m must be at least 0 m"),
    ("fine text", lambda: ggo.GaitGraph(BASE, fine="x"), "fine: expected a Gait"),
    ("fine is coarse", lambda: ggo.GaitGraph(BASE, fine=BASE.resampled(21)), "fine: has 21 frames, the base gait 51"),
    (
        "fine of another gait",
        lambda: ggo.GaitGraph(BASE, fine=ggo.Gait(np.zeros((101, 4)), 0.005)),
        "fine: does not begin and end as the base gait does",
    ),
    (
        "frames beside fine",
        lambda: ggo.GaitGraph(BASE, fine=BASE.resampled(101)).add_obstacle(BOX, frames=[3]),
        "frames: with a gait at a higher sampling rate only `solve` chooses them",
    ),
    ("drift too far", lambda: ggo.GaitGraph(BASE, smoothness=1.0).begin_with([1e308] * 4), r"drift: angle 1e\+308 rad"),
    ("limits", lambda: ggo.step_over(BASE, [], limits={}), "limits: expected a JointLimits, got {}"),
    ("given 1", lambda: ggo.GaitGraph(BASE, smoothness=1.0).begin_with([0.0] * 4, 1.0), "given: 1 must be below 1"),
    ("drift NaN", lambda: ggo.GaitGraph(BASE, smoothness=1.0).begin_with([NAN] * 4), r"drift: value nan at \[0\]"),
    (
        "drift, no second order",
        lambda: anchored().begin_with(np.zeros(4)),
        "drift: the graph has no second-order edges",
    ),
    ("end of nothing", lambda: anchored().end(), "end: give a foothold"),
    ("end shank in degrees", lambda: anchored().end(shank_angle=90), "shank_angle: angle 90 rad .*looks like degrees"),
    ("end gain", lambda: anchored().end((0.39, 0), gain=INF), "gain: inf is not finite"),
    ("factor text", lambda: anchored().add_factor("x"), "factor: expected a gtsam factor, got str"),
    ("factor on x2", lambda: anchored().add_factor(prior(gtsam.symbol("x", 2))), "factor: key x2 is not"),
    ("factor on g99", lambda: anchored().add_factor(prior(gtsam.symbol("g", 99))), "frame 99 is not in this gait"),
    ("optimizer", lambda: anchored().solve("newton"), "optimizer: 'newton' is not known"),
    ("iterations 0", lambda: anchored().solve(max_iterations=0), "max_iterations: 0 must be at least 1"),
    ("iterations -5", lambda: anchored().solve(max_iterations=-5), "max_iterations: -5 must be at least 1"),
    (
        "edge without frames",
        lambda: ggo.checked_factor("mine", (), 2, good, unit(2)),
        "mine edge: frames .* must be one",
    ),
    (
        "edge of other noise",
        lambda: ggo.checked_factor("mine", (3,), 2, good, unit(3)),
        "noise of dimension 3, error of 2",
    ),
    ("check without value", lambda: ggo.check_jacobian(prior(5), gtsam.Values()), "values: no value for 5"),
    ("check step 0", lambda: ggo.check_jacobian(prior(5), gtsam.Values(), 0), "step: 0 must be at least 1e-12"),
]


def unit(rows: int) -> gtsam.noiseModel.Base:
    return gtsam.noiseModel.Unit.Create(rows)


def prior(key: int) -> gtsam.NoiseModelFactor:
    return gtsam.PriorFactorVector(key, np.zeros(4), unit(4))


def good(frame: np.ndarray, want_jacobian: bool) -> tuple[np.ndarray, tuple[np.ndarray, ...]]:
    return frame[:2] - 0.1, (np.eye(2, 4, order="F"),)


@pytest.mark.parametrize(("call", "message"), [case[1:] for case in CALLS], ids=[case[0] for case in CALLS])
def test_values_that_cannot_be_used(call, message):
    with pytest.raises(ggo.InputError, match=message) as caught:
        call()
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("function", "message"),
    [
        (lambda frame, want: (frame[:3], (np.eye(2, 4),)), r"error has shape \(3,\) of float64, expected shape \(2,\)"),
        (lambda frame, want: (0.0, (np.eye(2, 4),)), "error is 0.0, expected shape"),
        (lambda frame, want: ([0.0, 0.0], (np.eye(2, 4),)), "error is .* expected shape"),
        (lambda frame, want: (np.full(2, NAN), (np.eye(2, 4),)), "error .* is not finite"),
        (lambda frame, want: (frame[:2], ()), "0 Jacobians, expected 1"),
        (
            lambda frame, want: (frame[:2], (np.eye(3, 4),)),
            r"Jacobian 0 has shape \(3, 4\) of float64, expected shape \(2, 4\)",
        ),
        (
            lambda frame, want: (frame[:2], (np.eye(2, 3),)),
            r"Jacobian 0 has shape \(2, 3\) of float64, expected shape \(2, 4\)",
        ),
        (
            lambda frame, want: (frame[:2], (np.ones(4),)),
            r"Jacobian 0 has shape \(4,\) of float64, expected shape \(2, 4\)",
        ),
        (lambda frame, want: (frame[:2], (None,)), "Jacobian 0 is None, expected shape"),
        (lambda frame, want: (frame[:2], (np.full((2, 4), INF),)), "Jacobian 0 is not finite"),
    ],
)
def test_an_edge_of_the_users_own_that_is_wrong_is_named_and_kills_nothing(function, message):
    graph = anchored()
    with pytest.raises(ggo.GraphError, match=f"mine edge at frame 25: {message}"):
        graph.add_factor(ggo.checked_factor("mine", (25,), 2, function, unit(2)))


def test_an_edge_with_a_wrong_jacobian_does_not_pass_as_solved():
    graph = anchored()
    graph.add_factor(ggo.checked_factor("mine", (25,), 2, lambda g, want: (g[:2] - 0.5, (-np.eye(2, 4),)), unit(2)))
    solution = graph.solve()
    assert not solution.ok
    assert "not converged" in solution.reason


@pytest.mark.parametrize("hard", [(0.5, 0.4), (0.3, 0.6)])
def test_hard_edges_that_contradict_are_said_to(hard):
    graph = anchored()
    for x in hard:
        graph.end((x, 0.0), hard=True)
    solution = graph.solve()
    assert not solution.ok
    assert solution.reason.startswith("contradicting: a hard edge at frame 50 is missed by")
    with pytest.raises(ggo.InfeasibleGaitError, match="contradicting"):
        solution.require_ok()


def test_a_graph_without_an_anchor():
    with pytest.raises(ggo.GraphError, match="frame 0 is not anchored"):
        ggo.GaitGraph(BASE).solve()


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (
            lambda: ggo.step_over(BASE, [], foothold=(9.0, 0.0)),
            r"foothold \(9, 0\) is 9.000 m .* two legs reach 1.560 m",
        ),
        (lambda: anchored().end((0.0, -2.0)), r"foothold \(0, -2\) is 2.000 m"),
        (lambda: BASE.legs().inverse_kinematics([2.0, 0.0], [0, 0]), "target is 2.1.* m from the hip"),
    ],
)
def test_what_no_leg_reaches(call, message):
    with pytest.raises(ggo.UnreachableFootholdError, match=message) as caught:
        call()
    assert caught.value.distance > caught.value.reach > 0.0


@pytest.mark.parametrize(
    ("call", "kind"),
    [
        (lambda: ggo.step_over(BASE, [ggo.Obstacle(-0.01, 0.01, 0.05)]), "obstacle in the supporting foot"),
        (lambda: ggo.step_over(BASE, [ggo.Obstacle(0.0, 0.1, 0.05)]), "obstacle in the supporting foot"),
        (lambda: ggo.step_over(BASE, [ggo.Obstacle(-0.4, -0.3, 0.05)]), "obstacle in the swinging foot's start"),
        (lambda: ggo.step_over(BASE, [ggo.Obstacle(0.3, 0.39, 0.05)], foothold=(0.39, 0)), "obstacle in the foothold"),
        (lambda: ggo.step_over(BASE, [], foothold=(0.39, 0), gaps=[ggo.Gap(0.38, 0.4)]), "foothold in a gap"),
        (lambda: ggo.step_over(BASE, [], foothold=(0.39, -0.1)), "foothold off the ground"),
    ],
)
def test_what_no_gait_can_do_is_refused_with_its_numbers(call, kind):
    with pytest.raises(ggo.InfeasibleGaitError) as caught:
        call()
    first, *others = [violation.kind for violation in caught.value.violations]
    assert first == kind
    assert all("shank in obstacle" in other for other in others)  # the leg over the foot
    assert caught.value.step == 1
    if kind.startswith("foothold"):
        x, y = caught.value.nearest_foothold
        assert abs(x - 0.39) < 0.2
        assert y == 0.0


@pytest.mark.parametrize("load", [ggo.load_gait, ggo.load_walk])
def test_loading_what_is_no_file(tmp_path, load):
    with pytest.raises(ggo.InputError, match=r"none\.csv: cannot be read: No such file"):
        load(tmp_path / "none.csv")
    with pytest.raises(ggo.InputError, match="cannot be read: Is a directory"):
        load(tmp_path)


def test_saving_where_nothing_can_be_written(tmp_path):
    with pytest.raises(ggo.InputError, match="cannot be written: No such file"):
        BASE.save(tmp_path / "none" / "base.csv")
    with pytest.raises(ggo.InputError, match="must be one printable line"):
        ggo.Gait(FRAMES, 0.01, name="two\nlines").save(tmp_path / "base.csv")
    assert list(tmp_path.iterdir()) == []


# -- what is odd but good -------------------------------------------------------------------------------------------


def test_numbers_of_other_types_are_numbers():
    assert ggo.LegModel(np.float32(0.5), np.int32(1)) == ggo.LegModel(0.5, 1.0)
    assert gait(np.zeros((3, 4), np.int32)).frames.dtype == np.float64
    graph = ggo.GaitGraph(BASE, keyframes=np.array([3, 5], np.int32))
    graph.anchor(FRAMES[0].tolist())
    assert {3, 5} <= set(graph.solve().keyframes)


def test_generators_do_as_well_as_lists():
    boxes = (box for box in [BOX])
    assert ggo.step_over(BASE, boxes, foothold=(0.39, 0.0)).report.clearance >= 0.0
    walk = ggo.walk(BASE, (ggo.Step((0.39, 0.0)) for _ in range(2)))
    assert len(walk.gaits) == 2


def test_what_can_be_read_only_once_is_read_once():
    ground = ggo.Ground(iter([0.3, 0.6]), (0.1 * k for k in range(3)))
    assert ground == ggo.Ground((0.3, 0.6), (0.0, 0.1, 0.2))
    assert ggo.stair_ground(0.3, 0.3, iter([0.1, 0.1])).edges == (0.3, 0.6)
    np.testing.assert_array_equal(gait(iter(FRAMES.tolist())).frames, FRAMES)
    step = ggo.Step(iter([0.39, 0.0]), iter([BOX]), (ggo.Gap(x, x + 0.1) for x in (0.5, 0.7)))
    assert step == ggo.Step((0.39, 0.0), (BOX,), (ggo.Gap(0.5, 0.6), ggo.Gap(0.7, 0.7 + 0.1)))


@pytest.mark.parametrize("value", [True, False, np.True_, np.False_])
def test_truth_values_are_taken(value):
    assert as_bool(value, "hard") is bool(value)


@pytest.mark.parametrize("value", [1, 0, "yes", "", None, {}, [], 1.0, np.array([True])])
def test_what_is_no_truth_value_is_refused(value):
    with pytest.raises(ggo.InputError, match="hard: expected True or False, got "):
        as_bool(value, "hard")


def test_a_gait_keeps_no_hold_of_what_it_was_made_from():
    frames = FRAMES.copy()
    made = gait(frames)
    frames[:] = 0.0
    np.testing.assert_array_equal(made.frames, FRAMES)
    with pytest.raises(ValueError, match="read-only"):
        made.frames[0, 0] = 1.0
