"""Penalties, their proximal operators, and the order of constraints."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from ..._data import Array

Penalty = Callable[[Any, Any], Any]


def _weight(x: Any, weight: Any) -> Any:
    """The weight of a penalty: a number, or one for each entry of `x`."""
    if isinstance(weight, np.ndarray):
        if weight.shape != np.shape(x):
            raise ValueError(f"weights of the penalty: expected the shape {np.shape(x)} of x, found {weight.shape}")
    elif not isinstance(weight, (int, float)):
        raise ValueError(f"weight of the penalty: expected a number or an array, found {type(weight).__name__}")
    return weight


def _family(regularization: str, of: dict[str, Penalty]) -> Penalty:
    kind = regularization.lower().removeprefix("weighted_")
    if kind not in of:
        raise ValueError(f"regularizer: expected l0, l1, l2 or weighted_ before one of these, found {regularization}")
    chosen = of[kind]
    return lambda x, weight: chosen(np.asarray(x), _weight(x, weight))


def get_prox(regularization: str) -> Penalty:
    """The proximal operator of a penalty: ``prox(x, weight)``.

    Parameters
    ----------
    regularization : {"l0", "l1", "l2", "weighted_l0", "weighted_l1", "weighted_l2"}

    Examples
    --------
    >>> import numpy as np
    >>> get_prox("l1")(np.array([2.0, -0.3]), 0.5)
    array([1.5, 0. ])
    """
    return _family(
        regularization,
        {
            "l0": lambda x, w: np.where(x * x > 2.0 * w, x, 0),
            "l1": lambda x, w: x - np.clip(x, -w, w) if np.ndim(w) == 0 else x - np.minimum(np.maximum(x, -w), w),
            "l2": lambda x, w: x / (1.0 + 2.0 * w),
        },
    )


def get_regularization(regularization: str) -> Penalty:
    """A penalty as a function ``penalty(x, weight)``; names as for `get_prox`."""
    return _family(
        regularization,
        {
            "l0": lambda x, w: float(np.sum(w * np.not_equal(x, 0))),
            "l1": lambda x, w: float(np.sum(w * np.abs(x))),
            "l2": lambda x, w: float(np.sum(w * x * x)),
        },
    )


def reorder_constraints(arr: Any, n_features: int, output_order: str = "feature") -> Any:
    """Columns of constraints from target order (all terms of the first equation first) to feature order, or back.

    Parameters
    ----------
    arr : ndarray
        One row for each constraint.
    n_features : int
        Terms of the library.
    output_order : {"feature", "target"}
        The order that is wanted.
    """
    rows = np.atleast_2d(arr)
    count = rows.shape[1] // n_features
    inner = (count, n_features) if output_order == "feature" else (n_features, count)
    return np.swapaxes(rows.reshape(len(rows), *inner), 1, 2).reshape(len(rows), -1)


def validate_control_variables(x: Sequence[Any], u: Sequence[Any]) -> list[Any]:
    """The inputs of every trajectory, if there are as many rows of them as of states."""
    if not isinstance(x, Sequence) or not isinstance(u, Sequence):
        raise ValueError("x and u: expected a list of trajectories each")
    if len(x) != len(u):
        raise ValueError(f"u: expected {len(x)} trajectories, as many as x has; found {len(u)}")
    for states, inputs in zip(x, u):
        if np.shape(states)[:-1] != np.shape(inputs)[:-1]:
            raise ValueError(f"u: expected rows of shape {np.shape(states)[:-1]}, found {np.shape(inputs)[:-1]}")
    return list(u)


def supports_multiple_targets(estimator: Any) -> bool:
    """Whether an estimator takes a matrix of targets, by scikit-learn's tags."""
    from sklearn.utils import get_tags

    return bool(get_tags(estimator).target_tags.multi_output)


def capped_simplex_projection(trimming_array: Array, trimming_fraction: float) -> Array:
    """The nearest weights between 0 and 1 whose sum is a share of their number.

    Bisection on the shift that all of them have in common; 100 halvings reach the resolution of a double. Where any shift
    of an interval will do, the one inside leaves weights that are 0 and 1 exactly.
    """
    total = (1.0 - trimming_fraction) * trimming_array.size
    low, high = float(trimming_array.min()) - 1.0, float(trimming_array.max())
    for _ in range(100):
        middle = 0.5 * (low + high)
        excess = np.clip(trimming_array - middle, 0.0, 1.0).sum() - total
        if excess == 0.0:
            high = middle
            break
        if excess > 0.0:
            low = middle
        else:
            high = middle
    out: Array = np.clip(trimming_array - high, 0.0, 1.0)
    return out
