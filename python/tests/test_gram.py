"""Statistics of rows: added, merged and pickled, they give what all rows at once give."""

from __future__ import annotations

import pickle

import numpy as np
import pytest
from systems import Array, driven

import sindy


def slopes() -> tuple[Array, Array, Array]:
    """States, slopes and input of x' = v, v' = -2 x - 0.4 v + u, with noise on the slopes."""
    _, x, u = driven()
    dot = np.column_stack([x[:, 1], -2.0 * x[:, 0] - 0.4 * x[:, 1] + u[:, 0]])
    return x, dot + 0.01 * np.random.default_rng(11).normal(size=dot.shape), u


def make() -> sindy.Gram:
    return sindy.Gram("poly(2)", ["x", "v"], ["u"])


def test_prop_merged_pickled_parts_are_the_whole() -> None:
    x, dot, u = slopes()
    blocks = [slice(k, k + 300) for k in range(0, len(x), 300)]
    one = make()
    for b in blocks:
        one.update(x[b], dot[b], u[b])
    first, second = make(), make()
    for b in blocks[:2]:
        first.update(x[b], dot[b], u[b])
    parts = [make().update(x[b], dot[b], u[b]) for b in blocks[2:]]
    for part in parts:
        second = pickle.loads(pickle.dumps(first if part is parts[0] else second)).merge(part)
    solver = sindy.STLSQ(0.05, 0.0)
    # Blocks in their order: the same sums in the same order.
    assert second.fit(solver).to_json() == one.fit(solver).to_json()
    assert (one.rows, one.skipped) == (len(x), 0)
    whole = sindy.SINDy("poly(2)", solver, states=["x", "v"], inputs=["u"]).fit(x, u=u, x_dot=dot)
    # Sums in another order: rounding of a Gram matrix of well-scaled terms.
    assert np.abs(one.fit(solver).coef_ - whole.coef_).max() < 1e-10
    assert one.terms == whole.get_feature_names()


def test_analytic_weights_count_rows_twice() -> None:
    x, dot, u = slopes()
    twice = make().update(np.repeat(x, 2, axis=0), np.repeat(dot, 2, axis=0), np.repeat(u, 2, axis=0))
    weighed = make().update(x, dot, u, sample_weight=np.full(len(x), 2.0))
    coefficients = [g.fit(sindy.STLSQ(0.0, 0.0)).coef_ for g in (twice, weighed)]
    # The same sums, but for rounding.
    assert np.abs(coefficients[0] - coefficients[1]).max() < 1e-10


def test_prop_rows_that_are_not_finite_are_left_out_and_counted() -> None:
    x, dot, u = slopes()
    broken = x.copy()
    broken[[3, 700]] = np.nan
    gram = make().update(broken, dot, u)
    assert (gram.rows, gram.skipped) == (len(x) - 2, 2)
    with pytest.warns(sindy.SindyWarning, match="2 rows are not finite"):
        gram.fit(sindy.STLSQ(0.05))


def test_prop_other_statistics_are_refused() -> None:
    other = sindy.Gram("poly(3)", ["x", "v"], ["u"])
    for call in (lambda: make().merge(other), lambda: other.merge(other), lambda: make().merge(3), lambda: make().update(np.ones((3, 2)), np.ones((2, 2)))):
        with pytest.raises(sindy.SindyError) as caught:
            call()  # type: ignore[no-untyped-call]
        assert caught.value.expected and caught.value.found
