"""Penalties and constraints of optimizers, and right-hand sides of known systems."""

from ._axes import AxesArray
from .base import (
    capped_simplex_projection,
    get_prox,
    get_regularization,
    reorder_constraints,
    supports_multiple_targets,
    validate_control_variables,
)
from .odes import (
    bacterial,
    cubic_damped_SHO,
    cubic_oscillator,
    duffing,
    enzyme,
    hopf,
    linear_3D,
    linear_damped_SHO,
    logistic_map,
    logistic_map_control,
    logistic_map_multicontrol,
    lorenz,
    lorenz_control,
    lorenz_u,
    lotka,
    meanfield,
    oscillator,
    rossler,
    van_der_pol,
)

__all__ = [
    "AxesArray", "bacterial", "capped_simplex_projection", "cubic_damped_SHO", "cubic_oscillator", "duffing", "enzyme",
    "get_prox", "get_regularization", "hopf", "linear_3D", "linear_damped_SHO", "logistic_map", "logistic_map_control",
    "logistic_map_multicontrol", "lorenz", "lorenz_control", "lorenz_u", "lotka", "meanfield", "oscillator",
    "reorder_constraints", "rossler", "supports_multiple_targets", "validate_control_variables", "van_der_pol",
]  # fmt: skip
