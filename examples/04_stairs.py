"""Stairs: up from standing, down within joint limits.

Writes 04_up.mcap, 04_down.csv, 04_stairs.png.
"""

import matplotlib.pyplot as plt

import ggo_factors as ggo

base = ggo.paper_base_gait()

# Uneven risers, a start and an end with both feet together.
up = ggo.climb_stairs(base, [0.10, 0.14, 0.12], tread=0.30, first_edge=0.20, start=ggo.STANDING, to_standing=True)

# Down, the foot would land too fast at the base gait's pace. Within limits the same path is walked slower.
down = ggo.descend_stairs(base, 0.15, tread=0.29, first_edge=0.20, steps=4, limits=ggo.JointLimits())

for name, walk in {"up": up, "down": down}.items():
    landing = max(step.report.landing_speed for step in walk.steps)
    print(f"{name}: {len(walk.steps)} steps in {walk.times[-1]:.2f} s; the foot lands at {landing:.2f} m/s at most")

ggo.export_mcap(up, "04_up.mcap")
down.save("04_down.csv")  # with its limits and a checksum; `ggo verify 04_down.csv` checks it again

figure, panels = plt.subplots(1, 2, figsize=(12, 5), layout="constrained")
for ax, walk in zip(panels, (up, down), strict=True):
    ggo.plot.plot_stick_figure(walk, ax=ax)
figure.savefig("04_stairs.png", dpi=100)
