"""Replanning in mid-step: what is walked stays to the bit, the rest is verified or truly refused."""

import numpy as np
import pytest
from independent import clearance, path_of
from scipy.optimize import minimize

import ggo_factors as ggo

BASE = ggo.paper_base_gait()
HELD = 2  # frames that the search for any motion holds an acceleration for
FIRST = ggo.step_over(BASE, [ggo.Obstacle(0.20, 0.25, 0.08)], foothold=(0.39, 0.0))


def rates(frames):
    return np.diff(frames - BASE.frames, axis=0) / BASE.dt


@pytest.mark.parametrize("frame", [0, 1, 10, 25, 40])
def test_the_walked_frames_stay_and_the_rest_joins_without_a_jump(frame):
    again = ggo.replan(FIRST, frame, obstacles=[ggo.Obstacle(0.30, 0.33, 0.06)], foothold=(0.45, 0.0))
    assert again.ok
    frames = again.gait.frames
    np.testing.assert_array_equal(frames[: frame + 1], FIRST.gait.frames[: frame + 1])
    assert np.abs(frames[frame + 1 :] - FIRST.gait.frames[frame + 1 :]).max() > 1e-3
    assert clearance(frames, 0.30, 0.33, 0.06) > 0.0
    assert np.hypot(*(path_of(frames)[-1] - [0.45, 0.0])) < 1e-3
    jump = np.abs(rates(frames)[frame] - rates(FIRST.gait.frames)[max(frame - 1, 0)]).max()
    fastest = np.abs(np.diff(frames, axis=0)).max() / BASE.dt
    assert jump < 0.01 * fastest


def test_what_is_left_out_stays_as_it_was_asked_for():
    same = ggo.replan(FIRST, 12)
    assert same.task.step == FIRST.task.step
    np.testing.assert_allclose(same.gait.frames, FIRST.gait.frames, atol=1e-2)
    without = ggo.replan(FIRST, 12, obstacles=[])
    assert clearance(without.gait.frames, 0.20, 0.25, 0.08) < 0.0 < clearance(FIRST.gait.frames, 0.20, 0.25, 0.08)


def test_a_replan_can_be_replanned():
    once = ggo.replan(FIRST, 10, obstacles=[ggo.Obstacle(0.22, 0.27, 0.10)])
    twice = ggo.replan(once, 20, obstacles=[ggo.Obstacle(0.24, 0.29, 0.10)], foothold=(0.43, 0.0))
    np.testing.assert_array_equal(twice.gait.frames[:21], once.gait.frames[:21])
    assert twice.keyframes[0] == 20
    assert twice.ok


def test_a_step_of_a_walk_and_of_stairs_can_be_replanned():
    walk = ggo.climb_stairs(BASE, 0.10)
    again = ggo.replan(walk.steps[1], 15, limits=ggo.JointLimits(hip_acceleration=1e3, knee_acceleration=1e3))
    np.testing.assert_array_equal(again.gait.frames[:16], walk.steps[1].gait.frames[:16])
    assert again.report.ground_clearance > 0.0


def random_replans(count, seed):
    rng = np.random.default_rng(seed)
    for _ in range(count):
        x = rng.uniform(0.05, 0.28)
        box = (x, x + rng.uniform(0.02, 0.08), rng.uniform(0.03, 0.16))
        yield int(rng.integers(0, 49)), box, float(rng.uniform(0.36, 0.46))


@pytest.mark.parametrize(("count", "seed"), [(50, 11), pytest.param(400, 12, marks=pytest.mark.campaign)])
def test_random_replans_are_verified_or_truly_refused(count, seed):
    refused = []
    for frame, box, x in random_replans(count, seed):
        try:
            again = ggo.replan(FIRST, frame, obstacles=[ggo.Obstacle(*box)], foothold=(x, 0.0))
        except ggo.InfeasibleGaitError as error:
            refused.append((frame, box, x, str(error)))
            continue
        frames = again.gait.frames
        np.testing.assert_array_equal(frames[: frame + 1], FIRST.gait.frames[: frame + 1])
        assert clearance(frames, *box) > 0.0
        assert np.hypot(*(path_of(frames)[-1] - [x, 0.0])) < 1e-3
        late = frames[max(frame - 1, 0) :]
        limit = np.degrees(np.abs(np.diff(late, n=2, axis=0)).max(axis=0)) / BASE.dt**2
        assert (limit <= np.array([3000.0, 10000.0, 3000.0, 10000.0]) * 1.0011).all()
    # Most are refused since the foot is in the box's place or past it already; the others for want of time.
    assert 0 < len(refused) < 0.3 * count
    path = path_of(FIRST.gait.frames)
    late = [each for each in refused if each[0] <= 47 and path[each[0], 0] <= each[1][0]]
    for frame, _, _, message in refused:
        assert message.startswith(f"replan at frame {frame}: ")
    for frame, box, x, message in sorted(late)[-2:]:  # the fewer frames are left, the shorter the search
        assert not way_there(frame, box, x), (frame, box, x, message)


