"""Models under PySINDy's names."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Sequence
from typing import Any, TypeVar

import numpy as np
from scipy.integrate import odeint, solve_ivp
from scipy.interpolate import interp1d
from sklearn.base import BaseEstimator
from sklearn.metrics import r2_score
from sklearn.utils.validation import check_is_fitted

from .._data import Array
from ._arrays import finite_rows, flat, inputs, times, trajectories
from .differentiation import BaseDifferentiation, FiniteDifference
from .feature_library import BaseFeatureLibrary, PolynomialLibrary, WeakPDELibrary
from .optimizers import STLSQ, SINDyPI

Self = TypeVar("Self", bound="_Model")
_TIGHT = {"method": "LSODA", "rtol": 1e-12, "atol": 1e-12}
_DROPPED = "the last time is dropped, as PySINDy does with sampled inputs; a function of time as u keeps it"
_IGNORED = "u is ignored: the model was fitted without inputs"


class _Model(BaseEstimator):  # type: ignore[misc]
    """What models of continuous and of discrete time share."""

    optimizer: Any
    feature_library: BaseFeatureLibrary
    feature_names: list[str] | None
    n_control_features_: int

    def _learn(self, x: list[Array], targets: list[Array], u: list[Array] | None, names: Sequence[str] | None) -> None:
        self.n_control_features_ = 0 if u is None else u[0].shape[-1]
        joined = x if u is None else [np.concatenate(pair, axis=-1) for pair in zip(x, u)]
        terms, right = flat(self.feature_library.fit_transform(joined)), flat(targets)
        if len(terms) != len(right):
            raise ValueError(f"x, x_dot: expected as many rows, found {len(terms)} and {len(right)}")
        kept = finite_rows(terms, right)
        self.optimizer.fit(terms[kept], right[kept])
        self.n_features_in_ = self.feature_library.n_features_in_
        self.n_output_features_ = self.feature_library.n_output_features_
        states = self.n_features_in_ - self.n_control_features_
        default = [f"x{k}" for k in range(states)] + [f"u{k}" for k in range(self.n_control_features_)]
        self.feature_names = default if names is None else list(names)

    def _fitted(self) -> None:
        check_is_fitted(self, "n_features_in_")

    def _rows(self, x: Array, u: Array | None) -> Array:
        joined = x if u is None else np.concatenate([x, u], axis=-1)
        terms = self.feature_library.transform(joined)
        out: Array = np.asarray(self.optimizer.predict(terms.reshape(-1, terms.shape[-1])))
        if isinstance(self.feature_library, WeakPDELibrary):  # one row for each window
            return out
        return out.reshape(*x.shape[:-1], -1)

    def predict(self, x: Any, u: Any = None) -> Any:
        """The right-hand sides at given states and inputs; a list where `x` is one."""
        self._fitted()
        many = isinstance(x, (list, tuple))
        runs = trajectories("x", x)
        if self.n_control_features_ and u is None:
            raise TypeError("u: expected inputs, for the model was fitted with them; found none")
        if not self.n_control_features_ and u is not None:
            warnings.warn(_IGNORED, stacklevel=2)
            u = None
        given = [None] * len(runs) if u is None else inputs(u, runs, many)
        out = [self._rows(run, one) for run, one in zip(runs, given)]
        return out if many else out[0]

    def coefficients(self) -> Array:
        """Coefficients: one row for each state, one column for each of `get_feature_names`."""
        self._fitted()
        return np.atleast_2d(np.asarray(self.optimizer.coef_))

    def get_feature_names(self) -> list[str]:
        """The names of the terms."""
        self._fitted()
        return self.feature_library.get_feature_names(self.feature_names)

    def _texts(self, names: list[str], precision: int) -> list[str]:
        out = []
        for row in self.coefficients():
            shown = [f"{c: .{precision}f} {name}" for c, name in zip(row, names) if round(float(c), precision) != 0.0]
            out.append(" + ".join(shown) or f"{0.0: .{precision}f}")
        return out

    def equations(self, precision: int = 3) -> list[str]:
        """The right-hand sides as text; coefficients that round to 0 are left out."""
        return self._texts(self.get_feature_names(), precision)

    @property
    def complexity(self) -> int:
        """The number of coefficients that are not zero."""
        return int(np.count_nonzero(self.coefficients()))


class SINDy(_Model):
    """Sparse identification of a differential equation.

    Parameters
    ----------
    optimizer : BaseOptimizer, optional
        `STLSQ` by default; also an estimator of scikit-learn with ``fit_intercept=False``.
    feature_library : BaseFeatureLibrary, optional
        `PolynomialLibrary` by default.
    differentiation_method : BaseDifferentiation, optional
        `FiniteDifference` by default.
    """

    def __init__(
        self,
        optimizer: Any = None,
        feature_library: BaseFeatureLibrary | None = None,
        differentiation_method: BaseDifferentiation | None = None,
    ) -> None:
        self.optimizer = STLSQ() if optimizer is None else optimizer
        self.feature_library = PolynomialLibrary() if feature_library is None else feature_library
        given = differentiation_method is not None
        self.differentiation_method = differentiation_method if given else FiniteDifference(axis=-2)

    def _slopes(self, x: list[Array], each: list[Any]) -> tuple[list[Array], list[Array]]:
        """States, smoothed where the method smooths, and their slopes."""
        method, states, slopes = self.differentiation_method, [], []
        assert method is not None
        if isinstance(self.feature_library, WeakPDELibrary):
            return x, [self.feature_library.weak_slopes(run) for run in x]
        for run, t in zip(x, each):
            slopes.append(np.asarray(method(run, t)))
            states.append(np.asarray(getattr(method, "smoothed_x_", run)))
        return states, slopes

    def _given(self, x: list[Array], slopes: list[Array]) -> list[Array]:
        """Slopes that were given, integrated over windows where terms are."""
        library = self.feature_library
        if not isinstance(library, WeakPDELibrary):
            return slopes
        return [library.weak_slopes(run, slope) for run, slope in zip(x, slopes)]

    def fit(
        self: Self,
        x: Any,
        t: Any,
        x_dot: Any = None,
        u: Any = None,
        feature_names: Sequence[str] | None = None,
    ) -> Self:
        """Identifies a model.

        Parameters
        ----------
        x : array of shape (n_samples, n_states), or list of these
            One for each trajectory. Further axes may stand before that of time.
        t : float, array, or list of these
            A step or times.
        x_dot, u : as `x`, optional
            Slopes and inputs.
        feature_names : list of str, optional
            Names of states and inputs.
        """
        assert isinstance(self, SINDy)
        many = isinstance(x, (list, tuple))
        runs = trajectories("x", x)
        each = times(t, runs, many)
        given = None if u is None else inputs(u, runs, many)
        if x_dot is None:
            runs, slopes = self._slopes(runs, each)
        else:
            slopes = self._given(runs, trajectories("x_dot", x_dot, runs, many))
        self._learn(runs, slopes, given, feature_names)
        return self

    def differentiate(self, x: Any, t: Any = 1) -> Any:
        """The slopes by `differentiation_method`, as PySINDy 1 had it."""
        many = isinstance(x, (list, tuple))
        runs = trajectories("x", x)
        slopes = self._slopes(runs, times(t, runs, many))[1]
        return slopes if many else slopes[0]

    def print(self, lhs: Sequence[str] | None = None, precision: int = 3, **kwargs: Any) -> None:
        """Prints the equations; `lhs` replaces the left-hand sides, other options are those of Python's `print`."""
        texts = self.equations(precision)
        if lhs is not None:
            names = list(lhs)
        elif isinstance(self.optimizer, SINDyPI):
            names = [f"({name})" for name in self.get_feature_names()]
        else:
            names = [f"({name})'" for name in self.feature_names or []]
        for name, text in zip(names, texts):
            print(f"{name} = {text}", **kwargs)

    def score(
        self,
        x: Any,
        t: Any,
        x_dot: Any = None,
        u: Any = None,
        metric: Callable[..., float] = r2_score,
        **metric_kws: Any,
    ) -> float:
        """A metric of the predicted slopes, R² by default."""
        self._fitted()
        many = isinstance(x, (list, tuple))
        runs = trajectories("x", x)
        each = times(t, runs, many)
        predicted = self.predict(x, u)
        given = None if x_dot is None else trajectories("x_dot", x_dot, runs, many)
        slopes = self._slopes(runs, each)[1] if given is None else self._given(runs, given)
        return _measure(metric, slopes, predicted if many else [predicted], metric_kws)

    def simulate(
        self,
        x0: Any,
        t: Any,
        u: Any = None,
        integrator: str = "solve_ivp",
        interpolator: Callable[..., Any] | None = None,
        integrator_kws: dict[str, Any] | None = None,
        interpolator_kws: dict[str, Any] | None = None,
    ) -> Array:
        """A run of the model at given times.

        Parameters
        ----------
        x0 : array
            The states at the first time.
        t : array
            Times.
        u : array or callable, optional
            Inputs at these times, or a function of time. With an array the last time is dropped: scripts for PySINDy expect it.
        integrator : {"solve_ivp", "odeint"}
        interpolator : callable, optional
            ``interpolator(t, u, **interpolator_kws)`` gives a function of time; cubic by default.
        integrator_kws, interpolator_kws : dict, optional
            By default LSODA with tolerances of 1e-12.
        """
        self._fitted()
        if np.ndim(t) == 0:
            raise ValueError("t: expected an array of times, found a number")
        if self.n_control_features_ and u is None:
            raise TypeError("u: expected inputs, for the model was fitted with them; found none")
        if not self.n_control_features_ and u is not None:
            warnings.warn(_IGNORED, stacklevel=2)
            u = None
        if u is not None and not callable(u):
            if interpolator is None:
                u = interp1d(t, u, axis=0, kind="cubic", fill_value="extrapolate")
            else:
                u = interpolator(t, u, **(interpolator_kws or {}))
            t = t[:-1]
            warnings.warn(_DROPPED, stacklevel=2)

        def rhs(time: float, state: Array) -> Array:
            given = None if u is None else np.asarray(u(time), dtype=np.float64).reshape(1, -1)
            slope: Array = self._rows(state[None, :], given)[0]
            return slope

        options = _TIGHT if integrator_kws is None else integrator_kws
        start = np.atleast_1d(np.asarray(x0, dtype=np.float64))
        if integrator == "solve_ivp":
            return np.asarray(solve_ivp(rhs, (t[0], t[-1]), start, t_eval=t, **options).y.T)
        if integrator == "odeint":
            options = {name: value for name, value in options.items() if name != "method"}
            return np.asarray(odeint(rhs, start, t, tfirst=True, **options))
        raise ValueError(f"integrator: expected solve_ivp or odeint, found {integrator}")


