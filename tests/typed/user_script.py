"""What users write, with lists and arrays where they have them: mypy and pyright find nothing wrong with it.

Kept as a script of its own, since a type checker reads it and the tests run it; see `tests/test_typing.py`.
"""

from __future__ import annotations

import numpy as np

import ggo_factors as ggo

base = ggo.paper_base_gait()
rough = ggo.Gait([[0.0, 0.1, 0.0, 0.1], [0.1, 0.2, -0.1, 0.2]], 0.5, notes=["made by hand"])
level = ggo.BaseGaits(base, base)

# Places in the plane: a list, a tuple, an array, a row of one.
places = np.array([[0.4, 0.0], [0.45, 0.0]])
boxes = [ggo.Obstacle(0.2, 0.25, 0.05)]
one: ggo.StepSolution = ggo.step_over(base, boxes, foothold=[0.45, 0.0])
two = ggo.step_over(level, tuple(boxes), foothold=places[1], start=list(base.frames[0]))
three = ggo.replan(two, at_frame=10, foothold=[0.44, 0.0], obstacles=boxes)
walk: ggo.Walk = ggo.walk(base, [ggo.Step([0.4, 0.0], boxes), ggo.Step(places[1]), ggo.Step((0.4, 0.0), gaps=[])])
stand = ggo.Step(end_frame=ggo.STANDING)
up = ggo.climb_stairs(base, [0.1, 0.12], tread=0.35)
again = ggo.Walk(list(walk.gaits), list(walk.plan), notes=["put together by hand"])
first: tuple[float, float] | None = again.plan[0].foothold

ground = ggo.Ground([0.3], [0.0, 0.1], [0.0, 0.0])
stairs = ggo.stair_ground(0.3, 0.3, np.array([0.1, 0.1]))
edges: tuple[float, ...] = ground.edges
report = ggo.verify(base, obstacles=boxes, gaps=[ggo.Gap(0.9, 1.0)], foothold=places[0], ground=ground)
seen = ggo.verify_step(base, ggo.Step(places[0], boxes), start=base.frames[0])

graph = ggo.GaitGraph(base, keyframes=[10, 20])
graph.anchor(list(base.frames[0]))
graph.end([0.45, 0.0])
graph.land(places[1])
graph.balance(1.0, support=[-0.1, 0.1])
solution: ggo.Solution = graph.solve(initial=base.frames.tolist())

tasks = [ggo.Task("step_over", {"obstacles": boxes, "foothold": [0.4, 0.0]})]
grid = ggo.Grid(stride=[0.8, 0.9], steps=1)
terms = {angle: {angle: 1.0} for angle in ("alpha_left", "beta_left", "alpha_right", "beta_right")}
joints = ggo.JointMap(terms, notes=["made by hand"], order=list(terms)[::-1])
trajectory = walk.joint_trajectory(rate=100.0)

axes = ggo.plot.plot_joint_angles(one, base)
ax = ggo.plot.plot_stick_figure(one, obstacles=boxes, foothold=(0.45, 0.0), frames=[0, 25, 50])
log = str(ggo.datasets.children_walk())
for made in (rough, one, two, three, walk, up, stand, again, first, edges, stairs, report, seen, solution, tasks, grid):
    print(made)
print(joints.order[0], trajectory.time[-1], len(axes), ax.get_xlabel(), log)
