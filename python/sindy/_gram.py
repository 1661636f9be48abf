"""The statistics of rows."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from typing import Any

from . import _native
from ._data import collect
from ._errors import fault, whole
from ._library import Library, libraries
from ._model import SINDy
from ._solvers import Solver, default, threads
from ._subsets import Certificate, Subsets


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

    @classmethod
    def _of(cls, native: _native.Gram, library: Any, states: list[str], inputs: list[str]) -> Gram:
        """Statistics that the library made elsewhere."""
        out = cls(library, states, inputs)
        out._native = native
        return out

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

    def best_subsets(
        self,
        max_size: int | None = None,
        *,
        node_limit: int | None = None,
        tolerance: float = 0.0,
        n_jobs: int | None = None,
    ) -> dict[str, Subsets]:
        """The best subset of every number of terms for each state, with the proof that none is better.

        Parameters
        ----------
        max_size : int, optional
            Terms at most.
        node_limit : int, optional
            Nodes of the search at most; what is not proven then says by how much it could be improved.
        tolerance : float
            A subset within this relative distance of the least residual will do.
        n_jobs : int, optional
            Threads.

        Examples
        --------
        >>> import numpy as np, sindy
        >>> x = np.random.default_rng(1).normal(size=(1000, 1))
        >>> gram = sindy.Gram("poly(4)", ["x"]).update(x, 2.0 * x - 0.5 * x**3)
        >>> found = gram.best_subsets()["x"]
        >>> found.proven, found[2].terms
        (True, ['x', 'x^3'])
        """
        most, nodes = whole("max_size", max_size, 1), whole("node_limit", node_limit, 1)
        text = self._native.best_subsets(most, nodes, tolerance, threads(n_jobs))
        return {state: Subsets(said) for state, said in zip(self.states, json.loads(text))}

    def certify(
        self, terms: Mapping[str, Sequence[str]], *, node_limit: int | None = None, n_jobs: int | None = None
    ) -> dict[str, Certificate]:
        """How given terms compare with the best subset of as many terms.

        Parameters
        ----------
        terms : mapping
            For each state that is asked for, its terms, by the names of `terms`.
        node_limit, n_jobs : as for `best_subsets`

        Examples
        --------
        >>> import numpy as np, sindy
        >>> x = np.random.default_rng(1).normal(size=(1000, 1))
        >>> gram = sindy.Gram("poly(4)", ["x"]).update(x, 2.0 * x - 0.5 * x**3)
        >>> gram.certify({"x": ["x", "x^3"]})["x"].is_best, gram.certify({"x": ["x", "x^2"]})["x"].is_best
        (True, False)
        """
        for state in terms:
            if state not in self.states:
                raise fault("terms", "states among " + ", ".join(self.states), state)
        most = max((len(set(own)) for own in terms.values()), default=0)
        found = self.best_subsets(most, node_limit=node_limit, n_jobs=n_jobs)
        out = {}
        for state, own in terms.items():
            names, coefficients, residual = self._native.on_terms(self.states.index(state), list(own))
            if len(found[state]) <= len(names):
                raise fault("terms", f"at most {len(found[state]) - 1} terms that are not zero throughout", len(names))
            out[state] = Certificate(dict(zip(names, coefficients)), residual, found[state][len(names)])
        return out
