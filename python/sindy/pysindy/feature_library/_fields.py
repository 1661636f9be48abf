"""Candidate terms with derivatives in space under PySINDy's names."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Sequence
from itertools import product
from typing import Any

import numpy as np

from ..._data import Array
from ..differentiation import FiniteDifference
from ._pointwise import BaseFeatureLibrary, PolynomialLibrary


class PDELibrary(BaseFeatureLibrary):
    """Functions of fields, the fields' derivatives in space, and products of both.

    Fields stand in arrays with the axes of space first, then time, then the fields themselves.

    Parameters
    ----------
    function_library : BaseFeatureLibrary, optional
        Functions of the fields; by default ``PolynomialLibrary(degree=3, include_bias=False)``.
    derivative_order : int
        Highest order of derivatives, mixed ones as well.
    spatial_grid : ndarray, optional
        Coordinates: of shape (n,) in one dimension of space, of shape (n, m, 2) in two, and so on. Those of an axis must not
        depend on the other axes.
    include_bias : bool
        Whether 1 is a term.
    include_interaction : bool
        Whether products of functions and derivatives are terms.
    multiindices : array of int, optional
        The orders along each axis, one row for each derivative; by default all up to `derivative_order`.
    differentiation_method : callable
        ``differentiation_method(d=order, axis=axis, **diff_kwargs)`` gives a function of the fields and the coordinates.
    diff_kwargs : dict, optional
        Its settings.
    implicit_terms : bool
        Whether derivatives in time are terms as well. In names time has the number after the last axis of space.
    temporal_grid : ndarray, optional
        The times, if, and only if, `implicit_terms` is set.
    is_uniform, periodic
        There for compatibility: they do nothing but warn. Their place is `diff_kwargs`.

    Examples
    --------
    >>> import numpy as np
    >>> library = PDELibrary(PolynomialLibrary(1, include_bias=False), derivative_order=2, spatial_grid=np.arange(5.0))
    >>> library.fit(np.ones((5, 3, 1))).get_feature_names(["u"])
    ['u', 'u_1', 'u_11', 'uu_1', 'uu_11']
    """

    def __init__(
        self,
        function_library: BaseFeatureLibrary | None = None,
        derivative_order: int = 0,
        spatial_grid: Any = None,
        temporal_grid: Any = None,
        include_bias: bool = False,
        include_interaction: bool = True,
        implicit_terms: bool = False,
        multiindices: Any = None,
        differentiation_method: Callable[..., Any] = FiniteDifference,
        diff_kwargs: dict[str, Any] | None = None,
        is_uniform: bool | None = None,
        periodic: bool | None = None,
    ) -> None:
        if derivative_order < 0:
            raise ValueError(f"derivative_order: expected a number of at least 0, found {derivative_order}")
        if implicit_terms != (temporal_grid is not None):
            raise ValueError("implicit_terms, temporal_grid: expected both or neither, found one")
        if temporal_grid is not None and np.ndim(temporal_grid) != 1:
            raise ValueError(f"temporal_grid: expected one axis, found {np.ndim(temporal_grid)}")
        without = spatial_grid is None and temporal_grid is None
        if derivative_order > 0 and without or derivative_order == 0 and spatial_grid is not None:
            raise ValueError("spatial_grid, derivative_order: expected both or neither, found one")
        if is_uniform is not None or periodic is not None:
            warnings.warn("is_uniform, periodic: expected in diff_kwargs; as arguments they do nothing", stacklevel=2)
        self.function_library = function_library
        self.derivative_order = derivative_order
        self.spatial_grid = spatial_grid
        self.temporal_grid = temporal_grid
        self.include_bias = include_bias
        self.include_interaction = include_interaction
        self.implicit_terms = implicit_terms
        self.multiindices = multiindices
        self.differentiation_method = differentiation_method
        self.diff_kwargs = diff_kwargs
        self.is_uniform = is_uniform
        self.periodic = periodic

    def _functions(self) -> BaseFeatureLibrary:
        if self.function_library is None:
            return PolynomialLibrary(degree=3, include_bias=False)
        return self.function_library

    def _axes(self) -> list[Array]:
        """The coordinates of each axis along which there are derivatives."""
        times = [np.asarray(self.temporal_grid, dtype=np.float64)] if self.implicit_terms else []
        if self.spatial_grid is None:
            return times
        return self._lines(self.spatial_grid) + times

    @staticmethod
    def _lines(coordinates: Any) -> list[Array]:
        """The coordinates along each axis of a grid."""
        grid = np.asarray(coordinates, dtype=np.float64)
        grid = grid[:, None] if grid.ndim == 1 else grid
        dimensions = grid.ndim - 1
        if grid.shape[-1] != dimensions:
            raise ValueError(f"grid: expected {dimensions} coordinates of {dimensions} axes, found {grid.shape[-1]}")
        lines = []
        for axis in range(dimensions):
            along = np.moveaxis(grid[..., axis], axis, -1)
            line = along[(0,) * (dimensions - 1)]
            if not np.allclose(along, line, rtol=1e-9):
                raise ValueError(f"grid: expected coordinates of axis {axis} that do not depend on other axes")
            lines.append(np.array(line))
        return lines

    def _orders(self) -> list[tuple[int, ...]]:
        """The orders along each axis, for each derivative."""
        dimensions = len(self._axes())
        if self.multiindices is not None:
            return [tuple(int(order) for order in np.atleast_1d(one)) for one in self.multiindices]
        every = product(range(self.derivative_order + 1), repeat=dimensions)
        return [orders for orders in every if 0 < sum(orders) <= self.derivative_order]

    def _size(self, variables: int) -> int:
        functions, derivatives = self._functions()._size(variables), variables * len(self._orders())
        return self.include_bias + functions + derivatives + self.include_interaction * functions * derivatives

    def _derivative(self, x: Array, orders: Sequence[int], lines: list[Array]) -> Array:
        """The derivative of some orders along each axis."""
        for axis, order in enumerate(orders):
            if order > 0:
                method = self.differentiation_method(d=order, axis=axis, **(self.diff_kwargs or {}))
                x = np.asarray(method(x, lines[axis]))
        return x

    def _derivatives(self, x: Array) -> Array:
        """The derivatives on the last axis, those of one order for all fields together."""
        lines = self._axes()
        if x.shape[: len(lines)] != tuple(len(line) for line in lines):
            raise ValueError(f"x: expected the grid's {[len(line) for line in lines]} points first, found {x.shape}")
        columns = [self._derivative(x, orders, lines) for orders in self._orders()]
        return np.concatenate([x[..., :0], *columns], axis=-1)

    def _columns(self, x: Array) -> Array:
        functions, derivatives = self._functions()._columns(x), self._derivatives(x)
        columns = [np.ones((*x.shape[:-1], 1))] if self.include_bias else []
        columns += [functions, derivatives]
        if self.include_interaction:
            both = derivatives[..., :, None] * functions[..., None, :]
            columns.append(both.reshape(*x.shape[:-1], -1))
        return np.concatenate(columns, axis=-1)

    def _names(self, variables: Sequence[str]) -> list[str]:
        functions = self._functions()._names(list(variables))
        which = ["".join(str(axis + 1) * order for axis, order in enumerate(orders)) for orders in self._orders()]
        derivatives = [f"{name}_{one}" for one in which for name in variables]
        names = (["1"] if self.include_bias else []) + functions + derivatives
        return names + [f + d for d in derivatives for f in functions] if self.include_interaction else names
