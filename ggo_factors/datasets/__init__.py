"""Sample data: where the files that come with the library are.

They stand in the folder `datasets/` of the source, the one place of them; the build puts that folder into the wheel as
`ggo_factors/datasets/`. Its README says what they are and where they are from.
"""

from __future__ import annotations

from pathlib import Path

from ggo_factors.errors import InputError

_INSTALLED = Path(__file__).parent
_SOURCE = Path(__file__).parents[2] / "datasets"


def path(name: str) -> Path:
    """Where a sample file is.

    Args:
        name: its name, for example ``"children_walk.mcap"``.

    Raises:
        InputError: where there is no such file, with the names of those that there are.
    """
    # An installed library has them beside this file; there the folder above it is not ours.
    folder = _INSTALLED if (_INSTALLED / "README.md").is_file() else _SOURCE
    known = sorted(item.name for item in folder.iterdir() if item.is_file() and item.suffix not in (".md", ".py"))
    if name not in known:
        raise InputError(f"name: no sample file {name!r:.40}; there are {', '.join(known)}")
    return folder / name


def children_walk() -> Path:
    """A log of level walking, ROS 2 MCAP of 21 s: for `import_base_gait`, with `children_walk_joints` as its joints.

    It is assembled from single gait cycles of 24 children, and is not one person's walk.
    """
    return path("children_walk.mcap")


def children_walk_joints() -> Path:
    """The joint map of `children_walk`: which logged joints make the four angles of the model."""
    return path("children_walk.toml")


def course() -> Path:
    """A terrain of 7 m for `load_terrain` and `plan_walk`: kerb, box, pit, three stairs up, a ramp down; goal 6.6 m.

    The paper's base gait walks it from standing to standing.
    """
    return path("course.toml")


def paper_base_gait() -> Path:
    """The paper's base gait as a gait file, for `load_gait`: one step of 0.5 s in 51 frames, legs of 0.39 + 0.39 m."""
    return path("paper_base_gait.csv")
