"""Pictures of gaits, as in the paper and beyond it: angles, residuals, imports, comfort, spread, likeness to people.

Every function draws on the axes it is given, or on new ones with a title, and returns them; none shows or saves a
figure. Right leg vermilion, left leg blue, in all of them; of a single step the swinging and the supporting leg. Save
vector files inside `matplotlib.rc_context(VECTOR_TEXT)`, and their text stays text.
"""

from ggo_factors.plot.comfort import plot_comfort
from ggo_factors.plot.curves import plot_joint_angles, plot_joint_trajectory, plot_residual
from ggo_factors.plot.likeness import plot_comparison
from ggo_factors.plot.panels import (
    ANGLE_COLOURS,
    ANGLE_NAMES,
    ANGLE_TITLES,
    BASE_COLOUR,
    GROUND_COLOUR,
    LEG_COLOURS,
    OBSTACLE_COLOUR,
    PATH_COLOUR,
    SUPPORT_COLOUR,
    SWING_COLOUR,
    VECTOR_TEXT,
)
from ggo_factors.plot.seen import plot_seen
from ggo_factors.plot.spread import plot_spread
from ggo_factors.plot.stick_figure import plot_stick_figure
from ggo_factors.plot.strides import plot_import

__all__ = [
    "ANGLE_COLOURS",
    "ANGLE_NAMES",
    "ANGLE_TITLES",
    "BASE_COLOUR",
    "GROUND_COLOUR",
    "LEG_COLOURS",
    "OBSTACLE_COLOUR",
    "PATH_COLOUR",
    "SUPPORT_COLOUR",
    "SWING_COLOUR",
    "VECTOR_TEXT",
    "plot_comfort",
    "plot_comparison",
    "plot_import",
    "plot_joint_angles",
    "plot_joint_trajectory",
    "plot_residual",
    "plot_seen",
    "plot_spread",
    "plot_stick_figure",
]
