"""Lifting the path in rounds: what one round got wrong the next one must mend."""

import pytest
from independent import clearance, path_of, stair_clearance

import ggo_factors as ggo


def test_a_frame_that_moved_over_a_higher_tread_is_lifted_again():
    """The first lift draws frames forward, over the riser, where their edges are too low."""
    base, edges, heights = ggo.paper_base_gait(26), (0.059,), (0.0, 0.153)
    graph = ggo.GaitGraph(base, smoothness=100.0)
    graph.anchor(base.frames[0])
    graph.end((0.117, 0.153), gain=5.0 * 26)
    graph.add_ground(ggo.Ground(edges, heights), hold=0.3, gamma=4.0, margin=0.03)
    solution = graph.solve()
    assert solution.converged, solution.reason
    assert "ground" not in [fault.kind for fault in solution.violations]
    assert stair_clearance(solution.gait.frames, edges, heights) > 0.005


@pytest.mark.parametrize("frame", [187, 188, 192])
def test_a_dip_between_the_frames_that_stand_for_their_neighbours_is_lifted(frame):
    """At 501 frames an edge over a box stands for five; a base gait that dips in one frame between them needs its own.

    The frames with an edge are 185, 190 and 195 here.
    """
    even = ggo.paper_base_gait(501)
    frames = even.frames.copy()
    below = path_of(frames)[frame] - [0.0, 0.04]
    frames[frame, 2:] = even.legs().inverse_kinematics(below, frames[frame, :2])
    graph = ggo.GaitGraph(ggo.Gait(frames, even.dt, model=even.model))
    graph.anchor(frames[0])
    graph.end((0.39, 0.0), gain=5.0 * 501)
    graph.add_obstacle(ggo.Obstacle(-0.25, -0.10, 0.20), hold=1.0)
    solution = graph.solve()
    assert len(solution.keyframes) < 100
    x, y = path_of(solution.gait.frames)[frame]
    assert -0.25 < x < -0.10
    assert y > 0.20
    assert clearance(solution.gait.frames, -0.25, -0.10, 0.20) > 0.0
    # The base gait itself dips as fast as no joint turns.
    assert {fault.kind for fault in solution.violations} <= {"knee turns", "hip turns", "knee spike", "hip spike"}
