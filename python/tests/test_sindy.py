"""The estimator against known systems, PySINDy's numbers, and its own promises."""

from __future__ import annotations

import copy
import pickle
import warnings

import numpy as np
import pytest
from systems import LORENZ, driven, lorenz

import sindy


def table_of(model: sindy.SINDy) -> dict[tuple[str, str], float]:
    names = model.get_feature_names()
    kept = zip(*np.nonzero(model.coef_))
    return {(model.feature_names_in_[i], names[j]): model.coef_[i, j] for i, j in kept}


@pytest.fixture(scope="module")
def fitted() -> sindy.SINDy:
    t, x = lorenz(noise=0.01)
    return sindy.SINDy("poly(2)", states=["x", "y", "z"]).fit(x, t)


def test_analytic_the_automatic_call_finds_lorenz_in_noise(fitted: sindy.SINDy) -> None:
    found = table_of(fitted)
    assert found.keys() == LORENZ.keys()
    for key, value in LORENZ.items():
        i = list(fitted.feature_names_in_).index(key[0])
        error = fitted.std_error_[i, fitted.get_feature_names().index(key[1])]
        # Five standard errors: seven coefficients, one seed; and the errors are no excuse for a bad fit.
        assert abs(found[key] - value) < 5.0 * error < 0.05 * abs(value) + 0.05, (key, found[key], error)
    assert fitted.choice_.reason and fitted.equations_[0]["front"]


@pytest.mark.parametrize(
    "solver", [sindy.STLSQ(0.2, 0.0), sindy.SR3(lam=1e-4, nu=1.0, scaled=True), sindy.Stepwise(), sindy.BestSubset()]
)
def test_analytic_every_solver_finds_lorenz_from_exact_slopes(solver: sindy.Solver) -> None:
    _, x = lorenz()
    dot = np.column_stack([10 * (x[:, 1] - x[:, 0]), 28 * x[:, 0] - x[:, 1] - x[:, 0] * x[:, 2],
                           x[:, 0] * x[:, 1] - 8 / 3 * x[:, 2]])  # fmt: skip
    found = table_of(sindy.SINDy("poly(2)", solver, states=["x", "y", "z"]).fit(x, x_dot=dot))
    # Slopes are exact, so all that is left is the rounding of a Gram matrix: far below 1e-8.
    assert found == pytest.approx(LORENZ, rel=1e-8)


@pytest.mark.parametrize("smoothing", ["automatic", "weak", "spline", {"finite_difference": {"order": 6}}])
def test_analytic_slopes_from_states_find_lorenz(smoothing: object) -> None:
    t, x = lorenz()
    model = sindy.SINDy("poly(2)", sindy.STLSQ(0.5, 0.0), smoothing=smoothing, states=["x", "y", "z"]).fit(x, t)
    # Without noise slopes err by their formula's bias alone: 1e-3 of the coefficients is ten times what the worst leaves.
    assert table_of(model) == pytest.approx(LORENZ, rel=1e-3, abs=1e-2)


def test_xval_pysindy_stlsq() -> None:
    # PySINDy 2.1.0, `STLSQ(threshold, alpha, unbias, max_iter).fit(X, y)` on these rows, as in crates/sindy.
    i = np.arange(60.0)
    t = 0.1 * i
    u = np.column_stack(
        [np.sin(t), np.cos(2 * t), np.sin(t) * np.cos(2 * t), 10 * np.sin(0.7 * t) ** 2, 0.1 * np.cos(3 * t)]
    )
    y = 0.5 + 1.2 * u[:, 0] - 0.08 * u[:, 3] + 3.0 * u[:, 4] + 0.06 * u[:, 1]
    y = y + 0.02 * np.sin(17.0 * i) + 0.05 * np.cos(5.3 * i * i)
    cases = [
        (sindy.STLSQ(0.1, 0.05), [0.14589163657879137, 0.9489468290135741, 0, 0, 0, 3.287710753553758]),
        (sindy.STLSQ(0.1, 0.05, unbias=False), [0.14393545361138219, 0.9480970305484309, 0, 0, 0, 2.8097495191754596]),
        (sindy.STLSQ(0.07, 2.0, unbias=False), [0.1309475317804781, 0.8957483447566519, 0, 0, 0, 0.4218101791684589]),
    ]
    for solver, expected in cases:
        model = sindy.SINDy(["1", "a", "b", "c", "d", "e"], solver, states=["y"], inputs=list("abcde"))
        model.fit(y, u=u, x_dot=y)
        # A Gram matrix of condition about 1e3 against a factorisation of the rows.
        assert np.abs(model.coef_[0] - expected).max() < 1e-12


