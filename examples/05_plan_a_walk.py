"""Ground as a camera measured it: footholds are chosen, the walk over them is made and checked.

Writes 05_ground.toml, 05_walk.csv, 05_plan_a_walk.png.
"""

import matplotlib.pyplot as plt

import ggo_factors as ggo

base = ggo.paper_base_gait()

# Level ground, two stairs up, level ground: x in the world frame, in [m]. Edges and height of the box to 10 mm each.
ground = ggo.Terrain.level(1.3) + ggo.Terrain.stairs(2, riser=0.12, tread=0.32) + ggo.Terrain.level(1.0)
box = ggo.Obstacle(0.50, 0.56, 0.06, edge_std=0.01, height_std=0.01)
ground = ground.with_boxes(box).with_pits(ggo.Gap(0.85, 1.02))
ground.save("05_ground.toml")

# Steps keep clear of a larger box: the true one sticks out of it with a probability of at most 0.001.
larger = ggo.cautious(box)
print(f"keeps clear of {larger.x_start:.3f} to {larger.x_end:.3f} m, {larger.height:.3f} m high")

plan = ggo.plan_walk(base, ground, goal=2.5, start=ggo.STANDING, to_standing=True)
print("lands at", [round(x, 3) for x in plan.footholds], "m")
for number, step in enumerate(plan.walk.steps, start=1):
    print(f"step {number}: probability of a hit {step.report.hit_probability:.0e}", *step.report.notes)

plan.walk.save("05_walk.csv")
figure, ax = plt.subplots(figsize=(11, 5), layout="constrained")
ggo.plot.plot_stick_figure(plan.walk, ax=ax)
figure.savefig("05_plan_a_walk.png", dpi=100)
