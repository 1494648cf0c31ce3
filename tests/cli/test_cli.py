"""The `ggo` command, run for real: every subcommand, what it prints, what it writes, and its exit code."""

from __future__ import annotations

import json
import os
import re
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from mcap.reader import make_reader
from mcap_ros2.decoder import DecoderFactory

import ggo_factors as ggo
from ggo_factors.cli import main

DATASETS = Path(__file__).parents[2] / "datasets"
PNG = b"\x89PNG\r\n\x1a\n"
SUBCOMMANDS = ("import", "inspect", "stride", "step-over", "stairs", "walk", "verify", "plot", "export", "sweep")

Run = Callable[..., tuple[int, str, str]]


@pytest.fixture
def ggo_command(capsys: pytest.CaptureFixture[str]) -> Run:
    def run(*arguments: object) -> tuple[int, str, str]:
        code = main([str(argument) for argument in arguments])
        captured = capsys.readouterr()
        return code, captured.out, captured.err

    return run


@pytest.fixture
def base_file(tmp_path: Path) -> Path:
    path = tmp_path / "base.csv"
    ggo.paper_base_gait().save(path)
    return path


@pytest.fixture(scope="module")
def stairs_walk() -> ggo.Walk:
    return ggo.climb_stairs(ggo.paper_base_gait())


@pytest.fixture
def walk_file(tmp_path: Path, stairs_walk: ggo.Walk) -> Path:
    path = tmp_path / "walk.csv"
    stairs_walk.save(path)
    return path


def damage(path: Path, row: int, column: int, degrees: float) -> Path:
    """A copy of a walk file beside it, one angle overwritten."""
    lines = path.read_text().splitlines()
    first = next(i for i, line in enumerate(lines) if not line.startswith("#")) + 1
    cells = lines[first + row].split(",")
    cells[column] = f"{degrees}"
    lines[first + row] = ",".join(cells)
    damaged = path.with_name("damaged.csv")
    damaged.write_text("\n".join(lines) + "\n")
    return damaged


def joint_states(path: Path) -> np.ndarray:
    """Every position of `/joint_states`, shape (k, joints), as another reader decodes it."""
    with path.open("rb") as stream:
        reader = make_reader(stream, validate_crcs=True, decoder_factories=[DecoderFactory()])
        messages = reader.iter_decoded_messages(topics=["/joint_states"])
        return np.array([list(decoded.position) for _, _, _, decoded in messages])


# -- the command as a program ---------------------------------------------------------------------------------------


def test_runs_as_a_program(tmp_path):
    output = tmp_path / "walk.csv"
    command = [sys.executable, "-m", "ggo_factors.cli", "stride", "paper", "--stride", "0.585", "-o", str(output)]
    done = subprocess.run(command, check=False, capture_output=True, text=True, timeout=60)
    assert (done.returncode, done.stderr) == (0, "")
    assert f"wrote {output}" in done.stdout
    landings = [gait.endpoints()[-1, 0] for gait in ggo.load_walk(output).gaits]
    assert landings == pytest.approx([0.2925, 0.2925], abs=1e-3)


def test_exit_code_of_the_program_where_there_is_no_safe_gait(tmp_path):
    output = tmp_path / "walk.csv"
    command = [sys.executable, "-m", "ggo_factors.cli", "stride", "paper", "--stride", "9", "-o", str(output)]
    done = subprocess.run(command, check=False, capture_output=True, text=True, timeout=60)
    assert done.returncode == 3
    assert re.fullmatch(r"ggo: step 1: foothold \(4\.5, 0\) is .*reach 1\.560 m\n", done.stderr)
    assert list(tmp_path.iterdir()) == []


def test_version(ggo_command):
    assert ggo_command("--version") == (0, f"ggo, version {ggo.__version__}\n", "")


def test_help_names_every_command_and_exit_code(ggo_command):
    code, out, err = ggo_command("--help")
    assert (code, err) == (0, "")
    assert [name for name in SUBCOMMANDS if not re.search(rf"^  {name} ", out, re.MULTILINE)] == []
    assert "0 done, 2 bad input, 3 no safe gait" in " ".join(out.split())


