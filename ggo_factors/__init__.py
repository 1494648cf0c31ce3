"""Gait Graph Optimization: variable gaits for lower-limb exoskeletons, bent from one base gait by a factor graph."""

from importlib.metadata import version as _version
from typing import TYPE_CHECKING, Any

from ggo_factors.errors import (
    GgoError,
    GraphError,
    InfeasibleGaitError,
    InputError,
    LogError,
    UnreachableFootholdError,
    Violation,
)
from ggo_factors.factors import check_jacobian, checked_factor
from ggo_factors.gait import Gait, load_gait, paper_base_gait
from ggo_factors.generate import adjust_stride, climb_stairs, descend_stairs, step_over, walk
from ggo_factors.graph import GaitGraph
from ggo_factors.limits import JointLimits
from ggo_factors.model import Foot, LegModel
from ggo_factors.replan import replan
from ggo_factors.solve import Solution
from ggo_factors.terrain import Gap, Ground, Obstacle, stair_ground
from ggo_factors.uncertainty import all_cautious, cautious, hit_probability
from ggo_factors.verify import Report, Tolerances, verify
from ggo_factors.walk import STANDING, JointTrajectory, Step, Walk, joint_trajectory, load_walk, verify_step

if TYPE_CHECKING:
    from ggo_factors.grid import Grid
    from ggo_factors.many import Row, Task, generate_many
    from ggo_factors.recording.base_gait import import_base_gait
    from ggo_factors.recording.inspect import inspect_log
    from ggo_factors.recording.joint_map import JointMap
    from ggo_factors.recording.report import ImportReport
    from ggo_factors.recording.write import export_mcap
    from ggo_factors.spread import joint_spread
    from ggo_factors.sweep_file import sweep

__version__ = _version("ggo-factors")

__all__ = [
    "STANDING",
    "Foot",
    "Gait",
    "GaitGraph",
    "Gap",
    "GgoError",
    "GraphError",
    "Grid",
    "Ground",
    "ImportReport",
    "InfeasibleGaitError",
    "InputError",
    "JointLimits",
    "JointMap",
    "JointTrajectory",
    "LegModel",
    "LogError",
    "Obstacle",
    "Report",
    "Row",
    "Solution",
    "Step",
    "Task",
    "Tolerances",
    "UnreachableFootholdError",
    "Violation",
    "Walk",
    "__version__",
    "adjust_stride",
    "all_cautious",
    "cautious",
    "check_jacobian",
    "checked_factor",
    "climb_stairs",
    "descend_stairs",
    "export_mcap",
    "generate_many",
    "hit_probability",
    "import_base_gait",
    "inspect_log",
    "joint_spread",
    "joint_trajectory",
    "load_gait",
    "load_walk",
    "paper_base_gait",
    "replan",
    "stair_ground",
    "step_over",
    "sweep",
    "verify",
    "verify_step",
    "walk",
]

# What reads and writes recordings brings mcap with it, what runs many gaits multiprocessing, the spread SciPy: fetched
# when used.
_LATER = {
    "Grid": "grid",
    "ImportReport": "recording.report",
    "JointMap": "recording.joint_map",
    "Row": "many",
    "Task": "many",
    "export_mcap": "recording.write",
    "generate_many": "many",
    "import_base_gait": "recording.base_gait",
    "inspect_log": "recording.inspect",
    "joint_spread": "spread",
    "sweep": "sweep_file",
}


def __getattr__(name: str) -> Any:
    if name not in _LATER:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    from importlib import import_module

    return getattr(import_module(f"ggo_factors.{_LATER[name]}"), name)
