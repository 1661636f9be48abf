"""What optimizers share, and those that wrap others."""

from __future__ import annotations

import warnings
from collections.abc import Callable
from typing import Any, TypeVar

import numpy as np
from sklearn.base import BaseEstimator, MultiOutputMixin, RegressorMixin
from sklearn.utils.validation import check_is_fitted

from ..._data import Array
from .._arrays import finite_rows

Self = TypeVar("Self", bound="BaseOptimizer")

# Coefficients that are zero but for rounding: far below any term's, above what a regression of scaled columns leaves.
ZERO = 1e-14


def least_squares(x: Array, y: Array) -> Array:
    """Coefficients of least squares, the shortest where they are not unique; one row for each target."""
    return np.asarray(np.linalg.lstsq(x, y, rcond=None)[0].T, dtype=np.float64)


def ridge(x: Array, y: Array, penalty: Any) -> Array:
    """Least squares with ``penalty * coefficient²`` added, a number or one for each column."""
    rows = np.diag(np.sqrt(np.broadcast_to(np.asarray(penalty, dtype=np.float64), (x.shape[1],))))
    below = np.zeros((x.shape[1], *y.shape[1:]))
    return least_squares(np.concatenate([x, rows]), np.concatenate([y, below]))


def on_support(x: Array, y: Array, support: Any) -> Array:
    """Plain least squares on the terms of each target's support."""
    out = np.zeros((y.shape[1], x.shape[1]))
    for i, kept in enumerate(support):
        if kept.any():
            out[i, kept] = least_squares(x[:, kept], y[:, i])
    return out


class BaseOptimizer(RegressorMixin, MultiOutputMixin, BaseEstimator):  # type: ignore[misc]
    """An optimizer. One of one's own defines ``_reduce(x, y)``, which sets ``coef_``.

    Parameters
    ----------
    max_iter : int
        Iterations at most.
    normalize_columns : bool
        Whether columns are divided by their Euclidean length first. Coefficients are scaled back.
    initial_guess : ndarray of shape (n_targets, n_terms), optional
        Where to start; least squares by default.
    copy_X : bool
        There for compatibility: data are never overwritten.
    unbias : bool
        Whether plain least squares on the terms found gives the coefficients.

    Attributes
    ----------
    coef_ : ndarray of shape (n_targets, n_terms)
    ind_ : ndarray of bool
        Which coefficients are not zero.
    history_ : list
        Coefficients over the iterations, as far as they are kept.
    """

    coef_: Array
    ind_: Any
    history_: list[Array]
    # Whether `_reduce` starts from `coef_`.
    _starts = True

    def __init__(
        self,
        max_iter: int = 20,
        normalize_columns: bool = False,
        initial_guess: Any = None,
        copy_X: bool = True,
        unbias: bool = True,
    ) -> None:
        self.max_iter = max_iter
        self.normalize_columns = normalize_columns
        self.initial_guess = initial_guess
        self.copy_X = copy_X
        self.unbias = unbias
        self._check()

    def _check(self) -> None:
        """Raises where settings are not allowed; called after every change by `set_params`."""
        if not self.max_iter > 0:
            raise ValueError(f"max_iter: expected a number above 0, found {self.max_iter}")

    def set_params(self: Self, **params: Any) -> Self:
        """Sets parameters by name and checks them."""
        super().set_params(**params)
        self._check()
        return self

    def _reduce(self, x: Array, y: Array) -> None:
        raise NotImplementedError

    def fit(self: Self, x_: Any, y: Any, sample_weight: Any = None, **reduce_kws: Any) -> Self:
        """Finds coefficients. Rows with NaN are left out.

        Parameters
        ----------
        x_ : array of shape (n_samples, n_terms)
        y : array of shape (n_samples,) or (n_samples, n_targets)
        sample_weight : array, optional
            A weight for each row.
        """
        x = np.asarray(x_, dtype=np.float64)
        y = np.asarray(y, dtype=np.float64)
        y = y.reshape(-1, 1) if y.ndim == 1 else y
        if x.ndim != 2 or len(x) != len(y):
            raise ValueError(f"x_, y: expected matrices with as many rows, found the shapes {x.shape} and {y.shape}")
        if sample_weight is not None:
            root = np.sqrt(np.broadcast_to(np.asarray(sample_weight, dtype=np.float64), (len(x),)))[:, None]
            x, y = x * root, y * root
        kept = finite_rows(x, y)
        if not kept.all():
            x, y = x[kept], y[kept]
        if not (np.isfinite(x).all() and np.isfinite(y).all()) or not len(x):
            raise ValueError("x_, y: expected finite rows, found infinite values or no row without NaN")
        self.n_features_in_ = x.shape[1]
        self.Theta_ = x
        lengths = np.ones(x.shape[1])
        if self.normalize_columns:
            lengths = np.linalg.norm(x, axis=0)
            lengths[lengths == 0.0] = 1.0
            x = x / lengths
        self._lengths = lengths
        self._start(x, y)
        self._reduce(x, y, **reduce_kws)
        self.ind_ = np.abs(self.coef_) > ZERO
        if self.unbias:
            self._unbias(x, y)
        if self.normalize_columns:
            self._scale_back(lengths)
        self.intercept_ = 0.0
        return self

    def _start(self, x: Array, y: Array) -> None:
        shape = (y.shape[1], x.shape[1])
        self.iters = 0
        self.ind_ = np.ones(shape, dtype=bool)
        if self.initial_guess is not None:
            guess = np.atleast_2d(np.asarray(self.initial_guess, dtype=np.float64))
            if guess.shape != shape:
                raise ValueError(f"initial_guess: expected the shape {shape}, found {guess.shape}")
            self.coef_ = guess
        else:
            self.coef_ = least_squares(x, y) if self._starts else np.zeros(shape)
        self.history_ = [self.coef_]

    def _unbias(self, x: Array, y: Array) -> None:
        self.coef_ = on_support(x, y, self.ind_)

    def _scale_back(self, lengths: Array) -> None:
        self.coef_ = self.coef_ / lengths
        self.history_ = [one / lengths for one in self.history_]

    def predict(self, x: Any) -> Array:
        """The targets of the coefficients found."""
        check_is_fitted(self, "coef_")
        out: Array = np.asarray(x, dtype=np.float64) @ self.coef_.T
        return out

    @property
    def complexity(self) -> int:
        """The number of coefficients that are not zero."""
        check_is_fitted(self, "coef_")
        return int(np.count_nonzero(self.coef_))


