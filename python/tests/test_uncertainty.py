"""Best subsets with proofs, and intervals and bands by resampling."""

from __future__ import annotations

from itertools import combinations

import numpy as np
import pytest
from systems import lorenz

import sindy


def oscillator(rows: int, noise: float, seed: int = 1) -> tuple[np.ndarray, np.ndarray]:
    """Rows and slopes of x' = y, y' = -x, the slopes with independent noise."""
    rng = np.random.default_rng(seed)
    x = rng.normal(size=(rows, 2))
    return x, np.column_stack([x[:, 1], -x[:, 0]]) + noise * rng.normal(size=x.shape)


def test_xval_best_subsets_are_those_of_all_subsets() -> None:
    rng = np.random.default_rng(4)
    x = rng.normal(size=(200, 1))
    target = 1.0 + x[:, 0] ** 2 - 0.3 * x[:, 0] ** 3 + rng.normal(size=200)
    gram = sindy.Gram("poly(5)", ["x"]).update(x, target)
    found = gram.best_subsets()["x"]
    columns = {"1": np.ones(200), **{f"x^{k}" if k > 1 else "x": x[:, 0] ** k for k in range(1, 6)}}
    assert list(columns) == gram.terms and found.proven and len(found) == 7 and found.ridge == 0.0
    for size in range(1, 7):
        by = {
            terms: float(np.sum((target - theta @ np.linalg.lstsq(theta, target, rcond=None)[0]) ** 2))
            for terms in combinations(columns, size)
            for theta in [np.column_stack([columns[term] for term in terms])]
        }
        best = min(by, key=lambda terms: by[terms])
        assert tuple(found[size].terms) == best and found[size].gap == 0.0
        # Sums of squares by normal equations against an orthogonal factor.
        assert abs(found[size].residual_sum / by[best] - 1.0) < 1e-9
        other = max(by, key=lambda terms: by[terms])
        if size < 6:
            certificate = gram.certify({"x": other})["x"]
            assert not certificate.is_best
            assert abs(certificate.excess - (1.0 - by[best] / by[other])) < 1e-9
            assert gram.certify({"x": best})["x"].is_best and gram.certify({"x": best})["x"].excess == 0.0


def test_prop_what_is_not_proven_says_so() -> None:
    t, x = lorenz(600, noise=0.05)
    gram = sindy.WeakForm().system("poly(4)", x, t, states=["x", "y", "z"]).gram
    assert all(found.proven for found in gram.best_subsets(3).values())
    cut = gram.best_subsets(8, node_limit=1)["y"]
    assert cut.outcome == "node_limit" and not cut.proven
    doubtful = [subset for subset in cut if not subset.proven]
    assert doubtful and all(0.0 < one.gap <= 1.0 and one.lower_bound < one.residual_sum for one in doubtful)
    certificate = gram.certify({"y": doubtful[0].terms}, node_limit=1)["y"]
    assert not certificate.is_best and certificate.excess > 0.0


def test_prop_faults_of_certificates_are_named() -> None:
    x, x_dot = oscillator(100, 0.0)
    gram = sindy.Gram("poly(2)", ["x", "y"]).update(x, x_dot)
    with pytest.raises(sindy.SindyError, match="x, y.*found z"):
        gram.certify({"z": ["x"]})
    with pytest.raises(sindy.SindyError, match="found x\\^9"):
        gram.certify({"x": ["x^9"]})
    with pytest.raises(sindy.SindyError) as caught:
        gram.best_subsets(tolerance=1.0)
    for bad in (0, -1, 1.5):
        with pytest.raises(sindy.SindyError, match="max_size"):
            gram.best_subsets(bad)  # type: ignore[arg-type]
    assert caught.value.key == "tolerance"


# Bootstrap


def test_analytic_standard_errors_are_those_of_independent_noise() -> None:
    x, x_dot = oscillator(2000, 0.1)
    model = sindy.SINDy("poly(1)", sindy.STLSQ(0.0, 0.0), states=["x", "y"])
    ensemble = sindy.Bootstrap(model, 400, seed=5, resampling=5).fit(x, x_dot=x_dot)
    assert ensemble.blocks == 400 and ensemble.block_rows == 5
    theta = np.column_stack([np.ones(len(x)), x])
    expected = 0.1 * np.sqrt(np.diag(np.linalg.inv(theta.T @ theta)))
    # 400 replicates of 400 blocks: 5 % each, so four standard deviations are 20 and 28 %.
    assert np.abs(ensemble.std_error / expected - 1.0).max() < 0.28, ensemble.std_error / expected
    assert np.allclose(np.sqrt(np.diag(ensemble.covariance[0])), ensemble.std_error[0], rtol=1e-12)
    width = (ensemble.upper - ensemble.lower) / ensemble.std_error
    # 2 * 1.96 standard errors; an end of 400 sorted replicates is off by a tenth of one.
    assert np.abs(width - 3.92).max() < 0.8, width
    assert np.array_equal(ensemble.fit.coef_, model.fit(x, x_dot=x_dot).coef_)


