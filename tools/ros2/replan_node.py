"""A ROS 2 node that makes the rest of a walk again for the boxes that it sees, while the walk goes on.

    python tools/ros2/replan_node.py WALK.csv BASE.csv

It hears `/joint_states` (sensor_msgs/JointState), whose stamps say how far the walk is since the first of them, and
`/obstacles` (std_msgs/Float64MultiArray: x_start, x_end and height of each box in [m], in the frame `map` of an
exported walk: from the ankle that supports first). It publishes `/gait/trajectory` (trajectory_msgs/JointTrajectory),
stamped with the start of the walk: a joint_trajectory_controller goes on from where it is.

A replan takes hundredths of a second, sometimes up to its deadline; a controller at 50 Hz cannot wait for it. So it
runs beside the ticks, and changes nothing before `AHEAD` from now: until then the walk that is played stays, to the
bit. What comes later than that is dropped and asked for again. `Replanner` needs no ROS; `main` imports rclpy.
"""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from concurrent.futures import Executor, Future, ThreadPoolExecutor
from dataclasses import dataclass, field, replace

import ggo_factors as ggo

DEADLINE = 0.25
"""A replan may take so long in [s]."""
AHEAD = 0.3
"""The walk is not changed before so long from now in [s]: the deadline, and two ticks at 50 Hz."""
FRAMES_LEFT = 6
"""Where a step has fewer frames left the next one is changed: the joints need time to land elsewhere."""

Boxes = tuple[ggo.Obstacle, ...]


@dataclass
class Replanner:
    """A walk that is played, made again beside the ticks of its controller when other boxes are seen.

    Attributes:
        walk: the walk as it is planned now.
        base: the base gait that it was bent from, where the walk was read from a file.
        worker: runs the replans, one at a time.
        asked: replans that were begun.
        late: those that were ready too late, and dropped.
        refused: why boxes were not taken; the walk stays as it was.
    """

    walk: ggo.Walk
    base: ggo.Gait | None = None
    worker: Executor = field(default_factory=lambda: ThreadPoolExecutor(1))
    asked: int = 0
    late: int = 0
    refused: list[str] = field(default_factory=list)
    _boxes: Boxes = ()
    _waiting: bool = False
    _running: tuple[Future[ggo.Walk], float] | None = None

    def see(self, boxes: Sequence[ggo.Obstacle]) -> None:
        """Take all boxes that are seen now, in the body frame of the first step."""
        if tuple(boxes) != self._boxes:
            self._boxes, self._waiting = tuple(boxes), True

    def tick(self, now: float) -> bool:
        """Take a replan that is ready, begin one that is due; never wait.

        Args:
            now: time since the start of the walk in [s].

        Returns:
            Whether `walk` is another one now.
        """
        changed = self._running is not None and self._running[0].done() and self._take(*self._running, now)
        if self._waiting and self._running is None:
            self._waiting = False
            self._begin(now)
        return changed

    def _take(self, replanned: Future[ggo.Walk], begins: float, now: float) -> bool:
        """The walk that was made again from `begins` on in [s], unless that is past."""
        self._running = None
        if error := replanned.exception():
            if not isinstance(error, ggo.GgoError):
                raise error
            self.refused.append(str(error))
            return False
        if now > begins:
            self.late += 1
            self._waiting = True
            return False
        self.walk = replanned.result()
        return True

    def _begin(self, now: float) -> None:
        place = changeable(self.walk, now + AHEAD)
        if place is None:
            self.refused.append(f"at {now:.3f} s: the walk is nearly over")
            return
        self.asked += 1
        step, frame, begins = place
        self._running = self.worker.submit(made_again, self.walk, self.base, step, frame, self._boxes), begins


def changeable(walk: ggo.Walk, time: float) -> tuple[int, int, float] | None:
    """The first frame from a time in [s] on after which a walk can change: its step, from 0, its number, its time."""
    began = 0.0
    for number, gait in enumerate(walk.gaits):
        for frame in range(len(gait) - FRAMES_LEFT):
            at = began + float(gait.times[frame])
            if at >= time:
                return number, frame, at
        began += gait.duration
    return None


def made_again(walk: ggo.Walk, base: ggo.Gait | None, step: int, frame: int, boxes: Boxes) -> ggo.Walk:
    """The walk with its rest made again for boxes in the body frame of its first step.

    Raises:
        GgoError: where it cannot be made.
    """
    plan = list(walk.plan)
    # The leg that trails must clear them as well: all later steps see the boxes too.
    for number in range(step, len(plan)):
        x, y = walk.origins()[number].tolist()
        plan[number] = replace(plan[number], obstacles=tuple(box.shifted(x, y) for box in boxes))
    seen = replace(walk, plan=tuple(plan))
    return ggo.replan(seen, frame, step=step + 1, base=None if walk.steps else base, deadline=DEADLINE)


def main() -> None:
    """Run the node."""
    parser = argparse.ArgumentParser(description="Make the rest of a walk again for the boxes that are seen.")
    parser.add_argument("walk", help="a walk as `ggo walk -o` writes it")
    parser.add_argument("base", help="the base gait that it was bent from, or 'paper'")
    args = parser.parse_args()
    import rclpy
    from builtin_interfaces.msg import Duration, Time
    from rclpy.node import Node
    from sensor_msgs.msg import JointState
    from std_msgs.msg import Float64MultiArray
    from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint

    base = ggo.paper_base_gait() if args.base == "paper" else ggo.load_gait(args.base)
    planner = Replanner(ggo.load_walk(args.walk), base)
    rclpy.init()
    node = Node("ggo_replan")
    publisher = node.create_publisher(JointTrajectory, "/gait/trajectory", 1)
    start: list[Time] = []

    def seen(message: Float64MultiArray) -> None:
        numbers = list(message.data)
        planner.see([ggo.Obstacle(*numbers[k : k + 3]) for k in range(0, len(numbers) - 2, 3)])

    def heard(message: JointState) -> None:
        stamp = message.header.stamp
        start.extend([] if start else [stamp])
        now = stamp.sec - start[0].sec + 1e-9 * (stamp.nanosec - start[0].nanosec)
        if planner.tick(now):
            publish(now)
        for reason in planner.refused:
            node.get_logger().warning(reason)
        planner.refused.clear()

    def publish(now: float) -> None:
        made = planner.walk.joint_trajectory()
        out = JointTrajectory(joint_names=["left_hip", "left_knee", "right_hip", "right_knee"])
        out.header.stamp = start[0]
        for k in range(int((made.time <= now).sum()), len(made.time)):
            sec, nanosec = divmod(round(made.time[k] * 1e9), 10**9)
            point = JointTrajectoryPoint(time_from_start=Duration(sec=sec, nanosec=nanosec))
            point.positions, point.velocities = made.positions[k].tolist(), made.velocities[k].tolist()
            point.accelerations = made.accelerations[k].tolist()
            out.points.append(point)
        publisher.publish(out)

    node.create_subscription(JointState, "/joint_states", heard, 10)
    node.create_subscription(Float64MultiArray, "/obstacles", seen, 1)
    rclpy.spin(node)


if __name__ == "__main__":
    main()
