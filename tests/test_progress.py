"""`progress=`, wherever something takes long: a function of the share that is done, or an error before anything is."""

import inspect

import pytest

import ggo_factors as ggo
from ggo_factors.recording.learning import learn_from_logs

BASE = ggo.paper_base_gait()
LOG, JOINTS = ggo.datasets.children_walk(), ggo.datasets.children_walk_joints()
CALLS = {
    "compare": lambda path, **asked: ggo.compare(BASE, LOG, joints=JOINTS, **asked),
    "convert_log": lambda path, **asked: ggo.convert_log(LOG, path / "out.mcap", **asked),
    "generate_many": lambda path, **asked: ggo.generate_many([ggo.Task("adjust_stride")], BASE, workers=1, **asked),
    "import_base_gait": lambda path, **asked: ggo.import_base_gait(LOG, joints=JOINTS, **asked),
    "inspect_log": lambda path, **asked: ggo.inspect_log(LOG, **asked),
    "learn_from_logs": lambda path, **asked: learn_from_logs([LOG], joints=JOINTS, **asked),
    "plan_walk": lambda path, **asked: ggo.plan_walk(BASE, ggo.Terrain.level(2.0), goal=0.8, **asked),
    "sweep": lambda path, **asked: ggo.sweep(ggo.Grid(stride=[0.7]), BASE, path / "out.nc", workers=1, **asked),
}


def test_every_public_function_with_a_progress_is_called_here():
    public = {name: getattr(ggo, name) for name in ggo.__all__}
    takes = [name for name, what in public.items() if inspect.isfunction(what)]
    assert {name for name in takes if "progress" in inspect.signature(public[name]).parameters} == set(CALLS) - {
        "learn_from_logs"
    }


@pytest.mark.parametrize("call", CALLS)
@pytest.mark.parametrize("wrong", ["yes", True, 1])
def test_what_cannot_be_called_is_refused_before_anything_is_done(call, wrong, tmp_path):
    with pytest.raises(ggo.InputError, match=f"progress: expected a function of the share that is done, got {wrong!r}"):
        CALLS[call](tmp_path, progress=wrong)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("call", ["plan_walk", "inspect_log", "generate_many"])
def test_a_function_is_told_shares_that_grow_to_1(call, tmp_path):
    shares = []
    CALLS[call](tmp_path, progress=shares.append)
    assert shares == sorted(shares)
    assert shares[-1] == pytest.approx(1.0)
