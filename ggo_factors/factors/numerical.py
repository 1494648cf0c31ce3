"""Jacobians compared with finite differences, for the library's factors and a user's own."""

from __future__ import annotations

import gtsam
import numpy as np

from ggo_factors.errors import InputError
from ggo_factors.support.inputs import Array, as_instance, as_number


def check_jacobian(factor: gtsam.NoiseModelFactor, values: gtsam.Values, step: float = 1e-6) -> float:
    """Largest difference between a factor's Jacobians and central differences of its error.

    Args:
        factor: any factor with a Gaussian or constrained noise model on vector variables.
        values: the variables to differentiate at. Stay several `step` away from a kink, where the two sides differ.
        step: step of the differences, in the unit of the variables.

    Returns:
        The largest absolute difference over all entries, the noise model taken out.

    Raises:
        InputError: where a variable is missing, the noise model is a robust one, or the factor has no Jacobian.
    """
    size = as_number(step, "step", at_least=1e-12)
    as_instance(values, "values", gtsam.Values)
    noise = as_instance(factor, "factor", gtsam.NoiseModelFactor).noiseModel()
    if isinstance(noise, gtsam.noiseModel.Robust):
        raise InputError("factor: give it without its robust loss, whose weight changes with the error")
    missing = [gtsam.DefaultKeyFormatter(key) for key in factor.keys() if not values.exists(key)]
    if missing:
        raise InputError(f"values: no value for {', '.join(missing)}")
    try:
        whitened = _whitened_jacobian(factor, values)
        rows = len(factor.unwhitenedError(values))
        root = np.stack([noise.whiten(column) for column in np.eye(rows)], -1)
        analytic = np.linalg.solve(root, whitened)
        numeric = _differences(factor, values, size)
    except (RuntimeError, ValueError, AttributeError, np.linalg.LinAlgError) as error:
        raise InputError(f"factor: cannot be differentiated here: {error}") from error
    return float(np.abs(analytic - numeric).max())


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
