"""From what a user has (arrays, lists of arrays, tables) to trajectories."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ._errors import fault

Array = NDArray[np.float64]
Given = tuple[Array, Array, "Array | None", "Array | None"]


@dataclass
class Trajectory:
    """One run: states, and what was given beside them."""

    x: Array
    t: Array | None
    u: Array | None
    x_dot: Array | None
    weight: Array | None

    def times(self) -> Array:
        """The times, which have to be known."""
        if self.t is None:
            raise fault("t", "a step of time, times, or the name of the column of times", "none")
        return self.t


@dataclass
class Data:
    """Trajectories of the same states and inputs."""

    trajectories: list[Trajectory]
    states: list[str]
    inputs: list[str]
    many: bool

    def given(self) -> list[Given]:
        """For the library: times, states, inputs, weights."""
        return [(r.times(), r.x, r.u, r.weight) for r in self.trajectories]


def floats(what: str, values: Any, expected: str) -> Array:
    """Numbers as float64, without a copy where they are; what is masked is NaN."""
    if isinstance(values, np.ma.MaskedArray) and values.dtype.kind in "biuf":
        values = np.ma.filled(values.astype(np.float64), np.nan)
    try:
        array = np.asarray(values)
        if array.dtype.kind in "mMcSU":
            raise TypeError
        out: Array = np.asarray(array, dtype=np.float64)
    except (TypeError, ValueError, OverflowError):
        raise fault(what, expected, _kind(values)) from None
    return out


def seconds(what: str, values: Any) -> Array:
    """Times in seconds. Dates are counted from the first, durations are converted."""
    expected = "times in seconds, dates or durations"
    kind = getattr(values, "dtype", None)
    if isinstance(kind, np.dtype) and kind.kind in "mM":
        missing: Any = np.array("NaT", kind)  # NumPy's stubs know no dates here
        array: Any = np.ma.filled(values, missing).reshape(-1)
        if kind.kind == "M":
            array = array - array[:1]
        return np.asarray(array / np.timedelta64(1, "s"), dtype=np.float64)
    return floats(what, values, expected)


class Table:
    """Named columns of pandas, polars, Arrow, or anything with ``__arrow_c_stream__``."""

    def __init__(self, names: list[str], columns: list[Any]) -> None:
        self.names = names
        self.columns = columns

    def column(self, name: str) -> Any:
        """One column, as it is."""
        if name not in self.names:
            raise fault("names", "one of " + ", ".join(self.names), name)
        return self.columns[self.names.index(name)]

    def matrix(self, names: Sequence[str]) -> Array:
        """Columns side by side."""
        out = np.empty((len(self.columns[0]) if self.columns else 0, len(names)), order="F")
        for k, name in enumerate(names):
            out[:, k] = floats(name, self.column(name), "a column of numbers")
        return out


def table(x: Any) -> Table | None:
    """The table that `x` is, or none."""
    if isinstance(x, (np.ndarray, list, tuple)) or len(getattr(x, "shape", (0, 0))) == 1:
        return None
    if hasattr(x, "iloc") and hasattr(x, "columns"):  # pandas
        columns = [x.iloc[:, k].to_numpy() for k in range(x.shape[1])]
        return Table([str(name) for name in x.columns], columns)
    if hasattr(x, "get_columns"):  # polars
        return Table(list(x.columns), [c.to_numpy() for c in x.get_columns()])
    if hasattr(x, "__arrow_c_stream__") and not hasattr(x, "column_names"):
        import pyarrow

        try:
            x = pyarrow.table(x)
        except (pyarrow.ArrowInvalid, TypeError, ValueError):
            return None  # one column
    if hasattr(x, "column_names"):  # pyarrow
        columns = [x.column(k).to_numpy() for k in range(x.num_columns)]
        return Table(list(x.column_names), columns)
    return None


def matrix(what: str, values: ArrayLike) -> Array:
    """A matrix of numbers; float64 arrays are taken as they are."""
    expected = "a matrix of numbers, one row for each time"
    array: Array = np.require(floats(what, values, expected), requirements="A")
    if array.ndim == 1:
        array = array.reshape(-1, 1)
    if array.ndim != 2:
        raise fault(what, "a matrix, one row for each time", f"{array.ndim} dimensions")
    return array


def _kind(values: Any) -> str:
    dtype = getattr(values, "dtype", None)
    return type(values).__name__ if dtype is None else f"{type(values).__name__} of {dtype}"


def vector(what: str, values: ArrayLike, rows: int) -> Array:
    """As many numbers as there are rows."""
    array = np.ascontiguousarray(floats(what, values, "numbers, one for each row").reshape(-1))
    if len(array) != rows:
        raise fault(what, f"{rows} numbers, one for each row", len(array))
    return array


def is_many(x: Any) -> bool:
    """Whether `x` is a list of trajectories: of tables, matrices, or arrays of one state."""
    if not isinstance(x, (list, tuple)) or not x:
        return False
    return all(table(r) is not None or getattr(r, "ndim", 0) in (1, 2) for r in x)


def _each(what: str, values: Any, count: int, many: bool) -> list[Any]:
    """One of `values` for each trajectory."""
    if not many:
        return [values]
    if values is None or np.isscalar(values):
        return [values] * count
    if not isinstance(values, (list, tuple)) or len(values) != count:
        found = len(values) if isinstance(values, (list, tuple)) else type(values).__name__
        raise fault(what, f"a list of {count}, one for each trajectory", found)
    return list(values)


def _times(t: Any, rows: int, columns: Table | None) -> Array | None:
    if t is None:
        return None
    if isinstance(t, str):
        if columns is None:
            raise fault("t", "a step or times; names are of columns of a table", t)
        return seconds(t, columns.column(t))
    if np.ndim(t) == 0 and not hasattr(t, "__len__"):
        step = float(floats("t", t, "a step of time above 0, or times"))
        if not (step > 0.0 and np.isfinite(step)):
            raise fault("t", "a step of time above 0", t)
        return np.arange(rows, dtype=np.float64) * np.float64(step)
    return vector("t", seconds("t", t), rows)


def _names(prefix: str, given: Sequence[str] | None, count: int, what: str) -> list[str]:
    if given is None:
        return [f"{prefix}{k}" for k in range(count)]
    names = [str(name) for name in given]
    if len(names) != count:
        raise fault(what, f"{count} names, one for each column", f"{len(names)} ({', '.join(names)})")
    for name in names:
        if not name.isprintable() or "=" in name:
            raise fault(what, "names without control characters and equals signs", repr(name))
    return names


def _of_table(
    x: Table, t: Any, states: Sequence[str] | None, inputs: Sequence[str] | None, u: Any
) -> tuple[list[str], list[str]]:
    """Which columns of a table are states, and which inputs."""
    own = [str(name) for name in inputs or []] if u is None else []
    if states is not None:
        return [str(name) for name in states], own
    of_time = t if isinstance(t, str) else None
    return [name for name in x.names if name != of_time and name not in own], own


def _split(groups: Any, rows: int) -> list[slice]:
    """Stretches of rows with one label."""
    labels = np.asarray(groups).reshape(-1)
    if len(labels) != rows:
        raise fault("groups", f"{rows} labels, one for each row", len(labels))
    cuts = [0, *(np.flatnonzero(labels[1:] != labels[:-1]) + 1).tolist(), rows]
    return [slice(a, b) for a, b in zip(cuts[:-1], cuts[1:])]


def _rows(what: str, array: Array | None, rows: int, columns: int | None) -> None:
    if array is not None and len(array) != rows:
        raise fault(what, f"{rows} rows, those of x", len(array))
    if array is not None and columns is not None and array.shape[1] != columns:
        raise fault(what, f"{columns} columns", array.shape[1])


def collect(
    x: Any,
    t: Any = None,
    u: Any = None,
    x_dot: Any = None,
    weight: Any = None,
    groups: Any = None,
    states: Sequence[str] | None = None,
    inputs: Sequence[str] | None = None,
) -> Data:
    """The trajectories of `x` with all that belongs to them."""
    states = None if states is None else [str(name) for name in states]
    inputs = None if inputs is None else [str(name) for name in inputs]
    many = is_many(x)
    runs = list(x) if many else [x]
    given = [_each(n, v, len(runs), many) for n, v in (("t", t), ("u", u), ("x_dot", x_dot), ("sample_weight", weight))]
    if groups is not None and many:
        raise fault("groups", "none where x is a list of trajectories", "labels")
    out: list[Trajectory] = []
    names: tuple[list[str], list[str]] | None = None
    for k, run in enumerate(runs):
        run_t, run_u, run_dot, run_weight = (values[k] for values in given)
        columns = table(run)
        inputs_of = table(run_u) if run_u is not None else None
        if inputs_of is not None:
            own = list(inputs or inputs_of.names)
            inputs, run_u = own, inputs_of.matrix(own)
        if columns is not None:
            of_states, of_inputs = _of_table(columns, run_t, states, inputs, run_u)
            array = columns.matrix(of_states)
            run_u = columns.matrix(of_inputs) if of_inputs else run_u
            states = of_states
            inputs = of_inputs or inputs
        else:
            array = matrix("x", run)
        u_array = None if run_u is None else matrix("u", run_u)
        dots = table(run_dot) if run_dot is not None else None
        rows, m = array.shape
        if dots is not None and states is not None and set(states) <= set(dots.names):
            dot: Array | None = dots.matrix(states)  # by name; else in the order of its columns
        else:
            dot = None if run_dot is None else dots.matrix(dots.names) if dots else matrix("x_dot", run_dot)
        if names is None:
            count = 0 if u_array is None else u_array.shape[1]
            if inputs and u_array is None:
                raise fault("u", "inputs for " + ", ".join(inputs), "none")
            names = (_names("x", states, m, "states"), _names("u", inputs, count, "inputs"))
        _rows("x", array, rows, len(names[0]))
        _rows("u", u_array, rows, len(names[1]))
        _rows("x_dot", dot, rows, m)
        if u_array is None and names[1]:
            raise fault("u", "inputs for " + ", ".join(names[1]), "none")
        time = _times(run_t, rows, columns)
        w = None if run_weight is None else vector("sample_weight", run_weight, rows)
        for part in [slice(0, rows)] if groups is None else _split(groups, rows):
            cut = [None if a is None else a[part] for a in (time, u_array, dot, w)]
            out.append(Trajectory(array[part], cut[0], cut[1], cut[2], cut[3]))
    assert names is not None
    return Data(out, names[0], names[1], many)
