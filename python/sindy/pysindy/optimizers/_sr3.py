"""Sparse relaxed regularised regression, with linear constraints as well."""

from __future__ import annotations

import warnings
from typing import Any, TypeVar

import numpy as np
from scipy.linalg import cho_factor, cho_solve
from sklearn.exceptions import ConvergenceWarning

from ..._data import Array
from ..utils import capped_simplex_projection, get_prox, get_regularization, reorder_constraints
from ._base import BaseOptimizer
from ._convex import Constraints, check_penalty, minimise

Self = TypeVar("Self", bound="SR3")
_PENALTIES = ("l0", "l1", "l2", "weighted_l0", "weighted_l1", "weighted_l2")


class SR3(BaseOptimizer):
    """Minimises ``|y - X w|²/2 + λ R(u) + |w - u|²/(2ν)`` by turns in w and u; u is the result.

    Parameters
    ----------
    reg_weight_lam : float, or ndarray of shape (n_targets, n_terms) for the weighted penalties
        λ.
    regularizer : {"l0", "l1", "l2", "weighted_l0", "weighted_l1", "weighted_l2"}
        R.
    relax_coeff_nu : float
        ν.
    tol : float
        The change of u, divided by ν, that counts as converged.
    trimming_fraction : float
        Share of rows to leave out as outliers.
    trimming_step_size : float
        Step of the rows' weights.
    max_iter, copy_X, initial_guess, normalize_columns, unbias
        As for `BaseOptimizer`.
    verbose : bool
        Whether every iteration is printed.
    """

    def __init__(
        self,
        reg_weight_lam: Any = 0.005,
        regularizer: str = "L0",
        relax_coeff_nu: float = 1.0,
        tol: float = 1e-5,
        trimming_fraction: float = 0.0,
        trimming_step_size: float = 1.0,
        max_iter: int = 30,
        copy_X: bool = True,
        initial_guess: Any = None,
        normalize_columns: bool = False,
        verbose: bool = False,
        unbias: bool = False,
    ) -> None:
        self.reg_weight_lam = reg_weight_lam
        self.regularizer = regularizer
        self.relax_coeff_nu = relax_coeff_nu
        self.tol = tol
        self.trimming_fraction = trimming_fraction
        self.trimming_step_size = trimming_step_size
        self.verbose = verbose
        super().__init__(max_iter, normalize_columns, initial_guess, copy_X, unbias)

    def _check(self) -> None:
        super()._check()
        for name, value in (("relax_coeff_nu", self.relax_coeff_nu), ("tol", self.tol)):
            if not value > 0:
                raise ValueError(f"{name}: expected a number above 0, found {value}")
        if not 0.0 <= self.trimming_fraction <= 1.0:
            raise ValueError(f"trimming_fraction: expected a share from 0 to 1, found {self.trimming_fraction}")
        if self.trimming_fraction > 0 and self.unbias:
            raise ValueError("unbias: expected False with trimming, for it brings trimmed rows back; found True")
        if self.regularizer.lower() not in _PENALTIES:
            raise NotImplementedError(f"regularizer: expected one of {', '.join(_PENALTIES)}; found {self.regularizer}")
        if self.regularizer.lower().startswith("weighted") and not isinstance(self.reg_weight_lam, np.ndarray):
            raise ValueError("reg_weight_lam: expected an array for a weighted penalty")
        if self.reg_weight_lam is None or np.any(np.asarray(self.reg_weight_lam) < 0):
            raise ValueError("reg_weight_lam: expected numbers of at least 0")

    @staticmethod
    def calculate_l0_weight(threshold: Any, relax_coeff_nu: float) -> Any:
        """The λ at which the penalty l0 drops coefficients below a threshold: ``threshold² / (2 ν)``."""
        return threshold**2 / (2.0 * relax_coeff_nu)

    def enable_trimming(self, trimming_fraction: float) -> None:
        """Leaves out a share of the rows as outliers."""
        self.trimming_fraction = trimming_fraction

    def disable_trimming(self) -> None:
        """Uses all rows."""
        self.trimming_fraction = 0.0

    @property
    def use_trimming(self) -> bool:
        """Whether rows are left out as outliers."""
        return self.trimming_fraction > 0.0

    def _relaxed(self, gram: Array, right: Array) -> Array:
        """The coefficients w, one column for each target, of the normal equations with 1/ν added."""
        out: Array = cho_solve(cho_factor(gram), right)
        return out

    def _reduce(self, x: Array, y: Array) -> None:
        nu = self.relax_coeff_nu
        lam = self.reg_weight_lam.T if isinstance(self.reg_weight_lam, np.ndarray) else float(self.reg_weight_lam)
        prox, penalty = get_prox(self.regularizer), get_regularization(self.regularizer)
        sparse = self.coef_.T.copy()
        full = sparse.copy()
        weights = np.full(len(x), 1.0 - self.trimming_fraction)
        unit = np.eye(x.shape[1]) / nu
        gram, right = x.T @ x + unit, x.T @ y
        self.objective_history: list[float] = []
        converged = False
        for k in range(self.max_iter):
            errors = np.sum((y - x @ full) ** 2, axis=1)
            if self.use_trimming:
                weighted = x * weights[:, None]
                gram, right = weighted.T @ x + unit, weighted.T @ y
            full = self._relaxed(gram, right + sparse / nu)
            # The first comparison is with zero, as PySINDy's is.
            before = sparse if k else np.zeros_like(sparse)
            sparse = prox(full, lam * nu)
            change = float(np.linalg.norm(sparse - before)) / nu
            self.iters += 1
            self.history_.append(sparse.T)
            if self.use_trimming:
                moved = capped_simplex_projection(
                    weights - 0.5 * self.trimming_step_size * errors, self.trimming_fraction
                )
                change += float(np.linalg.norm(moved - weights)) / self.trimming_step_size
                weights = moved
            rows = np.sum((y - x @ full) ** 2, axis=1) * (weights if self.use_trimming else 1.0)
            objective = 0.5 * (rows.sum() + penalty(full, lam) + np.sum((full - sparse) ** 2) / nu)
            self.objective_history.append(float(objective))
            if self.verbose:
                print(f"{k:5d}  objective {objective:.4e}  terms {np.count_nonzero(sparse)}")
            if change < self.tol:
                converged = True
                break
        if not converged:
            warnings.warn(f"{type(self).__name__} did not converge after {self.max_iter} iterations", ConvergenceWarning)
        self.coef_, self.coef_full_ = sparse.T, full.T
        if self.use_trimming:
            self.trimming_array = weights

    def _scale_back(self, lengths: Array) -> None:
        super()._scale_back(lengths)
        self.coef_full_ = self.coef_full_ / lengths