def test_analytic_controls_simulation_and_score() -> None:
    t, x, u = driven()
    model = sindy.SINDy("poly(2)", states=["x", "v"], inputs=["u"]).fit(x, t, u=u)
    found = table_of(model)
    expected = {("x", "v"): 1.0, ("v", "x"): -2.0, ("v", "v"): -0.4, ("v", "u"): 1.0}
    assert found == pytest.approx(expected, abs=1e-3)
    run = model.simulate(x[0], t, u=u)
    # 15 s of a damped system: coefficients of 1e-3 leave some 1e-3 of its motion of about 1.
    assert run.finished and np.abs(run.x - x).max() < 5e-3
    assert model.score(x, t, u=u) > 0.999
    assert np.array_equal(np.asarray(run), run.x)


def test_analytic_discrete_time() -> None:
    x = np.empty(200)
    x[0] = 0.3
    for k in range(199):
        x[k + 1] = 3.7 * x[k] * (1.0 - x[k])
    for solver in (None, sindy.STLSQ(0.1, 0.0)):
        model = sindy.SINDy("poly(3)", solver, discrete=True, states=["x"]).fit(x, 1.0)
        assert table_of(model) == pytest.approx({("x", "x"): 3.7, ("x", "x^2"): -3.7}, rel=1e-9)
        # Chaos doubles an error of 1e-13 at each step or so: ten steps leave 1e-9.
        assert np.abs(model.simulate([0.3], 11).x[:, 0] - x[:11]).max() < 1e-8
        assert model.score(x) > 1.0 - 1e-9


def test_prop_json_pickle_copy_and_parameters(fitted: sindy.SINDy) -> None:
    x = np.random.default_rng(5).normal(size=(50, 3))
    expected = fitted.predict(x)
    for again in (sindy.SINDy.from_json(fitted.to_json()), pickle.loads(pickle.dumps(fitted)), copy.deepcopy(fitted)):
        assert np.array_equal(again.predict(x), expected)
        assert again.equations() == fitted.equations()
    other = sindy.SINDy(**fitted.get_params(deep=False))
    assert other.get_params() == fitted.get_params() and not hasattr(other, "model_")
    solver = sindy.SINDy(solver=sindy.STLSQ()).set_params(solver__threshold=0.7, n_jobs=2)
    assert solver.get_params()["solver__threshold"] == 0.7
    with pytest.raises(ValueError, match="expected one of"):
        solver.set_params(treshold=1)


def test_prop_exports_compute_what_the_model_does(fitted: sindy.SINDy) -> None:
    sympy = pytest.importorskip("sympy")
    x = np.random.default_rng(6).normal(size=(3, 20))
    expected = fitted.predict(x.T).T
    # The same products and sums, in another order.
    assert np.allclose(fitted.to_callable()(0.0, x), expected, rtol=1e-12, atol=1e-12)
    symbols = [sympy.Symbol(n, real=True) for n in fitted.feature_names_in_]
    for row, expression in zip(expected, fitted.to_sympy()):
        assert np.allclose(sympy.lambdify(symbols, expression)(*x), row, rtol=1e-12, atol=1e-12)
    odd = sindy.SINDy(["if(x > 0.5 and not (y < 1), x^2, -x)", "atan2(y, x)", "min(x, abs(y))"], sindy.STLSQ(0.0, 0.0))
    odd.set_params(states=["x", "y"]).fit(x[:2].T, x_dot=np.random.default_rng(7).normal(size=(20, 2)))
    assert np.allclose(odd.to_callable()(0.0, x[:2]), odd.predict(x[:2].T).T, rtol=1e-12, atol=1e-12)


