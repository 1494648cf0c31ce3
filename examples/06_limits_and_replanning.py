"""Within what a machine can do, and changed in mid-step.

Writes 06_limits_and_replanning.png.
"""

import matplotlib.pyplot as plt

import ggo_factors as ggo

base, foothold = ggo.paper_base_gait(), (0.39, 0.0)
box = ggo.Obstacle(0.20, 0.25, 0.08)
machine = ggo.JointLimits(hip_speed=2.5, knee_speed=5.0)  # [rad/s]; angles and accelerations have defaults

fast = ggo.step_over(base, [box], foothold=foothold)
slow = ggo.step_over(base, [box], foothold=foothold, limits=machine)
print(f"{fast.gait.duration:.2f} s without limits, {slow.gait.duration:.2f} s within them")

# In mid-step the camera sees the box further ahead. What is walked stays to the bit; the rest goes on as it moves.
moved = ggo.Obstacle(0.24, 0.29, 0.08)
again = ggo.replan(slow, at_frame=20, obstacles=[moved], foothold=(0.42, 0.0), deadline=2.0)  # [s], by default 0.3
assert (again.gait.frames[:21] == slow.gait.frames[:21]).all()
print(f"replanned: clearance {1e3 * again.report.clearance:.0f} mm, lands at {again.gait.endpoints()[-1, 0]:.3f} m")

played = ggo.joint_trajectory([slow.gait], rate=500)  # positions, velocities, accelerations for a controller
print(f"fastest knee: {abs(played.velocities[:, [1, 3]]).max():.2f} of 5.00 rad/s")

figure, panels = plt.subplots(1, 2, figsize=(11, 5), layout="constrained")
for ax, step, there in zip(panels, (slow, again), (box, moved), strict=True):
    ggo.plot.plot_stick_figure(step, obstacles=[there], base=base, ax=ax)
figure.savefig("06_limits_and_replanning.png", dpi=100)
