"""Quadratic models whose solutions stay bounded, by the trapping theorem."""

from __future__ import annotations

import warnings
from collections.abc import Callable
from itertools import permutations
from typing import Any

import numpy as np
from sklearn.exceptions import ConvergenceWarning

from ..._data import Array
from ..feature_library import PolynomialLibrary
from ..utils import get_regularization
from ._convex import Constraints, EquationLeastSquares, check_penalty, independent_rows, minimise_rows
from ._quadratic import (  # noqa: F401 - two of them for PySINDy's own tests
    Term,
    _antisymm_double_constraint,
    _antisymm_triple_constraints,
    _make_constraints,
    _places,
    _symmetric,
)
from ._sr3 import ConstrainedSR3

# η without a number: the stability term is as good as absent.
_NO_ETA = 1e20


class TrappingSR3(ConstrainedSR3):
    """Quadratic models ``x_i' = c_i + L_ij x_j + Q_ijk x_j x_k`` whose solutions stay in a bounded region.

    The quadratic part keeps the energy ``|x|²/2``: ``Q_ijk + Q_jki + Q_kij = 0``. Then all solutions end in a ball around m, if
    ``A_S(m)``, the symmetric part of ``L_ij + 2 Q_ijk m_k``, has negative eigenvalues only (Schlegel and Noack 2015,
    doi:10.1017/jfm.2014.735). The coefficients w, m and a matrix A with eigenvalues of γ at most minimise
    ``|y - X w|² + λ R(w) + |A_S(m) - A|²/η`` by turns (Kaptanoglu et al. 2021, doi:10.1103/PhysRevFluids.6.094401).
    ``method="local"`` adds ``|Q|²/α + |Q_ijk + Q_jki + Q_kij|²/β`` in place of the equations, for models whose solutions stay
    bounded near m only (Peng et al. 2024). Terms are those of ``PolynomialLibrary(2)``. λ > 0 needs the package ``clarabel``.

    A warning names the largest eigenvalue of ``A_S(m)`` where it is not negative.

    Parameters
    ----------
    _n_tgts : int, optional
        The number of states; that of the data by default.
    _include_bias, _interaction_only : bool
        Those of the `PolynomialLibrary`.
    method : {"global", "local"}
    eta : float, optional
        η; without it stability does not change w, and m is looked for all the same.
    eps_solver : float
        Tolerance of the solver, at most 1e-8.
    alpha, beta : float, optional
        α and β of the local method; without a number their terms are left out.
    mod_matrix : ndarray of shape (n_targets, n_targets), optional
        A symmetric positive definite P, for the energy ``x·P x/2``.
    alpha_A, alpha_m : float, optional
        Steps of A and m, of η at most; η and 0.01 η by default.
    gamma : float
        γ, negative.
    tol, tol_m : float
        Changes of w and of m that count as converged.
    m0, A0 : ndarray, optional
        Where m and A start: by default at random numbers from -2 to 0, the same each time, and at γ times the identity.
    reg_weight_lam, regularizer
        λ and a convex R, "l1", "l2", "weighted_l1" or "weighted_l2".
    constraint_lhs, constraint_rhs, equality_constraints, inequality_constraints, constraint_separation_index
        Constraints beside those of the energy, as for `ConstrainedSR3`.
    constraint_order : {"target", "feature"}, optional
        As for `ConstrainedSR3`; "feature" by default, and "target" with the local method.
    trimming_fraction
        Has to be 0.
    relax_coeff_nu, trimming_step_size
        There for compatibility.
    max_iter, normalize_columns, copy_X, initial_guess, verbose, verbose_cvxpy, unbias
        As for `ConstrainedSR3`.

    Attributes
    ----------
    m_history_, A_history_ : list of ndarray
        m and A, the start first.
    PW_history_, PWeigs_history_ : list of ndarray
        ``A_S`` and its eigenvalues in each iteration, at the m before its step.
    PC_, PL_unsym_, PL_, PQ_, PT_, PM_ : ndarray
        What makes constants, L, the symmetric part of L, Q, Q_jik and Q_ijk + Q_jik of the coefficients, in the last two axes.
    objective_history : list of float
    """

    def __init__(
        self,
        *,
        _n_tgts: int | None = None,
        _include_bias: bool = False,
        _interaction_only: bool = False,
        method: str = "global",
        eta: float | None = None,
        eps_solver: float = 1e-7,
        alpha: float | None = None,
        beta: float | None = None,
        mod_matrix: Any = None,
        alpha_A: float | None = None,
        alpha_m: float | None = None,
        gamma: float = -0.1,
        tol_m: float = 1e-5,
        regularizer: str = "l1",
        m0: Any = None,
        A0: Any = None,
        reg_weight_lam: Any = 0.005,
        relax_coeff_nu: float = 1.0,
        tol: float = 1e-5,
        max_iter: int = 30,
        trimming_fraction: float = 0.0,
        trimming_step_size: float = 1.0,
        constraint_lhs: Any = None,
        constraint_rhs: Any = None,
        constraint_order: str | None = None,
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
        self._n_tgts, self._include_bias, self._interaction_only = _n_tgts, _include_bias, _interaction_only
        self.method, self.mod_matrix, self.gamma, self.m0, self.A0 = method, mod_matrix, gamma, m0, A0
        self.eta, self.alpha, self.beta, self.alpha_A, self.alpha_m = eta, alpha, beta, alpha_A, alpha_m
        self.eps_solver, self.tol_m = eps_solver, tol_m
        # Its type has no None, which stands for the order of the method.
        order: Any = constraint_order
        super().__init__(
            reg_weight_lam, regularizer, relax_coeff_nu, tol, max_iter, trimming_fraction, trimming_step_size, constraint_lhs,
            constraint_rhs, order, normalize_columns, copy_X, initial_guess, equality_constraints, inequality_constraints,
            constraint_separation_index, verbose, verbose_cvxpy, unbias,
        )  # fmt: skip

    def _check(self) -> None:
        super()._check()
        check_penalty(self.regularizer)
        if self.method not in ("global", "local"):
            raise ValueError(f"method: expected global or local, found {self.method}")
        for name in ("eta", "alpha", "beta", "eps_solver", "tol_m"):
            value = getattr(self, name)
            if value is not None and not value > 0:
                raise ValueError(f"{name}: expected a number above 0, found {value}")
        for name in ("alpha_A", "alpha_m"):
            value = getattr(self, name)
            if value is not None and self.eta is not None and not 0 <= value <= self.eta:
                raise ValueError(f"{name}: expected a number from 0 to eta, found {value}")
        if not self.gamma < 0:
            raise ValueError(f"gamma: expected a number below 0, found {self.gamma}")
        if self.inequality_constraints and np.any(np.asarray(self.reg_weight_lam) == 0.0):
            raise ValueError("reg_weight_lam: expected numbers above 0 with inequalities, found 0")
        if self.use_trimming:
            raise ValueError(f"trimming_fraction: expected 0, found {self.trimming_fraction}")
        if self.unbias and self.method == "global":
            raise ValueError("unbias: expected False, for it does not keep the energy; found True")
        if self.mod_matrix is not None:
            matrix = np.asarray(self.mod_matrix, dtype=np.float64)
            if matrix.ndim != 2 or not np.array_equal(matrix, matrix.T) or np.linalg.eigvalsh(matrix)[0] <= 0:
                raise ValueError("mod_matrix: expected a symmetric positive definite matrix")

    @property
    def _order(self) -> Any:
        return self.constraint_order or ("feature" if self.method == "global" else "target")

    @staticmethod
    def _build_PL(polyterms: list[Term]) -> tuple[Array, Array]:
        """What makes the symmetric part of L of coefficients, and L."""
        targets = len(polyterms[0][1])
        out = np.zeros((targets, targets, targets, len(polyterms)))
        for state, place in _places(polyterms)[0].items():
            out[range(targets), state, range(targets), place] = 1.0
        return _symmetric(out), out

    @staticmethod
    def _build_PQ(polyterms: list[Term]) -> Array:
        """What makes Q of coefficients, symmetric in its last two states."""
        targets = len(polyterms[0][1])
        out = np.zeros((targets, targets, targets, targets, len(polyterms)))
        _, squares, products = _places(polyterms)
        for state, place in squares.items():
            out[range(targets), state, state, range(targets), place] = 1.0
        for pair, place in products.items():
            for j, k in permutations(pair):
                out[range(targets), j, k, range(targets), place] = 0.5
        return out

    def _set_operators(self, targets: int, terms: int) -> None:
        """What makes matrices of coefficients; those without a public name are of normalised columns, in units of √P x."""
        library = PolynomialLibrary(2, include_bias=self._include_bias, interaction_only=self._interaction_only)
        polyterms = list(enumerate(library.fit(np.zeros((1, targets))).powers_))
        if len(polyterms) != terms:
            wanted = f"PolynomialLibrary(2, include_bias={self._include_bias}, interaction_only={self._interaction_only})"
            raise ValueError(
                f"x_: expected the {len(polyterms)} terms of {wanted} for {targets} states, found {terms}; "
                "_include_bias and _interaction_only have to be those of the library"
            )
        self.PC_ = np.zeros((targets, targets, len(polyterms)))
        self.PC_[range(targets), range(targets), 0] = float(self._include_bias)
        self.PL_, self.PL_unsym_ = self._build_PL(polyterms)
        self.PQ_ = self._build_PQ(polyterms)
        self.PT_ = np.swapaxes(self.PQ_, 0, 1)
        self.PM_ = self.PQ_ + self.PT_
        if self._n_tgts not in (None, targets):
            raise ValueError(f"_n_tgts: expected {targets}, the number of targets; found {self._n_tgts}")
        energy = np.eye(targets) if self.mod_matrix is None else np.asarray(self.mod_matrix, dtype=np.float64)
        if len(energy) != targets:
            raise ValueError(f"mod_matrix: expected {targets} rows, found {len(energy)}")
        values, vectors = np.linalg.eigh(energy)
        root, inverse = (vectors * np.sqrt(values)) @ vectors.T, (vectors / np.sqrt(values)) @ vectors.T
        self._energy, self._inverse_root = energy, inverse
        # A_S is the first at m = 0 and grows by the second with m.
        self._growth_0 = _symmetric(np.einsum("ya,abtf,bz->yztf", root, self.PL_unsym_, inverse)) / self._lengths
        self._growth_m = _symmetric(np.einsum("ya,abctf,bz->yzctf", root, 2.0 * self.PQ_, inverse)) / self._lengths

    def _local_rows(self) -> Array:
        """Rows over the coefficients whose squares the local method adds."""
        quadratic = self.PQ_ / self._lengths
        count = quadratic.shape[-1] * quadratic.shape[-2]
        rows = [np.zeros((0, count))]
        if self.method == "local" and self.alpha is not None:
            rows.append(quadratic.reshape(-1, count) / np.sqrt(self.alpha))
        if self.method == "local" and self.beta is not None:
            growth = np.einsum("xi,ijktf->xjktf", self._energy, quadratic)
            growth = growth + np.einsum("ijktf->jkitf", growth) + np.einsum("ijktf->kijtf", growth)
            growth = np.einsum("xi,yj,zk,ijktf->xyztf", *[self._inverse_root] * 3, growth)
            rows.append(growth.reshape(-1, count) / np.sqrt(self.beta))
        return np.concatenate(rows)

    def _sides(self, terms: int, targets: int) -> tuple[Constraints, Constraints]:
        below, equal = super()._sides(terms, targets)
        if self.method == "local":
            return below, equal
        right, rows = _make_constraints(targets, include_bias=self._include_bias, interaction_only=self._interaction_only)
        rows = np.swapaxes(rows @ self._energy, 1, 2) / self._lengths
        rows = rows.reshape(len(rows), -1)
        if equal is not None:
            rows, right = np.concatenate([equal[0], rows]), np.concatenate([equal[1], right])
        return below, (rows, right)

    def _regression(self, x: Array, y: Array) -> Callable[[Array, Array], Array | None]:
        """A function that finds w, given the rows and right sides of the stability term."""
        shape = (y.shape[1], x.shape[1])
        data, right, units = independent_rows(x, y)
        data = np.concatenate([data, self._local * units])
        right = np.concatenate([right, np.zeros(len(self._local))])
        lam = np.broadcast_to(np.asarray(self.reg_weight_lam, dtype=np.float64), shape).ravel()
        below, equal = self._sides(shape[1], shape[0])
        if below is None and not lam.any():
            scaled = None if equal is None else (equal[0] * units, equal[1])
            problem = EquationLeastSquares(data, right, scaled)

            def find(more: Array, more_right: Array) -> Array | None:
                found = problem.solve(more * units, more_right)
                return None if found is None else (units * found).reshape(shape)
        else:

            def find(more: Array, more_right: Array) -> Array | None:
                rows, all_right = np.concatenate([data, more * units]), np.concatenate([right, more_right])
                found = minimise_rows(
                    rows, all_right, units, self.regularizer, lam, below, equal, self.eps_solver, self.verbose_cvxpy
                )
                return None if found is None else found.reshape(shape)

        return find

    def _reduce(self, x: Array, y: Array) -> None:
        targets = y.shape[1]
        # As PySINDy's, without a change of the state of numpy.random.
        random = 2.0 * (np.random.RandomState(1).rand(targets) - 1.0)
        center = random if self.m0 is None else np.asarray(self.m0, dtype=np.float64)
        proxy = self.gamma * np.eye(targets) if self.A0 is None else np.asarray(self.A0, dtype=np.float64)
        if center.shape != (targets,) or proxy.shape != (targets, targets):
            raise ValueError(f"m0, A0: expected {targets} states, found the shapes {center.shape} and {proxy.shape}")
        self.m_history_, self.A_history_ = [center], [proxy]
        self.PW_history_: list[Array] = []
        self.PWeigs_history_: list[Array] = []
        self.objective_history: list[float] = []
        self.history_ = []
        converged = self.max_iter > 0 and self._iterate(x, y)
        self.coef_full_ = self.coef_
        said = ""
        if self.history_:
            growth = self._growth(self.m_history_[-1])
            largest = float(np.linalg.eigvalsh(np.tensordot(growth, self.coef_, axes=2))[-1])
            if not largest < 0.0:
                said = f"the largest eigenvalue of A_S(m) is {largest:.3g}, so solutions may be unbounded"
        if not converged:
            said = said and f"; {said}"
            warnings.warn(f"TrappingSR3 did not converge after {self.iters} iterations{said}", ConvergenceWarning)
        elif said:
            warnings.warn(f"{said}. A smaller eta or another m0 may help")

    def _growth(self, center: Array) -> Array:
        """What makes A_S(m) of coefficients."""
        return np.asarray(self._growth_0 + np.einsum("ijctf,c->ijtf", self._growth_m, center))

    def _iterate(self, x: Array, y: Array) -> bool:
        """Finds w, m and A by turns; whether they converged."""
        targets, terms = y.shape[1], x.shape[1]
        self._set_operators(targets, terms)
        self._local = self._local_rows()
        eta, step, share = self._steps()
        find = self._regression(x, y)
        for k in range(self.max_iter):
            center, proxy, before = self.m_history_[-1], self.A_history_[-1], self.coef_
            growth = self._growth(center)
            found = find(growth.reshape(targets**2, -1) / np.sqrt(eta), proxy.ravel() / np.sqrt(eta))
            if found is None:
                return False
            self.coef_ = found
            matrix = np.tensordot(growth, found, axes=2)
            slopes = np.tensordot(self._growth_m, found, axes=2)
            moved = center + step * np.einsum("ijc,ij->c", slopes, proxy - matrix)
            values, vectors = np.linalg.eigh(proxy - share * (proxy - matrix))
            proxy = (vectors * np.minimum(values, self.gamma)) @ vectors.T
            self.iters += 1
            self.history_.append(found)
            self.m_history_.append(moved)
            self.A_history_.append(proxy)
            self.PW_history_.append(matrix)
            self.PWeigs_history_.append(np.asarray(np.linalg.eigvalsh(matrix), dtype=np.float64))
            self.objective_history.append(self._objective(x, y, found.T, proxy, matrix, k))
            if np.abs(moved - center).sum() < self.tol_m and np.linalg.norm(found - before) < self.tol:
                return True
        return False

    def _steps(self) -> tuple[float, float, float]:
        """η, the step of m along the gradient of ``|A_S(m) - A|²/2``, and the step of A.

        The step of m is half of α_m/η: so are PySINDy's, whose gradient is half of this one where the energy is kept.
        """
        if self.eta is None:
            return _NO_ETA, 0.005, 1.0
        step = 0.005 if self.alpha_m is None else self.alpha_m / self.eta / 2.0
        return self.eta, step, 1.0 if self.alpha_A is None else self.alpha_A / self.eta

    def _objective(self, x: Array, y: Array, coef_sparse: Array, A: Array, PW: Array, k: int) -> float:
        """Half of what is minimised; printed where that is asked for."""
        parts = [np.sum((y - x @ coef_sparse) ** 2), np.sum((A - PW) ** 2) / (_NO_ETA if self.eta is None else self.eta)]
        weights = self.reg_weight_lam.T if isinstance(self.reg_weight_lam, np.ndarray) else self.reg_weight_lam
        parts.append(get_regularization(self.regularizer)(coef_sparse, weights))
        if self.method == "local":
            parts.append(np.sum((self._local @ coef_sparse.T.ravel()) ** 2))
        out = 0.5 * float(sum(parts))
        if self.verbose:
            print(f"{k:5d}  objective {out:.4e}  error {parts[0] / 2:.4e}  stability {parts[1] / 2:.4e}")
        return out
