"""Convex problems: least squares under equations; inequalities or an absolute penalty, solved by Clarabel; SINDy-PI over them."""

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


def independent_rows(x: Array, y: Array) -> tuple[Array, Array, Array]:
    """Rows and right sides of ``|y - X w|²`` over all coefficients, as few as there are coefficients, and units of these.

    Coefficients run over the terms of the first target first. They are ``units * v``, and the rows are those of v: columns have
    length 1, so that the condition of the data does not depend on the terms' units.
    """
    lengths = np.linalg.norm(x, axis=0)
    lengths[lengths == 0.0] = 1.0
    orthogonal, upper = np.linalg.qr(x / lengths)
    targets = y.shape[1]
    return np.kron(np.eye(targets), upper), (orthogonal.T @ y).T.ravel(), np.tile(1.0 / lengths, targets)


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
    below, equal, tol, verbose
        As for `minimise_rows`.
    """
    shape = (y.shape[1], x.shape[1])
    rows, right, units = independent_rows(x, y)
    lam = np.broadcast_to(np.asarray(weight, dtype=np.float64), shape).ravel()
    found = minimise_rows(rows, right, units, regularizer, lam, below, equal, tol, verbose)
    return np.zeros(shape) if found is None else found.reshape(shape)


def minimise_rows(
    rows: Array,
    right: Array,
    units: Array,
    regularizer: str,
    lam: Array,
    below: Constraints = None,
    equal: Constraints = None,
    tol: float = 1e-8,
    verbose: bool = False,
) -> Array | None:
    """Coefficients ``w = units * v`` that minimise ``|right - rows v|² + Σ λ |w|`` or ``… + Σ λ w²``.

    None, with a warning, where the solver finds none.

    Parameters
    ----------
    rows, right : array of shape (n_rows, n_coefficients), and (n_rows,)
    units : array of shape (n_coefficients,)
        Of `independent_rows`.
    regularizer : {"l1", "l2", "weighted_l1", "weighted_l2"}
    lam : array of shape (n_coefficients,)
        λ.
    below, equal : pair of arrays, optional
        A and b of ``A w ≤ b``, C and d of ``C w = d``.
    tol : float
        Tolerance of the solver, at most 1e-8.
    verbose : bool
        Whether the solver prints its iterations.
    """
    try:
        import clarabel
    except ImportError as error:
        raise ImportError(
            "inequalities, SINDyPI, TrappingSR3 and StableLinearSR3 need the package clarabel: pip install clarabel"
        ) from error
    count = rows.shape[1]
    absolute = regularizer.lower().endswith("l1")
    square = np.zeros(count) if absolute else 2.0 * lam * units**2
    bound = count if absolute else 0  # for each coefficient a variable that its absolute value does not exceed

    def wide(matrix: Any) -> Any:
        """Rows over the coefficients alone."""
        return sparse.hstack([sparse.csc_matrix(matrix), sparse.csc_matrix((matrix.shape[0], len(right) + bound))])

    # The errors are variables of their own, so that the condition of the data is not squared.
    errors = sparse.hstack(
        [sparse.csc_matrix(rows), -sparse.eye(len(right)), sparse.csc_matrix((len(right), bound))]
    )
    left, limits = [errors], [right]
    for pair in (equal, below):
        if pair is not None:
            left.append(wide(np.atleast_2d(pair[0]) * units))
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
    linear = np.concatenate([np.zeros(count + len(right)), lam * units if absolute else []])
    # Tolerances are those of an objective whose penalty has weights of about 1.
    unit_of_objective = float(np.max(lam * units, initial=0.0)) or 1.0
    solver = clarabel.DefaultSolver(
        sparse.diags(quadratic / unit_of_objective).tocsc(), linear / unit_of_objective, sparse.vstack(left).tocsc(), every,
        cones, settings,
    )  # fmt: skip
    solution = solver.solve()
    if str(solution.status) not in ("Solved", "AlmostSolved"):
        warnings.warn(f"no coefficients found: the solver reports {solution.status}", ConvergenceWarning)
        return None
    return np.asarray(np.asarray(solution.x[:count]) * units, dtype=np.float64)


class EquationLeastSquares:
    """``|right - rows v|²`` at its least among the v that keep equations, over and over with other rows added.

    Parameters
    ----------
    rows, right : array of shape (n_rows, n_coefficients), and (n_rows,)
    equal : pair of arrays, optional
        C and d of ``C v = d``.
    """

    def __init__(self, rows: Array, right: Array, equal: Constraints = None) -> None:
        count = rows.shape[1]
        self._start, self._free = np.zeros(count), np.eye(count)
        self.consistent = True
        if equal is not None and len(equal[0]):
            left, values, across = np.linalg.svd(equal[0])
            rank = int(np.sum(values > 1e-12 * values[0]))
            self._start = across[:rank].T @ ((left[:, :rank].T @ equal[1]) / values[:rank])
            self._free = across[rank:].T
            gap = float(np.max(np.abs(equal[0] @ self._start - equal[1])))
            self.consistent = gap <= 1e-9 * max(1.0, float(np.max(np.abs(equal[1]))))
        orthogonal, self._upper = np.linalg.qr(rows @ self._free)
        self._right = orthogonal.T @ (right - rows @ self._start)

    def solve(self, rows: Array, right: Array) -> Array | None:
        """v with more rows; the shortest step where it is not unique, and none where the equations contradict each other."""
        if not self.consistent:
            warnings.warn("no coefficients found: the constraints contradict each other", ConvergenceWarning)
            return None
        matrix = np.concatenate([self._upper, rows @ self._free])
        step = np.linalg.lstsq(matrix, np.concatenate([self._right, right - rows @ self._start]), rcond=None)[0]
        return np.asarray(self._start + self._free @ step, dtype=np.float64)


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
