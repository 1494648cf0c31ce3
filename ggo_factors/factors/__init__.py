"""The edges of the gait graph, each a pure function, the edge made of it, and the custom factor made of that."""

from ggo_factors.factors.anchor import anchor_edge, anchor_factor
from ggo_factors.factors.balance import balance_edges
from ggo_factors.factors.between import BetweenFunction, edge_between, without_constants
from ggo_factors.factors.bone import BoneFunction, bone_edge
from ggo_factors.factors.checked import STYLE_KEY, checked_factor, frame_key, frame_of_key, precision
from ggo_factors.factors.edge import Edge
from ggo_factors.factors.end import (
    foothold_edge,
    foothold_factor,
    pose_edge,
    pose_factor,
    shank_angle,
    shank_edge,
    shank_factor,
)
from ggo_factors.factors.fit import frames_of, require_fit
from ggo_factors.factors.height import clear_edge, hip_edge
from ggo_factors.factors.knee import knee_edge, knee_factor
from ggo_factors.factors.landing import landing_edges, landing_factors
from ggo_factors.factors.leg import LegFunction, leg_edge
from ggo_factors.factors.limit import limit_edge
from ggo_factors.factors.numerical import check_jacobian
from ggo_factors.factors.obstacle import obstacle_edge, obstacle_factor
from ggo_factors.factors.placed import Place, placed_factor
from ggo_factors.factors.residual import rate_edge, residual_edge, residual_factor
from ggo_factors.factors.span import fill_frames, fill_spans, motion_edges, with_neighbours
from ggo_factors.factors.stacked import stacked_factor
from ggo_factors.factors.style import (
    style_anchor,
    style_prior,
    style_start,
    styled_edges,
    styled_landing,
    styled_rate_edge,
    with_style_held,
)

__all__ = [
    "STYLE_KEY",
    "BetweenFunction",
    "BoneFunction",
    "Edge",
    "LegFunction",
    "Place",
    "anchor_edge",
    "anchor_factor",
    "balance_edges",
    "bone_edge",
    "check_jacobian",
    "checked_factor",
    "clear_edge",
    "edge_between",
    "fill_frames",
    "fill_spans",
    "foothold_edge",
    "foothold_factor",
    "frame_key",
    "frame_of_key",
    "frames_of",
    "hip_edge",
    "knee_edge",
    "knee_factor",
    "landing_edges",
    "landing_factors",
    "leg_edge",
    "limit_edge",
    "motion_edges",
    "obstacle_edge",
    "obstacle_factor",
    "placed_factor",
    "pose_edge",
    "pose_factor",
    "precision",
    "rate_edge",
    "require_fit",
    "residual_edge",
    "residual_factor",
    "shank_angle",
    "shank_edge",
    "shank_factor",
    "stacked_factor",
    "style_anchor",
    "style_prior",
    "style_start",
    "styled_edges",
    "styled_landing",
    "styled_rate_edge",
    "with_neighbours",
    "with_style_held",
    "without_constants",
]
