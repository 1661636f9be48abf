"""Derivatives of measured trajectories, under PySINDy's names."""

from __future__ import annotations

from collections.abc import Callable
from math import factorial
from typing import Any

import numpy as np
from scipy.signal import savgol_filter
from sklearn.base import BaseEstimator

from .._data import Array
from ._arrays import check_times


class BaseDifferentiation(BaseEstimator):  # type: ignore[misc]
    """What all methods share: ``method(x, t)`` gives the derivative and keeps the states in ``smoothed_x_``."""

    smoothed_x_: Array

    def _differentiate(self, x: Any, t: Any = 1) -> Array:
        raise NotImplementedError

    def __call__(self, x: Any, t: Any = 1) -> Array:
        """The derivative, in the shape of `x`; `t` is a step or an array of times."""
        x = np.asarray(x, dtype=np.float64)
        check_times(t, x.shape[0] if x.ndim == 1 else x.shape[getattr(self, "axis", 0)])
        return self._differentiate(x, t)


class FiniteDifference(BaseDifferentiation):
    """Finite differences on even or uneven times.

    Parameters
    ----------
    order : int
        Order of the error in the step; 1 takes forward differences.
    d : int
        Which derivative.
    axis : int
        The axis of time.
    is_uniform : bool
        Whether times may be taken as even.
    drop_endpoints : bool
        Whether rows without a centred stencil become NaN.
    periodic : bool
        Whether the samples are one period, so that stencils continue at the other end.

    Examples
    --------
    >>> import numpy as np
    >>> FiniteDifference(order=2)(np.array([0.0, 1.0, 4.0, 9.0]), 1.0)
    array([0., 2., 4., 6.])
    """

    def __init__(
        self,
        order: int = 2,
        d: int = 1,
        axis: int = 0,
        is_uniform: bool = False,
        drop_endpoints: bool = False,
        periodic: bool = False,
    ) -> None:
        for name, value in (("order", order), ("d", d)):
            if not isinstance(value, (int, np.integer)) or value < 1:
                raise ValueError(f"{name}: expected a whole number of at least 1, found {value}")
        if d > 1 and order % 2 == 1:
            raise ValueError(f"order: expected an even number for a derivative above the first, found {order}")
        self.order = order
        self.d = d
        self.axis = axis
        self.is_uniform = is_uniform
        self.drop_endpoints = drop_endpoints
        self.periodic = periodic

    def _weights(self, offsets: Array) -> Array:
        """Weights of stencils whose points have these distances in time, one row for each stencil."""
        count = offsets.shape[1]
        scale = np.abs(offsets).max(axis=1, keepdims=True)  # else the moments' matrix is badly scaled
        moments = (offsets / scale)[:, None, :] ** np.arange(count)[:, None]
        right = np.zeros((len(offsets), count, 1))
        right[:, self.d] = factorial(self.d)
        out: Array = np.linalg.solve(moments, right)[..., 0] / scale**self.d
        return out

    def _apply(self, x: Array, t: Array, rows: Any, points: Any) -> Array:
        """The derivative at rows from their stencils' points; both may lie outside of 0 to n where samples are periodic."""
        n = len(t)
        offsets = t[points % n] - t[rows][:, None]
        if self.periodic:
            offsets = offsets + (t[-1] - t[0] + t[1] - t[0]) * (points // n)
        even = np.allclose(offsets, offsets[0], rtol=1e-9, atol=0.0) if len(offsets) else True
        if even or self.is_uniform:
            weights = np.broadcast_to(self._weights(offsets[:1])[0] if len(offsets) else 0.0, offsets.shape)
        else:
            weights = self._weights(offsets)
        out = np.zeros((len(rows), *x.shape[1:]))
        for k in range(points.shape[1]):
            out += weights[:, k].reshape(-1, *[1] * (x.ndim - 1)) * x[points[:, k] % n]
        return out

    def _differentiate(self, x: Any, t: Any = 1) -> Array:
        x = np.asarray(x, dtype=np.float64)
        moved = np.moveaxis(x, self.axis, 0)
        n = len(moved)
        times: Array = np.asarray(np.arange(n) * float(t) if np.ndim(t) == 0 else t, dtype=np.float64)
        centred = 2 * ((self.d + 1) // 2) - 1 + self.order
        before, after = (centred - 1) // 2, centred - 1 - (centred - 1) // 2
        one_sided = self.d + self.order
        if n < max(centred, one_sided):
            raise ValueError(f"x: expected at least {max(centred, one_sided)} samples, found {n}")
        rows = np.arange(n)
        inner = rows if self.periodic and not self.drop_endpoints else rows[before : n - after]
        out = np.full(moved.shape, np.nan)
        out[inner] = self._apply(moved, times, inner, inner[:, None] + np.arange(centred) - before)
        if not self.drop_endpoints and not self.periodic:
            for side, first in ((rows[:before], 0), (rows[n - after :], n - one_sided)):
                for row in side:
                    points = first + np.arange(one_sided)
                    out[row] = self._apply(moved, times, np.array([row]), points[None, :])[0]
        self.smoothed_x_ = x
        return np.moveaxis(out, 0, self.axis)


class SmoothedFiniteDifference(FiniteDifference):
    """Finite differences after a filter, a Savitzky–Golay filter by default.

    Parameters
    ----------
    smoother : callable
        ``smoother(x, **smoother_kws)``.
    smoother_kws : dict, optional
        For the default filter ``window_length`` (11) and ``polyorder`` (3); its axis is `axis`.
    save_smooth : bool
        Whether a model is fitted to the filtered states.
    order, d, axis, is_uniform, drop_endpoints, periodic
        As for `FiniteDifference`.
    """

    def __init__(
        self,
        smoother: Callable[..., Any] = savgol_filter,
        smoother_kws: dict[str, Any] | None = None,
        save_smooth: bool = True,
        order: int = 2,
        d: int = 1,
        axis: int = 0,
        is_uniform: bool = False,
        drop_endpoints: bool = False,
        periodic: bool = False,
    ) -> None:
        super().__init__(order, d, axis, is_uniform, drop_endpoints, periodic)
        self.smoother = smoother
        self.smoother_kws = smoother_kws
        self.save_smooth = save_smooth

    def _differentiate(self, x: Any, t: Any = 1) -> Array:
        options = dict(self.smoother_kws or {})
        if self.smoother is savgol_filter:
            options = {"window_length": 11, "polyorder": 3, "axis": self.axis} | options
        smooth = self.smoother(x, **options)
        out = super()._differentiate(smooth, t)
        self.smoothed_x_ = smooth if self.save_smooth else x
        return out


class SpectralDerivative(BaseDifferentiation):
    """The derivative by Fourier series, for even samples of one period.

    Parameters
    ----------
    d : int
        Which derivative.
    axis : int
        The axis of time.
    """

    def __init__(self, d: int = 1, axis: int = 0) -> None:
        self.d = d
        self.axis = axis

    def _differentiate(self, x: Any, t: Any = 1) -> Array:
        x = np.asarray(x, dtype=np.float64)
        step = float(t) if np.ndim(t) == 0 else float(t[1] - t[0])
        moved = np.moveaxis(x, self.axis, -1)
        n = moved.shape[-1]
        wave = 2.0 * np.pi * np.fft.rfftfreq(n, step)
        if n % 2 == 0 and self.d % 2 == 1:
            wave[-1] = 0.0  # the slope of the highest frequency is zero at every sample
        out = np.fft.irfft(np.fft.rfft(moved) * (1j * wave) ** self.d, n)
        self.smoothed_x_ = x
        return np.moveaxis(out, -1, self.axis)


class SINDyDerivative(BaseDifferentiation):
    """A method of the package ``derivative``, which has to be installed.

    Parameters
    ----------
    axis : int
        The axis of time.
    save_smooth : bool
        Whether a model is fitted to the smoothed states.
    **kwargs
        ``kind`` and the settings of that kind, as ``derivative.dxdt`` takes them.
    """

    def __init__(self, axis: int = 0, save_smooth: bool = True, **kwargs: Any) -> None:
        self.axis = axis
        self.save_smooth = save_smooth
        self.kwargs = kwargs

    def get_params(self, deep: bool = True) -> dict[str, Any]:
        """All settings, those of the kind as well."""
        return {"axis": self.axis, "save_smooth": self.save_smooth, **self.kwargs}

    def set_params(self, **params: Any) -> SINDyDerivative:
        """Sets settings; ``kwargs`` replaces the kind and all of its settings."""
        if "kwargs" in params:
            self.kwargs = dict(params.pop("kwargs"))
        for name in ("axis", "save_smooth"):
            if name in params:
                setattr(self, name, params.pop(name))
        self.kwargs = self.kwargs | params
        return self

    def _differentiate(self, x: Any, t: Any = 1) -> Array:
        from derivative import methods

        x = np.asarray(x, dtype=np.float64)
        check_times(t, x.shape[self.axis])
        times = np.arange(x.shape[self.axis]) * float(t) if np.ndim(t) == 0 else np.asarray(t, dtype=np.float64)
        settings = {name: value for name, value in self.kwargs.items() if name != "kind"}
        method = methods[self.kwargs["kind"]](**settings)
        self.smoothed_x_ = np.asarray(method.x(x, times, axis=self.axis)) if self.save_smooth else x
        return np.asarray(method.d(x, times, axis=self.axis))