class ConstrainedSR3(SR3):
    """`SR3` whose coefficients w keep linear equations, which may reach over several equations of the model.

    With inequalities u and ν are not there: w minimises ``|y - X w|² + λ R(w)``, by the package ``clarabel``, and is the result.

    Parameters
    ----------
    constraint_lhs : ndarray of shape (n_constraints, n_targets * n_terms), optional
        C of ``C w = d`` or ``C w ≤ d``.
    constraint_rhs : ndarray of shape (n_constraints,), optional
        d.
    constraint_order : {"target", "feature"}
        Whether columns of C run over the terms of the first equation first, or over the equations of the first term.
    equality_constraints, inequality_constraints : bool
        Whether there are rows with ``=``, and rows with ``≤``; equations by default.
    constraint_separation_index : int, optional
        With both, the number of inequalities, which stand first.
    verbose_cvxpy : bool
        Whether the solver of inequalities prints its iterations.
    """

    def __init__(
        self,
        reg_weight_lam: Any = 0.005,
        regularizer: str = "l0",
        relax_coeff_nu: float = 1.0,
        tol: float = 1e-5,
        max_iter: int = 30,
        trimming_fraction: float = 0.0,
        trimming_step_size: float = 1.0,
        constraint_lhs: Any = None,
        constraint_rhs: Any = None,
        constraint_order: str = "target",
        normalize_columns: bool = False,
        copy_X: bool = True,
        initial_guess: Any = None,
        equality_constraints: bool = False,
        inequality_constraints: bool = False,
        constraint_separation_index: Any = None,
        verbose: bool = False,
        verbose_cvxpy: bool = False,
        unbias: bool = False,
    ) -> None:
        self.constraint_lhs = constraint_lhs
        self.constraint_rhs = constraint_rhs
        self.constraint_order = constraint_order
        self.equality_constraints = equality_constraints
        self.inequality_constraints = inequality_constraints
        self.constraint_separation_index = constraint_separation_index
        self.verbose_cvxpy = verbose_cvxpy
        super().__init__(
            reg_weight_lam, regularizer, relax_coeff_nu, tol, trimming_fraction, trimming_step_size, max_iter, copy_X,
            initial_guess, normalize_columns, verbose, unbias,
        )  # fmt: skip

    def _check(self) -> None:
        super()._check()
        given = self.constraint_lhs is not None
        if given != (self.constraint_rhs is not None):
            raise ValueError("constraint_lhs, constraint_rhs: expected both or neither, found one")
        if given and self._order not in ("target", "feature"):
            raise ValueError(f"constraint_order: expected target or feature, found {self._order}")
        if given and self.unbias:
            raise ValueError("unbias: expected False with constraints, which it does not keep; found True")
        if self.inequality_constraints:
            check_penalty(self.regularizer)
            if not given:
                raise ValueError("constraint_lhs, constraint_rhs: expected both with inequality_constraints, found neither")
            if self.use_trimming:
                raise ValueError(f"trimming_fraction: expected 0 with inequalities, found {self.trimming_fraction}")
            if self.equality_constraints and self.constraint_separation_index is None:
                raise ValueError("constraint_separation_index: expected the number of inequalities, found None")

    @property
    def _order(self) -> Any:
        """The order of the constraints' columns."""
        return self.constraint_order

    def _left(self, terms: int, targets: int, order: str) -> Array:
        """The constraints' rows, in an order of columns, for the coefficients of normalised columns."""
        left = np.atleast_2d(np.asarray(self.constraint_lhs, dtype=np.float64))
        if left.shape[1] != terms * targets:
            raise ValueError(f"constraint_lhs: expected {terms * targets} columns, found {left.shape[1]}")
        if self._order != order:
            left = reorder_constraints(left, terms, order)
        lengths = np.repeat(self._lengths, targets) if order == "feature" else np.tile(self._lengths, targets)
        return np.asarray(left / lengths)

    def _sides(self, terms: int, targets: int) -> tuple[Constraints, Constraints]:
        """Inequalities and equations for the coefficients of normalised columns, over the terms of the first target first."""
        if self.constraint_lhs is None:
            return None, None
        left = self._left(terms, targets, "target")
        right = np.asarray(self.constraint_rhs, dtype=np.float64).reshape(-1)
        if not self.inequality_constraints:
            return None, (left, right)
        below = self.constraint_separation_index if self.equality_constraints else len(left)
        return (left[:below], right[:below]), (left[below:], right[below:])

    def _reduce(self, x: Array, y: Array) -> None:
        if not self.inequality_constraints:
            super()._reduce(x, y)
            return
        below, equal = self._sides(x.shape[1], y.shape[1])
        self.coef_ = self.coef_full_ = minimise(
            x, y, self.regularizer, self.reg_weight_lam, below, equal, self.tol, self.verbose_cvxpy
        )
        self.history_.append(self.coef_)

    def _relaxed(self, gram: Array, right: Array) -> Array:
        if self.constraint_lhs is None:
            return super()._relaxed(gram, right)
        terms, targets = right.shape
        left = self._left(terms, targets, "feature")
        # Lagrange multipliers: first the free solution, then the smallest correction in the metric of the Gram matrix.
        factor = cho_factor(gram)
        free = cho_solve(factor, right)
        steps = cho_solve(factor, left.T.reshape(terms, targets * len(left))).reshape(terms * targets, -1)
        gap = np.asarray(self.constraint_rhs, dtype=np.float64).reshape(-1) - left @ free.reshape(-1)
        multipliers = np.linalg.lstsq(left @ steps, gap, rcond=None)[0]
        out: Array = free + (steps @ multipliers).reshape(terms, targets)
        return out