@pytest.mark.parametrize("name", SUBCOMMANDS)
def test_help_of_each_command(ggo_command, name):
    code, out, err = ggo_command(name, "--help")
    assert (code, err) == (0, "")
    assert out.startswith(f"Usage: ggo {name} ")
    takes_output = name not in ("verify", "inspect")
    assert ("-o, --output" in out) == takes_output
    # The same flag means the same in every command.
    assert ("--thigh FLOAT" in out) == (name not in ("inspect", "sweep"))


# -- generating -----------------------------------------------------------------------------------------------------


def test_stride_table_says_ok_of_each_step(ggo_command):
    code, out, err = ggo_command("stride", "paper", "--stride", 0.975)
    assert (code, err) == (0, "")
    rows = [line.split() for line in out.splitlines() if line.startswith("step ") and "iter" not in line]
    assert [(row[:2], row[-1]) for row in rows] == [(["step", "1"], "ok"), (["step", "2"], "ok")]


def test_stride_json(ggo_command):
    code, out, err = ggo_command("stride", "paper", "--stride", 0.975, "--json")
    assert (code, err) == (0, "")
    said = json.loads(out)
    assert said["format_version"] == 1
    assert [step["verdict"] for step in said["steps"]] == ["ok", "ok"]
    assert max(step["foothold_error_mm"] for step in said["steps"]) < 1.0
    assert set(said["steps"][0]["change_deg"]) == {"alpha1", "beta1", "alpha2", "beta2"}


def test_json_stays_json_where_a_file_is_written(ggo_command, tmp_path):
    code, out, _ = ggo_command("stride", "paper", "--json", "-o", tmp_path / "w.csv")
    assert code == 0
    assert json.loads(out)["format_version"] == 1


def test_stride_round_trip_keeps_the_gait_and_its_steps(ggo_command, base_file, tmp_path):
    output = tmp_path / "out.csv"
    assert ggo_command("stride", base_file, "--stride", 0.9, "--steps", 3, "-o", output)[0] == 0
    made = ggo.adjust_stride(ggo.load_gait(base_file), stride=0.9, steps=3)
    back = ggo.load_walk(output)
    assert back.plan == made.plan
    for gait, other in zip(back.gaits, made.gaits, strict=True):
        np.testing.assert_allclose(gait.frames, other.frames, rtol=0, atol=1e-13)
        assert (gait.dt, gait.model) == (other.dt, other.model)
    assert all(report.ok for report in back.verify())


def test_stride_over_a_pit_lands_beside_it(ggo_command, tmp_path):
    output = tmp_path / "out.csv"
    assert ggo_command("stride", "paper", "--gap", "0.36,0.45", "-o", output)[0] == 0
    landings = [gait.endpoints()[-1, 0] for gait in ggo.load_walk(output).gaits]
    places = np.cumsum(landings)
    assert not ((places > 0.36) & (places < 0.45)).any()


def test_step_over_clears_the_obstacle(ggo_command, tmp_path):
    output = tmp_path / "out.csv"
    arguments = ("--obstacle", "0.2,0.25,0.08", "--foothold", "0.39,0", "--json", "-o", output)
    code, out, _ = ggo_command("step-over", "paper", *arguments)
    assert code == 0
    (step,) = json.loads(out)["steps"]
    assert step["clearance_mm"] >= 0.0
    (gait,) = ggo.load_walk(output).gaits
    path = gait.endpoints()
    assert path[(path[:, 0] >= 0.2) & (path[:, 0] <= 0.25), 1].min() >= 0.08
    np.testing.assert_allclose(path[-1], (0.39, 0.0), atol=1e-3)


def test_step_over_two_obstacles(ggo_command):
    arguments = ("--obstacle", "-0.2,-0.15,0.05", "--obstacle", "0.15,0.2,0.05")
    assert ggo_command("step-over", "paper", *arguments)[0] == 0


