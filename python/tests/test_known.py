"""What a user knows of a system: `SINDy(known=, signs=, conserve=, constraints=, stable=, noise=, diffusion=)`."""

from __future__ import annotations

import pickle
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import numpy as np
import pytest
from sklearn.base import clone
from systems import Array

import sindy

STATES = ["x", "v"]
KNOWN = ["x' = v"]


def swing(damping: float, rows: int, noise: float = 0.0, seed: int = 1) -> tuple[Array, Array]:
    """Times, position and velocity of x'' = -x - damping x' from (1, -damping/2), with white noise."""
    t = 0.05 * np.arange(rows)
    w = np.sqrt(1.0 - damping**2 / 4.0)
    c, s = np.cos(w * t), np.sin(w * t)
    x = np.exp(-damping / 2.0 * t)[:, None] * np.column_stack([c, -damping / 2.0 * c - w * s])
    return t, x + noise * np.random.default_rng(seed).standard_normal(x.shape)


def model(*library: str, **options: Any) -> sindy.SINDy:
    return sindy.SINDy(list(library) or "poly(3)", states=STATES, **options)


def row(fitted: sindy.SINDy, state: str) -> dict[str, tuple[float, float]]:
    """Coefficient and standard error of the terms of one equation."""
    i = list(fitted.feature_names_in_).index(state)
    names = fitted.get_feature_names()
    return {names[j]: (fitted.coef_[i, j], fitted.std_error_[i, j]) for j in np.flatnonzero(fitted.coef_[i])}


def near(found: dict[str, tuple[float, float]], truth: dict[str, float]) -> bool:
    # Five standard errors, and the errors are no excuse for a bad fit.
    close = (abs(found[name][0] - value) < 5.0 * found[name][1] < 0.1 for name, value in truth.items())
    return found.keys() == truth.keys() and all(close)


@pytest.mark.parametrize("many", [False, True])
def test_analytic_a_known_equation_stays_as_it_is_and_the_other_is_found(many: bool) -> None:
    t, x = swing(0.2, 500, 0.01)
    data = ([x[:250], x[250:]], [t[:250], t[250:]]) if many else (x, t)
    fitted = model(known=KNOWN).fit(*data)
    (coefficient, error), = row(fitted, "x").values()
    assert fitted.equations()[0] == "1.00*v" and coefficient == 1.0 and np.isnan(error)
    assert near(row(fitted, "v"), {"x": -1.0, "v": -0.2})
    assert pickle.loads(pickle.dumps(fitted)).equations() == fitted.equations()


def test_analytic_a_known_part_outside_of_the_library_is_kept_and_the_rest_is_found() -> None:
    t, x = swing(0.2, 500, 0.01)
    fitted = model("x", "x^3", "x*v", known=("v' = -0.2*v + ...",), settings={"known": KNOWN}).fit(x, t)
    found = row(fitted, "v")
    coefficient, error = found.pop("v")
    assert coefficient == -0.2 and np.isnan(error)
    assert near(found, {"x": -1.0}) and row(fitted, "x").keys() == {"v"}
    # 25 s of a damped swing: a rate that is 1e-3 off leaves some 1e-2 of its motion of about 1.
    assert np.abs(fitted.simulate([1.0, -0.1], t).x - swing(0.2, 500)[1]).max() < 0.02


def test_analytic_a_damping_that_noise_turns_round_is_left_out() -> None:
    # A damping of 0.001 with a standard error of 0.004: about half of the draws turn it round. With hardly any penalty it stays
    # in the model all the same.
    turned = 0
    for seed in range(8):
        t, x = swing(0.001, 120, 0.05, seed)
        free = model("x", "v", known=KNOWN, settings={"penalty": 1e-3}).fit(x, t)
        signed = clone(free).set_params(signs=["v': v < 0"]).fit(x, t)
        if row(free, "v").get("v", (-1.0, 0.0))[0] < 0.0:
            assert row(signed, "v").keys() == row(free, "v").keys(), seed
            continue
        turned += 1
        assert near(row(signed, "v"), {"x": -1.0}), seed
    assert 0 < turned < 8


