"""Titles that say what a figure shows, and of which gait or walk."""

from __future__ import annotations

from collections.abc import Sequence

from ggo_factors.graph.solution import Solution
from ggo_factors.motion.gait import Gait
from ggo_factors.motion.leg_model import LegModel
from ggo_factors.plot.panels import gaits_of
from ggo_factors.support.files import printable
from ggo_factors.walking.walk import Walk, made_from

LONGEST_NAME = 70
"""Letters of a name in a title; one that is longer is cut."""
FEW = 6
"""Steps whose strides are told one by one; of more, the range."""


def title_of(what: str, walk: Walk | Solution | Gait, model: LegModel | None = None) -> str:
    """What is shown of a gait or walk: its name, where it comes from, its steps and strides, a line or two.

    Args:
        what: what the figure shows, with a capital letter; nothing where the picture says it.
        walk: the walk, solution or gait.
        model: the legs, for the stride; by default the gait's own, and no stride where it has none.
    """
    gaits = gaits_of(walk)
    first = gaits[0]
    if isinstance(walk, Walk):
        name = short_name(walk.name)
    else:
        source = short_name(made_from(first)) or "a gait without a name"
        name = f"{short_name(first.name)}, {source}" if made_from(first) != first.name else source
    told = [f"{walk.first_swing} leg swings first"] if isinstance(walk, Walk) else []
    legs = first.model if model is None else model
    if legs is not None:
        told.append(strides([gait.stride(legs) for gait in gaits]))
    told.append(f"{sum(gait.duration for gait in gaits):.2f} s")
    return (f"{what}: {name}" if what else name[:1].upper() + name[1:]) + "\n" + "; ".join(told)


def file_name(source: str) -> str:
    """The name of a recording without the folders it is in."""
    return short_name(source.replace("\\", "/").rstrip("/").rpartition("/")[2])


def short_name(name: str) -> str:
    """A name, perhaps from a file, as a title has room for it."""
    shown = printable(name)
    return shown if len(shown) <= LONGEST_NAME else f"{shown[: LONGEST_NAME - 1]}\u2026"


def strides(lengths: Sequence[float]) -> str:
    """Strides in [m] in words."""
    if len(lengths) == 1:
        return f"stride {lengths[0]:.3f} m"
    if len(lengths) <= FEW:
        return f"strides {', '.join(f'{length:.3f}' for length in lengths)} m"
    return f"strides {min(lengths):.3f} to {max(lengths):.3f} m"
