"""What notebooks show: equations, tables and figures."""

from __future__ import annotations

import re
import sys
import warnings

import numpy as np
import pytest

import sindy
import touchdown as td
from touchdown import _plot

SWEEP = {"scenario": {"timeout_s": 20.0}, "grid": {"control.controller": ["feedback", "dynamic"]}}


@pytest.fixture(scope="module")
def landings() -> td.Landings:
    return td.land(SWEEP, space=True, trials=3, seed=2)


@pytest.fixture()
def axes() -> object:
    matplotlib = pytest.importorskip("matplotlib")
    matplotlib.use("Agg")
    from matplotlib import pyplot

    yield pyplot.subplots()[1]
    pyplot.close("all")


@pytest.fixture(scope="module")
def card() -> td.Card:
    t = np.arange(0.0, 60.0, 0.02)
    s = 0.5 + 0.2 * np.sin(0.5 * t) * np.sin(0.13 * t)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", td.SindyWarning)
        return td.identify.thrust(td.Trial({"time_s": t, "throttle": s, "thrust_n": 20.0 * s**2}))


def test_prop_a_fitted_model_shows_its_equations() -> None:
    model = sindy.SINDy("poly(1)", sindy.STLSQ(threshold=0.1), states=["x", "y"])
    assert model._repr_latex_() is None
    t = np.arange(0.0, 10.0, 0.01)
    model.fit(np.column_stack([np.cos(t), -np.sin(t)]), t)
    latex = model._repr_latex_() or ""
    assert latex.startswith("$$") and latex.endswith("$$") and r"\dot{x} &=" in latex and r"\dot{y} &=" in latex
    # Notebooks prefer a table in HTML to LaTeX, so there is none.
    assert not hasattr(model, "_repr_html_")


def test_prop_tables_hold_every_row_that_they_show(card: td.Card, landings: td.Landings) -> None:
    html = card._repr_html_()
    assert html.count("<tr>") == 1 + len(card.terms) and all(term["unit"] in html for term in card.terms)
    html = landings._repr_html_()
    assert html.count("<tr>") == 1 + 6 and "Landings(6 landings" in html and "control.controller" in html


def test_analytic_lines_end_at_the_share_that_has_a_value(axes: object) -> None:
    table = {
        "controller": ["a", "b", "a", "b", "a", "a", "none"],
        "trial": np.arange(7),
        "outcome": ["landed"] * 7,
        "v_l_mps": np.array([0.3, 0.5, np.nan, np.nan, 0.1, 0.2, np.nan]),
    }
    drawn = _plot.shares(table, "v_l_mps", axes)
    a, b, none = drawn.get_lines()
    assert drawn is axes and [line.get_label() for line in (a, b, none)] == ["a (3 of 4)", "b (1 of 2)", "none (0 of 1)"]
    assert np.array_equal(a.get_xdata(), [0.1, 0.1, 0.2, 0.3]) and np.array_equal(a.get_ydata(), [0.0, 0.25, 0.5, 0.75])
    assert np.array_equal(b.get_xdata(), [0.5, 0.5]) and np.array_equal(b.get_ydata(), [0.0, 0.5])
    assert len(none.get_xdata()) == 0
    with pytest.raises(td.SindyError, match="v_l_mps") as caught:
        _plot.shares(table, "outcome", axes)
    assert caught.value.key == "column"


def test_prop_landings_are_drawn_by_points(landings: td.Landings, axes: object) -> None:
    labels = [line.get_label() for line in landings.plot(ax=axes).get_lines()]
    assert [re.sub(r" \(.*", "", text) for text in labels] == ["control.controller feedback", "control.controller dynamic"]
    vehicle, deck = landings.plot_trace(1).get_lines()
    trace = landings.trace(1)
    assert np.array_equal(vehicle.get_ydata(), trace["position_m"][:, 2])
    assert np.array_equal(deck.get_ydata(), trace["deck_m"][:, 2])


def test_prop_vertical_landings_and_free_runs_are_drawn(card: td.Card, axes: object) -> None:
    landings = td.land(thrust=card, controllers=["feedback", "imbc"], trials=2, seed=2)
    assert len(landings.plot(ax=axes).get_lines()) == 2
    vehicle, _ = landings.plot_trace(0).get_lines()
    assert np.array_equal(vehicle.get_ydata(), landings.trace(0)["vehicle_height_m"])
    t = np.arange(0.0, 5.0, 0.02)
    trial = td.Trial({"time_s": t, "throttle": 0.5 + 0.1 * np.sin(t), "thrust_n": 20.0 * (0.5 + 0.1 * np.sin(t)) ** 2})
    (run,) = td.validate(card, trial)
    measured, predicted = run.plot().get_lines()
    assert np.array_equal(predicted.get_ydata(), run.predicted_n, equal_nan=True)
    assert np.array_equal(measured.get_ydata(), run.measured_n, equal_nan=True)


def test_prop_without_matplotlib_the_error_says_what_to_install(
    landings: td.Landings, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "matplotlib", None)
    with pytest.raises(ImportError, match="pip install matplotlib"):
        landings.plot()
