"""Sequentially thresholded least squares."""

from __future__ import annotations

import json
import warnings
from typing import Any

import numpy as np
from sklearn.exceptions import ConvergenceWarning

from ... import _native
from ..._data import Array
from ..._errors import SindyError
from ..._solvers import STLSQ as Solver
from ._base import BaseOptimizer, on_support, ridge


class STLSQ(BaseOptimizer):
    """Ridge regression, over and over, without the terms whose coefficients fell below a threshold.

    The library's own solver does the work, except where `sparse_ind` or `verbose` asks for more
    than it has, or the terms are dependent without ridge. `history_` then has no iterations.

    Parameters
    ----------
    threshold : float
        Terms with a smaller coefficient are dropped.
    alpha : float
        Ridge of the regressions on the way.
    max_iter : int
        Iterations at most.
    ridge_kw : dict, optional
        There for compatibility: it chooses among solvers of the same problem.
    normalize_columns, copy_X, initial_guess, unbias
        As for `BaseOptimizer`.
    verbose : bool
        Whether every iteration is printed.
    sparse_ind : list of int, optional
        The terms that threshold and ridge apply to. ``coef_`` has these only; the others are in ``optvar_non_sparse_``.
    """

    _starts = False

    def __init__(
        self,
        threshold: float = 0.1,
        alpha: float = 0.05,
        max_iter: int = 20,
        ridge_kw: dict[str, Any] | None = None,
        normalize_columns: bool = False,
        copy_X: bool = True,
        initial_guess: Any = None,
        verbose: bool = False,
        sparse_ind: Any = None,
        unbias: bool = True,
    ) -> None:
        self.threshold = threshold
        self.alpha = alpha
        self.ridge_kw = ridge_kw
        self.verbose = verbose
        self.sparse_ind = sparse_ind
        super().__init__(max_iter, normalize_columns, initial_guess, copy_X, unbias)

    def _check(self) -> None:
        super()._check()
        for name, value in (("threshold", self.threshold), ("alpha", self.alpha)):
            if value < 0:
                raise ValueError(f"{name}: expected at least 0, found {value}")

    def _reduce(self, x: Array, y: Array) -> None:
        plain = self.sparse_ind is None and not self.verbose and self.max_iter > 0
        found = self._by_library(x, y) if plain else None
        if found is None:
            found = self._by_numpy(x, y)
        coefficients, outcomes = found
        if "empty" in outcomes:
            warnings.warn(f"threshold {self.threshold} is above every coefficient of an equation: it has no term left")
        if "limit" in outcomes:
            warnings.warn(f"STLSQ did not converge after {self.max_iter} iterations", ConvergenceWarning)
        self.coef_ = coefficients
        if self.sparse_ind is not None:
            others = np.setdiff1d(np.arange(x.shape[1]), self.sparse_ind)
            self.optvar_non_sparse_ = coefficients[:, others]
            self.coef_ = coefficients[:, self.sparse_ind]

    def _by_library(self, x: Array, y: Array) -> tuple[Array, set[str]] | None:
        """Coefficients from the sums of the rows, or none where these are singular."""
        states = [f"y{i}" for i in range(y.shape[1])]
        terms = [f"f{k}" for k in range(x.shape[1])]
        solver = Solver(self.threshold, self.alpha, False, self.max_iter, False).describe()
        try:
            library = _native.Library.of_terms(terms)
            model, text = _native.fit_columns(states, terms, [[y, x, y]], False, [library], solver)
        except SindyError:
            return None
        out = np.zeros((y.shape[1], x.shape[1]))
        for i, equation in enumerate(model.terms):
            for name, value, *_ in equation:
                out[i, int(name[1:])] = value
        known = {"iteration_limit": "limit"}
        outcomes = {known.get(one["outcome"], one["outcome"]) for one in json.loads(text)}
        if not outcomes <= {"converged", "empty", "limit"} or not np.isfinite(out).all():
            return None
        return out, outcomes

    def _by_numpy(self, x: Array, y: Array) -> tuple[Array, set[str]]:
        terms = x.shape[1]
        thresholded = np.ones(terms, dtype=bool)
        if self.sparse_ind is not None:
            thresholded = np.isin(np.arange(terms), self.sparse_ind)
        penalty = np.where(thresholded, self.alpha, 0.0)
        kept = np.ones((y.shape[1], terms), dtype=bool)
        out, outcomes = np.zeros(kept.shape), {"limit"}
        for k in range(self.max_iter):
            before = kept.copy()
            out = np.zeros(kept.shape)
            for i, some in enumerate(before):
                if some.any():
                    out[i, some] = ridge(x[:, some], y[:, i], penalty[some])
                kept[i] = some & ((np.abs(out[i]) >= self.threshold) | ~thresholded)
                out[i, ~kept[i]] = 0.0
            self.iters += y.shape[1]
            self.history_.append(out)
            if self.verbose:
                print(f"{k:5d}  residual {np.sum((y - x @ out.T) ** 2):.4e}  terms {np.count_nonzero(out)}")
            if np.array_equal(before, kept):
                outcomes = {"converged"}
                break
        if not kept.any(axis=1).all():
            outcomes.add("empty")
        return out, outcomes

    def _unbias(self, x: Array, y: Array) -> None:
        if self.sparse_ind is None:
            return super()._unbias(x, y)
        others = np.setdiff1d(np.arange(x.shape[1]), self.sparse_ind)
        support = np.ones((y.shape[1], x.shape[1]), dtype=bool)
        support[:, self.sparse_ind] = self.ind_
        full = on_support(x, y, support)
        self.coef_, self.optvar_non_sparse_ = full[:, self.sparse_ind], full[:, others]