@pytest.mark.parametrize(("direction", "sign"), [("up", 1.0), ("down", -1.0)])
def test_stairs_land_on_their_treads(ggo_command, tmp_path, direction, sign):
    output = tmp_path / "out.csv"
    code, _, err = ggo_command("stairs", "paper", direction, "--riser", "0.10,0.14", "-o", output)
    assert (code, err) == (0, "")
    walk = ggo.load_walk(output)
    for gait, rise in zip(walk.gaits, (0.10, 0.14), strict=True):
        np.testing.assert_allclose(gait.endpoints()[-1], (0.39, sign * rise), atol=1e-3)
        assert abs(np.degrees(gait.frames[-1, 2] - gait.frames[-1, 3])) < 1.0


def test_walk_from_and_to_standing_over_an_obstacle(ggo_command, tmp_path):
    output = tmp_path / "out.csv"
    steps = ("--foothold", "0.39,0", "--foothold", "0.39,0", "--obstacle", "0.5,0.55,0.06")
    code, _, err = ggo_command("walk", "paper", "--from-standing", *steps, "--to-standing", "-o", output)
    assert (code, err) == (0, "")
    walk = ggo.load_walk(output)
    np.testing.assert_array_equal(walk.gaits[0].frames[0], ggo.STANDING)
    np.testing.assert_allclose(walk.gaits[-1].frames[-1], ggo.STANDING, rtol=0, atol=1e-9)
    # The obstacle lies on the way of the second foot, and of the first as it closes up.
    seen = [[round(box.x_start, 6) for box in step.obstacles] for step in walk.plan]
    assert seen == [[0.5], [pytest.approx(0.11, abs=1e-3)], [pytest.approx(-0.28, abs=1e-3)]]
    for gait, origin in zip(walk.gaits, walk.origins(), strict=True):
        path = gait.endpoints() + origin
        over = (path[:, 0] >= 0.5) & (path[:, 0] <= 0.55)
        assert (path[over, 1] >= 0.06).all()


def test_frames_and_legs_from_flags(ggo_command, tmp_path):
    output = tmp_path / "out.csv"
    flags = ("--frames", 31, "--thigh", 0.42, "--shank", 0.40)
    assert ggo_command("stride", "paper", *flags, "-o", output)[0] == 0
    gait = ggo.load_walk(output).gaits[0]
    assert (len(gait), gait.model) == (31, ggo.LegModel(0.42, 0.40))


def test_output_as_mcap(ggo_command, tmp_path):
    output = tmp_path / "out.mcap"
    assert ggo_command("stride", "paper", "-o", output)[0] == 0
    assert joint_states(output).shape == (101, 4)


def test_output_replaces_the_file_that_stood_there(ggo_command, tmp_path):
    output = tmp_path / "out.csv"
    output.write_text("old")
    assert ggo_command("stride", "paper", "-o", output)[0] == 0
    assert len(ggo.load_walk(output).gaits) == 2
    assert list(tmp_path.iterdir()) == [output]


# -- verifying ------------------------------------------------------------------------------------------------------


def test_verify_a_gait(ggo_command, base_file):
    code, out, err = ggo_command("verify", base_file)
    assert (code, err) == (0, "")
    assert "ok" in out


@pytest.mark.parametrize(
    ("flags", "fault"),
    [
        (("--obstacle", "0.2,0.25,0.08"), "obstacle (box from 0.2 to 0.25 m, 0.08 m high) at frame"),
        (("--foothold", "0.5,0"), "foothold at frame 50"),
        (("--gap", "0.3,0.5"), "foothold in a gap"),
        (("--thigh", "0.9", "--shank", "0.9", "--foothold", "0.39,0"), "foothold at frame 50"),
    ],
)
def test_verify_a_gait_against_what_it_does_not_do(ggo_command, base_file, flags, fault):
    code, out, _ = ggo_command("verify", base_file, *flags, "--json")
    assert code == 3
    assert fault in json.loads(out)["steps"][0]["verdict"]