def way_there(frame, box, x):
    """Whether some motion from here clears the box and lands within the joints' limits, comfort not considered.

    SLSQP over free accelerations of the four joints, from several starts, least violation of the limits as its goal.
    """
    frames = FIRST.gait.frames
    count, dt = len(frames) - 1 - frame, BASE.dt
    limit = np.radians([3000.0, 10000.0, 3000.0, 10000.0]) * dt**2
    here, speed = frames[frame], frames[frame] - frames[frame - 1]

    def motion(shares):
        each = np.repeat(shares.reshape(*shares.shape[:-1], -1, 4), HELD, axis=-2)[..., :count, :]
        pushes = np.cumsum(np.cumsum(each * limit, axis=-2), axis=-2)
        return here + np.arange(1, count + 1)[:, None] * speed + pushes

    def spare(shares, over):
        moved = motion(shares)
        path, knees = path_of(moved), moved[..., [1, 3]]
        knees = knees.reshape(*knees.shape[:-2], -1)
        return np.concatenate([knees, path[..., over, 1] - box[2], path[..., :-1, 1]], axis=-1)

    def landing(shares):
        return (path_of(motion(shares)[..., -1, :]) - [x, 0.0]) / 0.1

    def slopes(of):
        """The Jacobian by differences, all shares in one go: SLSQP's own goes through them one by one."""

        def jacobian(shares, *given):
            return (of(shares + 1e-8 * np.eye(len(shares)), *given) - of(shares, *given)[None]).T / 1e-8

        return jacobian

    push = np.diff(np.vstack([frames[frame - 1], frames[frame:]]), n=2, axis=0) / limit
    for lifted in (np.zeros(4), np.array([0.0, 0.0, 0.5, 0.5]), np.array([-0.2, 0.0, 0.8, 0.0])):
        start = np.clip(push + lifted * np.where(np.arange(count) < count // 3, 1.0, -0.5)[:, None], -1, 1)[
            ::HELD
        ].ravel()
        for _ in range(2):
            ankle = path_of(motion(start))[:, 0]
            over = (ankle > box[0] - 0.03) & (ankle < box[1] + 0.03)
            found = minimize(
                lambda s: float((s**2).sum()) * 1e-3,
                start,
                jac=lambda s: 2e-3 * s,
                method="SLSQP",
                bounds=[(-1.0, 1.0)] * len(start),
                constraints=[
                    {"type": "eq", "fun": landing, "jac": slopes(landing)},
                    {"type": "ineq", "fun": spare, "jac": slopes(spare), "args": (over,)},
                ],
                options={"maxiter": 20},
            )
            start = found.x
            reached = np.vstack([here, motion(start)])
            if (
                np.abs(landing(start)).max() < 0.01
                and reached[:, [1, 3]].min() > -0.005
                and clearance(reached, *box) > 0
            ):
                return True
    return False


@pytest.mark.parametrize(
    ("frame", "arguments", "error", "message"),
    [
        (48, {}, ggo.InfeasibleGaitError, "replan at frame 48: too late, 2 frames are left and 3 are needed"),
        (51, {}, ggo.InputError, "at_frame: 51 must be at most 50"),
        (-1, {}, ggo.InputError, "at_frame: -1 must be at least 0"),
        (10, {"foothold": (2.0, 0.0)}, ggo.UnreachableFootholdError, "replan at frame 10: foothold"),
        (10, {"foothold": (0.3,)}, ggo.InputError, r"foothold: expected shape \(2,\)"),
        (10, {"obstacles": ["box"]}, ggo.InputError, "obstacles"),
        (10, {"limits": 3}, ggo.InputError, "limits: expected a JointLimits"),
        (
            40,
            {"obstacles": [ggo.Obstacle(0.2, 0.25, 0.12)]},
            ggo.InfeasibleGaitError,
            "too late, already walked: obstacle",
        ),
        (10, {"foothold": (0.4, 0.1)}, ggo.InfeasibleGaitError, "off the ground"),
    ],
)
def test_what_cannot_be_is_refused(frame, arguments, error, message):
    with pytest.raises(error, match=message):
        ggo.replan(FIRST, frame, **arguments)


def test_only_a_step_of_a_procedure_can_be_replanned():
    graph = ggo.GaitGraph(BASE)
    graph.anchor(BASE.frames[0])
    graph.end((0.39, 0.0), gain=100.0)
    with pytest.raises(ggo.InputError, match="solution: expected a StepSolution"):
        ggo.replan(graph.solve(), 10)
