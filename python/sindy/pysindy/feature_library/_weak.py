"""Candidate terms of the weak form under PySINDy's names."""

from __future__ import annotations

from collections.abc import Callable
from itertools import product
from math import comb, prod
from typing import Any

import numpy as np
from numpy.polynomial import Polynomial

from ..._data import Array
from ..differentiation import FiniteDifference
from ._fields import PDELibrary
from ._pointwise import BaseFeatureLibrary


class WeakPDELibrary(PDELibrary):
    """Integrals of functions, derivatives and their products over windows in space and time.

    A window is a box around a point drawn at random by ``numpy.random``. An integral is ``∫ f φ`` with ``φ = Π (1 - s²)^p``,
    where s runs from -1 to 1 over the window along each axis. Derivatives of a field, that in time as well, are moved to φ by
    parts. In products half of them are; the others are those of the data, which noise disturbs. `SINDy` fits one row for each
    window.

    Parameters
    ----------
    function_library, derivative_order, include_bias, include_interaction, multiindices, differentiation_method, diff_kwargs,
    is_uniform, periodic
        As for `PDELibrary`; the last five concern derivatives in products.
    spatiotemporal_grid : ndarray
        Coordinates in space, then the time: of shape (n,) for times alone, (n, m, 2) for one dimension of space, and so on.
    K : int
        How many windows.
    H_xt : float or list of float, optional
        Half of a window's length along each axis; by default a twentieth of the grid's, and three steps at least.
    p : int
        The power in φ, at least `derivative_order`.
    implicit_terms, num_pts_per_domain
        There for compatibility: the first has to be False, the second does nothing.
    """

    def __init__(
        self,
        function_library: BaseFeatureLibrary | None = None,
        derivative_order: int = 0,
        spatiotemporal_grid: Any = None,
        include_bias: bool = False,
        include_interaction: bool = True,
        K: int = 100,
        H_xt: Any = None,
        p: int = 4,
        num_pts_per_domain: int | None = None,
        implicit_terms: bool = False,
        multiindices: Any = None,
        differentiation_method: Callable[..., Any] = FiniteDifference,
        diff_kwargs: dict[str, Any] | None = None,
        is_uniform: bool | None = None,
        periodic: bool | None = None,
    ) -> None:
        if spatiotemporal_grid is None:
            raise ValueError("spatiotemporal_grid: expected coordinates, found None")
        if implicit_terms:
            raise ValueError("implicit_terms: expected False, for derivatives in time are targets only; found True")
        if not K > 0 or p < 0:
            raise ValueError(f"K, p: expected at least 1 window and a power of at least 0, found {K} and {p}")
        grid = np.asarray(spatiotemporal_grid, dtype=np.float64)
        self.spatiotemporal_grid = grid[:, None] if grid.ndim == 1 else grid
        space = self.spatiotemporal_grid[..., 0, :-1]
        super().__init__(
            function_library, derivative_order, space if derivative_order else None, None, include_bias, include_interaction,
            False, multiindices, differentiation_method, diff_kwargs,
        )  # fmt: skip
        self.is_uniform, self.periodic = is_uniform, periodic
        self.K = K
        self.H_xt = H_xt
        self.p = p
        self.num_pts_per_domain = num_pts_per_domain
        self._draw()

    def _draw(self) -> None:
        """The windows: for each, and for each axis, the indices of its points and their weights by order of the derivative."""
        lines = self._lines(self.spatiotemporal_grid)
        lengths = np.array([line[-1] - line[0] for line in lines])
        if self.H_xt is None:
            steps = np.array([np.diff(line).max(initial=0.0) for line in lines])
            half = np.minimum(np.maximum(lengths / 20.0, 3.0 * steps), 0.49 * lengths)
        else:
            half = np.broadcast_to(np.asarray(self.H_xt, dtype=np.float64), lengths.shape)
        if np.any(half <= 0.0) or np.any(half >= lengths / 2.0):
            raise ValueError(f"H_xt: expected numbers above 0 and below {(lengths / 2.0).tolist()}, found {half.tolist()}")
        power = Polynomial([1.0, 0.0, -1.0]) ** max(self.p, self.derivative_order, 1)
        orders = range(self.derivative_order + 2)
        self._windows: list[list[tuple[slice, Array]]] = []
        for _ in range(self.K):
            window = []
            for line, h in zip(lines, half):
                centre = np.random.uniform(line[0] + h, line[-1] - h)
                inside = slice(*np.searchsorted(line, [centre - h, centre + h]))
                if inside.stop - inside.start < 3:
                    raise ValueError(f"H_xt: expected windows of 3 points at least along each axis, found a half length of {h}")
                rule = np.zeros(len(line))  # the trapezoidal one
                rule[1:] += 0.5 * np.diff(line)
                rule[:-1] += 0.5 * np.diff(line)
                # The window ends at points of the grid, where φ and its first derivatives are zero: the rule's error is least.
                points = line[inside]
                reach = 0.5 * (points[-1] - points[0])
                s = (points - points[0]) / reach - 1.0
                weights = np.stack([rule[inside] * power.deriv(order)(s) / reach**order for order in orders])
                window.append((inside, weights))
            self._windows.append(window)

    def _integrals(self, values: Array, orders: tuple[int, ...]) -> Array:
        """The integrals over all windows of values whose derivatives are moved to φ; one row for each window."""
        out = np.empty((len(self._windows), values.shape[-1]))
        for k, window in enumerate(self._windows):
            inside = values[tuple(part for part, _ in window)]
            for (_, weights), order in zip(window, orders):
                inside = np.tensordot((-1.0) ** order * weights[order], inside, axes=1)
            out[k] = inside
        return out

    def _products(self, x: Array, functions: Array, orders: tuple[int, ...]) -> Array:
        """The integrals of f D u for all functions f and fields u, with half of the derivatives moved to f φ.

        ``∫ f D u φ = (-1)^m ∫ D' u D" (f φ)`` with m the order of ``D"``, by the product rule. Where the order is odd, the mean
        of both ways to halve it: derivatives of the data then cancel in u u_x.
        """
        lines, total = self._axes(), sum(orders)
        means = []
        for kept in sorted({total // 2, total - total // 2}):
            stay: list[int] = []
            for order in orders:
                stay.append(min(order, kept - sum(stay)))
            moved = [order - still for order, still in zip(orders, stay)]
            field = self._derivative(x, stay, lines)[..., :, None]
            out: Any = 0.0
            for onto in product(*(range(order + 1) for order in moved)):
                both = field * self._derivative(functions, onto, lines)[..., None, :]
                rest = tuple(order - done for order, done in zip(moved, onto))
                share = prod(comb(order, done) for order, done in zip(moved, onto)) * (-1) ** sum(onto)
                out = out + share * self._integrals(both.reshape(*x.shape[:-1], -1), (*rest, 0))
            means.append(out)
        return np.asarray(np.mean(means, axis=0))

    def _still(self) -> tuple[int, ...]:
        """No derivative along any axis."""
        return (0,) * (self.spatiotemporal_grid.ndim - 1)

    def _columns(self, x: Array) -> Array:
        if x.shape[:-1] != self.spatiotemporal_grid.shape[:-1]:
            raise ValueError(f"x: expected the grid's shape {self.spatiotemporal_grid.shape[:-1]} first, found {x.shape}")
        functions = self._functions()._columns(x)
        columns = [self._integrals(np.ones((*x.shape[:-1], 1)), self._still())] if self.include_bias else []
        columns.append(self._integrals(functions, self._still()))
        columns += [self._integrals(x, (*orders, 0)) for orders in self._orders()]
        if self.include_interaction:
            columns += [self._products(x, functions, orders) for orders in self._orders()]
        return np.concatenate(columns, axis=-1)

    def weak_slopes(self, x: Array, x_dot: Array | None = None) -> Array:
        """The integrals of the slopes: those given, or those of `x`, moved to φ."""
        if x_dot is not None:
            return self._integrals(x_dot, self._still())
        return self._integrals(x, (*self._still()[:-1], 1))
