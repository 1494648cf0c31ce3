"""A student's way: a motion-lab file (OpenSim .mot) in, a step over a box out.

Writes 03_recorded.mot, 03_steps.csv, 03_steps.mot, 03_from_opensim.png.
"""

import ggo_factors as ggo

# Put your own file here. So that this script runs anywhere, it first writes one: twelve level steps in OpenSim's names.
recorded = "03_recorded.mot"
ggo.export_trajectory(ggo.adjust_stride(ggo.paper_base_gait(), steps=12), recorded, rate=100)

summary = ggo.inspect_log(recorded)  # what the file holds; `ggo inspect FILE` shows it as a table
print(f"{summary.duration_s:.1f} s,", ", ".join(f"{joint.name}: {joint.looks_like or '-'}" for joint in summary.joints))

# Names in wide use have presets, so no joint map has to be written. The legs are yours to measure.
legs = ggo.LegModel(0.42, 0.43)  # [m]
report = ggo.import_base_gait(recorded, joints="opensim", model=legs)
base = report.gait
print(f"{sum(report.strides_used.values())} strides, {base.duration:.2f} s a step, stride {base.stride():.2f} m")

foothold = (base.stride() / 2, 0.0)  # half a stride ahead of the supporting ankle
box = ggo.Obstacle(x_start=0.20, x_end=0.28, height=0.10)
walk = ggo.walk(base, [ggo.Step(foothold), ggo.Step(foothold, (box,)), ggo.Step(foothold)])
walk.save("03_steps.csv")
ggo.export_trajectory(walk, "03_steps.mot")  # back to OpenSim

axes = ggo.plot.plot_joint_trajectory(walk)
axes[0].figure.savefig("03_from_opensim.png", dpi=110)
