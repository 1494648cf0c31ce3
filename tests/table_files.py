"""Tables of joint values made for tests: CSV, OpenSim, C3D."""

from __future__ import annotations

import numpy as np

from ggo_factors.recording.log.joint_map import JointMap


def rows_of(times, values, separator=","):
    """Rows of numbers as text that reads back to the same bits."""
    return [separator.join(map(repr, row)) for row in np.column_stack([times, values]).tolist()]


def write_csv(path, times, values, names, separator=",", time="time"):
    """A CSV with a header."""
    path.write_text("\n".join([separator.join((time, *names)), *rows_of(times, values, separator)]) + "\n")
    return path


def write_mot(path, times, degrees, names, header=("inDegrees=yes",)):
    """An OpenSim motion file; further header lines as given."""
    head = ["Coordinates", "version=1", f"nRows={len(times)}", f"nColumns={len(names) + 1}", *header, "endheader"]
    path.write_text("\n".join([*head, "\t".join(("time", *names)), *rows_of(times, degrees, "\t")]) + "\n")
    return path


def write_c3d(ezc3d, path, rate, degrees, labels, units="deg"):
    """A C3D of model outputs: the given angles are the first component, the others are 1."""
    file = ezc3d.c3d()
    file["parameters"]["POINT"]["RATE"]["value"] = [float(rate)]
    file["parameters"]["POINT"]["LABELS"]["value"] = list(labels)
    points = np.ones((4, len(labels), len(degrees)))
    points[0] = degrees.T
    points[:3, (degrees == 0.0).T] = 0.0
    file["data"]["points"] = points
    file.add_parameter("POINT", "ANGLE_UNITS", [units])
    file.write(str(path))
    return path


def renamed(joints, name_of):
    """A joint map for a source that calls each value `name_of(name)`."""
    return JointMap({angle: {name_of(name): f for name, f in row.items()} for angle, row in joints.terms.items()})
