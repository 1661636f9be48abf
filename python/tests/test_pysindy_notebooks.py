"""What PySINDy's notebooks need beside its models: right-hand sides, fields, and one line that replaces its imports."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from sindy import pysindy as ps

CONFORMANCE = Path(__file__).parents[1] / "conformance"

# PySINDy 2.1.0: `getattr(ps.utils, name)(0.0, numpy.array(state))` with default parameters, printed with 10 decimals.
STATE = [0.5, -1.5, 2.0]
SLOPES = {
    "linear_damped_SHO": [-3.05, -0.85],
    "cubic_damped_SHO": [-6.7625, 0.0875],
    "linear_3D": [-3.05, -0.85, -0.6],
    "van_der_pol": [-1.5, -1.0625],
    "duffing": [-1.5, 0.15],
    "lotka": [8.0, -4.5],
    "cubic_oscillator": [-6.7625, 0.0875],
    "rossler": [-0.5, 0.2, -10.2],
    "hopf": [0.225, 4.325],
    "lorenz": [-20.0, 14.5, -6.08334],
    "meanfield": [0.505, 3.485, 0.5],
    "oscillator": [-0.8, -8.26, -6.02],
    "enzyme": [-0.3375],
}


@pytest.mark.parametrize("name", SLOPES)
def test_xval_pysindy_right_hand_sides(name: str) -> None:
    state = np.array(STATE[: len(SLOPES[name])])
    # Sums of a few products of numbers up to 30.
    np.testing.assert_allclose(getattr(ps.utils, name)(0.0, state), SLOPES[name], atol=1e-10)


def test_xval_pysindy_inputs_and_maps() -> None:
    # PySINDy 2.1.0, as printed.
    found = ps.utils.lorenz_control(0.3, STATE, ps.utils.lorenz_u)
    np.testing.assert_allclose(found, [-19.681178877238338, 14.5, -6.17334], rtol=1e-14)
    maps = [
        ps.utils.logistic_map(0.3, 3.6),
        ps.utils.logistic_map_control(0.3, 3.6, 0.1),
        ps.utils.logistic_map_multicontrol(0.3, 3.6, [0.1, 0.2]),
    ]
    np.testing.assert_allclose(maps, [0.756, 0.856, 0.776], rtol=1e-14)


def test_analytic_competence_has_its_slope() -> None:
    # x = y = 1: a₁ + a₂/(a₃ + 1) - 1/3 and b₁/(1 + b₂) - 1/3.
    found = ps.utils.bacterial(0.0, [1.0, 1.0], a1=0.5, a2=3.0, a3=1.0, b1=4.0, b2=1.0)
    np.testing.assert_allclose(found, [2.0 - 1 / 3, 2.0 - 1 / 3], rtol=1e-15)


def test_analytic_quadratic_terms_of_the_coupled_oscillators_keep_the_energy() -> None:
    x = np.array(STATE)
    slope = ps.utils.oscillator(0.0, x, mu1=0.0, mu2=0.0, omega=3.0)
    assert x @ np.array(slope) == pytest.approx(0.0, abs=1e-13)


# PySINDy 2.1.0: two rows of `PDELibrary(PolynomialLibrary(1, include_bias=False), 2, grid, include_bias=True).fit_transform(u)`
# for `field()`, printed with 8 decimals.
TERMS = {
    (1, 2, 3): [1.0, 0.50263895, -0.45295982, -1.61513947, 1.4, 0.5, 1.6, -0.22767525, -0.81183202, 0.70369454, 0.25131948,
                0.80422233],
    (0, 5, 1): [1.0, -0.02794155, 0.33798644, 1.23527943, 1.0, 0.0, 4.0, -0.00944386, -0.03451562, -0.02794155, 0.0,
                -0.1117662],
}  # fmt: skip


def field() -> tuple[Any, Any]:
    """A field over two dimensions of space and time, with the grid of space."""
    x, y, t = np.meshgrid(np.linspace(0, 1, 5), np.linspace(0, 2, 6), np.arange(4) * 0.1, indexing="ij")
    return (x**2 * y + np.sin(3 * y) * t + x)[..., None], np.stack([x[..., 0], y[..., 0]], axis=-1)


def test_xval_pysindy_terms_of_fields() -> None:
    u, grid = field()
    library = ps.PDELibrary(ps.PolynomialLibrary(1, include_bias=False), 2, grid, include_bias=True)
    found = library.fit_transform(u)
    assert library.get_feature_names(["u"]) == [
        "1", "u", "u_2", "u_22", "u_1", "u_12", "u_11", "uu_2", "uu_22", "uu_1", "uu_12", "uu_11",
    ]  # fmt: skip
    for row, expected in TERMS.items():
        np.testing.assert_allclose(found[row], expected, atol=1.5e-8)  # the last printed digit


def test_analytic_travelling_wave(capsys: pytest.CaptureFixture[str]) -> None:
    # u = sin(x - 2 t) + 0.5 cos(2 (x - 2 t)) has u_t = -2 u_x, and the library no other equation of that size.
    x, t = np.arange(0, 2 * np.pi, 2 * np.pi / 256), np.arange(0, 1, 0.005)
    phase = x[:, None] - 2 * t
    u = (np.sin(phase) + 0.5 * np.cos(2 * phase))[..., None]
    library = ps.PDELibrary(
        ps.PolynomialLibrary(2, include_bias=False), 3, x, diff_kwargs={"periodic": True, "is_uniform": True}
    )
    ps.SINDy(ps.STLSQ(threshold=0.5, normalize_columns=False), library).fit(u, t=t, feature_names=["u"]).print(precision=2)
    assert capsys.readouterr().out == "(u)' = -2.00 u_1\n"


def test_prop_grids_that_do_not_fit_are_refused() -> None:
    u, grid = field()
    with pytest.raises(ValueError, match="grid's"):
        ps.PDELibrary(derivative_order=1, spatial_grid=grid[:4]).fit_transform(u)
    bent = grid.copy()
    bent[0, 0, 0] += 0.1
    with pytest.raises(ValueError, match="axis 0"):
        ps.PDELibrary(derivative_order=1, spatial_grid=bent).fit_transform(u)
    with pytest.raises(ValueError, match="derivative_order"):
        ps.PDELibrary(derivative_order=1)


def weak() -> tuple[Any, Any, ps.WeakPDELibrary]:
    """Times, a wave ``u = sin(x - 2 t) + 0.5 cos(2 (x - 2 t))``, and a library of its weak form."""
    np.random.seed(3)
    x, t = np.linspace(0.0, 6.0, 121), np.linspace(0.0, 3.0, 121)
    grid = np.stack(np.meshgrid(x, t, indexing="ij"), axis=-1)
    phase = grid[..., 0] - 2.0 * grid[..., 1]
    u = (np.sin(phase) + 0.5 * np.cos(2.0 * phase))[..., None]
    functions = ps.PolynomialLibrary(2, include_bias=False)
    return t, u, ps.WeakPDELibrary(functions, 3, grid, K=60, H_xt=[1.0, 0.8], p=8, diff_kwargs={"order": 6})


def test_analytic_weak_form_of_a_wave_in_noise(capsys: pytest.CaptureFixture[str]) -> None:
    # u_t = -2 u_x. White noise of 5 % leaves finite differences no third derivative, and moves the weak coefficient by 1 %.
    t, u, library = weak()
    noisy = u + 0.05 * u.std() * np.random.default_rng(1).normal(size=u.shape)
    model = ps.SINDy(ps.STLSQ(threshold=0.3), library).fit(noisy, t=t, feature_names=["u"])
    model.print(precision=1)
    assert capsys.readouterr().out == "(u)' = -2.0 u_1\n"
    assert model.score(noisy, t=t) > 0.99


def test_analytic_integrals_by_parts() -> None:
    # Without noise the integrals of a product are those of its values, whichever derivatives are moved: f u_x, and so on.
    _, u, library = weak()
    names = library.fit(u).get_feature_names(["u"])
    found = library.transform(u)
    x = library.spatiotemporal_grid[..., 0] - 2.0 * library.spatiotemporal_grid[..., 1]
    slopes = [np.cos(x) - np.sin(2 * x), -np.sin(x) - 2 * np.cos(2 * x), -np.cos(x) + 4 * np.sin(2 * x)]
    for order, slope in enumerate(slopes, 1):
        for name, factor in (("", np.ones_like(x)), ("u", u[..., 0]), ("u^2", u[..., 0] ** 2)):
            expected = library.weak_slopes(u, (factor * slope)[..., None])[:, 0]
            column = found[:, names.index(f"{name}u_{'1' * order}")]
            # Differences of sixth order, and the trapezoidal rule for φ and its derivatives, on 40 points.
            np.testing.assert_allclose(column, expected, atol=1e-5 * np.abs(expected).max())


@pytest.mark.parametrize("order", ["target", "feature"])
def test_analytic_constraints_hold_with_normalised_columns(order: str) -> None:
    rng = np.random.default_rng(5)
    x = rng.normal(size=(200, 3)) * [1.0, 30.0, 0.01]
    y = x @ np.array([[2.0, 0.1, 50.0], [1.0, -0.2, 10.0]]).T + 0.1 * rng.normal(size=(200, 2))
    # The first coefficient of the first equation and twice the second one of the second are 1 together.
    lhs = np.zeros((1, 6))
    lhs[0, [0, 4] if order == "target" else [0, 3]] = 1.0, 2.0
    found = ps.ConstrainedSR3(
        constraint_lhs=lhs, constraint_rhs=np.array([1.0]), constraint_order=order, normalize_columns=True, max_iter=1000
    ).fit(x, y)
    # A few roundings of the solution, whose largest numbers are scaled by 1/0.01.
    assert found.coef_full_[0, 0] + 2.0 * found.coef_full_[1, 1] == pytest.approx(1.0, abs=1e-9)


def run(code: str) -> subprocess.CompletedProcess[str]:
    """Runs a script with the packages that are imported here."""
    first = f"import sys; sys.path[:] = {sys.path!r}\n"
    return subprocess.run([sys.executable, "-c", first + code], capture_output=True, text=True, check=False)


def test_prop_one_line_replaces_every_import() -> None:
    done = run(
        "import sindy.pysindy.drop_in\n"
        "from pysindy.utils.odes import lorenz\n"
        "from pysindy.feature_library import PolynomialLibrary\n"
        "import pysindy as ps, pysindy.differentiation, sindy\n"
        "assert ps is sindy.pysindy and ps.utils.lorenz is lorenz and ps.PolynomialLibrary is PolynomialLibrary\n"
        "from pysindy import ParameterizedLibrary\n"
    )
    assert done.stderr.strip().splitlines()[-1].startswith("ImportError: cannot import name 'ParameterizedLibrary'"), done.stderr


def test_prop_the_line_is_refused_after_pysindy() -> None:
    done = run("import types\nsys.modules['pysindy'] = types.ModuleType('pysindy')\nimport sindy.pysindy.drop_in\n")
    assert "expected to be imported before pysindy" in done.stderr


def test_prop_notebooks_run_with_one_line_changed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    nbformat = pytest.importorskip("nbformat")
    pytest.importorskip("ipykernel")
    monkeypatch.syspath_prepend(str(CONFORMANCE))
    monkeypatch.setenv("PYTHONPATH", str(Path(ps.__file__).parents[2]))
    notebooks = pytest.importorskip("notebooks")
    sources = ["import pysindy as ps", "print(ps.SINDy.__module__)", "ps.ParameterizedLibrary()", "print(1)"]
    book = nbformat.v4.new_notebook(cells=[nbformat.v4.new_code_cell(one) for one in sources])
    nbformat.write(book, tmp_path / "one.ipynb")
    found = notebooks.execute(tmp_path / "one.ipynb", layer=True, limit_s=120.0, every_cell=True)
    assert str(found).startswith("cell 3 of 4: AttributeError: ")
    assert found.printed == ["", "sindy.pysindy._core\n", "", "1\n"]
    assert notebooks.alike("x' = -1.001e-3 y + 2", "x' = -1.0015e-3 y + 2")
    assert not notebooks.alike("x' = 1.001 y", "x' = 1.003 y")
    assert not notebooks.alike("x' = 1.001 y", "x' = 1.001 z")
    # Imports of modules need the line that replaces all of them.
    cells = [nbformat.v4.new_code_cell("import pysindy as ps\nfrom pysindy.utils import lorenz")]
    notebooks.use_layer(cells, tmp_path)
    assert cells[0].source.splitlines() == [notebooks.DROP_IN, "import pysindy as ps", "from pysindy.utils import lorenz"]


def test_analytic_absolute_penalty_of_orthogonal_terms() -> None:
    # |y - X w|² + λ |w| over columns of length L: each coefficient is that of least squares, moved towards 0 by λ / (2 L²).
    pytest.importorskip("clarabel")
    x = np.array([[2.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 10.0]])
    y = np.array([[6.0, 0.4, 20.0], [-6.0, 1.0, 0.0]]).T
    bound = ps.ConstrainedSR3(
        reg_weight_lam=1.0, regularizer="l1", constraint_lhs=np.eye(1, 6), constraint_rhs=np.array([9.0]),
        inequality_constraints=True,
    ).fit(x, y)  # fmt: skip
    expected = [[3.0 - 0.125, 0.0, 2.0 - 0.005], [-3.0 + 0.125, 0.5, 0.0]]
    np.testing.assert_allclose(bound.coef_, expected, atol=1e-6)  # the solver's tolerance, 1e-8 of the objective


@pytest.mark.parametrize("normalised", [False, True])
def test_analytic_inequalities_hold_and_bind(normalised: bool) -> None:
    pytest.importorskip("clarabel")
    rng = np.random.default_rng(5)
    x = rng.normal(size=(400, 2)) * [1.0, 50.0]
    y = x @ np.array([[2.0, 0.3], [-1.0, 0.1]]).T
    # w of the first equation: 2 w₀ <= 3 binds. That of the second is free. One equation: the last coefficient is 0.2.
    lhs = np.array([[2.0, 0, 0, 0], [0, 0, 1.0, 0], [0, 0, 0, 1.0]])
    found = ps.ConstrainedSR3(
        reg_weight_lam=0.0, regularizer="l2", constraint_lhs=lhs, constraint_rhs=np.array([3.0, 5.0, 0.2]),
        inequality_constraints=True, equality_constraints=True, constraint_separation_index=2, normalize_columns=normalised,
    ).fit(x, y)  # fmt: skip
    other = np.array([2.0 - 1.5, 0.1 - 0.2])  # what the fixed coefficients leave, for the free ones by least squares
    cross = x[:, 0] @ x[:, 1]
    expected = [[1.5, 0.3 + other[0] * cross / (x[:, 1] @ x[:, 1])], [-1.0 + other[1] * cross / (x[:, 0] @ x[:, 0]), 0.2]]
    np.testing.assert_allclose(found.coef_, expected, atol=1e-5)  # the solver's tolerance


@pytest.mark.parametrize("normalised", [False, True])
def test_analytic_implicit_equation_of_an_enzyme(normalised: bool, capsys: pytest.CaptureFixture[str]) -> None:
    # x' = 0.6 - 1.5 x / (0.3 + x) is x = 0.2 - x'/3 - x x'/0.9.
    pytest.importorskip("clarabel")
    from scipy.integrate import solve_ivp

    t = np.arange(0.0, 4.0, 0.001)
    x = solve_ivp(ps.utils.enzyme, (0.0, t[-1]), [0.55], t_eval=t, rtol=1e-10, atol=1e-12).y.T
    name = [lambda x: x] * 2
    library = ps.SINDyPILibrary([lambda x: x], t, [lambda x: x], name, include_bias=True)
    optimizer = ps.SINDyPI(reg_weight_lam=1e-6, model_subset=[1], normalize_columns=normalised)
    model = ps.SINDy(optimizer, library, ps.FiniteDifference(drop_endpoints=True)).fit(x, t=t)
    # Slopes of second order at a step of 0.001, and the penalty.
    np.testing.assert_allclose(model.coefficients()[1], [0.2, 0.0, -1 / 3, -1 / 0.9], atol=2e-3)
    model.print(precision=2)
    assert "(x0) =  0.20 1 + -0.33 x0_dot + -1.11 x0x0_dot\n" in capsys.readouterr().out
