"""Candidate terms of one row under PySINDy's names, evaluated by NumPy."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Sequence
from functools import reduce
from itertools import combinations, combinations_with_replacement
from typing import Any, TypeVar

import numpy as np
from sklearn.base import BaseEstimator
from sklearn.utils.validation import check_is_fitted

from ..._data import Array

Self = TypeVar("Self", bound="BaseFeatureLibrary")


def _array(x: Any) -> Array:
    """An array with the variables on its last axis."""
    out = np.asarray(x.toarray() if hasattr(x, "toarray") else x, dtype=np.float64)
    return out.reshape(-1, 1) if out.ndim == 1 else out


class BaseFeatureLibrary(BaseEstimator):  # type: ignore[misc]
    """What all libraries share. A library of one's own defines `_size`, `_columns` and `_names`.

    Attributes
    ----------
    n_features_in_ : int
        Variables.
    n_output_features_ : int
        Terms.
    """

    n_features_in_: int
    n_output_features_: int

    def _size(self, variables: int) -> int:
        """The number of terms of so many variables."""
        raise NotImplementedError

    def _columns(self, x: Array) -> Array:
        """The terms on the last axis."""
        raise NotImplementedError

    def _names(self, variables: list[str]) -> list[str]:
        """The terms' names."""
        raise NotImplementedError

    def _fitted(self) -> None:
        if type(self)._columns is BaseFeatureLibrary._columns:
            raise NotImplementedError
        check_is_fitted(self, "n_features_in_")

    def fit(self: Self, x: Any, y: Any = None) -> Self:
        """Learns the number of variables from an array, or a list with one for each trajectory."""
        variables = _array(x[0] if isinstance(x, (list, tuple)) else x).shape[-1]
        self.n_output_features_ = self._size(variables)
        self.n_features_in_ = variables
        return self

    def transform(self, x: Any) -> Any:
        """The terms' values on the last axis; a list where `x` is one."""
        self._fitted()
        if isinstance(x, (list, tuple)):
            return [self.transform(run) for run in x]
        values = _array(x)
        if values.shape[-1] != self.n_features_in_:
            raise ValueError(f"x: expected {self.n_features_in_} variables, found {values.shape[-1]}")
        return self._columns(values)

    def fit_transform(self, x: Any, y: Any = None) -> Any:
        """`fit`, then `transform`."""
        return self.fit(x).transform(x)

    def get_feature_names(self, input_features: Sequence[str] | None = None) -> list[str]:
        """The terms' names over the names given, or over ``x0, x1, …``."""
        self._fitted()
        if input_features is None:
            return self._names([f"x{k}" for k in range(self.n_features_in_)])
        return self._names([str(name) for name in input_features])

    @property
    def size(self) -> int:
        """The number of terms."""
        self._fitted()
        return self.n_output_features_

    def __add__(self, other: BaseFeatureLibrary) -> ConcatLibrary:
        return ConcatLibrary([self, other])

    def __mul__(self, other: BaseFeatureLibrary) -> TensoredLibrary:
        return TensoredLibrary([self, other])


