"""Sweeps: grids, their one file with named axes, and the command."""

from __future__ import annotations

import json
import subprocess
import sys
from itertools import product

import numpy as np
import pytest
from made_gaits import ascent, pair
from many_rows import BASE, GRID, grid_rows

import ggo_factors as ggo
from ggo_factors.sweeps.grid import Grid
from ggo_factors.sweeps.netcdf import outcome, sweep


def load(path):
    import xarray  # not above: every worker process that reads this file would load it

    return xarray.load_dataset(path)


# -- grids -------------------------------------------------------------------------------------------------------------


def test_a_grid_has_every_combination_in_order():
    grid = Grid(obstacle_x=[0.1, 0.2], obstacle_height=0.05, stride=np.array([0.7, 0.8]), thigh=(0.4, 0.41, 0.42))
    assert grid.axes == {
        "obstacle_x": (0.1, 0.2),
        "obstacle_height": (0.05,),
        "stride": (0.7, 0.8),
        "thigh": (0.4, 0.41, 0.42),
    }
    assert (grid.shape, grid.size, grid.steps_a_row) == ((2, 1, 2, 3), 12, 1)
    for task, (x, stride, thigh) in zip(
        grid.tasks(BASE), product((0.1, 0.2), (0.7, 0.8), (0.4, 0.41, 0.42)), strict=True
    ):
        assert task.procedure == "step_over"
        assert task.arguments["obstacles"] == (ggo.Obstacle(x, x + 0.05, 0.05),)
        assert task.arguments["foothold"] == (stride / 2.0, 0.0)
        assert task.arguments["model"] == ggo.LegModel(thigh, 0.39)


def test_risers_go_up_and_down():
    up, down = Grid(riser=(0.1, -0.12), tread=0.35, steps=3).tasks(BASE)
    assert (up.procedure, up.arguments["riser"]) == ("climb_stairs", 0.1)
    assert (down.procedure, down.arguments["riser"]) == ("descend_stairs", 0.12)
    assert down.arguments["tread"] == 0.35
    assert down.arguments["steps"] == 3
    assert [task.arguments["stride"] for task in Grid(stride=(0.6, 0.7)).tasks(BASE)] == [0.6, 0.7]


def test_an_axis_may_be_an_iterator():
    assert Grid(stride=(value for value in (0.6, 0.7))) == Grid(stride=(0.6, 0.7))


@pytest.mark.parametrize(
    ("axes", "message"),
    [
        ({}, "grid: give at least one of"),
        ({"stride": []}, "stride: an axis needs at least one value"),
        ({"stride": [0.6, 0.7, 0.6]}, "stride: 0.6 m stands twice"),
        ({"stride": [0.6, np.nan]}, "stride: value nan"),
        ({"stride": "wide"}, "stride: expected numbers"),
        ({"stride": -0.6}, "stride: -0.6 m must be above 0 m"),
        ({"thigh": 39.0}, "thigh: 39 m must be at most 2 m"),
        ({"riser": [0.1, 0.0]}, "riser: 0 m is neither up nor down"),
        ({"riser": 0.1, "stride": 0.6}, "stride: does not go with riser"),
        ({"tread": 0.3}, "tread: stairs need a riser"),
        ({"obstacle_x": 0.1}, "obstacle_x: an obstacle needs"),
        ({"obstacle_x": 0.1, "obstacle_height": -0.1}, "obstacle_height: -0.1 m must be at least 0 m"),
        ({"obstacle_x": 0.1, "obstacle_height": 0.1, "steps": 2}, "steps: a step over an obstacle is one"),
        ({"stride": 0.6, "steps": 0}, "steps: 0 must be at least 1"),
        ({"stride": np.linspace(0.1, 1, 1001), "thigh": np.linspace(0.1, 1, 1000)}, "grid: 1001000 rows"),
    ],
)
def test_bad_grids_are_one_clear_error(axes, message):
    with pytest.raises(ggo.InputError, match=message):
        Grid(**axes)


# -- files -------------------------------------------------------------------------------------------------------------


