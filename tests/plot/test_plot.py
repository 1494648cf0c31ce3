"""Pictures: that what is drawn is what was computed, on the axes that were given, and that nothing else is touched."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Iterator
from dataclasses import replace
from types import SimpleNamespace

import matplotlib as mpl
import numpy as np
import pytest

mpl.use("Agg")

from matplotlib import pyplot as plt
from matplotlib.colors import to_rgb

from ggo_factors import plot
from ggo_factors.errors import InputError
from ggo_factors.evaluate.likeness import METHODS, ComparedStep, Comparison
from ggo_factors.motion.gait import Gait, swap_roles
from ggo_factors.motion.leg_model import LegModel
from ggo_factors.motion.paper_gait import paper_base_gait
from ggo_factors.motion.terrain import Gap, Ground, Obstacle
from ggo_factors.walking.step import Step
from ggo_factors.walking.walk import Walk

BASE = paper_base_gait()


@pytest.fixture(autouse=True)
def close_figures() -> Iterator[None]:
    yield
    plt.close("all")


def varied() -> Gait:
    """The base gait with a sum of known steps added: 0.1 degrees a frame on alpha2."""
    offset = np.zeros((len(BASE), 4))
    offset[:, 2] = np.radians(0.1) * np.arange(len(BASE))
    return Gait(BASE.frames + offset, BASE.dt, model=BASE.model)


def two_steps(**plan: object) -> Walk:
    fade = np.linspace(1.0, 0.0, len(BASE))[:, None]
    second = Gait(BASE.frames + fade * (swap_roles(BASE.frames[-1]) - BASE.frames[0]), BASE.dt, model=BASE.model)
    return Walk((BASE, second), (Step(foothold=(0.39, 0.0)), Step(foothold=(0.39, 0.0), **plan)))


def lines(ax: plt.Axes, gid: str) -> list[np.ndarray]:
    return [line.get_xydata() for line in ax.lines if line.get_gid() == gid]


def patches(ax: plt.Axes, gid: str) -> list[tuple[float, float, float, float]]:
    return [(*p.get_xy(), p.get_width(), p.get_height()) for p in ax.patches if p.get_gid() == gid]


def legend_words(ax: plt.Axes) -> list[str]:
    return [text.get_text() for text in ax.get_legend().get_texts()]


def test_path_of_p_is_drawn_as_computed():
    ax = plot.plot_stick_figure(varied(), base=BASE, foothold=(0.39, 0.0))
    np.testing.assert_allclose(lines(ax, "swing ankle")[0], varied().endpoints())
    np.testing.assert_allclose(lines(ax, "base path")[0], BASE.endpoints())
    np.testing.assert_allclose(lines(ax, "foothold")[0], [[0.39, 0.0]])
    assert ax.get_aspect() == 1.0
    assert (ax.get_xlabel(), ax.get_ylabel()) == ("x [m]", "y [m]")
    assert legend_words(ax) == ["support leg", "swing leg", "swing ankle", "swing ankle, base gait", "foothold"]


def test_legs_are_drawn_at_the_frames_asked_for():
    ax = plot.plot_stick_figure(BASE, frames=[0, 25, 50])
    legs = [line for line in ax.lines if line.get_marker() == "o"]
    joints = BASE.model.joints(BASE.frames[[0, 25, 50]])
    for number, want in enumerate(joints):
        support, swing = legs[2 * number], legs[2 * number + 1]
        np.testing.assert_allclose(support.get_xydata(), want[:3])
        np.testing.assert_allclose(swing.get_xydata(), want[2:])
    # Both legs of the last frame in full colour, the earlier ones lighter.
    np.testing.assert_allclose(legs[-2].get_color(), to_rgb(plot.SUPPORT_COLOUR))
    np.testing.assert_allclose(legs[-1].get_color(), to_rgb(plot.SWING_COLOUR))
    assert sum(legs[0].get_color()) > sum(legs[2].get_color()) > sum(legs[4].get_color())
    for count in (1, 4, 7):
        drawn = plot.plot_stick_figure(BASE, frames=count)
        assert sum(line.get_marker() == "o" for line in drawn.lines) == 2 * count


def test_obstacle_and_gap_stand_where_they_are():
    ax = plot.plot_stick_figure(BASE, obstacles=[Obstacle(0.2, 0.25, 0.08)], gaps=[Gap(0.05, 0.15)])
    np.testing.assert_allclose(patches(ax, "obstacle"), [(0.2, 0.0, 0.05, 0.08)])
    ((x, y, width, height),) = patches(ax, "gap")
    np.testing.assert_allclose((x, width, y + height), (0.05, 0.1, 0.0))
    assert {"obstacle", "gap"} < set(legend_words(ax))


def test_ground_is_drawn_with_its_risers():
    ax = plot.plot_stick_figure(BASE, ground=Ground((0.29,), (0.0, 0.1)))
    (profile,) = lines(ax, "ground")
    np.testing.assert_allclose(profile[1:3], [[0.29, 0.0], [0.29, 0.1]])
    assert profile[0, 0] == ax.get_xlim()[0]
    assert profile[-1, 0] == ax.get_xlim()[1]


def test_a_walk_is_drawn_in_the_frame_of_its_first_step():
    walk = two_steps(obstacles=(Obstacle(0.1, 0.2, 0.05),), gaps=(Gap(0.25, 0.3),))
    ax = plot.plot_stick_figure(walk)
    first, second = lines(ax, "swing ankle")
    (_, origin) = walk.origins()
    np.testing.assert_allclose(first, walk.gaits[0].endpoints())
    np.testing.assert_allclose(second, walk.gaits[1].endpoints() + origin)
    # The foot that swings in the second step starts where it stood in the first.
    np.testing.assert_allclose(second[0], 0.0, atol=1e-9)
    np.testing.assert_allclose(patches(ax, "obstacle"), [(origin[0] + 0.1, origin[1], 0.1, 0.05)])
    np.testing.assert_allclose(patches(ax, "gap")[0][0], origin[0] + 0.25)
    np.testing.assert_allclose(lines(ax, "foothold"), [[[0.39, 0.0]], [np.add(origin, (0.39, 0.0))]])
    # Seven figures of the first step, six of the second: the swap frame is not drawn twice.
    assert sum(line.get_marker() == "o" for line in ax.lines) == 2 * 13


def test_stairs_of_a_walk_are_drawn_once_and_without_their_edge_obstacles():
    ground = Ground((0.29, 0.68), (0.0, 0.1, 0.2))
    edge = Obstacle(0.28, 0.30, 0.1)
    walk = Walk(
        (BASE, BASE), (Step((0.39, 0.1), (edge,), ground=ground), Step((0.39, 0.1), ground=ground.shifted(0.39, 0.1)))
    )
    ax = plot.plot_stick_figure(walk)
    (profile,) = lines(ax, "ground")
    assert (np.diff(profile[:, 0]) >= 0.0).all()
    # The base gait itself climbs nothing, so the second step's ground stands lower by 0.1 m.
    x, y = walk.origins()[1]
    assert [0.29, 0.0] in np.round(profile, 12).tolist()
    np.testing.assert_allclose(profile[-1, 1], 0.1 + y)
    assert np.isclose(profile[:, 0], 0.29 + x).any()
    assert patches(ax, "obstacle") == []
    assert "obstacle" not in legend_words(ax)


def test_a_model_may_be_given():
    bare = Gait(BASE.frames, BASE.dt)
    with pytest.raises(InputError, match="model: gait"):
        plot.plot_stick_figure(bare)
    model = LegModel(0.5, 0.45)
    ax = plot.plot_stick_figure(bare, model=model)
    np.testing.assert_allclose(lines(ax, "swing ankle")[0], model.endpoint(BASE.frames))


def test_joint_angles_are_in_degrees_over_percent():
    axes = plot.plot_joint_angles(varied(), BASE, label="varied")
    assert len(axes) == 4
    for number, ax in enumerate(axes):
        dashed, full = ax.lines
        np.testing.assert_allclose(full.get_ydata(), np.degrees(varied().frames[:, number]))
        np.testing.assert_allclose(dashed.get_ydata(), np.degrees(BASE.frames[:, number]))
        np.testing.assert_allclose(full.get_xdata(), np.linspace(0.0, 100.0, 51))
        assert (dashed.get_linestyle(), full.get_linestyle()) == ("--", "-")
    assert [axes[k].yaxis.label.get_visible() for k in range(4)] == [True, False, True, False]
    assert [axes[k].xaxis.label.get_visible() for k in range(4)] == [False, False, True, True]
    assert axes[2].get_xlabel() == "step [%]"
    assert axes[0].get_ylabel() == "angle [deg]"
    (legend,) = axes[0].figure.legends
    assert [text.get_text() for text in legend.get_texts()] == ["base gait", "varied"]


def test_a_second_gait_goes_on_the_same_panels():
    axes = plot.plot_joint_angles(varied(), BASE, label="one")
    again = plot.plot_joint_angles(BASE.resampled(26), label="two", colour=plot.PATH_COLOUR, axes=axes)
    assert again == axes
    assert [len(ax.lines) for ax in axes] == [3, 3, 3, 3]
    (legend,) = axes[0].figure.legends
    assert [text.get_text() for text in legend.get_texts()] == ["base gait", "one", "two"]
    grid = plt.subplots(2, 2)[1]
    assert plot.plot_joint_angles(BASE, axes=grid) == tuple(grid.flat)


def test_joint_angles_fit_in_one_axes():
    _, ax = plt.subplots()
    assert plot.plot_joint_angles(varied(), BASE, axes=ax) == (ax,)
    assert len(ax.lines) == 8
    assert len(set(legend_words(ax))) == 8
    assert (ax.get_xlabel(), ax.get_ylabel()) == ("step [%]", "angle [deg]")
    with pytest.raises(InputError, match="one or four, got 3"):
        plot.plot_joint_angles(BASE, axes=plt.subplots(1, 3)[1])


def test_residual_is_the_norm_of_what_each_frame_adds():
    ax = plot.plot_residual(varied(), BASE, label="varied")
    (line,) = ax.lines
    np.testing.assert_allclose(line.get_ydata(), 0.1)
    np.testing.assert_array_equal(line.get_xdata(), np.arange(1, 51))
    assert "[deg]" in ax.get_ylabel()
    assert plot.plot_residual(BASE, BASE, ax=ax) is ax
    assert len(ax.lines) == 2
    assert ax.get_ylim()[0] == 0.0
    assert 0.1 < ax.get_ylim()[1] < 0.2
    with pytest.raises(InputError, match="26 frames, the base gait 51"):
        plot.plot_residual(BASE.resampled(26), BASE)
    # A gait that equals its base is a flat line, not an error.
    assert plot.plot_residual(BASE, BASE).get_ylim()[1] > 0.0


def test_joint_trajectory_is_drawn_over_time():
    walk = two_steps()
    want = walk.joint_trajectory("left")
    axes = plot.plot_joint_trajectory(walk, first_swing="left")
    for ax, joint in zip(axes, ("right_hip", "right_knee", "left_hip", "left_knee"), strict=True):
        line, swap = ax.lines
        np.testing.assert_allclose(line.get_ydata(), np.degrees(getattr(want, joint)))
        np.testing.assert_allclose(swap.get_xdata(), walk.gaits[0].duration)
        np.testing.assert_allclose(line.get_xdata(), want.time)
        assert ax.get_title() == joint.replace("_", " ")
    (one,) = plot.plot_joint_trajectory(want, axes=plt.subplots()[1])
    assert legend_words(one) == ["right hip", "right knee", "left hip", "left knee"]
    # A walk says itself which leg swings first.
    left_first = replace(walk, first_swing="left")
    (axes, *_) = plot.plot_joint_trajectory(left_first)
    np.testing.assert_allclose(axes.lines[0].get_ydata(), np.degrees(want.right_hip))
    assert "left leg swings first" in axes.figure.get_suptitle()
    with pytest.raises(InputError, match="first_swing"):
        plot.plot_joint_trajectory(walk, first_swing="both")


def level_report() -> SimpleNamespace:
    """An import of two strides a leg used and one refused, the right leg 2 degrees over the left."""
    phase = np.linspace(0.0, 2.0 * np.pi, 101)
    curve = np.radians(np.stack([20.0 * np.cos(phase), 30.0 - 30.0 * np.cos(phase)], -1))
    strides = [
        SimpleNamespace(leg=leg, reason=reason, angles=curve + np.radians(offset + (2.0 if leg == "right" else 0.0)))
        for leg in ("right", "left")
        for offset, reason in ((-1.0, ""), (1.0, ""), (40.0, "an outlier"))
    ]
    mean = {"right": (curve + np.radians(2.0))[:-1], "left": curve[:-1]}
    return SimpleNamespace(
        source="a_log.mcap",
        activity="level",
        used=[stride for stride in strides if not stride.reason],
        refused=[stride for stride in strides if stride.reason],
        mean_cycle=mean,
        spread={leg: np.full_like(row, np.radians(1.0)) for leg, row in mean.items()},
        strides_used={"right": 2, "left": 2},
    )


def test_import_shows_every_stride_and_their_mean():
    report = level_report()
    axes = plot.plot_import(report)
    assert [ax.get_title() for ax in axes] == ["right thigh", "right knee", "left thigh", "left knee"]
    for number, ax in enumerate(axes):
        leg, column = ("right", "left")[number // 2], number % 2
        (mean,) = lines(ax, "mean")
        np.testing.assert_allclose(mean[:-1, 1], np.degrees(report.mean_cycle[leg][:, column]))
        np.testing.assert_allclose(mean[-1], [100.0, mean[0, 1]])
        used = [stride for stride in report.used if stride.leg == leg]
        assert len(lines(ax, "stride")) == len(used) == 2
        for drawn, stride in zip(lines(ax, "stride"), used, strict=True):
            np.testing.assert_allclose(drawn[:, 1], np.degrees(stride.angles[:, column]))
        assert len(lines(ax, "refused")) == 1
        (band,) = ax.collections
        top, bottom = band.get_paths()[0].vertices[:, 1].max(), band.get_paths()[0].vertices[:, 1].min()
        np.testing.assert_allclose((top, bottom), (mean[:, 1].max() + 1.0, mean[:, 1].min() - 1.0))
    (legend,) = axes[0].figure.legends
    words = [text.get_text() for text in legend.get_texts()]
    kinds = {"one stride", "2 refused", "\u00b1 1 standard deviation"}
    assert set(words) == {"right mean, 2 used", "left mean, 2 used", *kinds}
    assert axes[0].figure.get_suptitle() == "Base gait from a_log.mcap\nlevel walk, 4 strides used, 2 refused"
    with pytest.raises(InputError, match="expected four, got 1"):
        plot.plot_import(report, axes=plt.subplots()[1])


def test_import_of_stairs_shows_the_swings_of_whichever_leg_there_is():
    swing = SimpleNamespace(leg="left", reason="", frames=BASE.frames)
    report = SimpleNamespace(
        source="a_log.mcap",
        activity="stairs-up",
        used=[swing],
        refused=[],
        mean_cycle={"left": BASE.frames},
        spread={"left": np.zeros((51, 4))},
        strides_used={"right": 0, "left": 1},
    )
    axes = plot.plot_import(report)
    for number, ax in enumerate(axes):
        (mean,) = lines(ax, "mean")
        np.testing.assert_allclose(mean[:, 1], np.degrees(BASE.frames[:, number]))
        np.testing.assert_allclose(mean[:, 0], np.linspace(0.0, 100.0, 51))
    assert axes[2].get_xlabel() == "step [%]"
    (legend,) = axes[0].figure.legends
    assert legend.get_texts()[0].get_text() == "left mean, 1 used"


def test_given_axes_are_used_and_no_figure_is_made():
    figure, grid = plt.subplots(1, 2)
    assert plot.plot_stick_figure(BASE, ax=grid[0]) is grid[0]
    assert plot.plot_residual(varied(), BASE, ax=grid[1]) is grid[1]
    assert plt.get_fignums() == [figure.number]
    assert tuple(figure.get_size_inches()) == tuple(mpl.rcParams["figure.figsize"])


def test_legends_lie_outside_the_data():
    figure, grid = plt.subplots(1, 2, figsize=(12, 4), layout="constrained")
    plot.plot_stick_figure(BASE, obstacles=[Obstacle(0.2, 0.25, 0.08)], base=BASE, ax=grid[0])
    plot.plot_residual(varied(), BASE, ax=grid[1])
    figure.canvas.draw()
    for ax in grid:
        assert ax.get_legend().get_window_extent().y0 >= ax.get_window_extent().y1 - 1.0
        assert ax.get_legend().get_window_extent().y1 <= figure.bbox.y1 + 1.0


def test_what_cannot_be_drawn_is_named():
    with pytest.raises(InputError, match="frames: 51 is not among the frames 0 to 50"):
        plot.plot_stick_figure(BASE, frames=[0, 51])
    with pytest.raises(InputError, match="frames: 0 must be at least 1"):
        plot.plot_stick_figure(BASE, frames=0)
    with pytest.raises(InputError, match="a walk has its own"):
        plot.plot_stick_figure(two_steps(), gaps=[Gap(0.1, 0.2)])
    with pytest.raises(InputError, match="expected a Gait"):
        plot.plot_stick_figure("gait.csv")
    assert plt.get_fignums() == []


def test_importing_chooses_no_backend():
    code = (
        "import sys, ggo_factors.plot; "
        "assert 'matplotlib.pyplot' not in sys.modules; "
        "import matplotlib; assert matplotlib.rcParams._get('backend') is matplotlib.rcsetup._auto_backend_sentinel"
    )
    result = subprocess.run([sys.executable, "-W", "error", "-c", code], capture_output=True, text=True, check=False,
                            env={"PYTHONPATH": ":".join(sys.path)})  # fmt: skip
    assert result.returncode == 0, result.stderr


def compared(*refused: str) -> Comparison:
    """One step, each method off by as many degrees as its place in the order, growing from frame to frame."""
    share = np.linspace(0.0, 1.0, len(BASE))[:, None] * np.radians([1.0, 2.0, 3.0, 4.0])
    made = {method: BASE.frames + number * share for number, method in enumerate(METHODS) if method not in refused}
    reasons = dict.fromkeys(refused, "no")
    step = ComparedStep("left", 0.0, 0.5, (0.4, 0.0), BASE.frames, made, reasons)
    return Comparison("base", "a log", "level", (step,), 0, 0, 0.0, BASE.legs())


def test_a_comparison_has_a_curve_for_each_method_in_each_panel():
    panels = plot.plot_comparison(compared())
    assert len(panels) == 4
    for joint, ax in enumerate(panels, start=1):
        curves = {line.get_gid(): line.get_ydata() for line in ax.lines}
        assert tuple(curves) == METHODS
        for number, method in enumerate(METHODS):
            assert curves[method][-1] == pytest.approx(number * joint)
    again = plot.plot_comparison(compared(), axes=plt.subplots(2, 2)[1].ravel())
    assert again[0].get_figure() is not panels[0].get_figure()


def test_a_comparison_of_nothing_or_on_other_axes_is_refused():
    with pytest.raises(InputError, match="no step"):
        plot.plot_comparison(compared("ggo"))
    with pytest.raises(InputError, match="expected four, got 1"):
        plot.plot_comparison(compared(), axes=[plt.subplots()[1]])
    with pytest.raises(InputError, match="comparison: expected a Comparison"):
        plot.plot_comparison(BASE)


def test_ground_that_nobody_saw_is_drawn_as_far_as_the_picture_reaches():
    walk = two_steps(gaps=(Gap(0.41, 100.0, unknown=True),))
    ax = plot.plot_stick_figure(walk)
    left, right = ax.get_xlim()
    assert right < 1.0
    (unseen,) = patches(ax, "unseen")
    assert unseen[0] == pytest.approx(walk.origins()[1, 0] + 0.41)
    assert unseen[0] + unseen[2] == pytest.approx(right)
    assert "ground nobody saw" in legend_words(ax)
    assert not patches(ax, "gap")
    far = plot.plot_stick_figure(two_steps(gaps=(Gap(2.0, 100.0, unknown=True),)))
    assert far.get_xlim() == (left, right)
    assert not patches(far, "unseen")
