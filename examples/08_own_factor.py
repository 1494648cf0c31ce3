"""A GTSAM user's way: a factor of one's own in a checked step, beside the library's.

Writes 08_own_factor.png.
"""

import gtsam
import numpy as np

import ggo_factors as ggo

base, box = ggo.paper_base_gait(), ggo.Obstacle(0.20, 0.25, 0.08)
legs, wanted, n = base.legs(), 0.74, 25  # hold the hip 0.74 m over the supporting ankle in frame 25


def hip_height(frame, want_jacobian):
    """One row; the frame is [alpha1, beta1, alpha2, beta2] in [rad], of the supporting (1) and the swinging leg (2)."""
    thigh, shank = frame[0], frame[0] - frame[1]  # from the vertical
    error = np.array([legs.thigh * np.cos(thigh) + legs.shank * np.cos(shank) - wanted])
    if not want_jacobian:
        return error, ()
    by_shank = -legs.shank * np.sin(shank)
    return error, (np.array([[by_shank - legs.thigh * np.sin(thigh), -by_shank, 0.0, 0.0]]),)


# The library's gate for factors: a wrong shape is an error that names the edge, not a crash inside GTSAM.
own = ggo.checked_factor("hip height", [n], 1, hip_height, gtsam.noiseModel.Isotropic.Sigma(1, 0.001))  # [m]
values = gtsam.Values()
values.insert(gtsam.symbol("g", n), base.frames[n])
print("Jacobian off by", ggo.check_jacobian(own, values))  # against finite differences; says which entry

# It acts with smoothness, ground, gains and the dense check as ever.
step = ggo.step_over(base, [box], foothold=(0.39, 0.0), factors=[own])
before, now = (legs.hip_height(gait.frames[n]) for gait in (base, step.gait))
print(f"hip in frame {n}: {before:.3f} m in the base gait, {now:.3f} m now; clearance {step.report.clearance:.3f} m")

axes = ggo.plot.plot_stick_figure(step, obstacles=[box], base=base, frames=(n, len(base) - 1))
axes.figure.savefig("08_own_factor.png", dpi=110)