class StoppedError(Exception):
    pass


def stop_at(part):
    def progress(now):
        if now >= part:
            raise StoppedError

    return progress


def test_results_in_one_file_with_named_axes(tmp_path):
    path = tmp_path / "out.nc"
    grid = Grid(obstacle_x=0.2, obstacle_height=(0.08, 0.6))
    found = sweep(grid, BASE, path, workers=1, keep_frames=True)
    assert [file.name for file in tmp_path.iterdir()] == ["out.nc"]
    assert load(path).identical(found)
    assert found.sizes == {"obstacle_x": 1, "obstacle_height": 2, "joint": 4, "step": 1, "frame": 21}
    good, bad = (found.sel(obstacle_x=0.2, obstacle_height=height) for height in (0.08, 0.6))
    solution = ggo.step_over(BASE, [ggo.Obstacle(0.2, 0.25, 0.08)])
    assert good.ok
    assert (good.iterations, good.clearance_mm) == (solution.iterations, solution.report.clearance * 1e3)
    np.testing.assert_array_equal(good.frames_deg[0], np.degrees(solution.gait.frames))
    assert not bad.ok
    assert (bad.error, "no gait found" in str(bad.reason.values)) == ("InfeasibleGaitError", True)
    assert np.isnan([bad.iterations, bad.knee_deg, *bad.frames_deg.values.ravel()]).all()
    counts = outcome(found)
    assert (counts["rows"], counts["ok"], counts["errors"]) == (2, 1, {"InfeasibleGaitError": 1})
    assert sum(counts["violations"].values()) >= 1


def test_base_gaits_and_a_style_are_those_of_every_row(tmp_path):
    (left, right), _ = pair(frames=21)
    base, path = ggo.BaseGaits(left, right, up=ascent()), tmp_path / "out.nc"
    waves = np.sin(np.linspace(0.0, 3.0, 51)[:, None, None] + np.arange(4)[:, None] + np.arange(3)) / 40.0
    style = ggo.Style(waves, 3e-6, 56, 1, 0.99, (5.9, 4.4), (0.68, 0.77))
    grid = Grid(riser=(-0.1, 0.15), tread=0.3, first_edge=0.2)
    with pytest.raises(StoppedError):
        sweep(grid, base, path, workers=1, style=style, keep_frames=True, progress=stop_at(0.0))
    for other, said in (({"style": None}, "style"), ({"base": ggo.BaseGaits(right, left, up=ascent())}, "base gait")):
        with pytest.raises(ggo.InputError, match=f"is of another sweep, {said} differs"):
            sweep(
                **{"grid": grid, "base": base, "path": path, "workers": 1, "style": style, "keep_frames": True, **other}
            )
    found = sweep(grid, base, path, workers=1, style=style, keep_frames=True).squeeze()
    longest = max(len(gait) for gait in base.gaits)
    assert found.sizes["frame"] == longest > min(len(gait) for gait in base.gaits)
    for riser, make in ((-0.1, ggo.descend_stairs), (0.15, ggo.climb_stairs)):
        row, made = found.sel(riser=riser), make(base, abs(riser), tread=0.3, first_edge=0.2, style=style)
        assert any(step.style is not None for step in made.steps)
        assert row.ok
        assert row.iterations == sum(step.iterations for step in made.steps)
        wanted = [np.degrees(gait.resampled(longest).frames) for gait in made.gaits]
        np.testing.assert_allclose(row.frames_deg, wanted, atol=1e-12)
    assert all(gait.name in found.attrs["base"] for gait in base.gaits)


