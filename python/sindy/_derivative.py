"""Methods of differentiation."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any, Literal, NamedTuple

from . import _native
from ._data import Array, collect
from ._errors import fault
from ._solvers import Parameters, dumps, threads


class Smoothed(NamedTuple):
    """Smoothed states and their slopes, NaN in gaps; for a list of trajectories, lists of these."""

    x: Any
    x_dot: Any


@dataclass
class Differentiator(Parameters):
    """What all methods share. `SINDy` takes one as its `smoothing`, beside a solver."""

    def describe(self) -> str:
        """The description that the library builds the method from."""
        return self._describe(self._name())

    def _name(self) -> str:
        raise NotImplementedError

    def smooth(self, x: Any, t: Any, n_jobs: int | None = None) -> Smoothed:
        """Smoothed states and slopes.

        Parameters
        ----------
        x, t : as for `SINDy.fit`
            Holes in time and NaN split a trajectory.
        n_jobs : int, optional
            Threads.

        Returns
        -------
        Smoothed
            Arrays as `x`, or lists of these.
        """
        data = collect(x, t)
        found = _native.slopes(data.states, data.given(), self.describe(), threads(n_jobs))
        if data.many:
            return Smoothed([values for values, _ in found], [slopes for _, slopes in found])
        return Smoothed(*found[0])

    def __call__(self, x: Any, t: Any, n_jobs: int | None = None) -> Any:
        """The slopes alone: those of `smooth`."""
        return self.smooth(x, t, n_jobs).x_dot


@dataclass
class FiniteDifference(Differentiator):
    """Finite differences on any grid, for data without noise.

    Parameters
    ----------
    order : {2, 4, 6}
        The order of accuracy.

    Examples
    --------
    >>> import numpy as np, sindy
    >>> t = np.arange(0.0, 10.0, 0.1)
    >>> slopes = sindy.FiniteDifference(order=4)(np.sin(t), t)
    >>> bool(abs(slopes[:, 0] - np.cos(t)).max() < 3e-5)
    True
    """

    order: Literal[2, 4, 6] = 4

    def _name(self) -> str:
        return "finite_difference"


@dataclass
class SavitzkyGolay(Differentiator):
    """Polynomials through a moving window.

    Parameters
    ----------
    window : int, optional
        Samples, odd. Without it, window and degree follow from the data, so that noise and bias of the slope balance; then
        the times have to be evenly spaced.
    degree : int, optional
        Degree of the polynomials; 3 beside a window.

    Examples
    --------
    >>> import numpy as np, sindy
    >>> t = np.arange(0.0, 10.0, 0.01)
    >>> x = np.sin(t) + 0.01 * np.random.default_rng(1).normal(size=t.size)
    >>> error = [abs(by(x, t)[50:-50, 0] - np.cos(t)[50:-50]).max() for by in (sindy.SavitzkyGolay(), sindy.FiniteDifference())]
    >>> bool(error[0] < 0.05 < 1.0 < error[1])
    True
    """

    window: int | None = None
    degree: int | None = None

    def _name(self) -> str:
        return "savitzky_golay"


@dataclass
class SmoothingSpline(Differentiator):
    """A cubic smoothing spline, on any grid.

    Parameters
    ----------
    lam : float, optional
        Smoothing strength, in the unit of time cubed; by generalised cross-validation if not given.
    """

    lam: float | None = None

    def _name(self) -> str:
        return "spline"


@dataclass
class KalmanSmoother(Differentiator):
    """A signal whose velocity or acceleration wanders as white noise, on any grid.

    Parameters
    ----------
    motion : {"constant_acceleration", "constant_velocity"}
        Whether the acceleration or the velocity wanders.
    ratio : float, optional
        Density of what drives it over the variance of a sample's noise, in the unit of time to the power -5 or -3; by maximum
        likelihood if not given.
    """

    motion: Literal["constant_acceleration", "constant_velocity"] = "constant_acceleration"
    ratio: float | None = None

    def _name(self) -> str:
        return "kalman"


@dataclass
class Spectral(Differentiator):
    """The fast Fourier transform, on evenly spaced times.

    Parameters
    ----------
    cutoff : float, "cross_validated" or None
        Cycles per unit of time up to which frequencies pass; as many as generalised cross-validation finds; or all.
    ends : {"reflected", "periodic"}
        Beyond the ends lies the reflection of the record about its end, or the record again.

    Examples
    --------
    >>> import numpy as np, sindy
    >>> t = np.arange(100) * 0.02 * np.pi  # a whole period
    >>> slopes = sindy.Spectral(cutoff=None, ends="periodic")(np.sin(t), t)
    >>> bool(abs(slopes[:, 0] - np.cos(t)).max() < 1e-12)
    True
    """

    cutoff: float | Literal["cross_validated"] | None = "cross_validated"
    ends: Literal["reflected", "periodic"] = "reflected"

    def _name(self) -> str:
        return "spectral"

    def describe(self) -> str:
        cutoff: Any = {"frequency": self.cutoff}
        if self.cutoff is None or isinstance(self.cutoff, str):
            cutoff = self.cutoff or "none"
        return dumps({self._name(): {**asdict(self), "cutoff": cutoff}})


# The methods that texts name.
_NAMED = {"spline": SmoothingSpline(), "kalman": KalmanSmoother()}


def describe(smoothing: Any) -> str:
    """The description of what is given as `smoothing` beside a solver: a text, a dict or a method."""
    if isinstance(smoothing, Differentiator):
        return smoothing.describe()
    if isinstance(smoothing, str):
        if smoothing == "automatic":
            return dumps({"automatic": {}})
        if smoothing not in _NAMED:
            raise fault("smoothing", "automatic, weak, " + ", ".join(_NAMED) + ", a dict or a method", smoothing)
        return _NAMED[smoothing].describe()
    return dumps(smoothing)


def differentiate(x: Any, t: Any, smoothing: Any = "automatic", n_jobs: int | None = None) -> Smoothed:
    """Smoothed states and slopes, as `SINDy` makes them beside a solver.

    Parameters
    ----------
    x, t : as for `SINDy.fit`
    smoothing : str, dict or Differentiator
        ``automatic``: a Savitzky–Golay filter chosen from the data, and a smoothing spline on uneven times or few samples;
        ``spline``; ``kalman``; a dict as for `SINDy`; or a method.
    n_jobs : int, optional
        Threads.

    Examples
    --------
    >>> import numpy as np, sindy
    >>> t = np.arange(0.0, 10.0, 0.01)
    >>> smoothed = sindy.differentiate(np.sin(t), t)
    >>> smoothed.x.shape, smoothed.x_dot.shape
    ((1000, 1), (1000, 1))
    """
    method = smoothing if isinstance(smoothing, Differentiator) else _Described(describe(smoothing))
    return method.smooth(x, t, n_jobs)


@dataclass
class _Described(Differentiator):
    """A method that was described already."""

    text: str = ""

    def describe(self) -> str:
        return self.text