def test_analytic_a_false_sign_is_kept_and_warned_of() -> None:
    t, x = swing(0.2, 500, 0.01)
    with pytest.warns(sindy.SindyWarning, match="contradict the sign of v in v'"):
        fitted = model("poly(2)", known=KNOWN, signs=np.array(["v': v > 0"])).fit(x, t)
    assert row(fitted, "v").get("v", (0.0, 0.0))[0] >= 0.0


def test_analytic_maps_and_equations_of_second_order_have_them_too() -> None:
    x = np.empty((200, 2))
    x[0] = 0.3, 0.1
    for k in range(199):
        x[k + 1] = x[k, 1], 1.2 * x[k, 1] - x[k, 0]  # a rotation
    stepping = model("x", "v", discrete=True, known=["x[k+1] = v"], signs=["v[k+1]: x < 0"]).fit(x, 1.0)
    # No noise: what is left is rounding.
    assert np.allclose(stepping.coef_, [[0.0, 1.0], [-1.0, 1.2]], rtol=0.0, atol=1e-9)
    t, x = swing(0.2, 500)
    options: dict[str, Any] = {"known": ["x'' = -0.2*x_dot + ..."], "settings": {"second_order": ["x"]}}
    second = sindy.SINDy("poly(2)", states=["x"], signs=["x'': x < 0"], **options).fit(x[:, :1], t)
    found = row(second, "x_dot")
    assert found.keys() == {"x", "x_dot"} and found["x_dot"][0] == -0.2
    # No noise, output error: the tolerance of the integrator and of the search's end.
    assert abs(found["x"][0] + 1.0) < 1e-4


def test_analytic_an_invariant_is_kept_and_friction_contradicts_it() -> None:
    t, x = swing(0.0, 500, 0.01)
    kept = model(conserve=["x^2 + v^2"]).fit(x, t)
    (position, error), = row(kept, "x").values()
    (velocity, _), = row(kept, "v").values()
    # The ratio to rounding, the frequency within five standard errors.
    assert abs(position + velocity) < 1e-14 and abs(position - 1.0) < 5.0 * error < 0.01
    assert not any("contradict" in warning for warning in kept.warnings_)
    t, x = swing(0.05, 500, 0.01)
    with pytest.warns(sindy.SindyWarning, match="contradict that `x\\^2 \\+ v\\^2` is conserved"):
        model(settings={"conserve": ["x^2 + v^2"]}).fit(x, t)


def test_analytic_a_relation_is_kept_and_a_false_one_is_warned_of() -> None:
    t, x = swing(0.0, 500, 0.01)
    kept = model(constraints=["[x': v] = -[v': x]"]).fit(x, t)
    (position, error), = row(kept, "x").values()
    (velocity, _), = row(kept, "v").values()
    # The ratio to rounding, the frequency within five standard errors.
    assert abs(position + velocity) < 1e-14 and abs(position - 1.0) < 5.0 * error < 0.01
    assert not any("contradict" in warning for warning in kept.warnings_)
    with pytest.warns(sindy.SindyWarning, match="contradict `\\[x': v\\] = \\[v': x\\]`"):
        model(settings={"constraints": ["[x': v] = [v': x]"]}).fit(x, t)


def test_analytic_a_stable_model_decays_where_noise_hides_the_damping() -> None:
    # A damping of 0.002 over 6 s, with a standard error above that: without the condition it comes out negative or is left out.
    t, x = swing(0.002, 120, 0.05, 3)
    found = sindy.SINDy("poly(1)", states=STATES, stable=True).fit(x, t)
    linear = np.array([[row(found, i).get(j, (0.0, 0.0))[0] for j in STATES] for i in STATES])
    assert np.linalg.eigvals(linear).real.max() < 0.0
    same = sindy.SINDy("poly(1)", states=STATES, settings={"stable": True}).fit(x, t)
    assert np.array_equal(same.coef_, found.coef_)


