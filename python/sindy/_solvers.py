"""Sparse solvers: what they are called and what they are set to. The library does the work."""

from __future__ import annotations

import json
from dataclasses import asdict, dataclass, fields
from numbers import Integral
from typing import Any, Literal, Self

import numpy as np

from ._errors import fault

Criterion = Literal["aic", "aicc", "bic", "evidence"]
# More threads than any processor has; each costs memory and a start.
MOST_THREADS = 1024


def dumps(value: Any) -> str:
    """JSON, of NumPy's numbers as well."""

    def plain(number: Any) -> Any:
        if isinstance(number, np.generic):
            return number.item()
        raise fault("settings", "numbers, texts, lists and tables", type(number).__name__)

    return json.dumps(value, default=plain)


def threads(n_jobs: Any) -> int | None:
    """Threads as the library takes them; none for as many as processors."""
    if n_jobs is None or (isinstance(n_jobs, Integral) and n_jobs == -1):
        return None
    if not isinstance(n_jobs, Integral) or isinstance(n_jobs, bool) or not 1 <= int(n_jobs) <= MOST_THREADS:
        raise fault("n_jobs", f"a number from 1 to {MOST_THREADS}, -1 or none", n_jobs)
    return int(n_jobs)


@dataclass
class Parameters:
    """Parameters in scikit-learn's way."""

    def get_params(self, deep: bool = True) -> dict[str, Any]:
        """The parameters by name."""
        return {f.name: getattr(self, f.name) for f in fields(self)}

    def set_params(self, **params: Any) -> Self:
        """Sets parameters by name."""
        known = self.get_params()
        for name, value in params.items():
            if name not in known:
                raise fault(type(self).__name__, "one of " + ", ".join(known), name)
            setattr(self, name, value)
        return self

    def _describe(self, name: str) -> str:
        return dumps({name: asdict(self)})


@dataclass
class Solver(Parameters):
    """What all solvers share."""

    def describe(self) -> str:
        """The description that the library builds the solver from."""
        raise NotImplementedError


@dataclass
class STLSQ(Solver):
    """Sequentially thresholded least squares.

    The defaults are those of PySINDy.

    Parameters
    ----------
    threshold : float
        Terms with a smaller coefficient are dropped: in the coefficients' own units, or, with `scaled`, of columns and
        target divided by their root mean square.
    alpha : float
        Ridge of the regressions on the way.
    scaled : bool
        Whether columns and target are scaled before the threshold sees them.
    max_iter : int
        Iterations at most.
    unbias : bool
        Whether plain least squares on the kept terms gives the coefficients.
    """

    threshold: float = 0.1
    alpha: float = 0.05
    scaled: bool = False
    max_iter: int = 20
    unbias: bool = True

    def describe(self) -> str:
        return self._describe("stlsq")


@dataclass
class SR3(Solver):
    """Sparse relaxed regularised regression, solved at its fixed point and refitted on its support.

    Parameters
    ----------
    lam : float
        Penalty λ. With the penalty `l0`, terms below √(2 λ ν) are dropped.
    nu : float
        Relaxation ν, in the unit of 1/Gram, or, with `scaled`, relative to the scaled Gram diagonal.
    penalty : {"l0", "l1"}
        What the penalty counts: terms, or the sum of their magnitudes.
    scaled : bool
        Whether columns and target are divided by their root mean square first.
    max_iter : int
        Iterations at most.
    """

    lam: float = 0.005
    nu: float = 1.0
    penalty: Literal["l0", "l1"] = "l0"
    scaled: bool = False
    max_iter: int = 100

    def describe(self) -> str:
        return self._describe("sr3")


@dataclass
class Stepwise(Solver):
    """Greedy selection, one term at a time, until a criterion no longer falls.

    Parameters
    ----------
    direction : {"forward", "backward", "both"}
        Additions from no terms, removals from all, or both.
    criterion : {"aic", "aicc", "bic", "evidence"}
        What supports are compared by.
    """

    direction: Literal["forward", "backward", "both"] = "forward"
    criterion: Criterion = "bic"

    def describe(self) -> str:
        return self._describe("stepwise")


@dataclass
class BestSubset(Solver):
    """The best terms of every number, proven; of these, the number that a criterion prefers.

    Parameters
    ----------
    criterion : {"aic", "aicc", "bic", "evidence"}
        What numbers of terms are compared by.
    max_size : int, optional
        Terms of an equation at most.
    node_limit : int, optional
        Where the search gives up the proof.
    """

    criterion: Criterion = "bic"
    max_size: int | None = None
    node_limit: int | None = None

    def describe(self) -> str:
        return self._describe("best_subset")


def default() -> BestSubset:
    """The solver of given slopes where none is chosen: a fraction of a second, then a warning that nothing is proven.

    The limit is that of the fronts of the automatic call.
    """
    return BestSubset(node_limit=200_000)
