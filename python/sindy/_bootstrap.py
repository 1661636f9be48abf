"""Intervals of coefficients and bands of predictions by resampling."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass
from numbers import Integral
from typing import Any, Literal

import numpy as np

from . import _native, _settings
from ._data import Array, collect
from ._derivative import describe
from ._errors import fault
from ._library import libraries
from ._model import SINDy
from ._solvers import Parameters, default, dumps, threads


@dataclass(frozen=True)
class Band:
    """Where members of an ensemble lie, point by point: a row for each time, a column for each state.

    It covers the uncertainty of the coefficients only: no noise of measurement, and no terms that the library lacks. A
    whole curve stays inside less often than a point.

    Attributes
    ----------
    lower, middle, upper : ndarray
        Quantiles of the members; the middle is the median.
    members : ndarray of int
        Members that each row is of.
    ended : list of str
        How members ended that did not reach the last time.
    """

    lower: Array
    middle: Array
    upper: Array
    members: Array
    ended: list[str]


class Ensemble:
    """A model with the replicates of its fit.

    Arrays have a row for each state and a column for each of `terms`, NaN where the library of a state lacks a term.

    Attributes
    ----------
    fit : SINDy
        The fit to all data.
    members : list of SINDy
        The model of each replicate.
    terms : list of str
        The candidate terms.
    inclusion : ndarray
        Share of the replicates that kept a term, among those that were offered it.
    mean, median, lower, upper : ndarray
        Of the coefficients of the replicates; `lower` and `upper` are the ends of percentile intervals.
    std_error : ndarray
        Standard errors.
    covariance : list of ndarray
        For each state the covariance of the coefficients, in the order of its own library.
    level : float
        What share the intervals cover.
    block_rows, blocks : int
        Rows of a block, and blocks that were resampled.
    correlation_rows : float or None
        The block length that the correlation of the residuals asks for. Where it is above `block_rows`, there are too few
        data, and the intervals are too narrow.
    """

    inclusion: Array
    mean: Array
    median: Array
    lower: Array
    upper: Array
    std_error: Array

    def __init__(
        self, fit: SINDy, members: list[_native.Model], said: list[dict[str, Any]], covariance: list[Array], level: float
    ) -> None:
        self.fit = fit
        self.terms = fit.get_feature_names()
        self.covariance = covariance
        self.level = level
        self._members = members
        for name in ("inclusion", "mean", "median", "lower", "upper", "std_error"):
            setattr(self, name, self._aligned(said, name))
        self.block_rows: int = said[0]["block_rows"]
        self.blocks: int = min(one["blocks"] for one in said)
        self.correlation_rows: float | None = said[0]["correlation_rows"]

    def _aligned(self, said: list[dict[str, Any]], name: str) -> Array:
        out = np.full((len(said), len(self.terms)), np.nan)
        for i, one in enumerate(said):
            offered = [count > 0 for count in one["offered"]]
            for term, value, has in zip(one["terms"], one[name], offered):
                if has:
                    out[i, self.terms.index(term)] = value
        return out

    @property
    def members(self) -> list[SINDy]:
        """The model of each replicate."""
        return [SINDy.from_json(member.to_json()) for member in self._members]

    def predict(self, x: Any, u: Any = None, *, level: float | None = None, n_jobs: int | None = None) -> Band:
        """The band of the right-hand sides for every row of states and inputs of one trajectory, as `SINDy.predict`."""
        data = self.fit._given(x, u)
        if data.many:
            raise fault("x", "one trajectory", "a list")
        run = data.trajectories[0]
        row = _native.band_of_predictions(self._members, run.x, run.u, level or self.level, threads(n_jobs))
        return _band(row)

    def simulate(
        self,
        x0: Any,
        t: Any,
        u: Any = None,
        *,
        level: float | None = None,
        rtol: float = 1e-8,
        atol: float = 1e-10,
        step: float | None = None,
        between: str | Sequence[str] | None = None,
        blow_up: float = 1e12,
        n_jobs: int | None = None,
    ) -> Band:
        """The band of runs from one start, with the parameters of `SINDy.simulate`.

        It ends where fewer than half of the members have come. With many that ended early (`Band.ended`) it is too narrow.
        """
        start, times, values, each = self.fit._runs(x0, t, u, between)
        jobs, share = threads(n_jobs), level or self.level
        if isinstance(times, int):
            return _band(_native.band_of_iterations(self._members, start, times, values, blow_up, share, jobs))
        tolerances = (float(rtol), float(atol))
        return _band(
            _native.band_of_runs(self._members, start, times, values, each, tolerances, step, blow_up, share, jobs)
        )

    def __repr__(self) -> str:
        return f"Ensemble({len(self._members)} replicates of {self.blocks} blocks of {self.block_rows} rows)"


@dataclass
class Bootstrap(Parameters):
    """Resamples blocks of rows, or trajectories, and fits a solver to each sample.

    The residuals of a dynamical fit are correlated from row to row. Rows that are drawn one by one then make intervals too
    narrow, often by several times.

    Parameters
    ----------
    model : SINDy
        With a solver. Its library, solver, smoothing and names are those of each fit.
    replicates : int
        Fits.
    level : float
        What share the intervals cover.
    resampling : "automatic", "groups" or int
        Blocks as long as the correlation of the residuals asks for; whole trajectories, better thirty than ten; or blocks of
        so many rows.
    omit : int
        Terms that are left out of each replicate's library, at random.
    keep_terms : bool
        Whether replicates keep the terms of the fit to all data. Otherwise each chooses its own, and intervals hold what
        the choice adds.
    seed : int
        Of the random numbers. Results do not depend on threads.

    Examples
    --------
    >>> import numpy as np, sindy
    >>> rng = np.random.default_rng(1)
    >>> x = rng.normal(size=(1000, 2))
    >>> x_dot = np.column_stack([x[:, 1], -x[:, 0]]) + 0.1 * rng.normal(size=x.shape)  # x' = y, y' = -x
    >>> model = sindy.SINDy("poly(2)", sindy.STLSQ(0.3), states=["x", "y"])
    >>> ensemble = sindy.Bootstrap(model, 100, seed=2).fit(x, x_dot=x_dot)
    >>> y = ensemble.terms.index("y")
    >>> bool(ensemble.lower[0, y] < 1.0 < ensemble.upper[0, y]), float(ensemble.inclusion[0, y])
    (True, 1.0)
    >>> band = ensemble.simulate([1.0, 0.0], np.linspace(0.0, 3.0, 31))
    >>> bool(band.lower[-1, 0] < np.cos(3.0) < band.upper[-1, 0])
    True
    """

    model: SINDy
    replicates: int = 200
    level: float = 0.95
    resampling: int | Literal["automatic", "groups"] = "automatic"
    omit: int = 0
    keep_terms: bool = False
    seed: int = 0

    def fit(
        self,
        x: Any,
        t: Any = None,
        *,
        u: Any = None,
        x_dot: Any = None,
        sample_weight: Any = None,
        groups: Any = None,
    ) -> Ensemble:
        """Fits all replicates; the parameters are those of `SINDy.fit`.

        Slopes are made once, and resampled with their rows.

        Returns
        -------
        Ensemble
        """
        model = self.model
        _settings.check(model)
        if model.solver is None and x_dot is None:
            raise fault("model", "a model with a solver", "none: the automatic call has intervals of its own")
        data = collect(x, t, u, x_dot, sample_weight, groups, model.states, model.inputs)
        built = libraries(model.library, data.states, data.inputs)
        solver, settings, jobs = (model.solver or default()).describe(), self._describe_settings(), model._jobs()
        if x_dot is not None or model.discrete:
            arrays, weighted, period = model._columns(data, x_dot is not None)
            found = _native.bootstrap_columns(
                data.states, data.inputs, arrays, weighted, built, solver, settings, period, jobs
            )
        else:
            if not model._has_slopes():
                raise fault("smoothing", "one that gives slopes", "the weak form")
            by = describe(model.smoothing)
            found = _native.bootstrap_slopes(
                data.states, data.inputs, data.given(), built, by, solver, settings, jobs
            )
        native, said, members, equations, covariance = found
        names = list(dict.fromkeys(name for library in built for name in library.names))
        fitted = type(model)(**model.get_params(deep=False))._learn(native, names, json.loads(said))
        return Ensemble(fitted, members, json.loads(equations), covariance, float(self.level))

    def _describe_settings(self) -> str:
        unit: Any = self.resampling
        if isinstance(unit, Integral) and not isinstance(unit, bool):
            unit = {"rows": int(unit)}
        elif unit not in ("automatic", "groups"):
            raise fault("resampling", "automatic, groups or a number of rows", unit)
        if self.omit and self.keep_terms:
            raise fault("omit", "0 where the terms are kept", self.omit)
        keys = ("replicates", "seed", "level", "omit", "keep_terms")
        return dumps({key: getattr(self, key) for key in keys} | {"resampling": unit})


def _band(row: tuple[Array, Array, Array, list[int], list[str]]) -> Band:
    lower, middle, upper, members, ended = row
    return Band(lower, middle, upper, np.asarray(members), ended)
