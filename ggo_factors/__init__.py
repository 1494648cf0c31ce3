"""Gait Graph Optimization: variable gaits for lower-limb exoskeletons, bent from one base gait by a factor graph."""

from importlib.metadata import version as _version
from typing import TYPE_CHECKING, Any

from ggo_factors.check.report import Report, Tolerances, load_report
from ggo_factors.check.uncertainty import all_cautious, cautious, hit_probability
from ggo_factors.check.verify import verify
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
from ggo_factors.graph.apart import GraphEdge
from ggo_factors.graph.gait_graph import GaitGraph
from ggo_factors.graph.solution import Solution
from ggo_factors.motion.base_gaits import BaseGaits, load_base_gaits
from ggo_factors.motion.gait import Gait, load_gait
from ggo_factors.motion.joint_limits import JointLimits
from ggo_factors.motion.leg_model import Foot, LegModel
from ggo_factors.motion.paper_gait import paper_base_gait
from ggo_factors.motion.style import Style, load_style
from ggo_factors.motion.surface import Surface
from ggo_factors.motion.terrain import Gap, Ground, Obstacle, stair_ground
from ggo_factors.motion.world import Terrain, load_terrain
from ggo_factors.procedures.replan import replan
from ggo_factors.procedures.stairs import climb_stairs, descend_stairs
from ggo_factors.procedures.steps import adjust_stride, step_over, walk
from ggo_factors.procedures.task import StepSolution
from ggo_factors.walking.step import STANDING, Step, verify_step
from ggo_factors.walking.trajectory import JointTrajectory, joint_trajectory
from ggo_factors.walking.walk import Walk, load_walk

if TYPE_CHECKING:
    from ggo_factors import datasets, plot
    from ggo_factors.evaluate.likeness import Comparison
    from ggo_factors.evaluate.style_learning import learn_style
    from ggo_factors.graph.spread import joint_spread
    from ggo_factors.planning.plan import Plan, plan_walk
    from ggo_factors.planning.plan_file import load_plan
    from ggo_factors.planning.replan_plan import replan_plan
    from ggo_factors.recording.base_gait import import_base_gait
    from ggo_factors.recording.clouds import read_sightings
    from ggo_factors.recording.compare import compare
    from ggo_factors.recording.export.convert import convert_log
    from ggo_factors.recording.export.export_mcap import export_mcap
    from ggo_factors.recording.export.export_trajectory import export_trajectory
    from ggo_factors.recording.learning import style_of
    from ggo_factors.recording.log.joint_log import JointLog
    from ggo_factors.recording.log.joint_map import JointMap
    from ggo_factors.recording.report import ImportReport
    from ggo_factors.recording.report_file import load_import_report
    from ggo_factors.recording.sources.inspect_any import inspect_log
    from ggo_factors.seeing.strip import Sighting
    from ggo_factors.seeing.terrain_seen import terrain_from_points, terrain_from_sightings
    from ggo_factors.sweeps.grid import Grid
    from ggo_factors.sweeps.netcdf import sweep
    from ggo_factors.sweeps.tasks import Row, Task, generate_many

__version__ = _version("ggo-factors")

__all__ = [
    "STANDING",
    "BaseGaits",
    "Comparison",
    "Foot",
    "Gait",
    "GaitGraph",
    "Gap",
    "GgoError",
    "GraphEdge",
    "GraphError",
    "Grid",
    "Ground",
    "ImportReport",
    "InfeasibleGaitError",
    "InputError",
    "JointLimits",
    "JointLog",
    "JointMap",
    "JointTrajectory",
    "LegModel",
    "LogError",
    "Obstacle",
    "Plan",
    "Report",
    "Row",
    "Sighting",
    "Solution",
    "Step",
    "StepSolution",
    "Style",
    "Surface",
    "Task",
    "Terrain",
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
    "compare",
    "convert_log",
    "datasets",
    "descend_stairs",
    "export_mcap",
    "export_trajectory",
    "generate_many",
    "hit_probability",
    "import_base_gait",
    "inspect_log",
    "joint_spread",
    "joint_trajectory",
    "learn_style",
    "load_base_gaits",
    "load_gait",
    "load_import_report",
    "load_plan",
    "load_report",
    "load_style",
    "load_terrain",
    "load_walk",
    "paper_base_gait",
    "plan_walk",
    "plot",
    "read_sightings",
    "replan",
    "replan_plan",
    "stair_ground",
    "step_over",
    "style_of",
    "sweep",
    "terrain_from_points",
    "terrain_from_sightings",
    "verify",
    "verify_step",
    "walk",
]

# What reads and writes recordings brings mcap with it, what runs many gaits multiprocessing, the spread SciPy: fetched
# when used.
_LATER = {
    "Comparison": "evaluate.likeness",
    "Grid": "sweeps.grid",
    "ImportReport": "recording.report",
    "JointLog": "recording.log.joint_log",
    "JointMap": "recording.log.joint_map",
    "Plan": "planning.plan",
    "Row": "sweeps.tasks",
    "Sighting": "seeing.strip",
    "Task": "sweeps.tasks",
    "compare": "recording.compare",
    "convert_log": "recording.export.convert",
    "export_mcap": "recording.export.export_mcap",
    "export_trajectory": "recording.export.export_trajectory",
    "generate_many": "sweeps.tasks",
    "import_base_gait": "recording.base_gait",
    "inspect_log": "recording.sources.inspect_any",
    "joint_spread": "graph.spread",
    "learn_style": "evaluate.style_learning",
    "load_import_report": "recording.report_file",
    "load_plan": "planning.plan_file",
    "plan_walk": "planning.plan",
    "read_sightings": "recording.clouds",
    "replan_plan": "planning.replan_plan",
    "style_of": "recording.learning",
    "sweep": "sweeps.netcdf",
    "terrain_from_points": "seeing.terrain_seen",
    "terrain_from_sightings": "seeing.terrain_seen",
}


_ROOMS = ("datasets", "plot")
"""Rooms of the package that are public names themselves; `plot` brings matplotlib with it."""


def __getattr__(name: str) -> Any:
    if name not in _LATER and name not in _ROOMS:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    from importlib import import_module

    if name in _ROOMS:
        return import_module(f"ggo_factors.{name}")
    return getattr(import_module(f"ggo_factors.{_LATER[name]}"), name)


def __dir__() -> list[str]:
    """The public names, without the rooms of the package and what this file imports for itself."""
    return sorted(__all__)
