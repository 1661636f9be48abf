"""Convex problems with inequalities or an absolute penalty, solved by Clarabel, and SINDy-PI over them."""

from __future__ import annotations

import warnings
from typing import Any

import numpy as np
from scipy import sparse
from sklearn.exceptions import ConvergenceWarning

from ..._data import Array
from ._base import BaseOptimizer

_PENALTIES = ("l1", "l2", "weighted_l1", "weighted_l2")
Constraints = tuple[Array, Array] | None


def check_penalty(regularizer: str) -> None:
    """Raises `ValueError` unless a penalty is convex."""
    if regularizer.lower() not in _PENALTIES:
        raise ValueError(f"regularizer: expected a convex one of {', '.join(_PENALTIES)}; found {regularizer}")


def minimise(
    x: Array,
    y: Array,
    regularizer: str,
    weight: Any,
    below: Constraints = None,
    equal: Constraints = None,
    tol: float = 1e-8,
    verbose: bool = False,
) -> Array:
    """Coefficients w, one row for each target, that minimise ``|y - X w|² + Σ λ |w|`` or ``… + Σ λ w²``.

    Parameters
    ----------
    x, y : array of shape (n_samples, n_terms), and (n_samples, n_targets)
    regularizer : {"l1", "l2", "weighted_l1", "weighted_l2"}
    weight : float or array of shape (n_targets, n_terms)
        λ.
    below, equal : pair of arrays, optional
        A and b of ``A w ≤ b``, C and d of ``C w = d``. Columns run over the terms of the first target first.
    tol : float
        Tolerance of the solver, at most 1e-8.
    verbose : bool
        Whether the solver prints its iterations.
    """
    try:
        import clarabel
    except ImportError as error:
        raise ImportError("inequalities and SINDyPI need the package clarabel: pip install clarabel") from error
    terms, targets = x.shape[1], y.shape[1]
    count = terms * targets
    # The solver's coefficients are those of columns of length 1. Their errors are variables of their own, so that the condition
    # of the data is not squared.
    lengths = np.linalg.norm(x, axis=0)
    lengths[lengths == 0.0] = 1.0
    scale = np.tile(1.0 / lengths, targets)
    orthogonal, upper = np.linalg.qr(x / lengths)
    right = (orthogonal.T @ y).T.ravel()
    lam = np.broadcast_to(np.asarray(weight, dtype=np.float64), (targets, terms)).ravel()
    absolute = regularizer.lower().endswith("l1")
    square = np.zeros(count) if absolute else 2.0 * lam * scale**2
    bound = count if absolute else 0  # for each coefficient a variable that its absolute value does not exceed

    def rows(matrix: Any) -> Any:
        """Rows over the coefficients alone."""
        return sparse.hstack([sparse.csc_matrix(matrix), sparse.csc_matrix((matrix.shape[0], len(right) + bound))])

    errors = sparse.hstack(
        [sparse.kron(sparse.eye(targets), upper), -sparse.eye(len(right)), sparse.csc_matrix((len(right), bound))]
    )
    left, limits = [errors], [right]
    for pair in (equal, below):
        if pair is not None:
            left.append(rows(np.atleast_2d(pair[0]) * scale))
            limits.append(np.atleast_1d(pair[1]))
    equations = len(right) + (0 if equal is None else len(limits[1]))
    if absolute:
        unit, none = sparse.eye(count), sparse.csc_matrix((count, len(right)))
        left += [sparse.hstack([unit, none, -unit]), sparse.hstack([-unit, none, -unit])]
        limits.append(np.zeros(2 * count))
    every = np.concatenate(limits).astype(np.float64)
    cones = [clarabel.ZeroConeT(equations)]
    if len(every) > equations:
        cones.append(clarabel.NonnegativeConeT(len(every) - equations))
    settings = clarabel.DefaultSettings()
    settings.verbose = verbose
    settings.tol_gap_abs = settings.tol_gap_rel = settings.tol_feas = min(tol, 1e-8)
    quadratic = np.concatenate([square, np.full(len(right), 2.0), np.zeros(bound)])
    linear = np.concatenate([np.zeros(count + len(right)), lam * scale if absolute else []])
    # Tolerances are those of an objective whose penalty has weights of about 1.
    unit_of_objective = float(np.max(lam * scale, initial=0.0)) or 1.0
    solver = clarabel.DefaultSolver(
        sparse.diags(quadratic / unit_of_objective).tocsc(), linear / unit_of_objective, sparse.vstack(left).tocsc(), every,
        cones, settings,
    )  # fmt: skip
    solution = solver.solve()
    if str(solution.status) not in ("Solved", "AlmostSolved"):
        warnings.warn(f"no coefficients found, all are set to 0: the solver reports {solution.status}", ConvergenceWarning)
        return np.zeros((targets, terms))
    return np.asarray(np.asarray(solution.x[:count]) * scale, dtype=np.float64).reshape(targets, terms)


