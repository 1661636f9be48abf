"""The layer with PySINDy's names against PySINDy's numbers, known systems, and what it promises to do otherwise."""

from __future__ import annotations

import warnings
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from sklearn.base import clone
from sklearn.exceptions import ConvergenceWarning
from systems import lorenz

from sindy import pysindy as ps

Array = NDArray[np.float64]


def rows() -> tuple[Array, Array]:
    """Terms and targets of a linear model in noise, as they were given to PySINDy."""
    rng = np.random.default_rng(5)
    x = rng.normal(size=(200, 3))
    terms = np.column_stack([np.ones(200), x])
    true = np.array([[0, 1.5, -2, 0], [0.7, 0, 0, 0.3]])
    return terms, terms @ true.T + 0.1 * rng.normal(size=(200, 2))


def spiral() -> tuple[Array, Array]:
    """x' = -x - 3 y, y' = 3 x - y."""
    t = np.arange(0, 2, 0.01)
    return t, np.column_stack([np.exp(-t) * np.cos(3 * t), np.exp(-t) * np.sin(3 * t)])


def slopes_of_lorenz(x: Array) -> Array:
    return np.column_stack([10 * (x[:, 1] - x[:, 0]), 28 * x[:, 0] - x[:, 1] - x[:, 0] * x[:, 2],
                            x[:, 0] * x[:, 1] - 8 / 3 * x[:, 2]])  # fmt: skip


# PySINDy 2.1.0 (SciPy 1.17, scikit-learn 1.9): `optimizer.fit(*rows()).coef_`, printed with 8 digits.
COEFFICIENTS = [
    (ps.STLSQ(threshold=0.4), [[0, 1.50217964, -2.00173581, 0], [0.70869872, 0, 0, 0]]),
    (ps.STLSQ(threshold=0.4, unbias=False), [[0, 1.50174977, -2.00125127, 0], [0.70852159, 0, 0, 0]]),
    (ps.SR3(reg_weight_lam=0.1), [[0, 1.50180155, -2.00139209, 0], [0.70482566, 0, 0, 0]]),
    (
        ps.SR3(reg_weight_lam=20.0, regularizer="l1", relax_coeff_nu=0.01),
        [[0, 1.18701712, -1.70261365, 0], [0.40499042, 0, 0, 0]],
    ),
    (ps.SSR(), [[0, 1.50217964, -2.00173581, 0], [0.70503675, 0, 0, 0.29652122]]),
    (
        ps.ConstrainedSR3(
            reg_weight_lam=0.01, constraint_lhs=np.eye(1, 8, 1), constraint_rhs=np.array([1.0]), equality_constraints=True
        ),
        [[0, 1.0, -1.96948772, 0], [0.70482318, 0, 0, 0.29641124]],
    ),
]


@pytest.mark.parametrize("optimizer, expected", COEFFICIENTS, ids=lambda v: type(v).__name__)
def test_xval_pysindy_coefficients(optimizer: ps.BaseOptimizer, expected: list[list[float]]) -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ConvergenceWarning)  # SR3 ends at its limit in PySINDy as well
        found = clone(optimizer).fit(*rows()).coef_
    # The last printed digit, and half of it for rounding.
    np.testing.assert_allclose(found, expected, atol=1.5e-8)


def test_xval_pysindy_slopes() -> None:
    # PySINDy 2.1.0: rows 0, 7 and -1 of `method(x, t)`, printed with 8 digits.
    t, x = spiral()
    expected = [
        (ps.FiniteDifference(order=4), t, [[-0.99999938, 3.00000005], [-1.49501005, 2.54136324], [-0.00370236, 0.43225301]]),
        (ps.SmoothedFiniteDifference(), t, [[-1.00074273, 3.00142635], [-1.49454813, 2.54117603], [-0.00387356, 0.43227467]]),
        (ps.SpectralDerivative(), t, [[59.78916607, 4.32796323], [-7.27784533, 2.38219816], [60.49400782, 2.55806301]]),
        (
            ps.FiniteDifference(order=2, d=2), t**1.5 + t,
            [[1.66188705, -28.866493], [-1.58527229, -6.2512579], [-0.13315374, -0.05339567]],
        ),
    ]  # fmt: skip
    for method, times, values in expected:
        # As printed; second derivatives lose the square of the step in rounding, so a few more of the last digits.
        np.testing.assert_allclose(method(x, times)[[0, 7, -1]], values, atol=1e-7)


