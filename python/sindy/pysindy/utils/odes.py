"""Right-hand sides of known systems, which examples and tests integrate, under PySINDy's names.

Functions take the time and the states, as `scipy.integrate.solve_ivp` calls them. Maps take the state.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np


def linear_damped_SHO(t: float, x: Any) -> list[Any]:
    """Damped linear oscillator: x' = -0.1 x + 2 y, y' = -2 x - 0.1 y (Brunton et al. 2016, doi:10.1073/pnas.1517384113)."""
    return [-0.1 * x[0] + 2.0 * x[1], -2.0 * x[0] - 0.1 * x[1]]


def cubic_damped_SHO(t: float, x: Any) -> list[Any]:
    """Damped cubic oscillator: x' = -0.1 x³ + 2 y³, y' = -2 x³ - 0.1 y³ (Brunton et al. 2016)."""
    return linear_damped_SHO(t, [x[0] ** 3, x[1] ** 3])


def linear_3D(t: float, x: Any) -> list[Any]:
    """Damped linear oscillator and a decay: `linear_damped_SHO` and z' = -0.3 z (Brunton et al. 2016)."""
    return [*linear_damped_SHO(t, x), -0.3 * x[2]]


def van_der_pol(t: float, x: Any, p: Sequence[float] = (0.5,)) -> list[Any]:
    """Van der Pol's oscillator: x' = y, y' = μ (1 - x²) y - x, with p = (μ,) (Strogatz, Nonlinear Dynamics and Chaos, 7.1)."""
    return [x[1], p[0] * (1.0 - x[0] ** 2) * x[1] - x[0]]


def duffing(t: float, x: Any, p: Sequence[float] = (0.2, 0.05, 1)) -> list[Any]:
    """Duffing's oscillator: x' = y, y' = -δ y - α x - β x³, with p = (δ, α, β) (Guckenheimer and Holmes 1983, 2.2)."""
    return [x[1], -p[0] * x[1] - p[1] * x[0] - p[2] * x[0] ** 3]


def lotka(t: float, x: Any, p: Sequence[float] = (1, 10)) -> list[Any]:
    """Lotka and Volterra's prey and predator (Murray, Mathematical Biology, 3.1), with p = (a, b):

    x' = a x - b x y, y' = b x y - 2 a y.
    """
    eaten = p[1] * x[0] * x[1]
    return [p[0] * x[0] - eaten, eaten - 2.0 * p[0] * x[1]]


def cubic_oscillator(t: float, x: Any, p: Sequence[float] = (-0.1, 2, -2, -0.1)) -> list[Any]:
    """Cubic oscillator: x' = a x³ + b y³, y' = c x³ + d y³, with p = (a, b, c, d); the defaults are `cubic_damped_SHO`."""
    return [p[0] * x[0] ** 3 + p[1] * x[1] ** 3, p[2] * x[0] ** 3 + p[3] * x[1] ** 3]


def rossler(t: float, x: Any, p: Sequence[float] = (0.2, 0.2, 5.7)) -> list[Any]:
    """Rössler's attractor (doi:10.1016/0375-9601(76)90101-8), with p = (a, b, c):

    x' = -y - z, y' = x + a y, z' = b + z (x - c).
    """
    return [-x[1] - x[2], x[0] + p[0] * x[1], p[1] + x[2] * (x[0] - p[2])]


def hopf(t: float, x: Any, mu: float = -0.05, omega: float = 1, A: float = 1) -> list[Any]:
    """Normal form of Hopf's bifurcation: z' = (μ + iω) z - A z |z|² with z = x + iy (Strogatz, 8.2)."""
    damping = mu - A * (x[0] ** 2 + x[1] ** 2)
    return [damping * x[0] - omega * x[1], omega * x[0] + damping * x[1]]


def logistic_map(x: Any, mu: float) -> Any:
    """Logistic map: x → μ x (1 - x) (Strogatz, 10.2)."""
    return mu * x * (1.0 - x)


def logistic_map_control(x: Any, mu: float, u: Any) -> Any:
    """Logistic map with an input: x → μ x (1 - x) + u."""
    return logistic_map(x, mu) + u


