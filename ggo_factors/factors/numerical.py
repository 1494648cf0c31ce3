"""Jacobians compared with finite differences, for the library's factors and a user's own."""

from __future__ import annotations

import gtsam
import numpy as np

from ggo_factors.errors import InputError
from ggo_factors.factors.fit import require_survivable
from ggo_factors.support.inputs import Array, as_instance, as_number


class JacobianDifference(float):
    """The largest difference between Jacobians and finite differences: a number, and the entry that it is at.

    Attributes:
        row: row of the error, from 0.
        column: entry of the variable, from 0; of a frame its joint angle alpha1, beta1, alpha2 or beta2.
        key: the variable in words, `g7` for frame 7.
        analytic: the factor's own Jacobian there.
        numeric: the finite difference there.
    """

    row: int
    column: int
    key: str
    analytic: float
    numeric: float

    def __repr__(self) -> str:
        here = f"row {self.row}, column {self.column} of {self.key}"
        return f"{float(self):.3g} at {here}: Jacobian {self.analytic:.6g}, finite difference {self.numeric:.6g}"


def check_jacobian(factor: gtsam.NoiseModelFactor, values: gtsam.Values, step: float = 1e-6) -> JacobianDifference:
    """Largest difference between a factor's Jacobians and central differences of its error, and where it is.

    A raw `gtsam.CustomFactor` is evaluated in a child process first, since it may kill the interpreter.

    Args:
        factor: any factor with a Gaussian or constrained noise model on vector variables.
        values: the variables to differentiate at. Stay several `step` away from a kink, where the two sides differ.
        step: step of the differences, in the unit of the variables.

    Returns:
        The largest absolute difference over all entries, the noise model taken out: a float that prints its row, its
        column and variable, and the two values.

    Raises:
        InputError: where a variable is missing, the noise model is a robust one, the factor has no Jacobian, or it
            kills the interpreter.
    """
    size = as_number(step, "step", at_least=1e-12)
    as_instance(values, "values", gtsam.Values)
    noise = as_instance(factor, "factor", gtsam.NoiseModelFactor).noiseModel()
    if isinstance(noise, gtsam.noiseModel.Robust):
        raise InputError("factor: give it without its robust loss, whose weight changes with the error")
    missing = [gtsam.DefaultKeyFormatter(key) for key in factor.keys() if not values.exists(key)]
    if missing:
        raise InputError(f"values: no value for {', '.join(missing)}")
    require_survivable(factor, lambda: _misshapen(factor, values))
    try:
        whitened = _whitened_jacobian(factor, values)
        rows = len(factor.unwhitenedError(values))
        root = np.stack([noise.whiten(column) for column in np.eye(rows)], -1)
        analytic = np.linalg.solve(root, whitened)
        numeric = _differences(factor, values, size)
        off = np.abs(analytic - numeric)
    except (RuntimeError, ValueError, AttributeError, np.linalg.LinAlgError) as error:
        raise InputError(f"factor: cannot be differentiated here: {error}") from error
    row, column = divmod(int(off.argmax()), off.shape[1])  # a NaN counts as the largest
    found = JacobianDifference(off[row, column])
    found.row, found.analytic, found.numeric = row, float(analytic[row, column]), float(numeric[row, column])
    for key in factor.keys():
        entries = len(values.atVector(key))
        if column < entries:
            found.key, found.column = gtsam.DefaultKeyFormatter(key), column
            break
        column -= entries
    return found


def _misshapen(factor: gtsam.NoiseModelFactor, values: gtsam.Values) -> str:
    """What is wrong with the shape of a Jacobian there, or nothing."""
    columns = _whitened_jacobian(factor, values).shape[1]
    wanted = sum(len(values.atVector(key)) for key in factor.keys())
    return "" if columns == wanted else f"its Jacobians have {columns} columns, its variables {wanted} entries"


def _differences(factor: gtsam.NoiseModelFactor, values: gtsam.Values, size: float) -> Array:
    columns: list[Array] = []
    for key in factor.keys():
        at = values.atVector(key)
        for direction in np.eye(len(at)) * size:
            errors = []
            for point in (at + direction, at - direction):
                moved = gtsam.Values(values)
                moved.update(key, point)
                errors.append(factor.unwhitenedError(moved))
            columns.append((errors[0] - errors[1]) / (2.0 * size))
    return np.stack(columns, -1)


def _whitened_jacobian(factor: gtsam.NoiseModelFactor, values: gtsam.Values) -> Array:
    linear = factor.linearize(values)
    if not isinstance(linear, gtsam.JacobianFactor):
        raise RuntimeError(f"{type(factor).__name__} linearizes to no Jacobian")
    return np.array(linear.getA())  # a copy: getA() hands out a view of memory that goes with `linear`
