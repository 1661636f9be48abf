"""Differential equations with few terms from measured trajectories.

>>> import numpy as np, sindy
>>> t = np.arange(0.0, 10.0, 0.01)
>>> x = np.column_stack([np.cos(t), -np.sin(t)])  # x' = y, y' = -x
>>> model = sindy.SINDy("poly(1)", states=["x", "y"]).fit(x, t)
>>> model.print()
x' = 1.00*y
y' = -1.00*x
"""

from . import dist
from ._bootstrap import Band, Bootstrap, Ensemble
from ._derivative import (
    Differentiator,
    FiniteDifference,
    KalmanSmoother,
    SavitzkyGolay,
    Smoothed,
    SmoothingSpline,
    Spectral,
    differentiate,
)
from ._errors import InternalError, SindyError, SindyWarning
from ._field import PDE
from ._gram import Gram
from ._library import Library
from ._model import SINDy
from ._native import __version__
from ._partial import PartialSums
from ._run import Run
from ._solvers import SR3, STLSQ, BestSubset, Solver, Stepwise
from ._subsets import Certificate, Subset, Subsets
from ._weak import WeakForm, WeakSystem

__all__ = [
    "SINDy",
    "Library",
    "Gram",
    "PartialSums",
    "PDE",
    "dist",
    "STLSQ",
    "SR3",
    "Stepwise",
    "BestSubset",
    "Solver",
    "Run",
    "differentiate",
    "Differentiator",
    "Smoothed",
    "FiniteDifference",
    "SavitzkyGolay",
    "SmoothingSpline",
    "KalmanSmoother",
    "Spectral",
    "WeakForm",
    "WeakSystem",
    "Subset",
    "Subsets",
    "Certificate",
    "Bootstrap",
    "Ensemble",
    "Band",
    "SindyError",
    "SindyWarning",
    "InternalError",
    "__version__",
]
