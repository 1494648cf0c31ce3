"""The edges of the gait graph, each a pure function and the custom factor made of it."""

from ggo_factors.factors.anchor import anchor_factor
from ggo_factors.factors.checked import checked_factor, frame_key, frame_of_key, precision, require_fit
from ggo_factors.factors.end import foothold_factor, pose_factor, shank_angle, shank_factor
from ggo_factors.factors.knee import knee_factor
from ggo_factors.factors.numerical import check_jacobian
from ggo_factors.factors.obstacle import obstacle_factor
from ggo_factors.factors.residual import fill_spans, residual_factor, span_gain

__all__ = [
    "anchor_factor",
    "check_jacobian",
    "checked_factor",
    "fill_spans",
    "foothold_factor",
    "frame_key",
    "frame_of_key",
    "knee_factor",
    "obstacle_factor",
    "pose_factor",
    "precision",
    "require_fit",
    "residual_factor",
    "shank_angle",
    "shank_factor",
    "span_gain",
]