def test_a_stopped_sweep_does_only_the_rest(tmp_path):
    path, partial = tmp_path / "out.nc", tmp_path / "out.nc.partial"
    with pytest.raises(StoppedError):
        sweep(GRID, BASE, path, workers=1, progress=stop_at(0.5))
    assert [file.name for file in tmp_path.iterdir()] == ["out.nc.partial"]
    lines = partial.read_bytes().splitlines(keepends=True)
    assert len(lines) == 1 + GRID.size // 2
    partial.write_bytes(b"".join(lines[:-1]) + lines[-1][:-20])  # and its last row was cut short
    seen = []
    found = sweep(GRID, BASE, path, workers=1, progress=seen.append)
    assert len(seen) == 1 + GRID.size - (len(lines) - 2)
    spent = found.milliseconds.values.ravel()
    assert [json.loads(line)["milliseconds"] for line in lines[1:-1]] == spent[: len(lines) - 2].tolist()
    assert found.clearance_mm.values.ravel().tolist() == [row.clearance * 1e3 for row in grid_rows()]
    assert [file.name for file in tmp_path.iterdir()] == ["out.nc"]


def test_a_killed_sweep_goes_on_and_leaves_no_process_behind(tmp_path):
    path, partial = tmp_path / "out.nc", tmp_path / "out.nc.partial"
    script = tmp_path / "script.py"
    script.write_text(
        "import sys\nimport ggo_factors as ggo\nfrom ggo_factors.sweeps.netcdf import Grid, sweep\n"
        "def hang(part):\n"
        "    if part > 0.0:\n"
        "        print('a row is written', flush=True)\n"
        "        sys.stdin.read()\n"
        "if __name__ == '__main__':\n"
        f"    sweep({GRID!r}, ggo.paper_base_gait({len(BASE)}), {str(path)!r}, workers=2, progress=hang)\n"
    )
    with subprocess.Popen([sys.executable, script], stdin=subprocess.PIPE, stdout=subprocess.PIPE) as process:
        assert process.stdout.readline() == b"a row is written\n"
        process.kill()
        # The workers hold the other end of this pipe: it closes when the last of them is gone.
        process.communicate(timeout=120)
    assert partial.read_bytes().count(b"\n") >= 2
    assert not path.exists()
    found = sweep(GRID, BASE, path, workers=1)
    assert found.clearance_mm.values.ravel().tolist() == [row.clearance * 1e3 for row in grid_rows()]


@pytest.mark.parametrize(
    ("other", "message"),
    [
        ({"grid": Grid(obstacle_x=(0.15, 0.20), obstacle_height=(0.04, 0.09))}, "obstacle_height, thigh differ"),
        ({"base": ggo.paper_base_gait(frames=22)}, "base gait, dt differ"),
        ({"model": ggo.LegModel(0.39, 0.4)}, "legs differs"),
        ({"keep_frames": True}, "keep_frames differs"),
    ],
)
def test_the_partial_file_of_another_sweep_is_refused(tmp_path, other, message):
    path = tmp_path / "out.nc"
    with pytest.raises(StoppedError):
        sweep(GRID, BASE, path, workers=1, progress=stop_at(0.0))
    before = (tmp_path / "out.nc.partial").read_bytes()
    with pytest.raises(ggo.InputError, match=f"is of another sweep, {message}"):
        sweep(**{"grid": GRID, "base": BASE, "path": path, "workers": 1, **other})
    assert (tmp_path / "out.nc.partial").read_bytes() == before


def test_bad_files_are_one_clear_error(tmp_path):
    path, partial = tmp_path / "out.nc", tmp_path / "out.nc.partial"
    for name, message in (("out.csv", "end in .nc"), ("no/out.nc", "cannot be written"), ("", "end in .nc")):
        with pytest.raises(ggo.InputError, match=message):
            sweep(GRID, BASE, tmp_path / name, workers=1)
    for content in (b"my notes", b"my notes\n", b"[1]\n"):
        partial.write_bytes(content)
        with pytest.raises(ggo.InputError, match="is no partial file of a sweep"):
            sweep(GRID, BASE, path, workers=1)
        assert partial.read_bytes() == content
    partial.unlink()
    with pytest.raises(StoppedError):
        sweep(GRID, BASE, path, workers=1, progress=stop_at(0.0))
    start = partial.read_bytes()
    for line in (b"{}\n", b'{"row": 99}\n', b"[]\n", b"\xff\n", b'{"row": 1, "ok": true}\n'):
        partial.write_bytes(start + line)
        with pytest.raises(ggo.InputError, match="line 2: is no row of this sweep"):
            sweep(GRID, BASE, path, workers=1)
    with pytest.raises(ggo.InputError, match=r"keep_frames: .* GB of frames"):
        sweep(
            Grid(stride=np.linspace(0.1, 1, 1000), thigh=np.linspace(0.3, 0.5, 1000), steps=4),
            BASE,
            path,
            keep_frames=True,
        )


