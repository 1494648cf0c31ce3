"""An engineer's way: a walk in the joints of a ROS 2 robot.

Writes 07_robot.toml, 07_robot.mcap, 07_goal.yaml, 07_ros2_robot.png.
"""

from pathlib import Path

import ggo_factors as ggo

# How the robot counts: names, signs, zero positions, order. The same file reads its logs and writes its goals.
Path("07_robot.toml").write_text("""
units = "rad"
order = ["hip_l", "knee_l", "ankle_l", "hip_r", "knee_r", "ankle_r"]
[alpha_left]
hip_l = 1.0
[beta_left]
knee_l = -1.0                # this robot counts knee flexion negative
[alpha_right]
hip_r = 1.0
[beta_right]
knee_r = -1.0
[offsets]
knee_l = 0.05                # reads 0.05 rad where the leg is straight
[fixed]
ankle_l = 0.0                # held still
ankle_r = 0.0
""")
base = ggo.paper_base_gait()
steps = [ggo.Step((0.35, 0.0)), ggo.Step((0.39, 0.0), (ggo.Obstacle(0.18, 0.23, 0.08),)), ggo.Step((0.35, 0.0))]
steps.append(ggo.Step((0.0, 0.0), end_frame=ggo.STANDING))  # a controller refuses a goal that ends in motion
walk = ggo.walk(base, steps, start=ggo.STANDING, limits=ggo.JointLimits(hip_speed=2.0, knee_speed=3.0))

ggo.export_trajectory(walk, "07_goal.yaml", joints="07_robot.toml", rate=100)  # FollowJointTrajectory
ggo.export_mcap(walk, "07_robot.mcap", joints="07_robot.toml", rate=100)  # JointState, URDF, /tf, markers
print(*[f"{topic.topic}: {topic.message_type}" for topic in ggo.inspect_log("07_robot.mcap").topics], sep="\n")
print(Path("07_goal.yaml").read_text()[:300])

axes = ggo.plot.plot_joint_trajectory(walk)
axes[0].figure.savefig("07_ros2_robot.png", dpi=110)
