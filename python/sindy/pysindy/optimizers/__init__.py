"""Sparse regression under PySINDy's names."""

from ._base import BaseOptimizer, EnsembleOptimizer, WrappedOptimizer
from ._best import MIOSR
from ._convex import SINDyPI
from ._greedy import FROLS, SSR
from ._sbr import SBR
from ._sr3 import SR3, ConstrainedSR3
from ._stable import StableLinearSR3
from ._stlsq import STLSQ
from ._trapping import TrappingSR3

__all__ = [
    "BaseOptimizer",
    "ConstrainedSR3",
    "EnsembleOptimizer",
    "FROLS",
    "MIOSR",
    "SBR",
    "SINDyPI",
    "SR3",
    "SSR",
    "STLSQ",
    "StableLinearSR3",
    "TrappingSR3",
    "WrappedOptimizer",
]
