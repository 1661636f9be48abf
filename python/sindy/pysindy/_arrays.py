"""Trajectories as PySINDy's methods take them: an array, or a list with one array for each trajectory."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from .._data import Array


def check_times(t: Any, rows: int) -> None:
    """Raises `ValueError` unless `t` is a step above 0 or as many rising times as there are rows."""
    if isinstance(t, (int, float, np.integer, np.floating)) and not isinstance(t, bool):
        if not t > 0:
            raise ValueError(f"t: expected a step above 0, found {t}")
        return
    if not hasattr(t, "shape") or np.ndim(t) != 1:
        raise ValueError(f"t: expected a step or an array of times, found {type(t).__name__}")
    if len(t) != rows:
        raise ValueError(f"t: expected {rows} times, one for each row of x; found {len(t)}")
    if not np.all(np.diff(np.asarray(t, dtype=np.float64)) > 0.0):
        raise ValueError("t: expected rising times, found equal or falling ones")


def array(what: str, values: Any) -> Array:
    """Numbers with states on the last axis and time on the one before it."""
    out = np.asarray(values)
    if out.dtype.kind not in "fiub":
        raise TypeError(f"{what}: expected an array of numbers, found {type(values).__name__}")
    if out.ndim == 0:
        raise TypeError(f"{what}: expected an array, found a number")
    out = out.astype(np.float64, copy=False)
    return out.reshape(-1, 1) if out.ndim == 1 else out


def trajectories(what: str, values: Any, like: list[Array] | None = None, many: bool = False) -> list[Array]:
    """One array for each trajectory, as many as `like` has."""
    if like is not None and isinstance(values, (list, tuple)) != many:
        raise TypeError(f"{what}: expected a list of trajectories if, and only if, x is one")
    runs = list(values) if isinstance(values, (list, tuple)) else [values]
    if like is not None and len(runs) != len(like):
        raise ValueError(f"{what}: expected {len(like)} trajectories, as many as x has; found {len(runs)}")
    return [array(what, run) for run in runs]


def times(t: Any, x: list[Array], many: bool) -> list[Any]:
    """A step or times for each trajectory, checked."""
    if isinstance(t, (list, tuple)):
        if not many:
            raise ValueError("t: expected a step or an array of times, found a list")
        if len(t) != len(x):
            raise ValueError(f"t: expected {len(x)} entries, one for each trajectory; found {len(t)}")
        each = list(t)
    else:
        each = [t] * len(x)
    for one, run in zip(each, x):
        check_times(one, run.shape[-2])
    return each


def inputs(u: Any, x: list[Array], many: bool) -> list[Array]:
    """Inputs of each trajectory; a number stays constant over its trajectory."""
    if many and isinstance(u, (list, tuple)) and len(u) == len(x):
        u = [np.full((*run.shape[:-1], 1), value) if np.ndim(value) == 0 else value for value, run in zip(u, x)]
    out = trajectories("u", u, x, many)
    for k, run in enumerate(x):
        if out[k].ndim != run.ndim and out[k].size % (run.size // run.shape[-1]) == 0:
            out[k] = out[k].reshape(*run.shape[:-1], -1)
        if out[k].shape[:-1] != run.shape[:-1]:
            raise ValueError(f"u: expected rows of shape {run.shape[:-1]}, found {out[k].shape[:-1]}")
    return out


def flat(runs: Sequence[Array]) -> Array:
    """All samples of all trajectories as rows of one matrix."""
    return np.concatenate([run.reshape(-1, run.shape[-1]) for run in runs])


def finite_rows(*matrices: Array) -> Array:
    """Rows where no matrix has a NaN."""
    out: Array = np.all([~np.isnan(m.reshape(len(m), -1)).any(axis=1) for m in matrices], axis=0)
    return out
