"""PySINDy 2.1's names and signatures over this package.

``from sindy import pysindy as ps`` runs scripts that were written for ``import pysindy as ps``. Names that are not here
(`ParameterizedLibrary`, for example) raise an `ImportError` or `AttributeError`. scikit-learn and SciPy have to be installed;
`SINDyDerivative` also wants ``derivative``, and `SINDyPI`, `TrappingSR3`, `StableLinearSR3` and inequalities want ``clarabel``.

Examples
--------
>>> import numpy as np
>>> from sindy import pysindy as ps
>>> t = np.arange(0.0, 10.0, 0.01)
>>> x = np.column_stack([np.cos(t), -np.sin(t)])  # x' = y, y' = -x
>>> model = ps.SINDy(feature_library=ps.PolynomialLibrary(degree=2), optimizer=ps.STLSQ(threshold=0.1))
>>> model = model.fit(x, t=t, feature_names=["x", "y"])
>>> model.print()
(x)' =  1.000 y
(y)' = -1.000 x
"""

from . import differentiation, feature_library, optimizers, utils
from ._core import DiscreteSINDy, SINDy
from .differentiation import (
    BaseDifferentiation,
    FiniteDifference,
    SINDyDerivative,
    SmoothedFiniteDifference,
    SpectralDerivative,
)
from .feature_library import (
    ConcatLibrary,
    CustomLibrary,
    FourierLibrary,
    GeneralizedLibrary,
    IdentityLibrary,
    PDELibrary,
    PolynomialLibrary,
    SINDyPILibrary,
    TensoredLibrary,
    WeakPDELibrary,
)
from .optimizers import (
    FROLS,
    MIOSR,
    SBR,
    SR3,
    SSR,
    STLSQ,
    BaseOptimizer,
    ConstrainedSR3,
    EnsembleOptimizer,
    SINDyPI,
    StableLinearSR3,
    TrappingSR3,
    WrappedOptimizer,
)
from .utils import AxesArray

# PySINDy's version whose names these are.
__version__ = "2.1.0"

__all__ = [
    "AxesArray", "SINDy", "DiscreteSINDy", "differentiation", "feature_library", "optimizers", "utils",
    "BaseDifferentiation", "FiniteDifference", "SINDyDerivative", "SmoothedFiniteDifference", "SpectralDerivative",
    "ConcatLibrary", "CustomLibrary", "FourierLibrary", "GeneralizedLibrary", "IdentityLibrary", "PDELibrary",
    "PolynomialLibrary", "SINDyPILibrary", "TensoredLibrary", "BaseOptimizer", "ConstrainedSR3", "EnsembleOptimizer", "FROLS",
    "MIOSR", "SBR", "SINDyPI", "SR3", "SSR", "STLSQ", "StableLinearSR3", "TrappingSR3", "WeakPDELibrary", "WrappedOptimizer",
]  # fmt: skip