def test_verify_a_walk(ggo_command, walk_file):
    code, out, err = ggo_command("verify", walk_file, "--json")
    assert (code, err) == (0, "")
    said = json.loads(out)
    assert said["format_version"] == 1
    assert [(step["name"], step["verdict"]) for step in said["steps"]] == [("step 1", "ok"), ("step 2", "ok")]


@pytest.mark.parametrize(
    ("row", "column", "degrees", "fault"),
    [
        (20, 2, -5.0, "knee"),
        (25, 4, 2.0, "ground"),
        (51, 1, 40.0, "start"),
        (101, 3, 60.0, "foothold"),
    ],
)
def test_a_walk_that_was_edited_to_be_unsafe_is_found_and_not_exported(
    ggo_command, walk_file, row, column, degrees, fault
):
    damaged = damage(walk_file, row, column, degrees)
    code, out, _ = ggo_command("verify", damaged, "--edited", "--json")
    assert code == 3
    assert re.search(fault, " ".join(step["verdict"] for step in json.loads(out)["steps"]))

    output = damaged.with_suffix(".mcap")
    code, _, err = ggo_command("export", damaged, "--edited", "-o", output)
    assert code == 3
    noticed, refused = err.splitlines()
    assert noticed.startswith(f"ggo: note: {damaged}: taken as edited")
    assert re.match(r"ggo: .*step \d is not safe: ", refused)
    assert not output.exists()


@pytest.mark.parametrize(
    "command",
    [
        "verify {}",
        "plot {} -o {}.png",
        "plot paper --base {} -o {}.png",
        "export {} -o {}.mcap",
        "verify paper --base {}",
    ]
    + [f"{made} -o {{}}.out.csv" for made in ("stride {}", "step-over {}", "stairs {} up", "walk {} --foothold 0.39,0")]
    + ["sweep {} --stride 0.7 --steps 1 --workers 1 -o {}.nc"],
)
def test_changed_numbers_are_taken_where_it_is_said(ggo_command, base_file, command):
    lines = base_file.read_text().splitlines()
    lines[-20] = ",".join(str(float(angle) + 0.01) for angle in lines[-20].split(","))
    base_file.write_text("\n".join(lines) + "\n")
    arguments = command.replace("{}", str(base_file)).split()
    code, _, err = ggo_command(*arguments)
    assert (code, err.count("\n")) == (2, 1)
    assert re.match(rf"ggo: {base_file}: .*changed since it was written.*--edited", err)
    code, _, err = ggo_command(*arguments, "--edited")
    assert (code, err) == (
        0,
        f"ggo: note: {base_file}: taken as edited, its rows, dt or limits were changed since it was written\n",
    )


def test_a_file_without_checksum_is_read_with_a_note(ggo_command, walk_file):
    text = re.sub("(?m)^# checksum: .*\n", "", walk_file.read_text())
    walk_file.write_text(text)
    code, out, err = ggo_command("verify", walk_file, "--json")
    assert (code, len(json.loads(out)["steps"])) == (0, 2)
    assert err == f"ggo: note: {walk_file}: has no checksum, so changed numbers cannot be told\n"


# -- pictures and logs ----------------------------------------------------------------------------------------------


@pytest.mark.parametrize("what", ["stick", "angles", "residual", "joints"])
def test_plot_writes_a_picture(ggo_command, walk_file, what):
    output = walk_file.with_suffix(".png")
    code, out, err = ggo_command("plot", walk_file, "--base", "paper", "--what", what, "-o", output)
    assert (code, err) == (0, "")
    assert out == f"wrote {output}\n"
    content = output.read_bytes()
    assert content.startswith(PNG)
    width, height = (int.from_bytes(content[at : at + 4], "big") for at in (16, 20))
    assert min(width, height) > 300


def test_plot_of_a_gait_as_svg(ggo_command, base_file):
    output = base_file.with_suffix(".svg")
    assert ggo_command("plot", base_file, "-o", output)[0] == 0
    assert "<svg" in output.read_text()