def test_xval_pysindy_model(capsys: pytest.CaptureFixture[str]) -> None:
    # PySINDy 2.1.0: `SINDy(STLSQ(threshold=0.2)).fit(x, t)`: `print`, `score` and the last row of `simulate`.
    t, x = spiral()
    model = ps.SINDy(ps.STLSQ(threshold=0.2)).fit(x, t)
    model.print()
    assert capsys.readouterr().out == "(x0)' = -1.000 x0 + -3.000 x1\n(x1)' =  3.000 x0 + -1.000 x1\n"
    assert model.score(x, t) == pytest.approx(0.9999999947453089, abs=1e-12)
    np.testing.assert_allclose(model.simulate(x[0], t)[-1], [0.13012571, -0.04222388], atol=1.5e-8)


def test_xval_pysindy_names_and_discrete(capsys: pytest.CaptureFixture[str]) -> None:
    t, x = spiral()
    product = (ps.PolynomialLibrary(1) * ps.FourierLibrary(1)).fit(x)
    assert product.get_feature_names()[:6] == [
        "1 sin(1 x0)", "1 cos(1 x0)", "1 sin(1 x1)", "1 cos(1 x1)", "x0 sin(1 x0)", "x0 cos(1 x0)",
    ]  # fmt: skip
    ps.DiscreteSINDy(ps.STLSQ(threshold=0.01)).fit(x, t=0.01).print(precision=5)
    said = "(x0)[k+1] =  0.98960 x0[k] + -0.02970 x1[k]\n(x1)[k+1] =  0.02970 x0[k] +  0.98960 x1[k]\n"
    assert capsys.readouterr().out == said


@pytest.mark.parametrize(
    "optimizer",
    [
        ps.STLSQ(threshold=0.5),
        ps.SSR(),
        ps.FROLS(max_iter=3, normalize_columns=True, kappa=1e-9),
        ps.MIOSR(target_sparsity=7),
        ps.EnsembleOptimizer(ps.STLSQ(threshold=0.5), bagging=True, n_models=5),
    ],
    ids=lambda v: type(v).__name__,
)
def test_analytic_optimizers_find_lorenz(optimizer: ps.BaseOptimizer) -> None:
    _, x = lorenz()
    model = ps.SINDy(clone(optimizer)).fit(x, 0.002, x_dot=slopes_of_lorenz(x))
    expected = np.zeros((3, 10))
    expected[0, 1:3] = -10, 10
    expected[1, [1, 2, 6]] = 28, -1, -1
    expected[2, [3, 5]] = -8 / 3, 1
    # Slopes are exact; MIOSR keeps its ridge of 0.01, which moves coefficients by 3e-5 of them. SSR
    # gives every equation three terms, as PySINDy does, so two equations keep one that is rounding.
    np.testing.assert_allclose(model.coefficients(), expected, rtol=1e-4, atol=1e-8)


def test_analytic_best_subsets_are_those_of_all_subsets() -> None:
    from itertools import combinations

    rng = np.random.default_rng(8)
    x = rng.normal(size=(40, 9)) + rng.normal(size=(40, 1))  # correlated, so that greedy choices go wrong
    y = x @ rng.normal(size=9) + rng.normal(size=40)
    for size in range(1, 6):
        found = ps.MIOSR(target_sparsity=size, alpha=0.0).fit(x, y)
        errors = [np.linalg.lstsq(x[:, c], y, rcond=None)[1][0] for c in combinations(range(9), size)]
        assert np.sum((y - x @ found.coef_[0]) ** 2) == pytest.approx(min(errors), rel=1e-10)


