"""Point clouds as messages: `sensor_msgs/PointCloud2`, as drivers of depth cameras write them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ggo_factors.errors import InputError
from ggo_factors.recording.export.ros2_log import header
from ggo_factors.seeing.strip import Sighting, axes_of
from ggo_factors.support.inputs import Array

FLOAT32 = 7
"""The type FLOAT32 of `sensor_msgs/PointField`."""


def cloud_message(points: ArrayLike, time_ns: int, frame: str) -> dict[str, Any]:
    """A cloud at a time in [ns].

    Args:
        points: in [m], shape (n, 3), or (rows, columns, 3) for an organised cloud.
        time_ns: the time.
        frame: name of the frame that the points are in.
    """
    values = np.asarray(points, dtype="<f4")
    rows, columns = values.shape[:2] if values.ndim == 3 else (1, len(values))
    fields = [{"name": axis, "offset": 4 * n, "datatype": FLOAT32, "count": 1} for n, axis in enumerate("xyz")]
    return {
        "header": header(time_ns, frame),
        "height": rows,
        "width": columns,
        "fields": fields,
        "is_bigendian": False,
        "point_step": 12,
        "row_step": 12 * columns,
        "data": values.tobytes(),
        "is_dense": bool(np.isfinite(values).all()),
    }


def points_of_scene(sightings: Sequence[Sighting], sole: float) -> Array:
    """All finite points of some frames in the frame of a scene (x forward, y left, z up) in [m], shape (n, 3).

    Args:
        sightings: the frames, which share their origin.
        sole: height in [m] of the first supporting ankle, the scene's origin, above the ground.

    Raises:
        InputError: where a frame does not say where that origin is.
    """
    found = []
    for sighting in sightings:
        cloud = np.asarray(sighting.points, dtype=np.float64)
        forward, up, right = axes_of(sighting.up, sighting.heading)
        if sighting.at is None:
            raise InputError("sightings: each needs its at, the ground under the first supporting ankle")
        cloud = cloud[np.isfinite(cloud).all(axis=1)] - np.asarray(sighting.at)
        found.append(cloud @ np.stack([forward, -right, up], axis=1) - [0.0, 0.0, sole])
    return np.concatenate(found)
