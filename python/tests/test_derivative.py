"""Methods of differentiation and the weak form, against SciPy and known slopes."""

from __future__ import annotations

import numpy as np
import pytest
from systems import lorenz

import sindy

T = np.arange(0.0, 6.0, 0.02)


def noisy(seed: int = 1, sd: float = 0.01) -> np.ndarray:
    return np.sin(T) + sd * np.random.default_rng(seed).normal(size=T.size)


@pytest.mark.parametrize("order", [2, 4, 6])
def test_analytic_differences_are_exact_for_polynomials_of_their_order(order: int) -> None:
    t = np.arange(0.0, 6.0, 0.25)
    slopes = sindy.FiniteDifference(order)(t**order, t)[:, 0]
    # Rounding of values of up to 5e4 over a step of 0.25.
    assert np.abs(slopes - order * t ** (order - 1)).max() < 1e-8
    # The next power is beyond it: the error is about the step to the power of the order, 2e-4 at the least.
    assert np.abs(sindy.FiniteDifference(order)(t ** (order + 1), t)[:, 0] - (order + 1) * t**order).max() > 1e-4


def test_xval_a_savitzky_golay_filter_is_that_of_scipy() -> None:
    signal = pytest.importorskip("scipy.signal")
    x = noisy()
    ours = sindy.SavitzkyGolay(21, 4).smooth(x, T)
    for values, derivative in zip(ours, (0, 1)):
        theirs = signal.savgol_filter(x, 21, 4, deriv=derivative, delta=0.02)
        # The same polynomials, solved in another order.
        assert np.abs(values[:, 0] - theirs).max() < 1e-9


def test_xval_a_spline_is_that_of_scipy() -> None:
    interpolate = pytest.importorskip("scipy.interpolate")
    t = np.sort(np.random.default_rng(3).uniform(0.0, 6.0, 120))
    x = np.sin(t)
    theirs = interpolate.make_smoothing_spline(t, x, lam=0.003)
    ours = sindy.SmoothingSpline(0.003).smooth(x, t)
    # Both solve the same banded equations, whose condition is about 1e6.
    assert np.abs(ours.x[:, 0] - theirs(t)).max() < 1e-8
    assert np.abs(ours.x_dot[:, 0] - theirs.derivative()(t)).max() < 1e-7


@pytest.mark.parametrize(
    "method",
    [
        sindy.SavitzkyGolay(),
        sindy.SavitzkyGolay(degree=4),
        sindy.SavitzkyGolay(window=61),
        sindy.SmoothingSpline(),
        sindy.KalmanSmoother(),
        sindy.KalmanSmoother("constant_velocity"),
        sindy.KalmanSmoother(ratio=1e4),
        sindy.Spectral(),
        sindy.Spectral(cutoff=0.5),
    ],
)
def test_prop_methods_that_smooth_beat_differences(method: sindy.Differentiator) -> None:
    inner = slice(40, -40)
    def error(by: sindy.Differentiator) -> float:
        return float(np.sqrt(np.mean((by(noisy(), T)[inner, 0] - np.cos(T)[inner]) ** 2)))

    # Differences turn noise of 0.01 into about 0.01 / (0.02 * sqrt(2)) = 0.35.
    assert error(sindy.FiniteDifference(2)) > 0.25 and error(method) < 0.12, error(method)
    assert eval(repr(method), vars(sindy)) == method


def test_analytic_a_spectral_derivative_of_whole_periods_is_exact() -> None:
    t = np.arange(200) * (2.0 * np.pi / 200.0)
    slopes = sindy.Spectral(cutoff=None, ends="periodic")(np.sin(3.0 * t), t)
    # Rounding of a transform of 200 numbers, times its highest frequency.
    assert np.abs(slopes[:, 0] - 3.0 * np.cos(3.0 * t)).max() < 1e-11


def test_prop_trajectories_and_gaps_keep_their_rows() -> None:
    x = noisy()
    x[100:110] = np.nan
    one, other = sindy.differentiate([x, x[:80]], [T, T[:80]], sindy.SavitzkyGolay(11, 3)).x_dot
    assert one.shape == (T.size, 1) and other.shape == (80, 1)
    assert np.isnan(one[100:110]).all() and np.isfinite(np.delete(one, np.s_[100:110])).all()
    assert sindy.differentiate(T, T, {"finite_difference": {"order": 4}}).x.shape == (T.size, 1)