def test_analytic_penalties_drop_where_dropping_is_cheaper() -> None:
    # (x - u)²/2 + w R(u): for l0 a coefficient stays above sqrt(2 w), for l1 it shrinks by w, for l2 by 1 + 2 w.
    x = np.array([1.40, 1.43, -1.43])
    for kind, expected in (("l0", [0, 1.43, -1.43]), ("l1", [0.4, 0.43, -0.43]), ("l2", [1.4 / 3, 1.43 / 3, -1.43 / 3])):
        np.testing.assert_allclose(ps.utils.get_prox(kind)(x, 1.0), expected, atol=1e-15)


def test_regress_ssr_returns_the_full_model_where_it_is_the_best() -> None:
    # PySINDy overwrites the full model's entry with the last step and returns two terms.
    found = ps.SSR(kappa=1e-3).fit(*rows())
    assert np.argmin(found.err_history_) == 0
    assert found.complexity == 8


def test_regress_parameters_set_later_are_used() -> None:
    # PySINDy keeps the penalty of the constructor.
    terms, y = rows()
    changed = ps.SR3(reg_weight_lam=20.0, relax_coeff_nu=0.01).set_params(regularizer="l1")
    fresh = ps.SR3(reg_weight_lam=20.0, relax_coeff_nu=0.01, regularizer="l1")
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ConvergenceWarning)
        np.testing.assert_array_equal(changed.fit(terms, y).coef_, fresh.fit(terms, y).coef_)
    with pytest.raises(ValueError, match="threshold"):
        ps.STLSQ().set_params(threshold=-1.0)


def test_regress_ensembles_forget_earlier_fits() -> None:
    terms, y = rows()
    ensemble = ps.EnsembleOptimizer(ps.STLSQ(), bagging=True, n_models=3)
    ensemble.fit(terms, 100.0 * y)
    assert len(ensemble.fit(terms, y).coef_list) == 3
    assert ensemble.n_subset is None
    assert np.abs(ensemble.coef_).max() < 3.0


def test_analytic_simulations_with_inputs() -> None:
    t = np.arange(0.0, 10.0, 0.01)
    u = np.sin(3.0 * t)
    x = 1.3 * np.exp(-t) + 0.1 * np.sin(3.0 * t) - 0.3 * np.cos(3.0 * t)  # x' = -x + u
    model = ps.SINDy(feature_library=ps.IdentityLibrary()).fit(x, t, u=u)
    # 1e-4 of second-order slopes at a step of 0.01 in the coefficients.
    np.testing.assert_allclose(model.simulate([x[0]], t, u=lambda t: np.sin(3.0 * t))[:, 0], x, atol=1e-3)
    # Scripts for PySINDy compare with t[:-1].
    with pytest.warns(UserWarning, match="last time is dropped"):
        np.testing.assert_allclose(model.simulate([x[0]], t, u=u)[:, 0], x[:-1], atol=1e-3)


def test_regress_what_is_not_there_is_refused() -> None:
    assert not hasattr(ps, "ParameterizedLibrary")
    with pytest.raises(ImportError):
        from sindy.pysindy import ParameterizedLibrary  # type: ignore[attr-defined]  # noqa: F401
    with pytest.raises(ValueError, match="inequality_constraints"):
        ps.ConstrainedSR3(inequality_constraints=True, regularizer="l1")


def quadratic_model(coefficients: Array) -> tuple[Array, Array]:
    """L and Q of ``x' = L x + Q(x, x)``, from coefficients of x, y, z, x², xy, xz, y², yz, z²."""
    pairs = [(0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2)]
    quadratic = np.zeros((3, 3, 3))
    for (j, k), column in zip(pairs, coefficients[:, 3:].T):
        quadratic[:, j, k] += column / 2
        quadratic[:, k, j] += column / 2
    return coefficients[:, :3], quadratic