class WrappedOptimizer(BaseOptimizer):
    """Any estimator of scikit-learn's kind that has ``coef_``, fitted to one target at a time.

    Parameters
    ----------
    optimizer : estimator
        With ``fit_intercept=False`` where it has one.
    max_iter, normalize_columns, initial_guess, copy_X, unbias
        As for `BaseOptimizer`.
    """

    _starts = False

    def __init__(
        self,
        optimizer: Any,
        max_iter: int = 20,
        normalize_columns: bool = False,
        initial_guess: Any = None,
        copy_X: bool = True,
        unbias: bool = True,
    ) -> None:
        super().__init__(max_iter, normalize_columns, initial_guess, copy_X, unbias)
        self.optimizer = optimizer

    def _reduce(self, x: Array, y: Array) -> None:
        from sklearn.multioutput import MultiOutputRegressor

        fitted = MultiOutputRegressor(self.optimizer).fit(x, y)
        self.estimators_ = fitted.estimators_
        rows = [np.asarray(one.coef_, dtype=np.float64).reshape(-1, x.shape[1]) for one in fitted.estimators_]
        self.coef_ = np.concatenate(rows)


class EnsembleOptimizer(BaseOptimizer):
    """The median of an optimizer's coefficients over resampled rows, over thinned libraries, or both.

    Random numbers are those of ``numpy.random``; ``numpy.random.seed`` makes them reproducible.

    Parameters
    ----------
    opt : BaseOptimizer
    bagging : bool
        Whether rows are resampled.
    library_ensemble : bool
        Whether terms are left out at random.
    n_models : int
        How many fits.
    n_subset : int, optional
        Rows of each fit: all of them, or 60 % without replacement.
    n_candidates_to_drop : int
        Terms that each fit leaves out.
    replace : bool
        Whether a row can be drawn twice.
    ensemble_aggregator : callable, optional
        What makes one matrix of the list of coefficients; the median by default.

    Attributes
    ----------
    coef_list : list of ndarray
        The coefficients of each fit of the last call of `fit`.
    """

    _starts = False

    def __init__(
        self,
        opt: BaseOptimizer,
        bagging: bool = False,
        library_ensemble: bool = False,
        n_models: int = 20,
        n_subset: int | None = None,
        n_candidates_to_drop: int = 1,
        replace: bool = True,
        ensemble_aggregator: Callable[[list[Array]], Array] | None = None,
    ) -> None:
        self.opt = opt
        self.bagging = bagging
        self.library_ensemble = library_ensemble
        self.n_models = n_models
        self.n_subset = n_subset
        self.n_candidates_to_drop = n_candidates_to_drop
        self.replace = replace
        self.ensemble_aggregator = ensemble_aggregator
        super().__init__(max_iter=getattr(opt, "max_iter", 20), unbias=False)

    def _check(self) -> None:
        super()._check()
        if not (self.bagging or self.library_ensemble):
            raise ValueError("bagging, library_ensemble: expected one of them at least, found neither")
        if self.n_models < 1:
            raise ValueError(f"n_models: expected at least 1, found {self.n_models}")
        if self.bagging and self.n_subset is not None and self.n_subset < 1:
            raise ValueError(f"n_subset: expected at least 1, found {self.n_subset}")
        if self.library_ensemble and not (self.n_candidates_to_drop or 0) >= 1:
            raise ValueError(f"n_candidates_to_drop: expected at least 1, found {self.n_candidates_to_drop}")

    def _reduce(self, x: Array, y: Array) -> None:
        rows, terms = x.shape
        draw = self.n_subset or (rows if self.replace else int(0.6 * rows))
        if self.bagging and not self.replace and draw > rows:
            warnings.warn(f"n_subset: {draw} rows cannot be drawn from {rows} without replacement; all are taken")
            draw = rows
        drop = self.n_candidates_to_drop if self.library_ensemble else 0
        if drop >= terms:
            warnings.warn(f"n_candidates_to_drop: {drop} of {terms} terms leave none; no term is left out")
            drop = 0
        self.coef_list: list[Array] = []
        for _ in range(self.n_models):
            some = np.random.choice(rows, draw, replace=self.replace) if self.bagging else np.arange(rows)
            kept = np.sort(np.random.choice(terms, terms - drop, replace=False))
            self.opt.fit(x[np.ix_(some, kept)], y[some])
            coefficients = np.zeros((y.shape[1], terms))
            coefficients[:, kept] = self.opt.coef_
            self.coef_list.append(coefficients)
        combine = self.ensemble_aggregator or (lambda found: np.median(found, axis=0))
        self.coef_ = np.asarray(combine(self.coef_list))