def test_prop_a_model_takes_methods_beside_a_solver() -> None:
    t, x = lorenz(800, noise=0.01)
    fits = [
        sindy.SINDy("poly(2)", sindy.STLSQ(0.3), smoothing=by).fit(x, t).coef_
        for by in (sindy.SavitzkyGolay(21, 3), {"savitzky_golay": {"window": 21, "degree": 3}}, sindy.SavitzkyGolay(31, 3))
    ]
    assert np.array_equal(fits[0], fits[1]) and not np.array_equal(fits[0], fits[2])
    named = [sindy.SINDy("poly(2)", sindy.STLSQ(0.3), smoothing=by).fit(x, t).coef_ for by in ("kalman", sindy.KalmanSmoother())]
    assert np.array_equal(*named)
    with pytest.raises(sindy.SindyError, match="a text or a dict"):
        sindy.SINDy(smoothing=sindy.SavitzkyGolay()).fit(x, t)


def test_prop_searches_set_the_parameters_of_a_method() -> None:
    model = sindy.SINDy(solver=sindy.STLSQ(), smoothing=sindy.SavitzkyGolay(11, 3))
    assert model.get_params()["smoothing__window"] == 11
    assert model.set_params(smoothing__window=31).smoothing == sindy.SavitzkyGolay(31, 3)


@pytest.mark.parametrize(
    ("method", "key"),
    [
        (sindy.FiniteDifference(3), "order"),
        (sindy.SavitzkyGolay(10, 3), "window"),
        (sindy.SmoothingSpline(-1.0), "lambda"),
        (sindy.KalmanSmoother(ratio=0.0), "ratio"),
        (sindy.KalmanSmoother("walk"), "kalman.motion"),
        (sindy.Spectral(cutoff=-1.0), "cutoff"),
        ("weak", "smoothing"),
        ("median", "smoothing"),
    ],
)
def test_prop_faults_of_methods_are_named(method: object, key: str) -> None:
    with pytest.raises(sindy.SindyError) as caught:
        sindy.differentiate(noisy(), T, method)
    assert caught.value.key == key, caught.value


# The weak form


def test_analytic_the_weak_form_finds_a_decay() -> None:
    # x' = u - 2 x with u = sin 3t.
    t = np.arange(0.0, 8.0, 0.01)
    x = (2.0 * np.sin(3.0 * t) - 3.0 * np.cos(3.0 * t)) / 13.0 + np.exp(-2.0 * t)
    system = sindy.WeakForm(half_width=0.5, spacing=0.5).system("poly(2)", x, t, u=np.sin(3.0 * t))
    model = system.gram.fit(sindy.STLSQ(0.1, 0.0))
    assert [model.terms_[k] for k in np.flatnonzero(model.coef_[0])] == ["x0", "u0"]
    # The trapezoidal rule on a smooth window of 100 samples: far below 1e-6.
    assert np.abs(model.coef_[0][np.flatnonzero(model.coef_[0])] - [-2.0, 1.0]).max() < 1e-6
    # Centres 0.25 apart, from 0.5 to 7.49.
    assert system.windows == {"x0": 28} and system.half_width == {"x0": 0.5} and system.gram.rows == 28


def test_prop_the_weak_form_of_a_model_is_its_system() -> None:
    t, x = lorenz(1500, noise=0.02)
    for form in (sindy.WeakForm(), sindy.WeakForm(half_width=0.2, power=4, generalised=True)):
        model = sindy.SINDy("poly(2)", sindy.STLSQ(0.3), smoothing=form).fit(x, t)
        assert np.array_equal(model.coef_, form.system("poly(2)", x, t).gram.fit(sindy.STLSQ(0.3)).coef_)
    plain = sindy.SINDy("poly(2)", sindy.STLSQ(0.3), smoothing="weak").fit(x, t)
    assert np.array_equal(plain.coef_, sindy.WeakForm().system("poly(2)", x, t).gram.fit(sindy.STLSQ(0.3)).coef_)


def test_prop_the_weak_form_says_what_it_left_out() -> None:
    t, x = lorenz(1200)
    x[300:310, 0] = np.nan
    t = t + np.where(np.arange(t.size) > 900, 5.0, 0.0)
    system = sindy.WeakForm(half_width=0.1).system("poly(2)", x, t)
    assert (system.missing_rows, system.holes, system.short) == (10, 1, 0)


@pytest.mark.parametrize(
    ("form", "key"),
    [
        (sindy.WeakForm(half_width=-1.0), "half_width"),
        (sindy.WeakForm(spacing=3.0), "spacing"),
        (sindy.WeakForm(power=1), "power"),
    ],
)
def test_prop_faults_of_the_weak_form_are_named(form: sindy.WeakForm, key: str) -> None:
    t, x = lorenz(400)
    with pytest.raises(sindy.SindyError) as caught:
        form.system("poly(2)", x, t)
    assert caught.value.key == key
    with pytest.raises(sindy.SindyError, match="sample_weight"):
        sindy.SINDy("poly(2)", sindy.STLSQ(), smoothing="weak").fit(x, t, sample_weight=np.ones(len(t)))
