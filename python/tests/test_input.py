"""What people give: tables, dates, masks, single columns, and what is refused."""

from typing import Any

import numpy as np
import pandas as pd
import polars as pl
import pyarrow as pa
import pytest

import sindy

T = np.arange(0.0, 10.0, 0.01)
# x' = y, y' = -x
X = np.column_stack([np.cos(T), -np.sin(T)])
SLOPES = np.column_stack([-np.sin(T), -np.cos(T)])
FRAME = pd.DataFrame(X, columns=["a", "b"])


def model(solver: Any = sindy.STLSQ(), **options: Any) -> sindy.SINDy:
    return sindy.SINDy("poly(1)", solver, **options)


def test_analytic_dates_and_durations_are_seconds() -> None:
    for unit in ("ms", "us", "ns"):
        durations = (T * 1e9).round().astype("timedelta64[ns]").astype(f"timedelta64[{unit}]")
        dates = np.datetime64("2026-01-01T00:00:00", unit) + durations
        for times in (durations, dates):
            assert model().fit(X, times).equations() == ["1.00*x1", "-1.00*x0"]
        assert model().fit(FRAME.assign(time=dates), "time").equations() == ["1.00*b", "-1.00*a"]


def test_prop_what_is_masked_is_missing() -> None:
    masked = np.ma.array(X.copy())
    masked.data[400:410] = 1e6
    masked[400:410] = np.ma.masked
    missing = X.copy()
    missing[400:410] = np.nan
    assert np.array_equal(model().fit(masked, T).coef_, model().fit(missing, T).coef_)
    dates = np.ma.array(np.datetime64("2026-01-01", "ms") + (1e3 * T).round().astype("timedelta64[ms]"))
    dates.data[400] += np.timedelta64(4, "ms")  # wrong, but in order
    dates[400] = np.ma.masked
    times = T.copy()
    times[400] = np.nan
    # The dates are rounded to milliseconds, which these times are but for rounding.
    assert np.allclose(model().fit(X, dates).coef_, model().fit(X, times).coef_, rtol=1e-6, atol=1e-9)


def test_prop_slopes_of_a_table_go_by_name() -> None:
    slopes = pd.DataFrame({"time": T, "b": SLOPES[:, 1], "a": SLOPES[:, 0]})
    assert model().fit(FRAME, x_dot=slopes).equations() == ["1.00*b", "-1.00*a"]


def test_prop_tables_take_times_and_inputs_beside_them() -> None:
    expected = ["1.00*b", "-1.00*a"]
    for table in (FRAME, pl.from_pandas(FRAME), pa.Table.from_pandas(FRAME)):
        for times in (T, pd.Series(T)):
            assert model().fit(table, times).equations() == expected
    u = np.sin(3.0 * T)
    given = [u, pd.Series(u), pl.Series(u), pa.chunked_array([u])]
    fitted = [model(inputs=np.array(["u"])).fit(X, T, u=one).coef_ for one in given]
    assert all(np.array_equal(fitted[0], other) for other in fitted)


def test_prop_numbers_of_numpy_are_settings() -> None:
    solver = sindy.STLSQ(max_iter=np.int64(5), threshold=np.float32(0.5))
    plain = sindy.STLSQ(max_iter=5, threshold=0.5)
    fits = [sindy.SINDy("poly(1)", s, n_jobs=jobs).fit(X, T) for s, jobs in ((solver, np.int64(2)), (plain, None))]
    assert np.array_equal(fits[0].coef_, fits[1].coef_)


@pytest.mark.parametrize(
    ("key", "options", "given"),
    [
        ("method", {"method": "regression"}, {}),
        ("settings", {"settings": {"foo": 1}}, {}),
        ("noise", {"solver": None, "noise": "foo"}, {}),
        ("rows", {"solver": None, "settings": {"rows": 1.5}}, {}),
        ("rows", {"solver": None, "settings": {"rows": -1}}, {}),
        ("rows", {"solver": None, "settings": {"rows": "many"}}, {}),
        ("settings", {"solver": None, "settings": {"foo": 1}}, {}),
        ("discrete", {"discrete": "yes"}, {}),
        ("smoothing", {"smoothing": None}, {}),
        ("n_jobs", {"n_jobs": 10**9}, {}),
        ("states", {"states": ["a = b", "c"]}, {}),
        ("states", {"states": ["a\nb", "c"]}, {}),
        ("x", {}, {"x": X + 0j}),
        ("x", {}, {"x": np.full((9, 1), "a")}),
        ("s", {}, {"x": FRAME.assign(s="q")}),
        ("t", {}, {"t": {}}),
        ("t", {}, {"t": -0.1}),
    ],
)
def test_prop_bad_input_is_one_error_with_its_key(key: str, options: dict[str, Any], given: dict[str, Any]) -> None:
    with pytest.raises(sindy.SindyError) as error:
        model(**options).fit(**{"x": X, "t": T, **given})
    assert error.value.key == key
    assert error.value.expected and error.value.found
    # No type of Rust, and nothing of the text that carries the settings.
    assert not any(word in str(error.value) for word in ("usize", "f64", "struct", "variant", "line 1"))


def test_prop_a_model_names_what_it_lacks() -> None:
    fitted = model(inputs=["u"]).fit(X, T, u=np.sin(3.0 * T))
    for call in (lambda: fitted.predict(X), lambda: fitted.score(X, T), lambda: fitted.simulate([1.0, 0.0], T)):
        with pytest.raises(sindy.SindyError, match="inputs for u"):
            call()
    with pytest.raises(sindy.SindyError, match="2 columns"):
        fitted.predict(X[:, :1], u=np.sin(3.0 * T))
    with pytest.raises(sindy.SindyError, match="2 columns"):
        fitted.predict([X[:, :1]], u=[np.sin(3.0 * T)])
    with pytest.raises(sindy.SindyError, match="times"):
        fitted.simulate([1.0, 0.0], 5, u=np.sin(3.0 * T))
    stepping = model(discrete=True).fit(X, T)
    for rows in (0, -1, 2.7):
        with pytest.raises(sindy.SindyError, match="number of rows"):
            stepping.simulate([1.0, 0.0], rows)