class PolynomialLibrary(BaseFeatureLibrary):
    """Monomials up to a degree.

    Parameters
    ----------
    degree : int
        The highest degree.
    include_interaction : bool
        Whether products of several variables are terms.
    interaction_only : bool
        Whether variables occur at most once in a term.
    include_bias : bool
        Whether 1 is a term.
    order : {"C", "F"}
        Memory order of the values.

    Examples
    --------
    >>> import numpy as np
    >>> PolynomialLibrary(degree=2).fit(np.ones((3, 2))).get_feature_names(["a", "b"])
    ['1', 'a', 'b', 'a^2', 'a b', 'b^2']
    """

    def __init__(
        self,
        degree: int = 2,
        include_interaction: bool = True,
        interaction_only: bool = False,
        include_bias: bool = True,
        order: str = "C",
    ) -> None:
        self.degree = degree
        self.include_interaction = include_interaction
        self.interaction_only = interaction_only
        self.include_bias = include_bias
        self.order = order

    def _factors(self, variables: int) -> list[tuple[int, ...]]:
        """The variables whose product is the term, for each term."""
        if not isinstance(self.degree, (int, np.integer)) or self.degree < 0:
            raise ValueError(f"degree: expected a whole number of at least 0, found {self.degree}")
        if self.interaction_only and not self.include_interaction:
            raise ValueError("interaction_only: expected include_interaction with it, found it set to False")
        terms: list[tuple[int, ...]] = [()] if self.include_bias else []
        for degree in range(1, self.degree + 1):
            if not self.include_interaction:
                terms += [(k,) * degree for k in range(variables)]
            else:
                choose = combinations if self.interaction_only else combinations_with_replacement
                terms += choose(range(variables), degree)
        return terms

    def fit(self: Self, x: Any, y: Any = None) -> Self:
        """Learns the number of variables."""
        self._size(0)  # settings are checked before data
        return super().fit(x)

    def _size(self, variables: int) -> int:
        return len(self._factors(variables))

    @property
    def powers_(self) -> Any:
        """Exponents: one row for each term, one column for each variable."""
        self._fitted()
        factors = self._factors(self.n_features_in_)
        rows = [np.bincount(f, minlength=self.n_features_in_) for f in factors if f]
        bias = [np.zeros(self.n_features_in_, dtype=np.int64)] * (len(factors) - len(rows))
        return np.array(bias + rows).reshape(len(factors), self.n_features_in_)

    def _columns(self, x: Array) -> Array:
        terms = self._factors(x.shape[-1])
        out = np.empty((*x.shape[:-1], len(terms)), order="F" if self.order == "F" else "C")
        place = {term: k for k, term in enumerate(terms)}
        for k, term in enumerate(terms):
            if not term:
                out[..., k] = 1.0
            elif len(term) == 1:
                out[..., k] = x[..., term[0]]
            elif term[:-1] in place:  # the term without its last factor is there already
                np.multiply(out[..., place[term[:-1]]], x[..., term[-1]], out=out[..., k])
            else:
                out[..., k] = np.prod(x[..., list(term)], axis=-1)
        return out

    def _names(self, variables: list[str]) -> list[str]:
        def power(name: str, exponent: int) -> str:
            return name if exponent == 1 else f"{name}^{exponent}"

        rows = self._factors(len(variables))
        return [" ".join(power(variables[k], f.count(k)) for k in dict.fromkeys(f)) or "1" for f in rows]


class IdentityLibrary(BaseFeatureLibrary):
    """The variables themselves."""

    def _size(self, variables: int) -> int:
        return variables

    def _columns(self, x: Array) -> Array:
        return x.copy()

    def _names(self, variables: list[str]) -> list[str]:
        return list(variables)


class FourierLibrary(BaseFeatureLibrary):
    """Sines and cosines of whole multiples of each variable.

    Parameters
    ----------
    n_frequencies : int
        The highest multiple.
    include_sin, include_cos : bool
        Which of both are terms.

    Examples
    --------
    >>> import numpy as np
    >>> FourierLibrary().fit(np.ones((3, 1))).get_feature_names()
    ['sin(1 x0)', 'cos(1 x0)']
    """

    def __init__(self, n_frequencies: int = 1, include_sin: bool = True, include_cos: bool = True) -> None:
        if not isinstance(n_frequencies, (int, np.integer)) or n_frequencies < 1:
            raise ValueError(f"n_frequencies: expected a whole number of at least 1, found {n_frequencies}")
        if not (include_sin or include_cos):
            raise ValueError("include_sin, include_cos: expected one of them at least, found neither")
        self.n_frequencies = n_frequencies
        self.include_sin = include_sin
        self.include_cos = include_cos

    def _waves(self) -> list[tuple[str, Callable[[Array], Array]]]:
        waves: list[tuple[str, Callable[[Array], Array], bool]] = [
            ("sin", np.sin, self.include_sin),
            ("cos", np.cos, self.include_cos),
        ]
        return [(name, function) for name, function, chosen in waves if chosen]

    def _size(self, variables: int) -> int:
        return variables * self.n_frequencies * len(self._waves())

    def _columns(self, x: Array) -> Array:
        multiples = range(1, self.n_frequencies + 1)
        columns = [f(m * x[..., k]) for m in multiples for k in range(x.shape[-1]) for _, f in self._waves()]
        return np.stack(columns, axis=-1)

    def _names(self, variables: list[str]) -> list[str]:
        multiples = range(1, self.n_frequencies + 1)
        return [f"{wave}({m} {name})" for m in multiples for name in variables for wave, _ in self._waves()]