@pytest.mark.parametrize("penalty, normalize", [(0.0, False), (0.1, False), (0.1, True)])
def test_analytic_trapping_keeps_the_energy_and_traps(penalty: float, normalize: bool) -> None:
    _, x = lorenz()
    x = x[::10]
    noise = np.random.default_rng(2).normal(size=x.shape)
    terms = ps.PolynomialLibrary(2, include_bias=False).fit_transform(x)
    optimizer = ps.TrappingSR3(
        _n_tgts=3, eta=1e3, alpha_m=800.0, gamma=-0.5, max_iter=300, reg_weight_lam=penalty, normalize_columns=normalize
    )
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ConvergenceWarning)  # the noise leaves w moving in its last digits
        optimizer = clone(optimizer).fit(terms, slopes_of_lorenz(x) + noise)
    linear, quadratic = quadratic_model(optimizer.coef_)
    np.testing.assert_allclose(linear, [[-10, 10, 0], [28, -1, 0], [0, 0, -8 / 3]], atol=0.2)
    # x·Q(x, x) = 0 for all x, which plain least squares of the same rows do not keep.
    points = np.random.default_rng(3).normal(size=(50, 3))
    growth = [np.einsum("ni,ijk,nj,nk->n", points, q, points, points) for q in
              (quadratic, quadratic_model(np.linalg.lstsq(terms, slopes_of_lorenz(x) + noise, rcond=None)[0].T)[1])]  # fmt: skip
    assert np.abs(growth[0]).max() < 1e-7
    assert np.abs(growth[1]).max() > 1e-3
    # The energy of x - m falls at large x by the quadratic form of A_S: the Jacobian at m, made symmetric.
    m = optimizer.m_history_[-1]
    jacobian = linear + 2 * np.einsum("ijk,k->ij", quadratic, m)
    assert np.linalg.eigvalsh((jacobian + jacobian.T) / 2)[-1] < -0.1
    start = linear + 2 * np.einsum("ijk,k->ij", quadratic, optimizer.m_history_[0])
    assert np.linalg.eigvalsh((start + start.T) / 2)[-1] > 1.0
    # The balance itself: far out, the energy falls in every direction.
    far = m + 1e4 * points / np.linalg.norm(points, axis=1)[:, None]
    velocity = far @ linear.T + np.einsum("ijk,nj,nk->ni", quadratic, far, far)
    assert np.all(np.sum((far - m) * velocity, axis=1) < 0)


def test_analytic_trapping_in_another_energy() -> None:
    # Lorenz with y in other units keeps x² + (s y)² + z², and A_S is that of the units in which it keeps the plain sum.
    _, x = lorenz()
    x, scale = x[::10], np.array([1.0, 4.0, 1.0])
    library = ps.PolynomialLibrary(2, include_bias=False)
    # η is large, so that A_S is that of the data: its pull would act in other units of y.
    settings: dict[str, float] = {"eta": 1e9, "gamma": -0.5, "max_iter": 2, "reg_weight_lam": 0.0}
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ConvergenceWarning)
        start = np.array([0.5, -1.0, 30.0])
        plain = ps.TrappingSR3(m0=start, **settings).fit(library.fit_transform(x), slopes_of_lorenz(x))
        changed = ps.TrappingSR3(m0=start / scale, mod_matrix=np.diag(scale**2), **settings)
        changed.fit(library.fit_transform(x / scale), slopes_of_lorenz(x) / scale)
    np.testing.assert_allclose(changed.PW_history_[0], plain.PW_history_[0], atol=1e-6)


