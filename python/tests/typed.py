"""What a user's program looks like to `mypy --strict`; it also runs."""

from __future__ import annotations

import numpy as np

import sindy


def main() -> None:
    """Fits and uses a model."""
    t = np.arange(0.0, 10.0, 0.01)
    x = np.column_stack([np.cos(t), -np.sin(t)])
    model = sindy.SINDy("poly(1)", sindy.STLSQ(threshold=0.1), states=["x", "y"]).fit(x, t)
    known = sindy.SINDy("poly(1)", states=("x", "y"), known=["x' = y"], signs=("y': x < 0",)).fit(x, t)
    kept = sindy.SINDy("poly(1)", states=("x", "y"), conserve=["x^2 + y^2"]).fit(x, t)
    bound = sindy.SINDy("poly(2)", states=("x", "y"), stable=True).fit(0.9 * x, t)
    related = sindy.SINDy("poly(1)", states=("x", "y"), constraints=("[x': y] = -[y': x]",), noise="measurement").fit(x, t)
    coefficients: np.ndarray[tuple[int, ...], np.dtype[np.float64]] = model.coef_
    slopes: sindy.Smoothed = sindy.differentiate(x, t, sindy.KalmanSmoother("constant_velocity"))
    weak: sindy.WeakSystem = sindy.WeakForm(half_width=0.5).system("poly(1)", x, t)
    found: dict[str, sindy.Subsets] = weak.gram.best_subsets(2)
    band: sindy.Band = sindy.Bootstrap(model, 20).fit(x, t).simulate([1.0, 0.0], t)
    run: sindy.Run = model.simulate([1.0, 0.0], t)
    lines: list[str] = model.equations(precision=2)
    score: float = model.score(x, t)
    print(coefficients.shape, run.finished, lines, score, known.equations(), kept.equations())
    print(bound.equations(), related.equations())


if __name__ == "__main__":
    main()