def _arguments(function: Any) -> int:
    """How many variables a function takes."""
    if isinstance(function, np.ufunc):
        return function.nin
    kinds = (inspect.Parameter.POSITIONAL_ONLY, inspect.Parameter.POSITIONAL_OR_KEYWORD)
    given = inspect.signature(function).parameters.values()
    return sum(p.kind in kinds and p.default is inspect.Parameter.empty for p in given)


class CustomLibrary(BaseFeatureLibrary):
    """Functions of one or more variables, each applied to every choice of variables.

    Parameters
    ----------
    library_functions : list of callable
        Functions of arrays; NumPy's own will do.
    function_names : list of callable, optional
        Functions of the variables' names that give the term's name.
    interaction_only : bool
        Whether the arguments of a function are different variables.
    include_bias : bool
        Whether 1 is a term.

    Examples
    --------
    >>> import numpy as np
    >>> library = CustomLibrary([np.exp, lambda x, y: x * y]).fit(np.ones((3, 2)))
    >>> library.get_feature_names()
    ['f0(x0)', 'f0(x1)', 'f1(x0,x1)']
    """

    def __init__(
        self,
        library_functions: Sequence[Callable[..., Any]],
        function_names: Sequence[Callable[..., str]] | None = None,
        interaction_only: bool = True,
        include_bias: bool = False,
    ) -> None:
        if function_names is not None and len(function_names) != len(library_functions):
            raise ValueError(f"function_names: expected {len(library_functions)}, found {len(function_names)}")
        self.library_functions = library_functions
        self.function_names = function_names
        self.interaction_only = interaction_only
        self.include_bias = include_bias

    def _choices(self, function: Any, variables: int) -> list[tuple[int, ...]]:
        choose = combinations if self.interaction_only else combinations_with_replacement
        return list(choose(range(variables), _arguments(function)))

    def _size(self, variables: int) -> int:
        return self.include_bias + sum(len(self._choices(f, variables)) for f in self.library_functions)

    def _columns(self, x: Array) -> Array:
        columns: list[Any] = [1.0] if self.include_bias else []
        for function in self.library_functions:
            columns += [function(*(x[..., k] for k in c)) for c in self._choices(function, x.shape[-1])]
        out = np.empty((*x.shape[:-1], len(columns)))
        for k, column in enumerate(columns):
            out[..., k] = column
        return out

    def _names(self, variables: list[str]) -> list[str]:
        names = ["1"] if self.include_bias else []
        for i, function in enumerate(self.library_functions):
            for choice in self._choices(function, len(variables)):
                given = [variables[k] for k in choice]
                text = f"f{i}({','.join(given)})" if self.function_names is None else self.function_names[i](*given)
                names.append(text)
        return names


class ConcatLibrary(BaseFeatureLibrary):
    """The terms of several libraries, one after another.

    Parameters
    ----------
    libraries : list of BaseFeatureLibrary
    """

    def __init__(self, libraries: Sequence[BaseFeatureLibrary]) -> None:
        self.libraries = libraries

    def _size(self, variables: int) -> int:
        return sum(library._size(variables) for library in self.libraries)

    def _columns(self, x: Array) -> Array:
        return np.concatenate([library._columns(x) for library in self.libraries], axis=-1)

    def _names(self, variables: list[str]) -> list[str]:
        return [name for library in self.libraries for name in library._names(variables)]


