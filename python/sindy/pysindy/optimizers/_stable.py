"""Linear models that are stable."""

from __future__ import annotations

import warnings
from typing import Any

import numpy as np
from sklearn.exceptions import ConvergenceWarning

from ..._data import Array
from ..utils import get_regularization
from ._convex import check_penalty, independent_rows, minimise_rows
from ._sr3 import ConstrainedSR3


class StableLinearSR3(ConstrainedSR3):
    """Linear models ``x' = A x + B u`` whose A has no eigenvalue on the right of a bound.

    Minimises ``|y - X w|² + λ R(w) + |w - s|²/(2ν)`` by turns. s is w with the real parts of the eigenvalues of A above γ set
    to γ. The library has to be linear: one term for each state first, then one for each input. w is the result and s is in
    ``coef_full_``. A small ν brings w to s; with a large one A can be unstable, which is a warning. PySINDy has 1/ν in place of
    1/(2ν) where λ is 0 and no constraints are given. Needs the package ``clarabel``.

    Parameters
    ----------
    reg_weight_lam : float, or ndarray of shape (n_targets, n_terms) for the weighted penalties
        λ.
    regularizer : {"l1", "l2", "weighted_l1", "weighted_l2"}
        R.
    relax_coeff_nu : float
        ν.
    tol : float
        The change of w, divided by ν, that counts as converged.
    gamma : float
        γ.
    trimming_fraction
        Has to be 0: PySINDy takes it and trims no rows.
    trimming_step_size
        There for compatibility.
    constraint_lhs, constraint_rhs, constraint_order, equality_constraints, inequality_constraints, constraint_separation_index
        For w, as for `ConstrainedSR3`.
    max_iter, normalize_columns, copy_X, initial_guess, verbose, verbose_cvxpy, unbias
        As for `ConstrainedSR3`.

    Attributes
    ----------
    coef_, coef_full_ : ndarray of shape (n_targets, n_terms)
        w and s.
    eigs_history : ndarray of shape (n_iterations, n_targets)
        The eigenvalues of A over the iterations, by their real parts. (PySINDy has singular values here.)
    coef_history : ndarray of shape (n_iterations, n_terms, n_targets)
        The transpose of w over the iterations.
    """

    def __init__(
        self,
        reg_weight_lam: Any = 0.1,
        regularizer: str = "l1",
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
        constraint_separation_index: Any = 0,
        verbose: bool = False,
        verbose_cvxpy: bool = False,
        gamma: float = -1e-8,
        unbias: bool = False,
    ) -> None:
        self.gamma = gamma
        super().__init__(
            reg_weight_lam, regularizer, relax_coeff_nu, tol, max_iter, trimming_fraction, trimming_step_size, constraint_lhs,
            constraint_rhs, constraint_order, normalize_columns, copy_X, initial_guess, equality_constraints,
            inequality_constraints, constraint_separation_index, verbose, verbose_cvxpy, unbias,
        )  # fmt: skip

    def _check(self) -> None:
        super()._check()
        check_penalty(self.regularizer)
        if self.use_trimming:
            raise ValueError(f"trimming_fraction: expected 0, found {self.trimming_fraction}")

    def _reduce(self, x: Array, y: Array) -> None:
        shape = (y.shape[1], x.shape[1])
        if shape[1] < shape[0]:
            raise ValueError(f"x_: expected a linear term for each of the {shape[0]} states at least, found {shape[1]} columns")
        rows, right, units = independent_rows(x, y)
        below, equal = self._sides(shape[1], shape[0])
        pull = 1.0 / np.sqrt(2.0 * self.relax_coeff_nu)
        rows = np.concatenate([rows, np.diag(pull * units)])
        lam = np.broadcast_to(np.asarray(self.reg_weight_lam, dtype=np.float64), shape)
        penalty = get_regularization(self.regularizer)
        linear, stable, change = self.coef_, self._moved(self.coef_), np.inf
        self.objective_history: list[float] = []
        eigenvalues, coefficients = [], []
        for k in range(self.max_iter):
            found = minimise_rows(
                rows, np.concatenate([right, pull * stable.ravel()]), units, self.regularizer, lam.ravel(), below, equal,
                self.tol, self.verbose_cvxpy,
            )  # fmt: skip
            if found is None:
                break
            before, linear = linear, found.reshape(shape)
            stable = self._moved(linear)
            self.iters += 1
            self.history_.append(linear)
            eigenvalues.append(self._eigenvalues(linear))
            coefficients.append(linear.T / self._lengths[:, None])
            moved = pull**2 * np.sum((linear - stable) ** 2)
            objective = float(np.sum((y - x @ linear.T) ** 2) + penalty(linear, lam) + moved)
            self.objective_history.append(objective)
            if self.verbose:
                print(f"{k:5d}  objective {objective:.4e}  largest real part {eigenvalues[-1][-1].real:.4e}")
            change = float(np.linalg.norm(linear - before)) / self.relax_coeff_nu
            if change < self.tol:
                break
        if not change < self.tol:
            warnings.warn(f"StableLinearSR3 did not converge after {self.iters} iterations", ConvergenceWarning)
        self.coef_, self.coef_full_ = linear, stable
        self.eigs_history, self.coef_history = np.array(eigenvalues), np.array(coefficients)
        self._warn_if_unstable()

    def _square(self, linear: Array) -> Array:
        """A, of the coefficients of normalised columns."""
        states = len(linear)
        return np.asarray(linear[:, :states] / self._lengths[:states])

    def _eigenvalues(self, linear: Array) -> Any:
        return np.sort_complex(np.linalg.eigvals(self._square(linear)))

    def _moved(self, linear: Array) -> Array:
        """Coefficients with the eigenvalues of A moved to real parts of γ at most."""
        square, states = self._square(linear), len(linear)
        values, vectors = np.linalg.eig(square)
        excess = np.maximum(values.real - self.gamma, 0.0)
        if np.linalg.cond(vectors) < 1e8:
            square = square - ((vectors * excess) @ np.linalg.inv(vectors)).real
        else:  # A has no basis of eigenvectors but for rounding: all eigenvalues are moved alike
            square = square - excess.max() * np.eye(states)
        out = linear.copy()
        out[:, :states] = square * self._lengths[:states]
        return out

    def _warn_if_unstable(self) -> None:
        largest = float(self._eigenvalues(self.coef_)[-1].real)
        if not largest < 0.0:
            warnings.warn(
                f"the model is not stable: an eigenvalue has the real part {largest:.3g}. Stable coefficients are in coef_full_; "
                "a smaller relax_coeff_nu or gamma brings coef_ closer to them"
            )