def test_analytic_a_diffusion_that_grows_with_the_state_is_found() -> None:
    # dx = -x dt + sqrt(0.1 + 0.4 x^2) dW by Euler and Maruyama, ten steps between rows.
    step, rng, x = 0.001, np.random.default_rng(5), 0.5
    rows = []
    for k in range(60_000):
        if k % 10 == 0:
            rows.append(x)
        x += -x * step + np.sqrt((0.1 + 0.4 * x * x) * step) * rng.standard_normal()
    data = np.array(rows)[:, None], 0.01 * np.arange(len(rows))
    found = sindy.SINDy("poly(3)", states=["x"], noise="process", diffusion=["poly(2)"]).fit(*data)
    terms = {term["term"]: term["coefficient"] for term in found.equations_[0]["diffusion"]}
    # 6000 squared innovations: standard errors of some 3 % and 10 %.
    assert terms.keys() == {"1", "x^2"} and abs(terms["1"] - 0.1) < 0.02 and abs(terms["x^2"] - 0.4) < 0.15
    same = sindy.SINDy("poly(3)", states=["x"], settings={"noise": "process", "diffusion": ["poly(2)"]}).fit(*data)
    assert np.array_equal(same.coef_, found.coef_)


def test_prop_they_are_parameters_like_all_others() -> None:
    given = {"known": KNOWN, "signs": ("v': v < 0", "v': x<=0")}
    one = model(**given)
    assert one.known is given["known"] and one.signs is given["signs"]
    assert one.get_params().items() >= given.items()
    copied = clone(one)
    assert copied.get_params() == one.get_params() and repr(copied) == repr(one)
    assert "known=[\"x' = v\"]" in repr(one) and "signs" not in repr(model())
    again = pickle.loads(pickle.dumps(one))
    t, x = swing(0.2, 300, 0.01)
    assert np.array_equal(again.fit(x, t).coef_, one.fit(x, t).coef_)
    # What is validated is validated in `fit`.
    broken = clone(one).set_params(known="x' = v", signs=3)
    assert broken.known == "x' = v" and broken.signs == 3
    with pytest.raises(ValueError, match="`known`: expected a list"):
        broken.fit(x, t)
    assert broken.set_params(known=None, signs=[]).fit(x, t).feature_names_in_.tolist() == STATES