def test_two_sweeps_do_not_write_one_file(tmp_path):
    path = tmp_path / "out.nc"

    def progress(part):
        with pytest.raises(ggo.InputError, match="another sweep is writing it"):
            sweep(GRID, BASE, path, workers=1)
        raise StoppedError

    with pytest.raises(StoppedError):
        sweep(GRID, BASE, path, workers=1, progress=progress)


# -- the command -------------------------------------------------------------------------------------------------------


def invoke(arguments):
    from click.testing import CliRunner

    from ggo_factors.cli.sweep import sweep as command

    return CliRunner().invoke(command, arguments)


def test_the_command_sweeps_and_says_what_became_of_the_rows(tmp_path):
    path = tmp_path / "out.nc"
    arguments = [
        "paper",
        "--frames",
        "21",
        "--stride",
        "0.6:0.7:3,9",
        "--steps",
        "1",
        "--workers",
        "1",
        "-o",
        str(path),
    ]
    done = invoke(arguments)
    assert (done.exit_code, done.stderr) == (0, "")
    assert (
        done.stdout == f"4 rows, 3 gaits\nrefused: UnreachableFootholdError 1\nlimits broken: reach 1\nwrote {path}\n"
    )
    assert load(path).stride.values.tolist() == [0.6, 0.65, 0.7, 9.0]
    done = invoke([*arguments, "--json"])
    assert json.loads(done.stdout) == {
        "format_version": 1,
        "rows": 4,
        "ok": 3,
        "errors": {"UnreachableFootholdError": 1},
        "violations": {"reach": 1},
        "output": str(path),
    }


def test_the_command_takes_base_gaits_and_a_style(tmp_path):
    (left, right), _ = pair(frames=21)
    base, up, style, path = (tmp_path / name for name in ("base.csv", "up.csv", "style.npz", "out.nc"))
    ggo.BaseGaits(left, right).save(base)
    ascent().save(up)
    waves = np.sin(np.linspace(0.0, 3.0, 51)[:, None, None] + np.arange(4)[:, None] + np.arange(3)) / 40.0
    ggo.Style(waves, 3e-6, 56, 1, 0.99, (5.9, 4.4), (0.68, 0.77)).save(style)
    stairs = ["--riser", "0.15", "--tread", "0.3", "--first-edge", "0.2", "--workers", "1", "-o", str(path)]
    done = invoke([str(base), "--up", str(up), "--style", str(style), *stairs])
    assert (done.exit_code, done.exception) == (0, None)
    given = ggo.BaseGaits(left, right, up=ascent())
    made = ggo.climb_stairs(given, 0.15, tread=0.3, first_edge=0.2, style=ggo.load_style(style))
    assert load(path).iterations.values.ravel().tolist() == [sum(step.iterations for step in made.steps)]


@pytest.mark.parametrize("values", ["wide", "0.1:0.2", "0.1:0.2:0", "0.1:0.2:2.5", "0.1,,0.2", ""])
def test_values_that_are_none_are_bad_input(tmp_path, values):
    done = invoke(["paper", "--stride", values, "-o", str(tmp_path / "out.nc")])
    assert done.exit_code == 2
    assert "is neither a number nor START:STOP:COUNT" in done.stderr


def test_importing_it_takes_no_xarray_and_no_dask_with_it():
    code = (
        "import sys, ggo_factors, ggo_factors.sweeps.tasks, ggo_factors.sweeps.netcdf, ggo_factors.cli.sweep; "
        "print([m for m in ('xarray', 'pandas', 'dask', 'distributed') if m in sys.modules])"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"
