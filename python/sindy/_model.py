"""The estimator."""

from __future__ import annotations

import json
import warnings
from collections.abc import Sequence
from numbers import Integral
from types import SimpleNamespace
from typing import Any, Literal, TypeVar

import numpy as np

from . import _native, _settings
from ._data import Array, Data, Given, collect, floats, is_many, matrix, table
from ._derivative import Differentiator, describe
from ._errors import SindyError, SindyWarning, fault
from ._library import Library, libraries
from ._run import Run
from ._sklearn import Estimator
from ._solvers import Solver, default, dumps, threads
from ._weak import WeakForm
from ._written import Written

Method = Literal["automatic", "output_error", "regression"]
Noise = Literal["automatic", "measurement", "process", "both"]
Self = TypeVar("Self", bound="SINDy")


class SINDy(Estimator, Written):
    """Sparse identification of nonlinear dynamics.

    Without a solver the automatic call of the library chooses smoothing, terms and coefficients from the data and says
    why. With one, slopes are made as `smoothing` says (or given as ``x_dot``), and the solver chooses the terms.

    Parameters
    ----------
    library : str, sequence of str, Library, or table of these by state, optional
        Candidate terms; ``poly(3)`` without one.
    solver : Solver, optional
        `STLSQ`, `SR3`, `Stepwise`, `BestSubset`, or none for the automatic call (with ``x_dot``: best subsets by the Bayesian
        criterion).
    smoothing : str, dict, Differentiator or WeakForm
        ``automatic``, ``weak``, ``spline``, ``kalman``, ``{"savitzky_golay": {"window": 41, "degree": 3}}`` or
        ``{"finite_difference": {"order": 4}}``. Beside a solver also `FiniteDifference`, `SavitzkyGolay`, `SmoothingSpline`,
        `KalmanSmoother`, `Spectral` or `WeakForm`.
    method : {"automatic", "output_error", "regression"}
        How the automatic call determines coefficients.
    discrete : bool
        Whether the equations give the next sample instead of the slope.
    states, inputs : sequence of str, optional
        Names; those of a table's columns, else ``x0, x1, …`` and ``u0, u1, …``. In a table they choose the columns.
    known : sequence of str, optional
        Parts of equations that are known, as for ``sindy fit --known``. ``x' = v`` is the whole equation of x, ``v' = -9.81 +
        ...`` a part of it: the rest is looked for. In discrete time ``x[k+1] = y``. Known terms have no standard error. Of the
        automatic call only.
    signs : sequence of str, optional
        Signs that coefficients must have, as for ``sindy fit --sign``. With ``v': v < 0`` the term v in the equation of v has a
        coefficient below 0, or is left out. In discrete time ``x[k+1]: x > 0``. A warning names signs that the data
        contradict. Of the automatic call only.
    conserve : sequence of str, optional
        Invariants that the equations keep exactly, as for ``sindy fit --conserve``: expressions of the states such as ``v^2/2 -
        cos(x)``. A warning tells where the data contradict them. Of the automatic call only, in continuous time, and not beside
        ``known`` or ``signs``.
    constraints : sequence of str, optional
        Linear relations between coefficients that hold exactly, as for ``sindy fit --constraint``: with ``[x': y] = -[y': x]`` the
        coefficient of y in the equation of x is minus that of x in the equation of y. A warning tells where the data contradict
        them. Of the automatic call only, in continuous time, and not beside ``signs``.
    stable : bool
        Whether all trajectories of the model must stay bounded, as for ``sindy fit --stable``. The library is linear in the states,
        or of degree 2 in them. Of the automatic call only, in continuous time, and not beside what is known or kept.
    noise : {"automatic", "measurement", "process", "both"}
        Where noise comes from, as for ``sindy fit --noise``: the measurement, disturbances of the system, or both. Of the automatic
        call only.
    diffusion : sequence of str, optional
        Candidate terms of the squared diffusion of each state, as for ``sindy fit --diffusion``, beside ``noise="process"`` or
        ``noise="both"``. Of the automatic call only.
    settings : dict, optional
        Further settings of the automatic call: those of ``sindy settings``, section ``identify``, such as ``{"penalty": 2.0}``.
    n_jobs : int, optional
        Threads; as many as processors without a number. Results do not depend on it, to the bit.

    Attributes
    ----------
    coef_ : ndarray of shape (n_states, n_terms)
        Coefficients of the terms of `get_feature_names`.
    std_error_, inclusion_ : ndarray of shape (n_states, n_terms)
        Standard errors, and probabilities that a term belongs there; NaN where unknown.
    feature_names_in_, input_names_ : ndarray of str
        Names of states and inputs.
    equations_ : list
        Of the automatic call: noise, residual, disturbance and diffusion of a disturbed system, confidence intervals and the front of terms against error of each state. Of
        a solver: its outcome.
    choice_ : SimpleNamespace
        What was chosen, and its `reason`.
    warnings_ : list of str
        What a user should know. Each was also a `SindyWarning`.

    Examples
    --------
    >>> import numpy as np, sindy
    >>> t = np.arange(0.0, 20.0, 0.01)
    >>> u = np.sin(3.0 * t)
    >>> x = 1.3 * np.exp(-t) + 0.1 * np.sin(3.0 * t) - 0.3 * np.cos(3.0 * t)  # x' = -x + u
    >>> model = sindy.SINDy("poly(1)", states=["x"], inputs=["u"]).fit(x, t, u=u)
    >>> model.equations(2)
    ['-1.0*x + 1.0*u']
    >>> model.simulate([1.0], t, u=u).finished
    True

    An oscillator, x'' = -x - 0.2 x', whose velocity is measured too, and whose damping takes energy away:

    >>> w = np.sqrt(0.99)
    >>> x = np.exp(-0.1 * t) * np.cos(w * t)
    >>> v = np.exp(-0.1 * t) * (-0.1 * np.cos(w * t) - w * np.sin(w * t))
    >>> model = sindy.SINDy("poly(2)", states=["x", "v"], known=["x' = v"], signs=["v': v < 0"])
    >>> model.fit(np.column_stack([x, v]), t).equations(2)
    ['1.0*v', '-1.0*x - 0.20*v']
    """

    def __init__(
        self,
        library: str | Sequence[str] | Library | dict[str, Any] | None = None,
        solver: Solver | None = None,
        *,
        smoothing: str | dict[str, Any] | Differentiator | WeakForm = "automatic",
        method: Method = "automatic",
        discrete: bool = False,
        states: Sequence[str] | None = None,
        inputs: Sequence[str] | None = None,
        known: Sequence[str] | None = None,
        signs: Sequence[str] | None = None,
        conserve: Sequence[str] | None = None,
        constraints: Sequence[str] | None = None,
        stable: bool = False,
        noise: Noise = "automatic",
        diffusion: Sequence[str] | None = None,
        settings: dict[str, Any] | None = None,
        n_jobs: int | None = None,
    ) -> None:
        self.library = library
        self.solver = solver
        self.smoothing = smoothing
        self.method = method
        self.discrete = discrete
        self.states = states
        self.inputs = inputs
        self.known = known
        self.signs = signs
        self.conserve = conserve
        self.constraints = constraints
        self.stable = stable
        self.noise = noise
        self.diffusion = diffusion
        self.settings = settings
        self.n_jobs = n_jobs

    # Fitting

    def fit(
        self: Self,
        x: Any,
        t: Any = None,
        *,
        u: Any = None,
        x_dot: Any = None,
        sample_weight: Any = None,
        groups: Any = None,
    ) -> Self:
        """Identifies a model.

        Parameters
        ----------
        x : array, table, or list of these
            States, one row for each time; a list has one entry for each trajectory. Rows with NaN
            have no weight in the automatic call, up to three in succession; longer gaps split a trajectory, and with a solver
            all of them do.
            float64 arrays are read where they are if ``x_dot`` is given, and copied once otherwise; other numbers are
            cast.
        t : float, array, str, or list of these
            A step of time, times, or the name of a table's column. Holes in time split a trajectory.
        u : array, table, or list of these, optional
            Inputs. Columns of the table `x` that ``inputs`` names are inputs as well.
        x_dot : array, or list, optional
            Slopes (in discrete time, the next samples).
        sample_weight : array, or list, optional
            A weight for each row, relative to the others.
        groups : array, optional
            A label for each row of one array `x`: where it changes, a trajectory ends.

        Returns
        -------
        SINDy
            The estimator.
        """
        _settings.check(self, None if x_dot is None else "`x_dot`")
        data = collect(x, t, u, x_dot, sample_weight, groups, self.states, self.inputs)
        built = libraries(self.library, data.states, data.inputs)
        jobs = self._jobs()
        if x_dot is not None or (self.discrete and self.solver is not None):
            model, said = self._fit_columns(data, built, x_dot is not None, jobs)
        elif self.solver is None:
            model, said = self._identify(data, built, jobs)
        else:
            model, said = self._fit_slopes(data, built, jobs)
        names = list(dict.fromkeys(name for library in built for name in library.names))
        return self._learn(model, names, json.loads(said))

    def _learn(self: Self, model: _native.Model, names: list[str], said: Any) -> Self:
        self._set(model, names, said)
        for text in self.warnings_:
            warnings.warn(text, SindyWarning, stacklevel=3)
        return self

    def _jobs(self) -> int | None:
        return threads(self.n_jobs)

    def _identify(self, data: Data, built: list[_native.Library], jobs: int | None) -> tuple[_native.Model, str]:
        return _native.identify(data.states, data.inputs, data.given(), built, dumps(_settings.automatic(self)), jobs)

    def _fit_slopes(self, data: Data, built: list[_native.Library], jobs: int | None) -> tuple[_native.Model, str]:
        assert self.solver is not None
        solver, given = self.solver.describe(), data.given()
        if not self._has_slopes():
            form = self.smoothing if isinstance(self.smoothing, WeakForm) else WeakForm()
            return form._of(data, built, jobs)[0].solve(solver, None, jobs)
        return _native.fit_slopes(data.states, data.inputs, given, built, describe(self.smoothing), solver, jobs)

    def _has_slopes(self) -> bool:
        """Whether the smoothing gives slopes: all do but the weak form."""
        return not isinstance(self.smoothing, WeakForm) and self.smoothing != "weak"

    def _fit_columns(
        self, data: Data, built: list[_native.Library], slopes: bool, jobs: int | None
    ) -> tuple[_native.Model, str]:
        groups, weighted, period = self._columns(data, slopes)
        solver = (self.solver or default()).describe()
        return _native.fit_columns(data.states, data.inputs, groups, weighted, built, solver, period, jobs)

    def _columns(self, data: Data, slopes: bool) -> tuple[list[list[Array]], bool, float | None]:
        """Arrays side by side, whether weights are among them, and in discrete time the period."""
        groups = []
        for run in data.trajectories:
            parts = [run.x, run.u, run.x_dot, None if run.weight is None else run.weight.reshape(-1, 1)]
            if not slopes:  # pairs of a sample and the next
                parts = [None if a is None else a[:-1] for a in parts]
                parts[2] = run.x[1:]
            groups.append([a for a in parts if a is not None])
        period = self._period(data) if self.discrete else None
        return groups, data.trajectories[0].weight is not None, period

    def _period(self, data: Data) -> float:
        t = data.trajectories[0].t
        steps = np.concatenate([np.diff(r.t) for r in data.trajectories if r.t is not None] or [np.empty(0)])
        if t is None or steps.size == 0:
            return 1.0
        period = float(np.median(steps))
        if np.any(np.abs(steps - period) > 1e-3 * period):
            raise fault("t", "times one period apart (give trajectories apart as a list)", "other steps")
        return period

    def _set(self, model: _native.Model, names: list[str], said: Any) -> None:
        self.model_ = model
        automatic = isinstance(said, dict)
        for terms in model.terms:
            names.extend(text for text, *_ in terms if text not in names)
        place = {name: k for k, name in enumerate(names)}
        shape = (len(model.terms), len(names))
        self.coef_ = np.zeros(shape)
        self.std_error_ = np.full(shape, np.nan)
        self.inclusion_ = np.full(shape, np.nan)
        for i, terms in enumerate(model.terms):
            for text, coefficient, error, inclusion in terms:
                k = place[text]
                self.coef_[i, k] = coefficient
                self.std_error_[i, k] = np.nan if error is None else error
                self.inclusion_[i, k] = np.nan if inclusion is None else inclusion
        self.terms_ = names
        self.feature_names_in_ = np.array(model.states, dtype=object)
        self.input_names_ = np.array(model.inputs, dtype=object)
        self.n_features_in_ = len(model.states)
        self.equations_: list[Any] = said["equations"] if automatic else said or []
        self.choice_ = SimpleNamespace(**said["choice"]) if automatic else SimpleNamespace(method="solver", reason="")
        self.candidates_: list[Any] = said["candidates"] if automatic else []
        self.data_: dict[str, Any] = said["data"] if automatic else {}
        self._between: list[str] = said["inputs_between"] if automatic else []
        self.warnings_: list[str] = list(said["warnings"]) if automatic else self._doubts(model, said or [])

    @staticmethod
    def _doubts(model: _native.Model, solved: list[Any]) -> list[str]:
        out = []
        for state, equation in zip(model.states, solved):
            if equation["outcome"] == "empty":
                out.append(f"{state}: every term was dropped; the threshold or penalty is above every coefficient")
            elif equation["outcome"] not in ("converged", "optimal", "within_tolerance"):
                out.append(f"{state}: the solver ended with `{equation['outcome']}`")
            if equation["skipped"]:
                out.append(f"{state}: {equation['skipped']} rows are not finite and were left out")
        return out

    def _fitted(self) -> _native.Model:
        model: _native.Model | None = getattr(self, "model_", None)
        if model is None:
            raise _not_fitted()
        return model

    # Using

    def _given(self, x: Any, u: Any) -> Data:
        model = self._fitted()
        for run in x if is_many(x) else [x]:
            columns = len(model.states) if table(run) is not None else matrix("x", run).shape[1]
            if columns != len(model.states):
                raise fault("x", f"{len(model.states)} columns, those of {', '.join(model.states)}", columns)
        return collect(x, None, u, states=model.states, inputs=model.inputs or None)

    def predict(self, x: Any, u: Any = None) -> Any:
        """The right-hand side: slopes, or in discrete time the next samples, of every row.

        Parameters
        ----------
        x, u : as for `fit`

        Returns
        -------
        ndarray, or list of ndarray for a list
        """
        model, data = self._fitted(), self._given(x, u)
        out = [model.predict(run.x, run.u) for run in data.trajectories]
        return out if data.many else out[0]

    def score(
        self,
        x: Any,
        t: Any = None,
        *,
        u: Any = None,
        x_dot: Any = None,
        sample_weight: Any = None,
        groups: Any = None,
    ) -> float:
        """R² of the slopes (in discrete time, of the next samples), its mean over the states.

        Without ``x_dot``, slopes are those of a Savitzky–Golay filter chosen from the given data (on uneven times a
        smoothing spline), and the model is evaluated at the smoothed states.
        """
        model = self._fitted()
        data = collect(x, t, u, x_dot, sample_weight, groups, model.states, model.inputs or None)
        truth, predicted, weights = [], [], []
        if x_dot is None and model.period is None:
            given: list[Given] = [(r.times(), r.x, None, r.weight) for r in data.trajectories]
            found = _native.slopes(data.states, given, describe("automatic"), self._jobs())
            for run, (values, slopes) in zip(data.trajectories, found):
                run.x, run.x_dot = values, slopes
        for run in data.trajectories:
            at, u_at, to, w = run.x, run.u, run.x_dot, run.weight
            if to is None:
                at, u_at, to = at[:-1], None if u_at is None else u_at[:-1], at[1:]
                w = None if w is None else w[:-1]
            truth.append(to)
            predicted.append(model.predict(at, u_at))
            weights.append(np.ones(len(to)) if w is None else w)
        return _r2(np.concatenate(truth), np.concatenate(predicted), np.concatenate(weights))

    def simulate(
        self,
        x0: Any,
        t: Any,
        u: Any = None,
        *,
        rtol: float = 1e-8,
        atol: float = 1e-10,
        step: float | None = None,
        between: str | Sequence[str] | None = None,
        blow_up: float = 1e12,
    ) -> Run:
        """A run of the model.

        Parameters
        ----------
        x0 : array
            The states at the first time.
        t : array, or int
            Times; in discrete time a number of rows will do.
        u : array or callable, optional
            Inputs at those times, or a function of time that is sampled there.
        rtol, atol : float
            Tolerances of the Dormand–Prince pair.
        step : float, optional
            The longest step of the classical Runge–Kutta method, used in its place.
        between : {"hold", "linear", "cubic"} or a list of these, optional
            What inputs are between their samples: what the automatic call found, else linear.
        blow_up : float
            A run ends where a state exceeds this magnitude.

        Returns
        -------
        Run
            Times, states and how the run ended. That it ended early is no error.
        """
        model = self._fitted()
        start, times, values, each = self._runs(x0, t, u, between)
        if isinstance(times, int):
            return Run.of(model.iterate(start, times, values, blow_up))
        return Run.of(model.simulate(start, times, times, values, each, rtol, atol, step, blow_up))

    def _runs(
        self, x0: Any, t: Any, u: Any, between: str | Sequence[str] | None
    ) -> tuple[list[float], Array | int, Array | None, list[str]]:
        """The start of a run, its times (in discrete time its steps), its inputs and what these are between their samples."""
        model = self._fitted()
        start = [float(v) for v in floats("x0", x0, "a number for each state").reshape(-1)]
        if model.period is not None:
            rows = t if np.ndim(t) == 0 else len(t)
            if not isinstance(rows, Integral) or rows < 1:
                raise fault("t", "times, or a number of rows of at least 1", repr(t))
            rows = int(rows)
            values = self._inputs(u, np.arange(rows, dtype=np.float64) * np.float64(model.period))
            return start, max(rows - 1, 0), values, []
        if np.ndim(t) == 0:
            raise fault("t", "times (in continuous time a number says nothing)", repr(t))
        times = np.ascontiguousarray(floats("t", t, "times").reshape(-1))
        values = self._inputs(u, times)
        if between is None:
            between = self._between or "linear"
        return start, times, values, [between] * len(model.inputs) if isinstance(between, str) else list(between)

    def _inputs(self, u: Any, times: Array) -> Array | None:
        names = self._fitted().inputs
        if not names and u is None:
            return None
        if u is None:
            raise fault("u", "inputs for " + ", ".join(names), "none")
        if callable(u):
            u = [np.atleast_1d(u(t)) for t in times]
        columns = table(u)
        values = matrix("u", u) if columns is None else columns.matrix(names)
        if values.shape[1] != len(names):
            raise fault("u", f"{len(names)} columns", values.shape[1])
        return values

    def get_feature_names(self) -> list[str]:
        """The candidate terms, in the order of `coef_`."""
        self._fitted()
        return list(self.terms_)

    @classmethod
    def from_json(cls: type[Self], text: str) -> Self:
        """An estimator with the model of a text in JSON; `coef_` and `terms_` have the terms of the model alone."""
        model = _native.Model.from_json(text)
        out = cls(discrete=model.period is not None, states=model.states, inputs=model.inputs or None)
        out._set(model, [], None)
        return out


def _r2(truth: Array, predicted: Array, weights: Array) -> float:
    """The mean R² over columns, over rows where all is finite."""
    kept = np.isfinite(truth).all(axis=1) & np.isfinite(predicted).all(axis=1) & (weights > 0.0)
    if kept.sum() < 2:
        raise fault("x", "two rows that are finite and have slopes", int(kept.sum()))
    truth, predicted, w = truth[kept], predicted[kept], weights[kept][:, None]
    mean = (w * truth).sum(axis=0) / w.sum()
    residual = (w * (truth - predicted) ** 2).sum(axis=0)
    total = (w * (truth - mean) ** 2).sum(axis=0)
    return float(np.mean(1.0 - residual / np.where(total > 0.0, total, np.finfo(float).tiny)))


def _not_fitted() -> Exception:
    try:
        from sklearn.exceptions import NotFittedError
    except ImportError:
        return fault("model", "a model (call `fit` first)", "none")
    error: Exception = NotFittedError("this SINDy has no model yet: call `fit` first")
    return error
