"""Makes the bench's data: python data.py DIRECTORY. Files that are there already are kept."""

import sys
from pathlib import Path

import numpy as np
from scipy.signal import lfilter

LORENZ_ROWS = 1_000_000
LORENZ_STEP = 0.002
GROUND_STEP = 0.01
SIGNAL_ROWS = 3_000_000


def lorenz(rows=LORENZ_ROWS, h=LORENZ_STEP):
    """Rows of x, y, z by the classical Runge-Kutta method, two steps a row."""
    h = h / 2
    x, y, z = -8.0, 7.0, 27.0
    out = np.empty((rows, 3))

    def slope(x, y, z):
        return 10.0 * (y - x), x * (28.0 - z) - y, x * y - 8.0 / 3.0 * z

    for i in range(rows):
        out[i] = x, y, z
        for _ in range(2):
            a, b, c = slope(x, y, z)
            d, e, f = slope(x + h / 2 * a, y + h / 2 * b, z + h / 2 * c)
            k, l, m = slope(x + h / 2 * d, y + h / 2 * e, z + h / 2 * f)
            p, q, r = slope(x + h * k, y + h * l, z + h * m)
            x += h / 6 * (a + 2 * (d + k) + p)
            y += h / 6 * (b + 2 * (e + l) + q)
            z += h / 6 * (c + 2 * (f + m) + r)
    return out


def ground_effect(rows, h=GROUND_STEP):
    """Five trajectories of (f, s, z, v_p, v_q): smooth motions of throttle, platform and vehicle, and the force
    of the paper's equation (12), whose only state enters linearly: f' = -0.088 f + g(t)."""
    out = np.empty((5, rows, 5))
    for k in range(5):

        def motion(t):
            s = 0.45 + 0.02 * k + 0.08 * np.sin((0.7 + 0.11 * k) * t + k) + 0.04 * np.sin((2.3 + 0.17 * k) * t)
            a, wa, b, wb = 0.10 + 0.01 * k, 0.9 + 0.13 * k, 0.05, 2.1 - 0.19 * k
            c, wc = 0.04 + 0.015 * k, 1.6 + 0.23 * k
            q = 0.35 + a * np.sin(wa * t + k) + b * np.sin(wb * t)
            p = c * np.sin(wc * t + 2 * k)
            v_q = a * wa * np.cos(wa * t + k) + b * wb * np.cos(wb * t)
            v_p = c * wc * np.cos(wc * t + 2 * k)
            return s, q - p, v_p, v_q

        def drive(s, z, v_p, v_q):
            linear = 0.804 - 3.912 * s + 0.586 * z + 1.051 * v_p - 1.049 * v_q
            square = 4.854 * s**2 + 1.103 * v_p * v_q - 2.504 * z**2 - 0.535 * v_p**2 - 0.562 * v_q**2
            return linear + square

        t = h * np.arange(rows)
        here = motion(t)
        g, half = drive(*here), drive(*motion(t + h / 2))
        # Simpson's rule for the integral over a step.
        decay = np.exp(-0.088 * h)
        gain = h / 6 * (decay * g[:-1] + 4 * np.sqrt(decay) * half[:-1] + g[1:])
        start = 0.4 + 0.2 * k
        out[k, :, 0] = lfilter([1.0], [1.0, -decay], np.concatenate(([start], gain)))
        for j, column in enumerate(here):
            out[k, :, 1 + j] = column
    return out


def signal(rows=SIGNAL_ROWS):
    t = 0.001 * np.arange(rows)
    return np.sin(t) + 0.05 * np.random.default_rng(1).standard_normal(rows)


def main():
    folder = Path(sys.argv[1])
    folder.mkdir(parents=True, exist_ok=True)
    for name, make in {
        "lorenz": lorenz,
        "ground_small": lambda: ground_effect(3_000),
        "ground_large": lambda: ground_effect(2_000_000),
        "signal": signal,
    }.items():
        path = folder / f"{name}.npy"
        if not path.exists():
            print(f"making {path}", file=sys.stderr)
            part = path.with_suffix(".part.npy")
            np.save(part, make())
            part.rename(path)


if __name__ == "__main__":
    main()
