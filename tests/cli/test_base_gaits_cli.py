"""Base gaits for each leg and for stairs on the command line: written by `import`, taken by what makes gaits."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from made_gaits import pair
from mcap.reader import make_reader

import ggo_factors as ggo
from ggo_factors.cli import main

DATASETS = Path(__file__).parents[2] / "datasets"
IMPORT = ["import", str(DATASETS / "children_walk.mcap"), "--joints", str(DATASETS / "children_walk.toml")]


@pytest.fixture(scope="module")
def each(tmp_path_factory):
    """A file with a gait for each leg."""
    path = tmp_path_factory.mktemp("each") / "each.csv"
    assert main([*IMPORT, "--leg", "each", "-o", str(path)]) == 0
    return str(path)


@pytest.fixture(scope="module")
def up(tmp_path_factory):
    """A stair gait imported from stairs that were made here and exported."""
    folder = tmp_path_factory.mktemp("up")
    log, base = str(folder / "stairs.mcap"), str(folder / "up.csv")
    flight = ["--riser", "0.16", "--tread", "0.3", "--first-edge", "0.2", "--steps", "5"]
    assert main(["stairs", "paper", "up", *flight, "-o", log]) == 0
    assert main(["import", log, "--joints", "direct", "--activity", "stairs-up", "-o", base]) == 0
    return base


def test_import_writes_a_gait_for_each_leg_or_of_one(each, tmp_path):
    read = ggo.load_base_gaits(each)
    assert read.left.name.endswith("left swings")
    one = str(tmp_path / "right.csv")
    assert main([*IMPORT, "--leg", "right", "-o", one]) == 0
    assert len(ggo.load_gait(one)) == 51


@pytest.mark.parametrize("first", ["right", "left"])
def test_walks_bend_the_gait_of_each_leg_and_say_so(each, tmp_path, capsys, first):
    out = str(tmp_path / "walk.csv")
    flags = ["--first-swing", first, "--frames", "61", "--steps", "2"]
    assert main(["stride", each, *flags, "-o", out]) == 0
    made = ggo.load_walk(out)
    assert made.first_swing == first
    assert made.gaits[0].origin.endswith(f", {first} swings")
    log = tmp_path / "walk.mcap"
    assert main(["export", out, "-o", str(log)]) == 0
    with log.open("rb") as file:
        (said,) = make_reader(file).iter_metadata()
    assert said.metadata["first_swing"] == first
    assert main(["verify", out]) == 0
    capsys.readouterr()
    assert main(["verify", out, "--base", each, "--json"]) == 0
    told = capsys.readouterr()
    assert "bent from other base gaits" not in told.err
    bases, other = ggo.load_base_gaits(each).resampled(61), "left" if first == "right" else "right"
    for leg, gait, row in zip((first, other), made.gaits, json.loads(told.out)["steps"], strict=True):
        wanted = np.degrees(np.abs(gait.frames - bases.gait("level", leg).frames).mean(axis=0))
        np.testing.assert_allclose(list(row["change_deg"].values()), wanted, atol=1e-9)


def test_steps_stand_beside_the_base_gait_of_their_leg_and_ground(up, tmp_path, capsys):
    """Of a walk from standing up stairs, and of one of its steps."""
    several, out, one = (str(tmp_path / name) for name in ("several.csv", "walk.csv", "step.csv"))
    (left, right), _ = pair()
    bases = ggo.BaseGaits(left, right, up=replace(ggo.load_gait(up), model=left.model))
    bases.save(several)
    made = ggo.climb_stairs(bases, 0.15, tread=0.29, first_edge=0.2, start=ggo.STANDING, to_standing=True)
    made.save(out)
    made.gaits[2].save(one)
    assert main(["verify", out, "--base", several, "--report", "--json"]) == 0
    told = capsys.readouterr()
    assert told.err == ""
    rows = json.loads(told.out)["steps"]
    for gait, row, (kind, leg) in zip(
        made.gaits, rows, (("first up", "right"), ("up", "left"), ("level", "right")), strict=True
    ):
        wanted = np.degrees(np.abs(gait.frames - bases.gait(kind, leg).frames).mean(axis=0))
        np.testing.assert_allclose(list(row["change_deg"].values()), wanted, atol=1e-9)
    assert ggo.load_gait(one).bent == ggo.load_walk(out).gaits[2].bent
    main(["verify", one, "--base", several, "--json"])
    assert json.loads(capsys.readouterr().out)["steps"][0]["change_deg"] == pytest.approx(rows[2]["change_deg"])
    main(["verify", out, "--base", "paper"])
    assert "paper: bent from other base gaits: step 1, 2, 3" in capsys.readouterr().err
    for what in ("stick", "angles", "residual", "comfort"):
        assert main(["plot", out, "--base", several, "--what", what, "-o", str(tmp_path / f"{what}.png")]) == 0


@pytest.mark.parametrize("command", [["step-over", "--obstacle", "0.2,0.25,0.05"], ["walk", "--foothold", "0.3,0"]])
def test_every_command_takes_them(each, command):
    assert main([command[0], each, *command[1:]]) == 0


@pytest.mark.parametrize(
    "flags", [["--from-standing"], ["--on-stairs"], ["--to-standing"], ["--from-standing", "--to-standing"]]
)
def test_stairs_from_a_stair_gait_beside_a_level_one_or_alone(up, flags, tmp_path):
    out = str(tmp_path / "walk.csv")
    flight = ["up", "--riser", "0.15", "--tread", "0.29", "--first-edge", "0.2", *flags, "-o", out]
    for base in ([up], ["paper", "--up", up]):
        assert main(["stairs", base[0], *flight, *base[1:]]) == 0
        made = ggo.load_walk(out)
        # The exported flight holds its first step; an ascent alone that is not told where it starts is on the stairs.
        first = "--from-standing" in flags or (base[1:] and "--on-stairs" not in flags)
        assert made.gaits[0].origin == "generated from stairs" + (", first step" if first else "")
        assert len(made.gaits) == 2 + ("--to-standing" in flags)
        assert all(report.ok for report in made.verify())


def test_a_flight_starts_out_of_walking_where_that_is_asked(up, tmp_path, capsys):
    out = str(tmp_path / "walk.csv")
    flight = ["stairs", "paper", "up", "--up", up, "--riser", "0.15", "--tread", "0.29", "--first-edge", "0.2"]
    assert main([*flight, "--from-walking", "-o", out]) == 0
    np.testing.assert_allclose(ggo.load_walk(out).gaits[0].frames[0], ggo.paper_base_gait().frames[0], atol=1e-8)
    assert main([*flight, "--from-walking", "--from-standing"]) == 2
    assert "one of them, a flight has one start" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("command", "said"),
    [
        (["stride"], "'stairs' walks stairs, its feet 0.160 m apart in height at the start"),
        (["walk", "--foothold", "0.4,0"], "say where the walker is (start=STANDING, --from-standing)"),
        (["stairs", "down"], "'stairs' walks stairs up, not down"),
    ],
)
def test_where_a_stair_gait_makes_no_sense_it_is_refused(up, command, said, capsys):
    assert main([command[0], up, *command[1:]]) == 2
    assert said in capsys.readouterr().err


def test_a_level_gait_is_no_stair_gait(capsys):
    assert main(["stairs", "paper", "up", "--up", "paper"]) == 2
    assert "lands at -0.010 m, which is no step up stairs" in capsys.readouterr().err


def test_legs_apart_are_refused_by_name_and_imported_by_one(recordings, capsys, tmp_path):
    log = [str(recordings / "refuse_legs_apart.mcap"), "--joints", "direct", "--min-strides", "1"]
    assert main(["import", *log]) == 2
    said = capsys.readouterr().err
    assert "the legs are 17 degrees apart" in said
    assert "--leg each" in said
    assert "--leg right" in said
    assert main(["import", *log, "--leg", "right", "-o", str(tmp_path / "right.csv")]) == 0
