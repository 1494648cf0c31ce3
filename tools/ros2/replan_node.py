"""A ROS 2 node that makes the rest of a step again for the boxes that it sees, and publishes it.

    python tools/ros2/replan_node.py

It hears `/obstacles` (std_msgs/Float64MultiArray: x_start, x_end, height of each box in [m], in the body frame of the
step) and `/gait/frame` (std_msgs/Int32: the last frame walked), and publishes `/gait/trajectory`
(trajectory_msgs/JointTrajectory) of what is left. `Replanner` needs no ROS; rclpy is imported in `main` only.
"""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass, field

import ggo_factors as ggo

RATE_HZ = 50.0
"""The controller asks for a frame this often, in [1/s]."""


@dataclass
class Replanner:
    """The step that is walked, made again when the boxes change.

    Attributes:
        step: the step as it is now.
        deadline: seconds that one call may take; by default a period of the controller.
        missed: calls that took longer.
        calls: how often a step was to be made again.
        refused: why a change was not taken; the step stays as it was.
    """

    step: ggo.StepSolution
    deadline: float = 1.0 / RATE_HZ
    missed: int = 0
    calls: int = 0
    refused: list[str] = field(default_factory=list)

    def see(self, obstacles: Sequence[ggo.Obstacle], at_frame: int) -> bool:
        """Take boxes as they are seen at a frame; whether the step was made again."""
        if tuple(obstacles) == self.step.task.step.obstacles:
            return False
        began = time.perf_counter()
        self.calls += 1
        try:
            self.step = ggo.replan(self.step, at_frame, obstacles=obstacles, deadline=self.deadline)
            return True
        except ggo.GgoError as error:
            self.refused.append(str(error))
            return False
        finally:
            self.missed += time.perf_counter() - began > self.deadline

    def planned(self) -> ggo.JointTrajectory:
        """The joint angles of the whole step, as it is planned now."""
        return ggo.Walk((self.step.gait,), (self.step.task.step,)).joint_trajectory()


def main() -> None:
    """Run the node."""
    import rclpy
    from builtin_interfaces.msg import Duration
    from rclpy.node import Node
    from std_msgs.msg import Float64MultiArray, Int32
    from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint

    rclpy.init()
    node = Node("ggo_replan")
    planner = Replanner(ggo.step_over(ggo.paper_base_gait(), [], foothold=(0.39, 0.0)))
    publisher = node.create_publisher(JointTrajectory, "/gait/trajectory", 1)
    frame = [0]

    def seen(message: Float64MultiArray) -> None:
        numbers = list(message.data)
        boxes = [ggo.Obstacle(*numbers[k : k + 3]) for k in range(0, len(numbers) - 2, 3)]
        at = frame[0]
        if not planner.see(boxes, at):
            return
        made = planner.planned()
        out = JointTrajectory(joint_names=["left_hip", "left_knee", "right_hip", "right_knee"])
        for k in range(at + 1, len(made.time)):
            ns = round((made.time[k] - made.time[at]) * 1e9)
            point = JointTrajectoryPoint(time_from_start=Duration(sec=ns // 10**9, nanosec=ns % 10**9))
            point.positions, point.velocities = made.positions[k].tolist(), made.velocities[k].tolist()
            point.accelerations = made.accelerations[k].tolist()
            out.points.append(point)
        publisher.publish(out)

    node.create_subscription(Int32, "/gait/frame", lambda message: frame.__setitem__(0, message.data), 10)
    node.create_subscription(Float64MultiArray, "/obstacles", seen, 1)
    rclpy.spin(node)


if __name__ == "__main__":
    main()
