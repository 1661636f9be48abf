"""The weak form."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import TYPE_CHECKING, Any

from . import _native
from ._data import Data, collect
from ._errors import fault
from ._library import libraries
from ._solvers import Parameters, dumps, threads

if TYPE_CHECKING:
    from ._gram import Gram


@dataclass
class WeakSystem:
    """Statistics of windows, and what was integrated.

    Attributes
    ----------
    gram : Gram
        For any solver: a row for each window.
    half_width : dict of float
        The half-width of the windows for each state.
    windows : dict of int
        Windows for each state.
    missing_rows, holes, short : int
        At most, over the states: rows with a NaN, steps of time that are too long to integrate over, stretches that are too short for a window.
    """

    gram: Gram
    half_width: dict[str, float]
    windows: dict[str, int]
    missing_rows: int
    holes: int
    short: int


@dataclass
class WeakForm(Parameters):
    """Regression without slopes: equations are multiplied by test functions and integrated by parts.

    The test functions are ``(1 - ((t - c)/half_width)^2)^power`` within a half-width of their centre c. `SINDy` takes a weak
    form as its `smoothing`, beside a solver.

    Parameters
    ----------
    half_width : float, optional
        In the unit of time; from the spectrum of each state if not given.
    spacing : float
        Distance of the centres, in half-widths, from 0.02 to 2.
    power : int
        From 2 to 32.
    generalised : bool
        Generalised least squares by the covariance of windows that overlap, in the place of ordinary ones.

    Examples
    --------
    >>> import numpy as np, sindy
    >>> t = np.arange(0.0, 20.0, 0.01)
    >>> x = np.column_stack([np.cos(t), -np.sin(t)])  # x' = y, y' = -x
    >>> x += 0.02 * np.random.default_rng(1).normal(size=x.shape)
    >>> model = sindy.SINDy("poly(2)", sindy.STLSQ(0.2), states=["x", "y"], smoothing=sindy.WeakForm(half_width=1.0))
    >>> model.fit(x, t).equations(2)
    ['1.0*y', '-1.0*x']
    >>> system = sindy.WeakForm(half_width=1.0).system("poly(2)", x, t, states=["x", "y"])
    >>> system.gram.fit(sindy.STLSQ(0.2)).equations(2), system.windows["x"]
    (['1.0*y', '-1.0*x'], 139)
    """

    half_width: float | None = None
    spacing: float = 0.125
    power: int = 8
    generalised: bool = False

    def system(
        self,
        library: Any,
        x: Any,
        t: Any,
        *,
        u: Any = None,
        states: Sequence[str] | None = None,
        inputs: Sequence[str] | None = None,
        n_jobs: int | None = None,
    ) -> WeakSystem:
        """The statistics of the weak form.

        Parameters
        ----------
        library : as for `SINDy`
        x, t, u : as for `SINDy.fit`
        states, inputs : sequence of str, optional
            Names.
        n_jobs : int, optional
            Threads.
        """
        from ._gram import Gram

        data = collect(x, t, u, states=states, inputs=inputs)
        native, windows = self._of(data, libraries(library, data.states, data.inputs), threads(n_jobs))
        said = dict(zip(data.states, windows))
        return WeakSystem(
            Gram._of(native, library, data.states, data.inputs),
            {state: one["half_width"] for state, one in said.items()},
            {state: one["windows"] for state, one in said.items()},
            max(one["missing_rows"] for one in windows),
            max(one["holes"] for one in windows),
            max(one["short"] for one in windows),
        )

    def _of(self, data: Data, built: list[_native.Library], jobs: int | None) -> tuple[_native.Gram, list[Any]]:
        """The library's statistics, and what was integrated for each state."""
        if data.trajectories[0].weight is not None:
            raise fault("sample_weight", "none with the weak form, whose rows are windows", "weights")
        native, text = _native.weak(data.states, data.inputs, data.given(), built, dumps(asdict(self)), jobs)
        return native, json.loads(text)