@pytest.mark.parametrize("first_swing", ["right", "left"])
def test_export_opens_in_another_reader(ggo_command, walk_file, stairs_walk, first_swing):
    output = walk_file.with_suffix(".mcap")
    assert ggo_command("export", walk_file, "--first-swing", first_swing, "-o", output)[0] == 0
    wanted = stairs_walk.joint_trajectory(first_swing)
    columns = np.stack([wanted.left_hip, wanted.left_knee, wanted.right_hip, wanted.right_knee], -1)
    np.testing.assert_allclose(joint_states(output), columns, rtol=0, atol=1e-12)


def test_export_takes_the_pelvis_tilt_from_the_hips(ggo_command, walk_file):
    plain, tilted = walk_file.with_name("plain.mcap"), walk_file.with_name("tilted.mcap")
    assert ggo_command("export", walk_file, "-o", plain)[0] == 0
    assert ggo_command("export", walk_file, "--pelvis-tilt", 10, "-o", tilted)[0] == 0
    taken = np.degrees(joint_states(plain) - joint_states(tilted))
    np.testing.assert_allclose(taken, np.tile([10.0, 0.0, 10.0, 0.0], (len(taken), 1)), atol=1e-9)


# -- recordings -----------------------------------------------------------------------------------------------------


def test_import_the_sample_log_and_walk_with_it(ggo_command, tmp_path):
    output, report = tmp_path / "base.csv", tmp_path / "report.json"
    log, joints = DATASETS / "children_walk.mcap", DATASETS / "children_walk.toml"
    code, out, _ = ggo_command("import", log, "--joints", joints, "-o", output, "--report", report)
    assert code == 0
    assert f"wrote {output}" in out
    assert json.loads(report.read_text())["strides_used"] == {"right": 24, "left": 24}
    assert len(ggo.load_gait(output)) == 51
    code, out, _ = ggo_command("import", log, "--joints", joints, "--json")
    assert code == 0
    assert json.loads(out)["format_version"] == 1
    assert ggo_command("step-over", output, "--obstacle", "0.2,0.25,0.08", "--foothold", "0.39,0")[0] == 0


def test_import_without_a_map_says_what_fits(ggo_command, tmp_path):
    code, out, err = ggo_command("import", DATASETS / "children_walk.mcap")
    assert (code, out) == (2, "")
    assert "there are left_hip_flexion, left_knee_flexion, pelvis_tilt" in err
    code, out, _ = ggo_command("import", "--help")
    assert all(preset in out.replace("-\n", "-").replace(" ", "") for preset in ("direct", "opensim", "segment-pitch"))


@pytest.mark.parametrize("command", ["import", "inspect"])
def test_the_paper_is_no_recording(ggo_command, tmp_path, monkeypatch, command):
    monkeypatch.chdir(tmp_path)
    code, _, err = ggo_command(command, "paper")
    assert code == 2
    assert "the base gait of the paper, not a recording" in err


@pytest.mark.parametrize(
    ("command", "name"),
    [
        (("stride", "paper"), "walk.txt"),
        (("stride", "paper"), "walk"),
        (("import", DATASETS / "children_walk.mcap", "--joints", DATASETS / "children_walk.toml"), "base.mcap"),
    ],
)
def test_a_file_is_not_written_in_a_form_that_its_ending_denies(ggo_command, tmp_path, command, name):
    code, out, err = ggo_command(*command, "-o", tmp_path / name)
    assert (code, out) == (2, "")
    assert f"{name}: must end in .csv" in err
    assert list(tmp_path.iterdir()) == []


def test_inspect_the_sample_log(ggo_command):
    code, out, _ = ggo_command("inspect", DATASETS / "children_walk.mcap")
    assert code == 0
    assert "/joint_states" in out
    code, out, _ = ggo_command("inspect", DATASETS / "children_walk.mcap", "--json")
    assert code == 0
    assert "format_version" in json.loads(out)


