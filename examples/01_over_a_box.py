"""One step over a box: the smallest thing the library does.

Writes 01_over_a_box.csv, 01_over_a_box.png.
"""

import ggo_factors as ggo

base = ggo.paper_base_gait()  # one healthy step, 51 frames, legs of 0.39 m + 0.39 m
box = ggo.Obstacle(x_start=0.20, x_end=0.25, height=0.08)  # [m], ahead of the supporting ankle

# The step that is least unlike the base gait, lands on the foothold and does not touch the box.
step = ggo.step_over(base, [box], foothold=(0.39, 0.0))

report = step.report  # what the dense check measured
print(f"clearance over the box: {1e3 * report.clearance:.1f} mm")
print(f"landing: {1e3 * report.foothold_error:.2f} mm off the foothold, {report.landing_speed:.2f} m/s downwards")

# The check refuses what cannot be done, and says why in numbers.
try:
    ggo.step_over(base, [ggo.Obstacle(0.20, 0.25, 0.60)], foothold=(0.39, 0.0))
except ggo.InfeasibleGaitError as error:
    print("a box of 0.60 m is refused:", str(error)[:80], "...")

step.gait.save("01_over_a_box.csv")
axes = ggo.plot.plot_stick_figure(step, obstacles=[box], base=base)
axes.figure.savefig("01_over_a_box.png", dpi=110)
