"""The statistics of rows."""

from __future__ import annotations

import json
from collections.abc import Sequence
from typing import Any

from . import _native
from ._data import collect
from ._errors import fault
from ._library import Library, libraries
from ._model import SINDy
from ._solvers import Solver, default, threads


class Gram:
    """All that a solver needs of any number of rows: added block by block, merged over processes, solved again and again.

    It holds a number for each pair of terms, and no row. One for each block, merged one after another in the blocks' order,
    gives the bits of a single process. Threads that share one take turns: each `update` or `merge` has to end before the next.

    Parameters
    ----------
    library : as for `SINDy`
    states : sequence of str
    inputs : sequence of str, optional

    Examples
    --------
    >>> import numpy as np, pickle, sindy
    >>> rng = np.random.default_rng(1)
    >>> def rows():
    ...     x = rng.normal(size=(1000, 2))
    ...     return x, np.column_stack([x[:, 1], -x[:, 0]])  # x' = y, y' = -x
    >>> first, second = (sindy.Gram("poly(3)", ["x", "y"]) for _ in range(2))
    >>> first = first.update(*rows()).update(*rows())
    >>> second = pickle.loads(pickle.dumps(second.update(*rows())))
    >>> gram = first.merge(second)
    >>> gram.rows
    3000
    >>> gram.fit(sindy.STLSQ()).equations(2)
    ['1.0*y', '-1.0*x']
    """

    def __init__(
        self,
        library: str | Sequence[str] | Library | dict[str, Any] | None,
        states: Sequence[str],
        inputs: Sequence[str] = (),
    ) -> None:
        self.states = list(states)
        self.inputs = list(inputs)
        self.library = library
        built = libraries(library, self.states, self.inputs)
        self.terms = list(dict.fromkeys(name for part in built for name in part.names))
        self._native = _native.Gram(self.states, self.inputs, built)

    def update(self, x: Any, x_dot: Any, u: Any = None, sample_weight: Any = None, n_jobs: int | None = None) -> Gram:
        """Adds rows of states, their slopes (in discrete time, the next samples) and inputs; arrays are read where they are."""
        data = collect(x, None, u, x_dot, sample_weight, None, self.states, self.inputs or None)
        weighted = sample_weight is not None
        groups = []
        for run in data.trajectories:
            parts = [run.x, run.u, run.x_dot, None if run.weight is None else run.weight.reshape(-1, 1)]
            groups.append([a for a in parts if a is not None])
        self._native.update(groups, weighted, threads(n_jobs))
        return self

    def merge(self, other: Gram) -> Gram:
        """Adds the rows of other statistics of the same terms."""
        if not isinstance(other, Gram) or other is self:
            raise fault("merge", "another Gram", type(other).__name__)
        self._native.merge(other._native)
        return self

    @property
    def rows(self) -> int:
        """Rows that were used."""
        return self._native.rows[0]

    @property
    def skipped(self) -> int:
        """Rows that were left out, because a value is not finite."""
        return self._native.rows[1]

    def fit(self, solver: Solver | None = None, *, period: float | None = None, n_jobs: int | None = None) -> SINDy:
        """The model of a solver, best subsets without one; with a period, in discrete time."""
        solver = solver or default()
        model, said = self._native.solve(solver.describe(), period, threads(n_jobs))
        out = SINDy(self.library, solver, discrete=period is not None, states=self.states, inputs=self.inputs or None)
        return out._learn(model, list(self.terms), json.loads(said))