def test_smoothness_hard_and_limits_reach_the_gait(ggo_command, tmp_path):
    box = ("--obstacle", "0.2,0.25,0.15", "--foothold", "0.39,0")
    walks = {}
    for name, flags in {"plain": (), "paper": ("--smoothness", 0), "kept": ("--hard", "--limits")}.items():
        code, _, err = ggo_command("step-over", "paper", *box, *flags, "-o", tmp_path / f"{name}.csv")
        assert code == 0, err
        walks[name] = ggo.load_walk(tmp_path / f"{name}.csv").gaits[0]
    rough, smooth = (np.abs(np.diff(walks[name].frames, n=2, axis=0)).max() for name in ("paper", "plain"))
    assert rough > 2.0 * smooth
    assert np.hypot(*(walks["kept"].endpoints()[-1] - [0.39, 0.0])) < 1e-6
    assert ggo.verify(walks["kept"], limits=ggo.JointLimits()).ok
    code, _, err = ggo_command("step-over", "paper", *box, "--smoothness", -1)
    assert (code, "smoothness: -1 must be at least 0" in err) == (2, True)


def test_verify_holds_a_walk_to_joint_limits_where_asked(ggo_command, tmp_path):
    steps = ("--foothold", "0.45,0", "--foothold", "0.45,0", "--from-standing", "--to-standing")
    for name, flags in {"free": ("--smoothness", 0), "kept": ("--limits",)}.items():
        code, _, err = ggo_command("walk", "paper", *steps, *flags, "-o", tmp_path / f"{name}.csv")
        assert code == 0, err
    assert ggo_command("verify", tmp_path / "free.csv")[0] == 0
    code, _, err = ggo_command("verify", tmp_path / "free.csv", "--limits")
    assert code == 3
    assert "acceleration" in err
    for flags in ((), ("--limits",)):
        code, out, err = ggo_command("verify", tmp_path / "kept.csv", "--json", *flags)
        assert code == 0, err
        assert all(step["landing_speed_m_s"] < 1.0 and step["notes"] == [] for step in json.loads(out)["steps"])


def test_balance_reaches_the_gait_and_is_told(ggo_command, tmp_path):
    box, out = ("--obstacle", "0.2,0.25,0.1", "--foothold", "0.39,0"), tmp_path / "balanced.csv"
    code, _, err = ggo_command("step-over", "paper", *box, "--balance", 2, "-o", out)
    assert code == 0, err
    said = {}
    for name, flags in {"free": (), "balanced": ("--balance", 2)}.items():
        (said[name],) = json.loads(ggo_command("step-over", "paper", *box, *flags, "--json")[1])["steps"]
        assert ("ZMP off" in ggo_command("step-over", "paper", *box, *flags)[1]) == (name == "balanced")
    assert said["free"]["zmp_off_mm"] is None
    assert 0.0 < said["balanced"]["zmp_off_mm"] < 10.0
    report = json.loads(ggo_command("verify", out, "--report", "--base", "paper", "--json")[1])["comfort"]
    assert report[0]["mean_zmp_off_mm"] == pytest.approx(said["balanced"]["zmp_off_mm"], rel=1e-6)
    assert report[1]["largest_zmp_off_mm"] is None  # the base gait itself
    text = ggo_command("verify", out, "--report", "--base", "paper")[1]
    assert "ZMP off base" in text
    assert "It is no check" in text
    assert "It is no check" not in ggo_command("verify", out)[1]
    code, _, err = ggo_command("step-over", "paper", *box, "--balance", -1)
    assert (code, "balance: -1 must be at least 0" in err) == (2, True)


def test_the_shell_completes_commands_and_flags(monkeypatch, capsys):
    asked = {"_GGO_COMPLETE": "bash_complete", "COMP_CWORD": "1", "COMP_WORDS": "ggo st"}
    code = [sys.executable, "-m", "ggo_factors.cli"]
    done = subprocess.run(code, env={**os.environ, **asked}, capture_output=True, text=True, check=False)
    assert done.stdout.split() == ["plain,stairs", "plain,step-over", "plain,stride"]
    for name, value in (asked | {"COMP_CWORD": "2", "COMP_WORDS": "ggo stairs --ri"}).items():
        monkeypatch.setenv(name, value)
    with pytest.raises(SystemExit):
        main([])
    assert capsys.readouterr().out.split() == ["plain,--riser"]