def test_xval_pysindy_trapping() -> None:
    # PySINDy 2.1.0: A_S's eigenvalues and m in the last of 50 iterations from its own start, printed with 8 digits.
    _, x = lorenz()
    x = x[::10]
    terms = ps.PolynomialLibrary(2, include_bias=False).fit_transform(x)
    optimizer = ps.TrappingSR3(_n_tgts=3, eta=1e3, alpha_m=100.0, gamma=-1, max_iter=50, reg_weight_lam=0.0)
    with pytest.warns(ConvergenceWarning, match="the largest eigenvalue of A_S"):
        optimizer.fit(terms, slopes_of_lorenz(x))
    np.testing.assert_allclose(optimizer.m_history_[-1], [-1.16595697, -0.37159288, 12.8412841], atol=1e-6)
    np.testing.assert_allclose(optimizer.PWeigs_history_[-1], [-18.95958855, -2.66632956, 7.95925025], atol=1e-6)


def test_analytic_local_trapping_shrinks_the_growth_of_energy() -> None:
    _, x = lorenz()
    x = x[::10]
    terms = ps.PolynomialLibrary(2, include_bias=False).fit_transform(x)
    noisy = slopes_of_lorenz(x) + 5.0 * np.random.default_rng(4).normal(size=x.shape)
    left = []
    for penalty in (0.0, 0.1):
        for beta in (None, 1e-8):
            with warnings.catch_warnings():
                warnings.simplefilter("ignore", ConvergenceWarning)
                found = ps.TrappingSR3(method="local", eta=1e3, beta=beta, max_iter=3, reg_weight_lam=penalty).fit(terms, noisy)
            _, q = quadratic_model(found.coef_)
            left.append(np.abs(q + q.transpose(1, 2, 0) + q.transpose(2, 0, 1)).max())
    assert left[0] > 1e-3 and left[2] > 1e-3
    assert max(left[1], left[3]) < 1e-4
    with pytest.raises(ValueError, match="_include_bias"):
        ps.TrappingSR3(_include_bias=True).fit(terms, noisy)


@pytest.mark.parametrize("penalty", [0.0, 0.1])
def test_analytic_stable_linear_models_are_stable(penalty: float) -> None:
    # A slowly damped spiral with an input, in noise that makes it grow.
    rng = np.random.default_rng(3)
    x, y = rng.normal(size=(200, 3)), rng.normal(size=(200, 2))
    y = x @ np.array([[0.05, 2.0, 0.5], [-2.0, 0.05, 0.0]]).T + 0.1 * y
    plain = ps.SR3(reg_weight_lam=1e-4).fit(x, y)
    assert np.linalg.eigvals(plain.coef_[:, :2]).real.max() > 0.02
    for normalize in (False, True):
        optimizer = ps.StableLinearSR3(
            penalty, relax_coeff_nu=1e-4, gamma=-0.1, max_iter=500, normalize_columns=normalize
        )
        with warnings.catch_warnings():
            warnings.simplefilter("error", UserWarning)
            warnings.simplefilter("ignore", ConvergenceWarning)  # at this ν the last digits take long
            found = clone(optimizer).fit(x, y)
        assert np.linalg.eigvals(found.coef_[:, :2]).real.max() < -0.05
        np.testing.assert_allclose(np.linalg.eigvals(found.coef_full_[:, :2]).real, -0.1, atol=1e-9)
        np.testing.assert_allclose(found.coef_, [[0, 2.0, 0.5], [-2.0, 0, 0]], atol=0.15)
    # A large ν leaves w where the data have it, and a warning names it.
    with pytest.warns(UserWarning, match="the model is not stable"):
        ps.StableLinearSR3(penalty).fit(x, y)


def test_xval_pysindy_stable_linear() -> None:
    # PySINDy 2.1.0, `StableLinearSR3(relax_coeff_nu=1e-3, gamma=-0.1, max_iter=200)`, printed with 8 digits.
    rng = np.random.default_rng(3)
    x = rng.normal(size=(200, 2))
    y = x @ np.array([[0.05, 2.0], [-2.0, 0.05]]).T + 0.1 * rng.normal(size=(200, 2))
    found = ps.StableLinearSR3(relax_coeff_nu=1e-3, gamma=-0.1, max_iter=200).fit(x, y)
    # Its solver's tolerance is 1e-5, ours 1e-8.
    np.testing.assert_allclose(found.coef_, [[-0.06283146, 1.99279057], [-1.99823204, -0.05451431]], atol=1e-6)
    np.testing.assert_allclose(found.coef_full_, [[-0.10415858, 1.99279057], [-1.99823204, -0.09584142]], atol=1e-6)


