"""A box that a depth camera measured: how probable is a hit?

Writes 05_uncertain_box.png.
"""

import ggo_factors as ggo

base = ggo.paper_base_gait()
seen = ggo.Obstacle(0.20, 0.25, 0.06, edge_std=0.01, height_std=0.01)  # [m]: edges and height to 10 mm each

# The procedures make the box larger, until the true one sticks out with a probability of at most 0.001.
larger = ggo.cautious(seen)
print(f"stepped over: {larger.x_start:.3f} to {larger.x_end:.3f} m, {larger.height:.3f} m high")

careful = ggo.step_over(base, [seen], foothold=(0.39, 0.0))
bold = ggo.step_over(base, [ggo.Obstacle(0.20, 0.25, 0.06)], foothold=(0.39, 0.0))
for name, step in {"careful": careful, "bold": bold}.items():
    hit = ggo.hit_probability(seen, step.gait.endpoints())  # of the box as it was measured
    print(f"{name}: clearance {1e3 * step.report.clearance:.0f} mm, probability of a hit {hit:.1e}")

# How far each joint could as well be elsewhere: the marginals of the factor graph.
spread = ggo.joint_spread(careful, step_std=0.035)  # [rad], (frames, 4)
print(f"largest spread of a joint: {57.3 * spread.max():.1f} degrees")
axes = ggo.plot.plot_spread(careful, base, step_std=0.035)
axes[0].figure.savefig("05_uncertain_box.png", dpi=110)