def test_prop_replicates_choose_their_terms_unless_these_are_kept() -> None:
    x, x_dot = oscillator(300, 0.5)
    model = sindy.SINDy("poly(2)", sindy.STLSQ(0.06, 0.0), states=["x", "y"])
    chosen = sindy.Bootstrap(model, 50, seed=1).fit(x, x_dot=x_dot)
    assert ((chosen.inclusion > 0.0) & (chosen.inclusion < 1.0)).any()
    kept = sindy.Bootstrap(model, 50, seed=1, keep_terms=True).fit(x, x_dot=x_dot)
    assert np.array_equal(kept.inclusion > 0.0, kept.fit.coef_ != 0.0) and set(np.unique(kept.inclusion)) == {0.0, 1.0}
    fewer = sindy.Bootstrap(model, 50, seed=1, omit=2).fit(x, x_dot=x_dot)
    shares = np.array([member.coef_.shape[1] for member in fewer.members])
    assert shares.max() <= 6 and not np.array_equal(fewer.mean, chosen.mean)
    with pytest.raises(sindy.SindyError, match="omit"):
        sindy.Bootstrap(model, 50, omit=1, keep_terms=True).fit(x, x_dot=x_dot)


def test_prop_results_depend_on_the_seed_alone() -> None:
    t, x = lorenz(600, noise=0.02)
    of = [
        sindy.Bootstrap(sindy.SINDy("poly(2)", sindy.STLSQ(0.3), n_jobs=jobs), 20, seed=seed).fit(x, t)
        for jobs, seed in ((1, 3), (2, 3), (2, 4))
    ]
    assert np.array_equal(of[0].lower, of[1].lower) and not np.array_equal(of[0].lower, of[2].lower)
    assert of[0].correlation_rows is not None and len(of[0].members) == 20
    whole = sindy.Bootstrap(sindy.SINDy("poly(2)", sindy.STLSQ(0.3)), 20, resampling="groups")
    parts = whole.fit([x[:200], x[200:400], x[400:]], [t[:200], t[:200], t[:200]])
    assert parts.blocks == 3 and parts.correlation_rows is None


def test_analytic_bands_hold_the_truth() -> None:
    x, x_dot = oscillator(1000, 0.1)
    model = sindy.SINDy("poly(1)", sindy.STLSQ(0.3), states=["x", "y"])
    ensemble = sindy.Bootstrap(model, 200, seed=2, level=0.99).fit(x, x_dot=x_dot)
    at = np.array([[1.0, 0.0], [0.5, -0.5]])
    band = ensemble.predict(at)
    truth = np.column_stack([at[:, 1], -at[:, 0]])
    assert ((band.lower <= truth) & (truth <= band.upper)).all() and (band.members == 200).all()
    times = np.linspace(0.0, 6.0, 61)
    run = ensemble.simulate([1.0, 0.0], times)
    exact = np.column_stack([np.cos(times), -np.sin(times)])
    # The interval of each of two coefficients is of 99 %; in the first row all members are at the start.
    assert (run.lower[0] == run.upper[0]).all() and run.ended == []
    inside = (run.lower - 1e-7 <= exact) & (exact <= run.upper + 1e-7)
    assert inside.mean() > 0.9 and (run.upper[-1] - run.lower[-1] > 0.01).all()
    narrow = ensemble.simulate([1.0, 0.0], times, level=0.5)
    assert (narrow.upper[1:] - narrow.lower[1:] <= run.upper[1:] - run.lower[1:]).all()


def test_prop_bands_of_discrete_models_and_of_members_that_blow_up() -> None:
    rng = np.random.default_rng(7)
    x = np.empty((400, 1))
    x[0] = 0.3
    for k in range(399):
        x[k + 1] = 0.9 * x[k] + 0.1 * rng.normal()
    model = sindy.SINDy("poly(1)", sindy.STLSQ(0.0, 0.0), discrete=True, states=["x"])
    ensemble = sindy.Bootstrap(model, 60, seed=1).fit(x, 1.0)
    run = ensemble.simulate([1.0], 10)
    assert run.middle.shape == (10, 1) and run.lower[3, 0] < 0.9**3 < run.upper[3, 0]
    grown = ensemble.simulate([1.0], 10, blow_up=0.99)
    assert len(grown.ended) == 60 and all("blew up" in text for text in grown.ended)


def test_prop_a_bootstrap_needs_a_solver_and_slopes() -> None:
    t, x = lorenz(300)
    with pytest.raises(sindy.SindyError, match="model with a solver"):
        sindy.Bootstrap(sindy.SINDy("poly(2)")).fit(x, t)
    with pytest.raises(sindy.SindyError, match="weak form"):
        sindy.Bootstrap(sindy.SINDy("poly(2)", sindy.STLSQ(), smoothing="weak")).fit(x, t)
    for key, value in (("replicates", 1), ("level", 1.5), ("resampling", "rows")):
        bootstrap = sindy.Bootstrap(sindy.SINDy("poly(2)", sindy.STLSQ())).set_params(**{key: value})
        with pytest.raises(sindy.SindyError) as caught:
            bootstrap.fit(x, t)
        assert caught.value.key == key
