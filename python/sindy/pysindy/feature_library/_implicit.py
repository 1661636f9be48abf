"""Candidate terms with slopes, for implicit equations."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from ..._data import Array
from ..differentiation import BaseDifferentiation, FiniteDifference
from ._pointwise import BaseFeatureLibrary, CustomLibrary


class SINDyPILibrary(BaseFeatureLibrary):
    """Functions of the variables, functions of their slopes, and all products of one of each.

    Parameters
    ----------
    library_functions : list of callable, optional
        Functions of the variables, as for `CustomLibrary`.
    t : array
        The times of the rows, for the slopes.
    x_dot_library_functions : list of callable, optional
        Functions of the slopes.
    function_names : list of callable, optional
        Functions of names that give the terms' names: those of `library_functions`, then those of `x_dot_library_functions`.
    interaction_only : bool
        Whether the arguments of a function are different variables.
    differentiation_method : BaseDifferentiation, optional
        What gives the slopes; `FiniteDifference` by default. Slopes that it leaves out are 0.
    include_bias : bool
        Whether 1 is a term.

    Examples
    --------
    >>> import numpy as np
    >>> library = SINDyPILibrary([lambda x: x], np.arange(3.0), [lambda x: x], [lambda x: x, lambda x: x], include_bias=True)
    >>> library.fit(np.ones((3, 2))).get_feature_names(["a", "b"])
    ['1', 'a', 'b', 'a_dot', 'b_dot', 'aa_dot', 'ba_dot', 'ab_dot', 'bb_dot']
    """

    def __init__(
        self,
        library_functions: Sequence[Callable[..., Any]] | None = None,
        t: Any = None,
        x_dot_library_functions: Sequence[Callable[..., Any]] | None = None,
        function_names: Sequence[Callable[..., str]] | None = None,
        interaction_only: bool = True,
        differentiation_method: BaseDifferentiation | None = None,
        include_bias: bool = False,
    ) -> None:
        if library_functions is None and x_dot_library_functions is None:
            raise ValueError("library_functions, x_dot_library_functions: expected one of them at least, found neither")
        if x_dot_library_functions is not None and t is None:
            raise ValueError("t: expected times with x_dot_library_functions, found none")
        count = len(library_functions or ()) + len(x_dot_library_functions or ())
        if function_names is not None and len(function_names) != count:
            raise ValueError(f"function_names: expected {count}, found {len(function_names)}")
        self.library_functions = library_functions
        self.t = t
        self.x_dot_library_functions = x_dot_library_functions
        self.function_names = function_names
        self.interaction_only = interaction_only
        self.differentiation_method = differentiation_method
        self.include_bias = include_bias

    def _parts(self) -> tuple[CustomLibrary, CustomLibrary]:
        """The functions of the variables, and those of the slopes."""
        first, second = list(self.library_functions or ()), list(self.x_dot_library_functions or ())
        names = self.function_names
        of_slopes = [_named(f"f_dot{k}") for k in range(len(second))] if names is None else names[len(first) :]
        return (
            CustomLibrary(first, None if names is None else names[: len(first)], self.interaction_only),
            CustomLibrary(second, of_slopes, self.interaction_only),
        )

    def _size(self, variables: int) -> int:
        first, second = (part._size(variables) for part in self._parts())
        return self.include_bias + first + second + first * second

    def _columns(self, x: Array) -> Array:
        functions, of_slopes = self._parts()
        first = functions._columns(x)
        if self.x_dot_library_functions is None:
            second = x[..., :0]
        else:
            method = self.differentiation_method or FiniteDifference()
            second = of_slopes._columns(np.nan_to_num(np.asarray(method(x, self.t))))
        both = (second[..., :, None] * first[..., None, :]).reshape(*x.shape[:-1], -1)
        bias = [np.ones((*x.shape[:-1], 1))] if self.include_bias else []
        return np.concatenate([*bias, first, second, both], axis=-1)

    def _names(self, variables: list[str]) -> list[str]:
        functions, of_slopes = self._parts()
        first, second = functions._names(variables), of_slopes._names([f"{name}_dot" for name in variables])
        return (["1"] if self.include_bias else []) + first + second + [a + b for b in second for a in first]


def _named(name: str) -> Callable[..., str]:
    return lambda *given: f"{name}({','.join(given)})"
