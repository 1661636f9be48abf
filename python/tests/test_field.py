"""Partial differential equations from arrays."""

from __future__ import annotations

import json
import os
import subprocess
from pathlib import Path

import numpy as np
import pytest
from systems import Array

import sindy


def modes(seed: int, noise: float) -> tuple[Array, dict[str, Array]]:
    """u_t = 0.2 u_xx - 0.7 u_x, as three waves that decay."""
    t, x = np.arange(0.0, 6.0, 0.04), np.arange(0.0, 12.0, 0.1)
    at, place = np.meshgrid(t, x, indexing="ij")
    u = sum(np.exp(-0.2 * k**2 * at) * np.cos(k * (place - 0.7 * at) + k) for k in (0.5, 1.0, 1.7))
    return u + noise * np.random.default_rng(seed).normal(size=u.shape), {"t": t, "x": x}


def test_analytic_waves_that_decay_are_found_in_noise() -> None:
    u, axes = modes(1, 0.02)
    model = sindy.PDE().fit(u, axes)
    found = {term["term"]: term for term in model.terms_["u"]}
    assert set(found) == {"u_xx", "u_x"}
    # Four standard errors: 6e-5 of all draws lie beyond.
    for name, truth in (("u_xx", 0.2), ("u_x", -0.7)):
        assert abs(found[name]["coefficient"] - truth) < 4 * found[name]["std_error"] < 0.05
    assert model.quality_["u"]["noise"] == pytest.approx(0.02, rel=0.1)  # the estimate scatters by some percent
    assert "u_xx" in str(model._repr_markdown_())


def test_prop_steps_orders_and_several_measurements_agree() -> None:
    u, axes = modes(2, 0.02)
    one = sindy.PDE(n_jobs=1).fit(u, axes)
    # Steps for coordinates, Fortran's order, a name for the field.
    same = sindy.PDE().fit({"u": np.asfortranarray(u)}, {"t": 0.04, "x": 0.1})
    assert [t["term"] for t in same.terms_["u"]] == [t["term"] for t in one.terms_["u"]]
    for a, b in zip(one.terms_["u"], same.terms_["u"]):
        # Coordinates are rounded sums of steps.
        assert a["coefficient"] == pytest.approx(b["coefficient"], rel=1e-9)
    both = sindy.PDE().fit([u, modes(3, 0.02)[0]], axes)
    # Each measurement has windows of its own.
    assert both.windows_ > one.windows_ and len(both.half_widths_) == 2


def test_prop_the_command_says_the_same(tmp_path: Path) -> None:
    command = os.environ.get("SINDY_COMMAND")
    if not command:
        pytest.skip("SINDY_COMMAND does not name the command")
    u, axes = modes(4, 0.05)
    np.savez(tmp_path / "field.npz", u=u, **axes)
    run = subprocess.run([command, "pde", str(tmp_path / "field.npz"), "--json"], capture_output=True, check=True)
    said = json.loads(run.stdout)
    model = sindy.PDE().fit(u, axes)
    assert said["text"] == model.equations(5)
    assert said["warnings"] == model.warnings_


@pytest.mark.parametrize(
    ("fields", "axes", "key"),
    [
        (np.ones((20, 20)), {"t": 0.1}, "axes"),
        (np.ones((20, 20)), {"t": 0.1, "x": np.arange(19.0)}, "x"),
        (np.ones((20, 20)), {"t": 0.1, "x": 0.0}, "step"),
        ({"u": np.ones((20, 20)), "v": np.ones((20, 21))}, {"t": 0.1, "x": 0.1}, "v"),
        ([], {"t": 0.1, "x": 0.1}, "fields"),
        ({}, {"t": 0.1, "x": 0.1}, "fields"),
        (np.array([["a"]]), {"t": 0.1, "x": 0.1}, "u"),
        (np.ones((20, 20)), [0.1, 0.1], "axes"),
    ],
)
def test_prop_faults_name_what_is_wrong(fields: object, axes: object, key: str) -> None:
    with pytest.raises(sindy.SindyError) as caught:
        sindy.PDE().fit(fields, axes)
    assert caught.value.key == key


def test_prop_an_estimator_without_equations_says_so() -> None:
    with pytest.raises(sindy.SindyError, match="call `fit` first"):
        sindy.PDE().equations()
