"""Users' own factors before they are taken in: raw ones that would kill the interpreter, Jacobians that are wrong."""

import os
import signal
import time

import gtsam
import numpy as np
import pytest

import ggo_factors as ggo
from ggo_factors.factors import child, fit, frame_key

BASE = ggo.paper_base_gait()
KEY = frame_key(25)
NOISE = gtsam.noiseModel.Isotropic.Precision(4, 10.0)


def raw(jacobian, keys=(KEY,)):
    """A raw custom factor, `jacobian(frame, blocks)` of which writes the Jacobians."""

    def function(this, values, blocks):
        frame = values.atVector(KEY)
        if blocks is not None:
            jacobian(frame, blocks)
        return frame

    return gtsam.CustomFactor(NOISE, list(keys), function)


def added(factor):
    graph = ggo.GaitGraph(BASE)
    graph.anchor(BASE.frames[0])
    graph.end((0.39, 0.0))
    graph.add_factor(factor)
    return graph


def write(block):
    def jacobian(frame, blocks):
        blocks[0] = block

    return jacobian


def die(how):
    return lambda frame, blocks: os.kill(os.getpid(), how)


def unset_in_a_branch(frame, blocks):
    if frame[0] < BASE.frames[25, 0] + 0.05:
        blocks[0] = np.eye(4)


@pytest.mark.parametrize("looked_at", [added, lambda factor: ggo.check_jacobian(factor, at_base())])
@pytest.mark.parametrize(
    ("jacobian", "message"),
    [
        (die(signal.SIGSEGV), r"kills the interpreter \(SIGSEGV\); ggo.checked_factor says"),
        (die(signal.SIGABRT), r"kills the interpreter \(SIGABRT\)"),
        (lambda frame, blocks: os._exit(3), r"kills the interpreter \(exit code 3\)"),
        (lambda frame, blocks: exec("raise SystemExit(3)"), "SystemExit: 3"),
        # As the memory happens to lie these are a segmentation fault or an error of GTSAM's.
        (lambda frame, blocks: None, "factor: (kills|.*Jacobian)"),
        (write(np.eye(4)[:2]), "factor: (kills|.*Jacobian)"),
        (write(np.ones((6, 4))), "factor: (kills|.*Jacobian)"),
        (write(np.ones(3)), "factor: (kills|.*Jacobian)"),
        (lambda frame, blocks: blocks.append(np.eye(4)), "factor: (kills|.*Jacobian)"),
        (write(np.ones(4)), "1 columns"),
        (write(np.eye(4)[:, :3]), "3 columns"),
    ],
)
def test_a_raw_factor_that_kills_is_refused_and_kills_nothing(jacobian, message, looked_at):
    with pytest.raises(ggo.InputError, match=message):
        looked_at(raw(jacobian))


def at_base():
    values = gtsam.Values()
    values.insert(KEY, BASE.frames[25])
    return values


def test_the_other_branch_is_looked_at_too():
    with pytest.raises(ggo.InputError, match=r"factor: (kills|.*Jacobian)"):
        added(raw(unset_in_a_branch))


def test_a_raw_factor_in_order_is_solved_and_looked_at_once(monkeypatch):
    looks = []
    monkeypatch.setattr(fit, "answer_of_child", lambda work: looks.append(1) or child.answer_of_child(work))
    factor = raw(write(np.eye(4)))
    assert added(factor).solve().converged
    added(factor)
    assert ggo.check_jacobian(factor, at_base()) < 1e-8
    assert len(looks) == 1
    ours = ggo.checked_factor("mine", [25], 4, lambda frame, want: (frame, (np.eye(4),)), NOISE)
    added(ours)
    added(gtsam.PriorFactorVector(KEY, np.zeros(4), NOISE))
    assert len(looks) == 1, "only raw factors are looked at"


def test_a_child_that_hangs_is_given_up(monkeypatch):
    monkeypatch.setattr(child, "SECONDS", 0.2)
    here = os.getpid()

    def hang_in_the_child(frame, blocks):
        blocks[0] = np.eye(4)
        if os.getpid() != here:
            time.sleep(30.0)

    began = time.perf_counter()
    with pytest.warns(UserWarning, match="could not be tried in a child process"):
        added(raw(hang_in_the_child))
    assert time.perf_counter() - began < 10.0


def test_a_system_without_fork_is_told(monkeypatch):
    monkeypatch.delattr(os, "fork")
    with pytest.warns(UserWarning, match="could not be tried in a child process"):
        added(raw(write(np.eye(4))))


def test_answers_of_a_child():
    assert child.answer_of_child(lambda: "fine") == "fine"
    assert child.answer_of_child(lambda: "long" * 10_000) == ("long" * 10_000)[: child.MOST_BYTES]
    assert child.answer_of_child(lambda: 1 // 0) == "ZeroDivisionError: integer division or modulo by zero"


def test_a_raw_factor_that_is_not_finite_is_refused():
    nan = gtsam.CustomFactor(NOISE, [KEY], lambda this, values, blocks: np.full(4, np.nan))
    with pytest.raises(ggo.InputError, match="factor: "):
        added(nan)
    with pytest.raises(ggo.InputError, match="not finite on the base gait"):
        added(gtsam.PriorFactorVector(KEY, np.full(4, np.nan), NOISE))


@pytest.mark.parametrize(("place", "row", "key", "column"), [((2, 3), 2, "g24", 3), ((1, 5), 1, "g25", 1)])
def test_check_jacobian_names_the_wrong_entry(place, row, key, column):
    wrong = np.hstack([-np.eye(4), np.eye(4)])
    wrong[place] += 0.5

    def motion(first, second, want):
        return second - first, (wrong[:, :4], wrong[:, 4:])

    factor = ggo.checked_factor("motion", [24, 25], 4, motion, NOISE)
    values = gtsam.Values()
    values.insert(frame_key(24), BASE.frames[24])
    values.insert(KEY, BASE.frames[25])
    found = ggo.check_jacobian(factor, values)
    assert found == pytest.approx(0.5)
    assert (found.row, found.key, found.column) == (row, key, column)
    right = wrong[place] - 0.5
    assert (found.analytic, found.numeric) == (pytest.approx(right + 0.5), pytest.approx(right, abs=1e-6))
    assert repr(found) == (
        f"0.5 at row {row}, column {column} of {key}: Jacobian {right + 0.5:.6g}, finite difference {found.numeric:.6g}"
    )


def test_a_jacobian_that_is_not_a_number_is_not_below_any_tolerance():
    assert not ggo.check_jacobian(raw(write(np.full((4, 4), np.nan))), at_base()) < 1e-6
