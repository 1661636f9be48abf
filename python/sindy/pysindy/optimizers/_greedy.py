"""Terms taken away, or added, one at a time."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..._data import Array
from ._base import BaseOptimizer, ridge


class SSR(BaseOptimizer):
    """Stepwise regression: from all terms, the least important one is dropped at a time.

    Parameters
    ----------
    alpha : float
        Ridge of the regressions.
    max_iter : int
        Terms to drop from each equation at most.
    ridge_kw : dict, optional
        There for compatibility.
    criteria : {"coefficient_value", "model_residual"}
        Whether the smallest coefficient goes, or the term without which the residual is smallest.
    kappa : float, optional
        What a term costs, times the condition number of the terms. Without it, the number of terms is where the squared
        residual grows by the largest factor when one more is dropped.
    normalize_columns, copy_X, unbias
        As for `BaseOptimizer`.
    verbose : bool
        Whether every step is printed.

    Attributes
    ----------
    history_, err_history_ : list
        Coefficients and squared residuals (with the cost of terms), from all terms to few.
    """

    _starts = False

    def __init__(
        self,
        alpha: float = 0.05,
        max_iter: int = 20,
        ridge_kw: dict[str, Any] | None = None,
        normalize_columns: bool = False,
        copy_X: bool = True,
        criteria: str = "coefficient_value",
        kappa: float | None = None,
        verbose: bool = False,
        unbias: bool = True,
    ) -> None:
        self.alpha = alpha
        self.ridge_kw = ridge_kw
        self.criteria = criteria
        self.kappa = kappa
        self.verbose = verbose
        super().__init__(max_iter, normalize_columns, None, copy_X, unbias)

    def _check(self) -> None:
        super()._check()
        if self.alpha < 0:
            raise ValueError(f"alpha: expected at least 0, found {self.alpha}")
        if self.criteria not in ("coefficient_value", "model_residual"):
            raise ValueError(f"criteria: expected coefficient_value or model_residual, found {self.criteria}")

    def _least(self, x: Array, y: Array, kept: Any, coefficients: Array) -> int:
        """The term of a support to drop next."""
        if self.criteria == "coefficient_value":
            return int(kept[np.argmin(np.abs(coefficients[kept]))])
        errors = []
        for k in range(len(kept)):
            rest = np.delete(kept, k)
            errors.append(float(np.sum((y - x[:, rest] @ ridge(x[:, rest], y, self.alpha)) ** 2)))
        return int(kept[np.argmin(errors)])

    def _reduce(self, x: Array, y: Array) -> None:
        price = 0.0 if self.kappa is None else self.kappa * float(np.linalg.cond(x))
        coefficients = ridge(x, y, self.alpha)
        supports = [np.arange(x.shape[1]) for _ in range(y.shape[1])]

        def error() -> float:
            return float(np.sum((y - x @ coefficients.T) ** 2)) + price * np.count_nonzero(coefficients)

        self.history_, self.err_history_ = [coefficients.copy()], [error()]
        for k in range(self.max_iter):
            if all(len(kept) <= 1 for kept in supports):
                break
            for i, kept in enumerate(supports):
                if len(kept) > 1:
                    rest = kept[kept != self._least(x, y[:, i], kept, coefficients[i])]
                    coefficients[i] = 0.0
                    coefficients[i, rest] = ridge(x[:, rest], y[:, i], self.alpha)
                    supports[i] = rest
            self.history_.append(coefficients.copy())
            self.err_history_.append(error())
            if self.verbose:
                print(f"{k:5d}  error {self.err_history_[-1]:.4e}  terms {np.count_nonzero(coefficients)}")
        self.coef_ = self.history_[self._best()].copy()

    def _best(self) -> int:
        errors = np.asarray(self.err_history_)
        if self.kappa is not None or len(errors) == 1:
            return int(np.argmin(errors))
        if np.any(errors == 0.0):
            return int(np.flatnonzero(errors == 0.0)[-1])
        return int(np.argmax(errors[1:] / errors[:-1]))


class FROLS(BaseOptimizer):
    """Forward regression by orthogonal least squares: the term that explains most of what is unexplained is added at a time.

    Terms that are combinations of those taken are not added.

    Parameters
    ----------
    normalize_columns, copy_X, unbias
        As for `BaseOptimizer`.
    kappa : float, optional
        What a term costs, as a share of the target's sum of squares, times the condition number of the terms. Without it
        as many terms are taken as `max_iter` allows.
    max_iter : int
        Terms of an equation at most.
    alpha : float
        Ridge of the coefficients on the terms found, where `unbias` is False.
    ridge_kw : dict, optional
        There for compatibility.
    verbose : bool
        Whether every term is printed.

    Attributes
    ----------
    ERR_global : ndarray of shape (n_terms, n_targets)
        Error reduction ratios, in the order in which terms were added.
    loss_ : ndarray of shape (n_terms + 1, n_targets)
        The unexplained share of each number of terms, with the cost of terms; infinite where not tried.
    """

    _starts = False

    def __init__(
        self,
        normalize_columns: bool = False,
        copy_X: bool = True,
        kappa: float | None = None,
        max_iter: int = 10,
        alpha: float = 0.05,
        ridge_kw: dict[str, Any] | None = None,
        verbose: bool = False,
        unbias: bool = True,
    ) -> None:
        self.kappa = kappa
        self.alpha = alpha
        self.ridge_kw = ridge_kw
        self.verbose = verbose
        super().__init__(max_iter, normalize_columns, None, copy_X, unbias)

    def _order(self, x: Array, y: Array) -> tuple[list[int], list[float]]:
        """Terms in the order of their error reduction ratios, and these."""
        left, target = x.copy(), y.copy()
        total = float(y @ y)
        squares = np.sum(x * x, axis=0)
        order: list[int] = []
        ratios: list[float] = []
        for _ in range(min(self.max_iter, x.shape[1])):
            remaining = np.sum(left * left, axis=0)
            # A column that lies in the span of those taken is left with rounding: 1e-12 of its square.
            free = remaining > 1e-12 * squares
            free[order] = False
            if not free.any():
                break
            gain = np.zeros(x.shape[1])
            gain[free] = (target @ left[:, free]) ** 2 / remaining[free]
            best = int(np.argmax(np.where(free, gain, -1.0)))
            unit = left[:, best] / np.sqrt(remaining[best])
            target = target - unit * (unit @ target)
            left = left - np.outer(unit, unit @ left)
            order.append(best)
            ratios.append(float(gain[best]) / total if total > 0.0 else 0.0)
        return order, ratios

    def _reduce(self, x: Array, y: Array) -> None:
        price = 0.0 if self.kappa is None else self.kappa * float(np.linalg.cond(x))
        terms, targets = x.shape[1], y.shape[1]
        self.ERR_global = np.zeros((terms, targets))
        self.loss_ = np.full((terms + 1, targets), np.inf)
        steps = np.zeros((min(self.max_iter, terms) + 1, targets, terms))
        self.coef_ = np.zeros((targets, terms))
        for i in range(targets):
            order, ratios = self._order(x, y[:, i])
            count = len(order)
            self.ERR_global[:count, i] = ratios
            self.loss_[: count + 1, i] = 1.0 - np.cumsum([0.0, *ratios]) + price * np.arange(count + 1)
            for k in range(1, count + 1):
                steps[k, i, order[:k]] = ridge(x[:, order[:k]], y[:, i], self.alpha)
            chosen = count if self.kappa is None else int(np.argmin(self.loss_[:, i]))
            self.coef_[i] = steps[chosen, i]
            if self.verbose:
                print(f"{i:5d}  terms {chosen}  unexplained share {self.loss_[chosen, i]:.4e}")
        self.history_ = list(steps)
