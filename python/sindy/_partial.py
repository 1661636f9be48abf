"""Partial sums of the automatic call."""

from __future__ import annotations

import copy
import json
from collections.abc import Callable, Sequence
from typing import Any

from . import _native
from ._data import Array, Data, collect
from ._errors import fault
from ._library import libraries
from ._model import SINDy
from ._settings import automatic, check
from ._solvers import dumps, threads

Arrays = list[list[Array]]
DATA = ("x", "t", "u", "sample_weight", "groups")


def _collect(data: dict[str, Any], states: Sequence[str] | None, inputs: Sequence[str] | None) -> Data:
    for name in data:
        if name not in DATA:
            raise fault("read", "data called " + ", ".join(DATA), name)
    x, t, u, weight, groups = (data.get(name) for name in DATA)
    if x is None:
        raise fault("read", "the states `x`", ", ".join(data) or "nothing")
    return collect(x, t, u, None, weight, groups, states, inputs)


class PartialSums:
    """What one pass over some of many files leaves: added file by file, merged over processes, ended to a model.

    The automatic call without output error, for rows that need not fit into memory. The sums of the files are added as a
    binary tree over their numbers, so every division among processes and every order give the same bits. The first 50 000
    rows of all files decide how slopes are taken; `sindy.dist.fit` does all of this on the workers of an executor.

    Parameters
    ----------
    model : SINDy
        Library, settings and names. It has no solver, no known parts, signs or invariants, and not the method ``output_error``.
    names : sequence of str
        Names of all files (or whatever holds whole trajectories), in the order of summation.
    read : callable
        Gives the data of the file with this number: a dict of ``x``, ``t``, and if there are any ``u``, ``sample_weight`` and
        ``groups``, as for `SINDy.fit`. Called for the first files only.

    Examples
    --------
    >>> import numpy as np, pickle, sindy
    >>> def run(k):  # x' = y, y' = -x
    ...     t = np.arange(0.0, 5.0, 0.01) + k
    ...     return {"x": np.column_stack([np.sin(t), np.cos(t)]), "t": t}
    >>> first = sindy.PartialSums(sindy.SINDy("poly(1)"), ["a", "b", "c"], run)
    >>> second = pickle.loads(pickle.dumps(first)).add(2, **run(2))
    >>> sums = first.add(1, **run(1)).add(0, **run(0)).merge(second)
    >>> sums.rows, sums.missing
    (1500, [])
    >>> sums.fit().equations(2)
    ['1.0*x1', '-1.0*x0']
    """

    def __init__(self, model: SINDy, names: Sequence[str], read: Callable[[int], dict[str, Any]]) -> None:
        check(model, "partial sums (`sindy.dist.fit`)")
        if model.solver is not None:
            raise fault("solver", "none: partial sums are of the automatic call", repr(model.solver))
        if not names:
            raise fault("names", "at least one file", "none")
        heads: list[Data] = []
        rows = 0
        while rows < _native.HEAD_ROWS and len(heads) < len(names):
            data = _collect(read(len(heads)), model.states, model.inputs)
            rows += sum(len(run.x) for run in data.trajectories)
            heads.append(data)
        self.names = list(names)
        self.states, self.inputs = heads[0].states, heads[0].inputs
        self._weighted = heads[0].trajectories[0].weight is not None
        self._model = model
        built = libraries(model.library, self.states, self.inputs)
        self.terms = list(dict.fromkeys(name for library in built for name in library.names))
        self._native = _native.PartialSums.begin(
            self.states,
            self.inputs,
            self._weighted,
            built,
            dumps(automatic(model)),
            self.names,
            [self._arrays(data) for data in heads],
            threads(model.n_jobs),
        )

    def __copy__(self) -> PartialSums:
        out = type(self).__new__(type(self))
        out.__dict__.update(self.__dict__, _native=copy.copy(self._native))
        return out

    def _arrays(self, data: Data) -> Arrays:
        if (data.trajectories[0].weight is not None) != self._weighted:
            raise fault("sample_weight", "weights in all files or in none", "some")
        out = []
        for run in data.trajectories:
            weight = None if run.weight is None else run.weight.reshape(-1, 1)
            parts = [run.times().reshape(-1, 1), run.x, run.u, weight]
            out.append([a for a in parts if a is not None])
        return out

    def add(self, number: int, *, n_jobs: int | None = None, **data: Any) -> PartialSums:
        """Passes over the data of the file with this number (those that `read` gives), and adds their sums."""
        rows = _collect(data, self.states, self.inputs or None)
        if not 0 <= number < len(self.names):
            raise fault("number", f"0 to {len(self.names) - 1}, a number of a file", number)
        self._native.add(number, self._arrays(rows), threads(n_jobs))
        return self

    def merge(self, other: PartialSums) -> PartialSums:
        """Adds the sums of other files of the same identification."""
        if not isinstance(other, PartialSums) or other is self:
            raise fault("merge", "other PartialSums", type(other).__name__)
        self._native.merge(other._native)
        return self

    @property
    def rows(self) -> int:
        """The rows in the sums."""
        return self._native.rows

    @property
    def missing(self) -> list[str]:
        """The names of the files that are not in the sums."""
        return self._native.missing

    def fit(self, n_jobs: int | None = None) -> SINDy:
        """The model of all files."""
        model, said = self._native.identify(threads(n_jobs))
        m = self._model
        out = SINDy(m.library, states=self.states, inputs=self.inputs or None, n_jobs=m.n_jobs)
        out.smoothing, out.method, out.discrete, out.settings = m.smoothing, m.method, m.discrete, m.settings
        return out._learn(model, list(self.terms), json.loads(said))