class SINDyPI(BaseOptimizer):
    """Implicit equations: each term as a sparse sum of the others (Kaheman et al. 2020, doi:10.1098/rspa.2020.0279).

    For each term j, w minimises ``|x_j - X w|² + λ R(w)`` with ``w_j = 0``. Needs the package ``clarabel``.

    Parameters
    ----------
    reg_weight_lam : float, or ndarray of shape (n_terms, n_terms) for the weighted penalties
        λ; one column for each term j.
    regularizer : {"l1", "l2", "weighted_l1", "weighted_l2"}
        R.
    tol : float
        Tolerance of the solver, at most 1e-8.
    model_subset : list of int, optional
        Terms to express by the others; all by default.
    normalize_columns, copy_X
        As for `BaseOptimizer`.
    verbose_cvxpy : bool
        Whether the solver prints its iterations.
    max_iter, unbias
        There for compatibility: the solver ends by itself, and `unbias` has to be False.

    Attributes
    ----------
    coef_ : ndarray of shape (n_terms, n_terms)
        One row for each term j.
    """

    _starts = False

    def __init__(
        self,
        reg_weight_lam: Any = 0.1,
        regularizer: str = "l1",
        tol: float = 1e-5,
        max_iter: int = 10000,
        copy_X: bool = True,
        model_subset: list[int] | None = None,
        normalize_columns: bool = False,
        verbose_cvxpy: bool = False,
        unbias: bool = False,
    ) -> None:
        self.reg_weight_lam = reg_weight_lam
        self.regularizer = regularizer
        self.tol = tol
        self.model_subset = model_subset
        self.verbose_cvxpy = verbose_cvxpy
        super().__init__(max_iter, normalize_columns, None, copy_X, unbias)

    def _check(self) -> None:
        super()._check()
        check_penalty(self.regularizer)
        if not self.tol > 0:
            raise ValueError(f"tol: expected a number above 0, found {self.tol}")
        if self.unbias:
            raise ValueError("unbias: expected False, found True")
        if self.regularizer.lower().startswith("weighted") and np.ndim(self.reg_weight_lam) != 2:
            raise ValueError("reg_weight_lam: expected a matrix for a weighted penalty")
        if self.reg_weight_lam is None or np.any(np.asarray(self.reg_weight_lam) < 0):
            raise ValueError("reg_weight_lam: expected numbers of at least 0")
        chosen = self.model_subset
        if chosen is not None and not (isinstance(chosen, list) and all(isinstance(k, int) for k in chosen)):
            raise ValueError(f"model_subset: expected a list of whole numbers, found {chosen}")

    def _reduce(self, x: Array, y: Array) -> None:
        terms = x.shape[1]
        chosen = list(range(terms)) if self.model_subset is None else self.model_subset
        if any(not -terms <= k < terms for k in chosen):
            raise ValueError(f"model_subset: expected indices of {terms} terms, found {chosen}")
        self.coef_ = np.zeros((terms, terms))
        for k in chosen:
            others = np.delete(np.arange(terms), k)
            lam = self.reg_weight_lam
            if self.regularizer.lower().startswith("weighted"):
                lam = np.asarray(lam)[others, k]
            found = minimise(x[:, others], x[:, [k]], self.regularizer, lam, tol=self.tol, verbose=self.verbose_cvxpy)
            self.coef_[k, others] = found[0]

    def _scale_back(self, lengths: Array) -> None:
        super()._scale_back(lengths)
        self.coef_ = self.coef_ * lengths[:, None]
