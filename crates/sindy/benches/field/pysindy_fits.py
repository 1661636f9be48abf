"""PySINDy's fits of one problem: `python pysindy_fits.py FOLDER`.

FOLDER holds what `cargo bench -p sindy --bench field -- --write` writes for a problem: a folder for each seed, with
`problem.json` and one CSV file for each trajectory. Prints a line of JSON for each seed and setting: the coefficients by
equation and term, or PySINDy's error. The first setting is PySINDy's default; the others are the grid, whose thresholds are
fractions of the smallest true coefficient, or those of `problem.json` where no truth is known. Nothing is scored here.
"""

import json
import sys
import warnings
from functools import lru_cache
from pathlib import Path

import numpy as np

warnings.filterwarnings("ignore")
import pysindy as ps

# Savitzky-Golay smoothing of degree 3, and then finite differences of order 4. A window of 1 does not smooth.
WINDOWS = [1, 5, 11, 21, 41, 81, 161, 321]
# Half-widths of the weak form's domains in median sampling intervals; test functions (1 - x^2)^p.
HALF_WIDTHS = [10, 20, 40, 80, 160, 320, 640]
TEST_DEGREES = [4, 8]
# Smoothing of positions before the weak form gets them with their velocities: each takes as long as the whole grid of other problems.
WEAK_VELOCITY_WINDOWS = [11, 41]
DOMAINS = 400
DOMAIN_SEED = 0
FRACTIONS = [0.05, 0.15, 0.3, 0.5, 0.7, 0.9]
# STLSQ: so small that it matters nowhere. PySINDy's 0.05 would dominate the weak form's small sums.
RIDGE = 1e-8
SR3_ITERATIONS = 100


class Recorder(ps.STLSQ):
    """The default optimizer, which keeps what `SINDy.fit` hands it."""

    def fit(self, x_, y, **arguments):
        self.library_values, self.targets = np.asarray(x_), np.asarray(y)
        return super().fit(x_, y, **arguments)


def interpolated(table, count):
    """The states linearly interpolated to the times of the one that was measured most often, where all have been measured."""
    t, states = table[:, 0], table[:, 1 : 1 + count].T
    known = [np.isfinite(state) for state in states]
    first = max(t[rows][0] for rows in known)
    last = min(t[rows][-1] for rows in known)
    kept = max(known, key=np.sum) & (t >= first) & (t <= last)
    columns = [np.interp(t[kept], t[rows], state[rows]) for rows, state in zip(known, states)]
    return np.column_stack([t[kept], *columns, table[kept, 1 + count :]])


def read(folder):
    """What is to be fitted, without rows that lack a state, which PySINDy refuses; columns of other rates are interpolated."""
    about = json.loads((folder / "problem.json").read_text())
    count = len(about["measured"])
    runs = []
    for path in sorted(folder.glob("run*.csv"), key=lambda p: int(p.stem[3:])):
        table = np.loadtxt(path, delimiter=",", skiprows=1, ndmin=2)
        if about["rates"]:
            table = interpolated(table, count)
        table = table[np.isfinite(table).all(axis=1)]
        runs.append((table[:, 0], table[:, 1 : 1 + count], table[:, 1 + count :]))
    return about, runs


def feature_library(about):
    if about["degree"] is not None:
        return ps.PolynomialLibrary(degree=about["degree"])
    variables = about["states"] + about["inputs"]
    head = f"lambda {', '.join(variables)}: "
    names = {"sin": np.sin, "cos": np.cos, "tanh": np.tanh, "sign": np.sign, "max": np.maximum, "min": np.minimum}
    # Functions of all variables: CustomLibrary has then one combination of arguments for each.
    functions = [
        eval(head + (f"0*{variables[0]} + 1" if term == "1" else term.replace("^", "**")), names)
        for term in about["library"]
    ]
    labels = [(lambda *_, term=term: term) for term in about["library"]]
    return ps.CustomLibrary(library_functions=functions, function_names=labels)


@lru_cache(maxsize=64)
def domains(times, half_width, degree):
    """PySINDy's library of the weak form. Its weights take longer than a fit, and seeds share them."""
    t = np.array(times)
    np.random.seed(DOMAIN_SEED)  # the library draws its domains from the global generator
    return ps.WeakPDELibrary(
        function_library=ps.PolynomialLibrary(), spatiotemporal_grid=t, K=DOMAINS,
        H_xt=half_width * float(np.median(np.diff(t))), p=degree,
    )  # fmt: skip


def differentiation(window, degree=3):
    if window == 1:
        return ps.FiniteDifference(order=4)
    return ps.SmoothedFiniteDifference(smoother_kws={"window_length": window, "polyorder": degree}, order=4)


def with_velocities(about, runs, method):
    """The runs with velocities behind the positions, and the positions as the method smoothed them, where these alone are measured."""
    if about["measured"] == about["states"]:
        return runs
    out = []
    for t, x, u in runs:
        velocities = method(x, t)
        out.append((t, np.hstack([method.smoothed_x_, velocities]), u))
    return out


