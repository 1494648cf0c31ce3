"""From a walking log to gaits that nobody walked.

Writes 02_base.csv, 02_walk.mcap, 02_from_a_log.png.
"""

import ggo_factors as ggo

# The joint map says which logged values make thigh and knee angles; see the page "Your own recording".
report = ggo.import_base_gait(ggo.datasets.children_walk(), joints=ggo.datasets.children_walk_joints())
print(report.text())  # strides used and refused, stride time, spread, what was decided
base = report.gait
base.save("02_base.csv")

longer = ggo.adjust_stride(base, stride=1.1 * base.stride(), steps=2)
boxes = [None, ggo.Obstacle(0.16, 0.21, 0.10), None]  # one box, in the second of three steps
walk = ggo.walk(base, [ggo.Step((0.39, 0.0), () if box is None else (box,)) for box in boxes])
for name, made in {"longer strides": longer, "over a box": walk}.items():
    change = max(abs(gait.frames - base.frames).mean() for gait in made.gaits)
    print(f"{name}: {len(made.steps)} steps in {made.times[-1]:.2f} s, joints changed by {57.3 * change:.1f} degrees")

ggo.export_mcap(walk, "02_walk.mcap")  # opens in Foxglove or plays in ROS 2
axes = ggo.plot.plot_import(report)
axes[0].figure.savefig("02_from_a_log.png", dpi=110)
