"""Candidate terms under PySINDy's names."""

from ._fields import PDELibrary
from ._implicit import SINDyPILibrary
from ._pointwise import (
    BaseFeatureLibrary,
    ConcatLibrary,
    CustomLibrary,
    FourierLibrary,
    GeneralizedLibrary,
    IdentityLibrary,
    PolynomialLibrary,
    TensoredLibrary,
)
from ._weak import WeakPDELibrary

__all__ = [
    "BaseFeatureLibrary",
    "ConcatLibrary",
    "CustomLibrary",
    "FourierLibrary",
    "GeneralizedLibrary",
    "IdentityLibrary",
    "PDELibrary",
    "PolynomialLibrary",
    "SINDyPILibrary",
    "TensoredLibrary",
    "WeakPDELibrary",
]