def model_of(about, runs, form, optimizer):
    """PySINDy's model of a form of the grid, not yet fitted."""
    library = feature_library(about)
    if about["discrete"]:
        return ps.DiscreteSINDy(optimizer=optimizer, feature_library=library)
    if form is None:
        return ps.SINDy(optimizer=optimizer, feature_library=library)
    name, size, degree = form
    if name == "weak":
        t = runs[0][0]
        if any(not np.array_equal(t, other) for other, _, _ in runs):
            raise ValueError("WeakPDELibrary has one time base for all trajectories")
        weak = domains(tuple(t), size, degree)
        weak.function_library = library
        return ps.SINDy(optimizer=optimizer, feature_library=weak)
    return ps.SINDy(
        optimizer=optimizer, feature_library=library, differentiation_method=differentiation(size, degree)
    )


def fit(model, about, runs):
    inputs = {"u": [u for _, _, u in runs]} if about["inputs"] else {}
    names = about["states"] + about["inputs"]
    model.fit([x for _, x, _ in runs], t=[t for t, _, _ in runs], feature_names=names, **inputs)


def term_names(about):
    """In the order of PySINDy's columns."""
    if about["degree"] is None:
        return about["library"]
    names = about["states"] + about["inputs"]
    width = np.zeros((1, len(names)))
    library = ps.PolynomialLibrary(degree=about["degree"]).fit(width)
    return [name.replace(" ", "*") for name in library.get_feature_names(names)]


def equations(about, matrix):
    names = term_names(about)
    if sorted(names) != sorted(about["library"]) or matrix.shape[1] != len(names):
        raise SystemExit(f"expected the library {about['library']}; PySINDy has {names}")
    if not np.isfinite(matrix).all():
        raise ValueError("coefficients that are not finite")
    return [{n: float(c) for n, c in zip(names, row) if c != 0.0} for row in matrix]


def optimizers(about):
    """The grid's optimizers by name."""
    if about["truth"]:
        smallest = min(abs(c) for equation in about["truth"] for _, c in equation)
        thresholds = {fraction: fraction * smallest for fraction in FRACTIONS}
    else:
        thresholds = {threshold: threshold for threshold in about["thresholds"]}
    for label, threshold in thresholds.items():
        yield f"STLSQ {label}", ps.STLSQ(threshold=threshold, alpha=RIDGE)
        for nu in (1.0, 100.0):
            weight = ps.SR3.calculate_l0_weight(threshold, nu)
            yield (
                f"SR3 {label}, nu {nu:g}",
                ps.SR3(reg_weight_lam=weight, relax_coeff_nu=nu, max_iter=SR3_ITERATIONS, unbias=True),
            )


def forms(about):
    """Names, forms and windows for velocities of the grid."""
    if about["discrete"]:
        return [("next row", None, 1)]
    strong = {w: f"smoothed over {w}" if w > 1 else "differences" for w in WINDOWS}
    weak = [(f"weak {h}, p {p}", ("weak", h, p)) for h in HALF_WIDTHS for p in TEST_DEGREES]
    if about["measured"] == about["states"]:
        return [(name, ("strong", w, 3), 1) for w, name in strong.items()] + [(*form, 1) for form in weak]
    found = []
    for window, name in strong.items():
        label = f"velocities {name}"
        found += [(f"{label}, {strong[w]}", ("strong", w, 3), window) for w in sorted({1, window})]
        if window in WEAK_VELOCITY_WINDOWS:
            found += [(f"{label}, {weak_name}", form, window) for weak_name, form in weak]
    return found


def fits(about, runs):
    """(setting, equations or error) of the default and of the grid."""
    try:
        model = model_of(about, runs, None, ps.STLSQ())
        fit(model, about, with_velocities(about, runs, ps.FiniteDifference()))
        yield "default", equations(about, model.coefficients())
    except (ValueError, np.linalg.LinAlgError) as error:
        yield "default", str(error)
    for name, form, window in forms(about):
        try:
            recorder = Recorder()
            fit(model_of(about, runs, form, recorder), about, with_velocities(about, runs, differentiation(window)))
        except (ValueError, np.linalg.LinAlgError) as error:
            yield name, str(error)
            continue
        # Both optimizers see the rows through products only: the triangular factor gives the same coefficients.
        count = recorder.library_values.shape[1]
        both = np.hstack([recorder.library_values, recorder.targets])
        factor = np.linalg.qr(both, mode="r") if len(both) > both.shape[1] else both
        for label, optimizer in optimizers(about):
            try:
                optimizer.fit(factor[:, :count], factor[:, count:])
                yield f"{name}, {label}", equations(about, optimizer.coef_)
            except (ValueError, np.linalg.LinAlgError) as error:
                yield f"{name}, {label}", str(error)


def main():
    folder = Path(sys.argv[1])
    for seed in sorted((f for f in folder.iterdir() if f.is_dir()), key=lambda f: int(f.name)):
        about, runs = read(seed)
        for setting, found in fits(about, runs):
            answer = {"error": found} if isinstance(found, str) else {"equations": found}
            print(json.dumps({"seed": int(seed.name), "setting": setting} | answer), flush=True)


if __name__ == "__main__":
    main()