def rows_of_sbr() -> tuple[Array, Array]:
    i = np.arange(60.0)
    t = 0.1 * i
    columns = [np.ones(60), np.sin(t), np.cos(2 * t), np.sin(t) * np.cos(2 * t), 10 * np.sin(0.7 * t) ** 2, 0.1 * np.cos(3 * t)]
    x = np.column_stack(columns)
    noise = 0.02 * np.sin(17 * i) + 0.05 * np.cos(5.3 * i * i)
    return x, 0.5 + x @ [0.0, 1.2, 0.06, 0.0, -0.08, 3.0] + noise


def test_xval_pysindy_posterior() -> None:
    # PySINDy 2.1.0 with numpyro 0.22.0 in double precision: SBR(num_warmup=2000, num_samples=25000, mcmc_kwargs={"num_chains": 4,
    # "seed": 1}, nuts_kwargs={"target_accept_prob": 0.99, "max_tree_depth": 12}).fit(x, y), mean and deviation of the draws.
    means = [0.49958195, 1.19692452, 0.05631332, 0.00550122, -0.08000711, 3.09028264]
    deviations = np.array([0.00940506, 0.00965832, 0.00666511, 0.01205363, 0.00185182, 0.06642668])
    x, y = rows_of_sbr()
    found = ps.SBR(mcmc_kwargs={"num_chains": 4, "progress_bar": False}).fit(x, y)
    draws = found.mcmc_.get_samples()
    # A twentieth of a deviation: five errors of means of 20 000 draws worth at least 10 000 each.
    assert (np.abs(found.coef_[0] - means) < 0.05 * deviations).all()
    np.testing.assert_allclose(draws["beta"].std(axis=0)[0], deviations, rtol=0.05)
    assert draws["beta"].shape == draws["lambda"].shape == (20_000, 1, 6)
    assert draws["tau"].shape == draws["c_sq"].shape == draws["sigma"].shape == (20_000,)
    by_chain = found.mcmc_.get_samples(group_by_chain=True)
    np.testing.assert_array_equal(by_chain["beta"][1], draws["beta"][5000:10_000])
    assert found.mcmc_.warning is None


def test_prop_posterior_by_seed_targets_and_units() -> None:
    x, y = rows_of_sbr()
    both = np.column_stack([y, -2.0 * y])
    optimizer = ps.SBR(num_warmup=100, num_samples=400, mcmc_kwargs={"seed": 3})
    first, again = optimizer.fit(x, both).coef_, clone(optimizer).fit(x, both).coef_
    np.testing.assert_array_equal(first, again)
    assert first.shape == (2, 6)
    # Each shrinks by some per cent at most, against other prior widths.
    np.testing.assert_allclose(first[1], -2.0 * first[0], atol=0.05)
    # Coefficients come back in the units of the terms.
    scaled = ps.SBR(num_warmup=100, num_samples=400, normalize_columns=True, slab_shape_s=20).fit(x, y)
    np.testing.assert_allclose(scaled.coef_[0], first[0], atol=0.05)
    with pytest.warns(ConvergenceWarning, match="have not converged"):
        ps.SBR(num_warmup=0, num_samples=3).fit(x, y)


@pytest.mark.parametrize(
    "params", [{"num_samples": 0}, {"mcmc_kwargs": {"num_chains": 0}}, {"mcmc_kwargs": {"thinning": 2}}, {"slab_shape_s": np.inf}]
)
def test_prop_settings_of_the_posterior_are_checked(params: dict[str, Any]) -> None:
    with pytest.raises(ValueError, match="expected"):
        ps.SBR(**params)


def test_prop_the_version_is_that_of_the_names() -> None:
    assert ps.__version__ == "2.1.0"