def _picked(inputs: Sequence[Sequence[int]] | None, count: int, variables: int) -> list[list[int]]:
    """The variables of each library, checked."""
    if inputs is None:
        return [list(range(variables))] * count
    if len(inputs) != count:
        raise ValueError(f"inputs_per_library: expected {count} lists, one for each library; found {len(inputs)}")
    for k in (k for one in inputs for k in one):
        if not 0 <= k < variables:
            raise ValueError(f"inputs_per_library: expected indices from 0 to {variables - 1}, found {k}")
    return [list(one) for one in inputs]


class TensoredLibrary(BaseFeatureLibrary):
    """All products of one term of each library.

    Parameters
    ----------
    libraries : list of BaseFeatureLibrary
    inputs_per_library : list of list of int, optional
        Indices of the variables that each library sees; all of them by default.
    """

    def __init__(
        self, libraries: Sequence[BaseFeatureLibrary], inputs_per_library: Sequence[Sequence[int]] | None = None
    ) -> None:
        self.libraries = libraries
        self.inputs_per_library = inputs_per_library

    def _parts(self, variables: int) -> list[tuple[BaseFeatureLibrary, list[int]]]:
        return list(zip(self.libraries, _picked(self.inputs_per_library, len(self.libraries), variables)))

    def _size(self, variables: int) -> int:
        return reduce(lambda n, part: n * part[0]._size(len(part[1])), self._parts(variables), 1)

    def _columns(self, x: Array) -> Array:
        out = np.ones((*x.shape[:-1], 1))
        for library, seen in self._parts(x.shape[-1]):
            columns = library._columns(x[..., seen])
            out = (out[..., :, None] * columns[..., None, :]).reshape(*x.shape[:-1], -1)
        return out

    def _names(self, variables: list[str]) -> list[str]:
        out = [""]
        for library, seen in self._parts(len(variables)):
            names = library._names([variables[k] for k in seen])
            out = [f"{a} {b}".strip() for a in out for b in names]
        return out


class GeneralizedLibrary(BaseFeatureLibrary):
    """Libraries of some variables each, one after another, and products of some of them.

    Parameters
    ----------
    libraries : list of BaseFeatureLibrary
    tensor_array : list of list of int, optional
        One row for each product, with 1 for the libraries in it and 0 for the others.
    inputs_per_library : list of list of int, optional
        Indices of the variables that each library sees; all of them by default.
    exclude_libraries : list of int
        Libraries that only occur in products.
    """

    def __init__(
        self,
        libraries: Sequence[BaseFeatureLibrary],
        tensor_array: Any = None,
        inputs_per_library: Sequence[Sequence[int]] | None = None,
        exclude_libraries: Sequence[int] = (),
    ) -> None:
        if len(libraries) == 0:
            raise ValueError("libraries: expected one at least, found none")
        if tensor_array is not None:
            rows = np.asarray(tensor_array)
            if rows.ndim != 2 or rows.shape[1] != len(libraries):
                raise ValueError(f"tensor_array: expected rows of {len(libraries)}, found the shape {rows.shape}")
            if not np.isin(rows, (0, 1)).all() or (rows.sum(axis=1) < 2).any():
                raise ValueError("tensor_array: expected 0 and 1, with two libraries in each row at least")
        self.libraries = libraries
        self.tensor_array = tensor_array
        self.inputs_per_library = inputs_per_library
        self.exclude_libraries = exclude_libraries

    def _parts(self, variables: int) -> list[TensoredLibrary]:
        """Single libraries, then products, each as a product over its variables."""
        count = len(self.libraries)
        seen = _picked(self.inputs_per_library, count, variables)
        chosen = [[k] for k in range(count) if k not in self.exclude_libraries]
        if self.tensor_array is not None:
            chosen += [np.flatnonzero(row).tolist() for row in np.asarray(self.tensor_array)]
        return [TensoredLibrary([self.libraries[k] for k in some], [seen[k] for k in some]) for some in chosen]

    def _size(self, variables: int) -> int:
        return sum(part._size(variables) for part in self._parts(variables))

    def _columns(self, x: Array) -> Array:
        return np.concatenate([part._columns(x) for part in self._parts(x.shape[-1])], axis=-1)

    def _names(self, variables: list[str]) -> list[str]:
        return [name for part in self._parts(len(variables)) for name in part._names(variables)]