@pytest.mark.parametrize(
    ("options", "key", "expected"),
    [
        ({"known": "x' = v"}, "known", "a list of texts"),
        ({"known": [3]}, "known", "a list of texts"),
        ({"known": {"x": "v"}}, "known", "a list of texts"),
        ({"known": np.array("x' = v")}, "known", "a list of texts"),
        ({"settings": {"known": "x' = v"}}, "known", "a list of texts"),
        ({"known": ["x'"]}, "known", "an equation"),
        ({"known": ["x = v"]}, "known", "one of x', v' before `=`"),
        ({"known": ["q' = v"]}, "known", "one of x', v' before `=`"),
        ({"known": ["x[k+1] = v"]}, "known", "one of x', v' before `=`"),
        ({"known": ["x' = v"], "discrete": True}, "known", "one of x[k+1], v[k+1] before `=`"),
        ({"known": ["x' = v*"]}, "known", "an expression"),
        ({"known": ["x' = q"]}, "known", "terms of x, v"),
        ({"known": ["x' = 0*v"]}, "known", "finite coefficients that are not 0"),
        ({"known": ["x' = v", "x' = v"]}, "known", "each equation once"),
        ({"known": ["x' = v"], "settings": {"known": ["x' = x"]}}, "known", "each equation once"),
        ({"known": ["x' = v", "v' = -x"]}, "known", "a part is not known"),
        ({"signs": "v': v < 0"}, "signs", "a list of texts"),
        ({"signs": ["v < 0"]}, "signs", "an equation, `:` and a sign"),
        ({"signs": ["q': v < 0"]}, "signs", "one of x', v' before `:`"),
        ({"signs": ["v': v < 1"]}, "signs", "`< 0` or `> 0`"),
        ({"signs": ["v': v* < 0"]}, "signs", "an expression"),
        ({"signs": ["v': sin(v) < 0"]}, "signs", "a candidate term"),
        ({"signs": ["x': v > 0"], "known": ["x' = v"]}, "signs", "an equation that is not known"),
        ({"signs": ["v': v < 0"], "settings": {"signs": ["v': v > 0"]}}, "signs", "nothing against"),
        ({"conserve": "x^2 + v^2"}, "conserve", "a list of texts"),
        ({"conserve": ["x^2 +"]}, "conserve", "an expression"),
        ({"conserve": ["x^2 + q^2"]}, "conserve", "an expression of the states x, v"),
        ({"conserve": ["v^2/2 - cos(x)"]}, "conserve", "`sin(x)` in v' are needed"),
        ({"conserve": ["x^2"], "settings": {"signs": ["v': v > 0"]}}, "conserve", "none beside `signs`"),
        ({"conserve": ["x^2"], "discrete": True}, "conserve", "none in discrete time"),
        ({"constraints": "[x': v] = 0"}, "constraints", "a list of texts"),
        ({"constraints": ["[x': v] = 1"]}, "constraints", "without a constant"),
        ({"constraints": ["[x': v] = 0"], "signs": ["v': v < 0"]}, "constraints", "none beside `signs`"),
        ({"stable": 1}, "stable", "True or False"),
        ({"stable": True, "known": KNOWN}, "stable", "false beside `known`"),
        ({"stable": True}, "stable", "degree 1 or 2"),
        ({"noise": 1}, "noise", "a text"),
        ({"diffusion": "poly(2)", "noise": "process"}, "diffusion", "a list of texts"),
        ({"diffusion": ["poly(2)"]}, "diffusion", "none unless `noise` is"),
    ],
)  # fmt: skip
def test_prop_bad_ones_are_one_error_that_says_what_was_expected(
    options: dict[str, Any], key: str, expected: str
) -> None:
    t, x = swing(0.2, 100)
    with pytest.raises(sindy.SindyError) as caught:
        model(**options).fit(x, t)
    error = caught.value
    assert error.key == key and expected in error.expected and error.found, str(error)
    assert f"`{key}`" in str(error) and "\n" not in str(error) and isinstance(error, ValueError)


TEXTS = [("known", KNOWN), ("signs", ["v': v < 0"]), ("conserve", ["x^2"]), ("constraints", ["[x': v] = 0"])]


@pytest.mark.parametrize(("key", "given"), [*TEXTS, ("diffusion", ["poly(2)"])])
def test_prop_fits_that_would_ignore_them_refuse(key: str, given: list[str]) -> None:
    t, x = swing(0.2, 100)
    with ThreadPoolExecutor(1) as executor:
        ways = {
            "a solver": lambda m: m.set_params(solver=sindy.STLSQ()).fit(x, t),
            "`x_dot`": lambda m: m.fit(x, x_dot=x),
            "partial sums": lambda m: sindy.PartialSums(m, ["a"], lambda _: {"x": x, "t": t}),
            "sindy.dist.fit": lambda m: sindy.dist.fit(executor, ["a"], m, read=lambda _: {"x": x, "t": t}),
        }
        for way, call in ways.items():
            with pytest.raises(sindy.SindyError, match=f"`{key}`: expected none with .*{way}") as caught:
                call(model(**{key: given}))
            assert caught.value.key == key and caught.value.found == given[0]
        for way in ("`x_dot`", "partial sums"):
            with pytest.raises(sindy.SindyError, match=f"`{key}`: expected none with {way}"):
                ways[way](model(settings={key: given}))


@pytest.mark.parametrize(("key", "given"), [("stable", True), ("noise", "process")])
def test_prop_fits_that_would_ignore_a_choice_refuse(key: str, given: bool | str) -> None:
    t, x = swing(0.2, 100)
    for options in ({key: given}, {"settings": {key: given}}):
        with pytest.raises(sindy.SindyError, match=f"`{key}`: expected .* with `x_dot`") as caught:
            model(**options).fit(x, x_dot=x)
        assert caught.value.key == key and caught.value.found == repr(given)
