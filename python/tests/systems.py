"""Data with known answers."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

Array = NDArray[np.float64]


def lorenz(rows: int = 2000, noise: float = 0.0, seed: int = 1) -> tuple[Array, Array]:
    """Times and states of x' = 10 (y - x), y' = 28 x - y - x z, z' = x y - 8/3 z; noise as a share of each state's spread."""

    def rhs(_t: float, s: Array) -> list[float]:
        x, y, z = s
        return [10.0 * (y - x), 28.0 * x - y - x * z, x * y - 8.0 / 3.0 * z]

    t = 0.002 * np.arange(rows)
    x = solve_ivp(rhs, (0.0, t[-1]), [-8.0, 8.0, 27.0], t_eval=t, rtol=1e-10, atol=1e-12).y.T
    return t, x + noise * x.std(axis=0) * np.random.default_rng(seed).standard_normal(x.shape)


LORENZ = {
    ("x", "x"): -10.0, ("x", "y"): 10.0, ("y", "x"): 28.0, ("y", "y"): -1.0,
    ("y", "x*z"): -1.0, ("z", "z"): -8.0 / 3.0, ("z", "x*y"): 1.0,
}  # fmt: skip


def driven(rows: int = 1500, seed: int = 3) -> tuple[Array, Array, Array]:
    """Times, states and input of x' = v, v' = -2 x - 0.4 v + u."""
    rng = np.random.default_rng(seed)
    t = 0.01 * np.arange(rows)
    w, p = rng.uniform(0.5, 4.0, 4), rng.uniform(0.0, 6.0, 4)

    def force(s: float | Array) -> float | Array:
        return sum(np.sin(w[k] * s + p[k]) for k in range(4))

    def rhs(s: float, y: Array) -> list[float]:
        return [y[1], -2.0 * y[0] - 0.4 * y[1] + float(force(s))]

    x = solve_ivp(rhs, (0.0, t[-1]), [1.0, 0.0], t_eval=t, rtol=1e-10, atol=1e-12).y.T
    return t, x, np.asarray(force(t)).reshape(-1, 1)