class DiscreteSINDy(_Model):
    """Sparse identification of a map from one sample to the next.

    Parameters
    ----------
    optimizer : BaseOptimizer, optional
        `STLSQ` by default.
    feature_library : BaseFeatureLibrary, optional
        `PolynomialLibrary` by default.
    """

    def __init__(self, optimizer: Any = None, feature_library: BaseFeatureLibrary | None = None) -> None:
        self.optimizer = STLSQ() if optimizer is None else optimizer
        self.feature_library = PolynomialLibrary() if feature_library is None else feature_library

    def fit(
        self: Self,
        x: Any,
        t: Any,
        x_next: Any = None,
        u: Any = None,
        feature_names: Sequence[str] | None = None,
    ) -> Self:
        """Identifies a model; without `x_next`, the next sample is the next row. Other parameters as for `SINDy.fit`."""
        many = isinstance(x, (list, tuple))
        runs = trajectories("x", x)
        times(t, runs, many)
        given = None if u is None else inputs(u, runs, many)
        if x_next is None:
            after = [run[..., 1:, :] for run in runs]
            runs = [run[..., :-1, :] for run in runs]
            given = None if given is None else [one[..., :-1, :] for one in given]
        else:
            after = trajectories("x_next", x_next, runs, many)
        self._learn(runs, after, given, feature_names)
        return self

    def equations(self, precision: int = 3) -> list[str]:
        """The next samples as text; coefficients that round to 0 are left out."""
        self._fitted()
        names = [f"{name}[k]" for name in self.feature_names or []]
        return self._texts(self.feature_library.get_feature_names(names), precision)

    def print(self, precision: int = 3, **kwargs: Any) -> None:
        """Prints the equations; options are those of Python's own `print`."""
        for name, text in zip(self.feature_names or [], self.equations(precision)):
            print(f"({name})[k+1] = {text}", **kwargs)

    def score(
        self,
        x: Any,
        t: Any,
        u: Any = None,
        x_next: Any = None,
        metric: Callable[..., float] = r2_score,
        **metric_kws: Any,
    ) -> float:
        """A metric of the predicted next samples, R² by default."""
        self._fitted()
        many = isinstance(x, (list, tuple))
        runs = trajectories("x", x)
        times(t, runs, many)
        predicted = self.predict(x, u)
        predicted = predicted if many else [predicted]
        if x_next is None:
            predicted = [one[..., :-1, :] for one in predicted]
            after = [run[..., 1:, :] for run in runs]
        else:
            after = trajectories("x_next", x_next, runs, many)
        return _measure(metric, after, predicted, metric_kws)

    def simulate(
        self, x0: Any, t: int, u: Any = None, stop_condition: Callable[[Array], bool] | None = None
    ) -> Array:
        """So many samples from a first one, with inputs as an array or as a function of the sample's index.

        The run ends after the first sample at which `stop_condition` holds.
        """
        if not isinstance(t, (int, np.integer)) or t <= 0:
            raise ValueError(f"t: expected a number of samples, found {t}")
        self._fitted()
        if self.n_control_features_ and u is None:
            raise TypeError("u: expected inputs, for the model was fitted with them; found none")
        if not self.n_control_features_ and u is not None:
            warnings.warn(_IGNORED, stacklevel=2)
            u = None
        out = np.zeros((t, self.n_features_in_ - self.n_control_features_))
        out[0] = x0
        for k in range(1, t):
            given = None
            if u is not None:
                given = np.asarray(u(k - 1) if callable(u) else u[k - 1], dtype=np.float64).reshape(1, -1)
            out[k] = self._rows(out[k - 1 : k], given)[0]
            if stop_condition is not None and stop_condition(out[k]):
                return out[: k + 1]
        return out


def _measure(metric: Callable[..., float], truth: list[Array], predicted: list[Array], options: dict[str, Any]) -> float:
    true, found = flat(truth), flat(predicted)
    kept = finite_rows(true, found)
    return float(metric(true[kept], found[kept], **options))