def logistic_map_multicontrol(x: Any, mu: float, u: Any) -> Any:
    """Logistic map with the product of two inputs: x → μ x (1 - x) + u₀ u₁."""
    return logistic_map(x, mu) + u[0] * u[1]


def lorenz(t: float, x: Any, sigma: float = 10, beta: float = 2.66667, rho: float = 28) -> list[Any]:
    """Lorenz's attractor: x' = σ (y - x), y' = x (ρ - z) - y, z' = x y - β z (doi:10.1175/1520-0469(1963)020<0130:DNF>2.0.CO;2).

    Examples
    --------
    >>> lorenz(0.0, [1.0, 2.0, 3.0], beta=2.0)
    [10.0, 23.0, -4.0]
    """
    return [sigma * (x[1] - x[0]), x[0] * (rho - x[2]) - x[1], x[0] * x[1] - beta * x[2]]


def lorenz_u(t: Any) -> Any:
    """Two inputs of `lorenz_control`: sin²(2 t) and t²; one row for each time."""
    return np.column_stack([np.sin(2.0 * np.asarray(t)) ** 2, np.asarray(t) ** 2])


def lorenz_control(
    t: float, x: Any, u_fun: Callable[[float], Any], sigma: float = 10, beta: float = 2.66667, rho: float = 28
) -> list[Any]:
    """`lorenz` with u₀ added to x' and u₁ subtracted from z'; ``u_fun(t)`` gives one row of two inputs."""
    u = u_fun(t)
    slope = lorenz(t, x, sigma, beta, rho)
    return [slope[0] + u[0, 0], slope[1], slope[2] - u[0, 1]]


def meanfield(t: float, x: Any, mu: float = 0.01) -> list[Any]:
    """Mean-field model of a cylinder's wake (Noack et al. 2003, doi:10.1017/S0022112003006694):

    x' = μ x - y - x z, y' = μ y + x - y z, z' = x² + y² - z.
    """
    return [mu * x[0] - x[1] - x[0] * x[2], mu * x[1] + x[0] - x[1] * x[2], x[0] ** 2 + x[1] ** 2 - x[2]]


def oscillator(
    t: float, x: Any, mu1: float = 0.05, mu2: float = -0.01, omega: float = 3.0, alpha: float = -2.0, beta: float = -5.0,
    sigma: float = 1.1,
) -> list[Any]:  # fmt: skip
    """Coupled oscillators whose nonlinear terms keep the energy (Tuwankotta, Int. J. Non-Linear Mech. 41, 2006):

    x' = μ₁ x + σ x y, y' = μ₂ y + w z - σ x², z' = μ₂ z - w y, with w = ω + α y + β z.
    """
    w = omega + alpha * x[1] + beta * x[2]
    return [mu1 * x[0] + sigma * x[0] * x[1], mu2 * x[1] + w * x[2] - sigma * x[0] ** 2, mu2 * x[2] - w * x[1]]


def enzyme(t: float, x: Any, jx: float = 0.6, Vmax: float = 1.5, Km: float = 0.3) -> Any:
    """Michaelis and Menten's kinetics with an influx (Mangan et al. 2016, doi:10.1109/TMBMC.2016.2633265):

    x' = j - V x / (K + x).
    """
    return jx - Vmax * x / (Km + x)


def bacterial(
    t: float, x: Any, a1: float = 0.004, a2: float = 0.07, a3: float = 0.04, b1: float = 0.82, b2: float = 1854.5
) -> list[Any]:
    """Competence of B. subtilis (Mangan et al. 2016, doi:10.1109/TMBMC.2016.2633265):

    x' = a₁ + a₂ x² / (a₃ + x²) - x / (1 + x + y), y' = b₁ / (1 + b₂ x⁵) - y / (1 + x + y).
    """
    both = 1.0 + x[0] + x[1]
    return [a1 + a2 * x[0] ** 2 / (a3 + x[0] ** 2) - x[0] / both, b1 / (1.0 + b2 * x[0] ** 5) - x[1] / both]