def test_prop_order_tables_lists_and_labels_do_not_matter() -> None:
    pandas, polars, pyarrow = (pytest.importorskip(n) for n in ("pandas", "polars", "pyarrow"))
    t, x, u = driven(600)
    make = lambda: sindy.SINDy("poly(2)", sindy.STLSQ(0.05), states=["x", "v"], inputs=["u"])  # noqa: E731
    expected = make().fit(x, t, u=u).coef_
    columns = {"t": t, "x": x[:, 0], "v": x[:, 1], "u": u[:, 0]}
    tables = [pandas.DataFrame(columns), polars.DataFrame(columns), pyarrow.table(columns)]
    others = [make().fit(frame, "t") for frame in tables]
    others += [make().fit(np.asfortranarray(x), t, u=u), make().fit(np.repeat(x, 2, axis=1)[:, ::2], t, u=u)]
    others += [make().fit([x], [t], u=[u]), make().fit(x.tolist(), t.tolist(), u=u.tolist())]
    assert all(np.array_equal(other.coef_, expected) for other in others)
    one = sindy.SINDy("poly(2)", sindy.STLSQ(0.0, 0.0))
    assert np.array_equal(one.fit([x[:, 0], x[:, 1]], 0.01).coef_, one.fit([x[:, :1], x[:, 1:]], 0.01).coef_)
    parts = make().fit([x[:300], x[300:]], [t[:300], t[300:]], u=[u[:300], u[300:]])
    labels = make().fit(x, t, u=u, groups=np.repeat(["a", "b"], 300))
    assert np.array_equal(parts.coef_, labels.coef_) and not np.array_equal(parts.coef_, expected)


def test_prop_threads_change_no_bit() -> None:
    t, x = lorenz(800, noise=0.02, seed=9)
    first, *others = [sindy.SINDy("poly(2)", n_jobs=n).fit(x, t).to_json() for n in (1, 2, 3)]
    assert all(other == first for other in others)


@pytest.mark.parametrize(
    ("key", "call"),
    [
        ("t", lambda m, t, x: m.fit(x)),
        ("t", lambda m, t, x: m.fit(x, t[:-1])),
        ("t", lambda m, t, x: m.fit(x, -0.1)),
        ("t", lambda m, t, x: m.fit(x, t[::-1])),
        ("u", lambda m, t, x: m.fit(x, t, u=np.ones((3, 1)))),
        ("x_dot", lambda m, t, x: m.fit(x, x_dot=x[:, :1])),
        ("x", lambda m, t, x: m.fit(np.array([["a"]]), t)),
        ("library", lambda m, t, x: m.set_params(library="poly(2").fit(x, t)),
        ("library", lambda m, t, x: m.set_params(library={"x0": "poly(1)"}).fit(x, t)),
        ("library", lambda m, t, x: m.set_params(library="q").fit(x, t)),
        ("threshold", lambda m, t, x: m.set_params(solver=sindy.STLSQ(-1.0)).fit(x, t)),
        ("stepwise.direction", lambda m, t, x: m.set_params(solver=sindy.Stepwise("up")).fit(x, t)),
        ("smoothing", lambda m, t, x: m.set_params(solver=sindy.STLSQ(), smoothing="soft").fit(x, t)),
        ("settings", lambda m, t, x: m.set_params(settings={"fold": 3}).fit(x, t)),
        ("folds", lambda m, t, x: m.set_params(settings={"folds": 1}).fit(x, t)),
        ("n_jobs", lambda m, t, x: m.set_params(n_jobs=0).fit(x, t)),
        ("states", lambda m, t, x: m.set_params(states=["a"]).fit(x, t)),
    ],
)
def test_prop_bad_input_says_what_and_why(key: str, call: object) -> None:
    t, x = lorenz(100)
    with pytest.raises(sindy.SindyError) as caught:
        call(sindy.SINDy(), t, x)
    error = caught.value
    names = {"library": ("library", "names"), "smoothing": ("smoothing",)}.get(key, (key,))
    assert error.key in names, (error.key, str(error))
    assert error.expected and error.found and isinstance(error, ValueError)
    assert pickle.loads(pickle.dumps(error)).key == error.key


def test_prop_warnings_are_warnings() -> None:
    t, x = lorenz(200)
    with pytest.warns(sindy.SindyWarning, match="every term was dropped"):
        model = sindy.SINDy("poly(1)", sindy.STLSQ(1e6)).fit(x, t)
    assert model.warnings_ and not model.coef_.any()
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        sindy.SINDy("poly(2)", sindy.STLSQ(0.5)).fit(x, t)


def test_prop_a_blow_up_is_an_outcome() -> None:
    t = np.linspace(0.0, 0.5, 51)
    x = 1.0 / (1.0 - t)  # x' = x^2
    model = sindy.SINDy(["x0^2"], sindy.STLSQ(0.1, 0.0)).fit(x, x_dot=x**2)
    run = model.simulate([1.0], np.linspace(0.0, 2.0, 201))
    assert not run.finished and "t = " in run.outcome and 90 < len(run.t) <= 101
