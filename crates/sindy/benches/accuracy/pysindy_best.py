"""PySINDy's best setting for a case, found *with* knowledge of the truth.

PySINDy has no automatic choice, so a grid of settings is fitted to all seeds and the one with the smallest
median coefficient error (which only somebody who knows the answer can compute) is kept:

- strong form: Savitzky-Golay smoothing (window x polynomial order) and finite differences of order 4,
- weak form: `WeakPDELibrary`, half-width of the sub-domains x degree of the test function,
- STLSQ with refit, threshold as a fraction of the smallest true coefficient.

Three shortcuts make the grid affordable and leave its results the same: STLSQ sees the library matrix and
the derivatives through products only, so it is given the triangular factor of their QR decomposition; the
weak form is linear in the library, so its weights are applied as one sparse matrix; monomials are evaluated
without PySINDy's array class; and a window or
half-width is tried with all thresholds only if least squares on the true support, which is what STLSQ
returns when it finds that support, is among the `KEPT` best. The winning setting is then fitted by plain
`SINDy.fit` on the arrays, and these are the numbers in the table.
"""

import warnings
from functools import lru_cache

import numpy as np
import scipy.sparse

warnings.filterwarnings("ignore")
import pysindy

from systems import evaluate

THRESHOLDS = [0.05, 0.15, 0.3, 0.5, 0.7, 0.9]
KEPT = 8
# The first two of each are the quick grid. A window of 1 is no smoothing.
WINDOWS = [11, 41, 1, 5, 7, 15, 21, 31, 61, 81, 121, 181, 261, 361]
ORDERS = [3, 5]
# Half-widths in samples, so that a grid serves all steps; the degree of (1 - x^2)^p.
HALF_WIDTHS = [20, 60, 10, 14, 28, 40, 85, 120, 170, 240, 340, 480, 680, 960]
DEGREES = [4, 8]
RIDGE = 1e-8  # so small that it matters nowhere; PySINDy's 0.05 would rule the weak form's small sums
DOMAINS = 400  # per trajectory
DOMAINS_SINGLE = 1000  # where there is one trajectory
DOMAIN_SEED = 0


def strong_settings(quick):
    windows, orders = (WINDOWS[:2], ORDERS[:1]) if quick else (WINDOWS, ORDERS)
    return [
        {"form": "strong", "window": w, "order": o} for w in windows for o in orders if w == 1 or w > o
    ]  # fmt: skip


def weak_settings(quick, runs):
    lengths = {len(t) for t, _, _ in runs}
    if len(lengths) > 1:
        return []  # WeakPDELibrary has one time base for all trajectories
    widths, degrees = (HALF_WIDTHS[:2], DEGREES[:1]) if quick else (HALF_WIDTHS, DEGREES)
    rows = lengths.pop()
    k = DOMAINS_SINGLE if len(runs) == 1 else DOMAINS
    return [
        {"form": "weak", "half_width": h, "degree": p, "domains": k}
        for h in widths for p in degrees if 2 * h < rows - 2
    ]  # fmt: skip


def grid(quick, runs):
    """All that decides the result besides the arrays."""
    settings = strong_settings(quick), weak_settings(quick, runs)
    return pysindy.__version__, settings, THRESHOLDS, KEPT, RIDGE, DOMAIN_SEED


def feature_library(system):
    if system.terms is None:
        return pysindy.PolynomialLibrary(degree=system.degree, include_bias=True)
    arguments = ", ".join(system.variables)
    first = system.variables[0]
    # Functions of all variables: CustomLibrary has then one combination of arguments for each.
    functions = [
        eval(f"lambda {arguments}: " + (f"0 * {first} + 1" if t == "1" else t.replace("^", "**")))
        for t in system.terms
    ]
    names = [(lambda *_, term=term: term) for term in system.terms]
    return pysindy.CustomLibrary(library_functions=functions, function_names=names)


def derivative_of(setting):
    if setting["window"] == 1:
        return pysindy.FiniteDifference(order=4)
    return pysindy.SmoothedFiniteDifference(
        smoother_kws={"window_length": setting["window"], "polyorder": setting["order"]}, order=4
    )


def model_of(system, setting, runs, optimizer):
    """PySINDy's model for a setting, not yet fitted."""
    library = feature_library(system)
    t = runs[0][0]
    step = float(t[1] - t[0])
    if setting["form"] == "weak":
        np.random.seed(DOMAIN_SEED)  # the library draws its sub-domains from the global generator
        library = pysindy.WeakPDELibrary(
            function_library=library, spatiotemporal_grid=t, K=setting["domains"],
            H_xt=setting["half_width"] * step, p=setting["degree"],
        )  # fmt: skip
        return pysindy.SINDy(optimizer=optimizer, feature_library=library)
    return pysindy.SINDy(
        optimizer=optimizer, feature_library=library, differentiation_method=derivative_of(setting)
    )


def fit(model, system, runs):
    arguments = {"u": [u for _, _, u in runs]} if system.inputs else {}
    return model.fit(
        [x for _, x, _ in runs], t=[t for t, _, _ in runs], feature_names=system.variables, **arguments
    )


def stlsq(system, fraction):
    smallest = min(abs(c) for e in system.equations.values() for c in e.values())
    return pysindy.STLSQ(threshold=fraction * smallest, alpha=RIDGE, unbias=True)


def term_names(system, library):
    library = getattr(library, "function_library", library)
    if system.terms is not None:
        return list(system.terms)
    return [name.replace(" ", "*") for name in library.get_feature_names(system.variables)]


def coefficients(system, names, matrix):
    return {
        state: {n: float(c) for n, c in zip(names, row) if c != 0.0}
        for state, row in zip(system.states, matrix)
    }


@lru_cache(maxsize=256)
def weak_weights(rows, domains, half_width, degree):
    """PySINDy's integration weights for unit steps: matrices (domains, rows) for the library and x'.

    With a whole number of samples as half-width all sub-domains hold as many samples and have the same
    weights, so that a library of one sub-domain gives them; the centres are drawn as PySINDy draws them.
    """
    one = pysindy.WeakPDELibrary(
        function_library=pysindy.PolynomialLibrary(degree=1),
        spatiotemporal_grid=np.arange(rows, dtype=float), K=1, H_xt=float(half_width), p=degree,
    )  # fmt: skip
    theta, rate = np.asarray(one.fullweights0[0]), -np.asarray(one.fulltweights[0])
    np.random.seed(DOMAIN_SEED)
    centres = np.random.uniform(half_width, rows - 1 - half_width, size=domains)
    first = np.floor(centres - half_width).astype(int) + 1
    columns = (first[:, None] + np.arange(len(theta))).ravel()
    starts = np.arange(domains + 1) * len(theta)
    return tuple(
        scipy.sparse.csr_matrix((np.tile(w, domains), columns, starts), (domains, rows))
        for w in (theta, rate)
    )


def library_values(system, x, u):
    columns = np.hstack([x, u])
    return np.column_stack([evaluate(t, columns, system.variables) for t in system.library_terms])


def triangular_factor(system, setting, runs, values):
    """The factor of [library, derivatives] that the setting hands to the optimizer.

    `values`: the library on the samples of each run, which the weak form integrates.
    """
    blocks = []
    if setting["form"] == "strong":
        derivative = derivative_of(setting)
        for t, x, u in runs:
            rate = np.asarray(derivative(x, t))
            smooth = x if setting["window"] == 1 else np.asarray(derivative.smoothed_x_)
            blocks.append(np.hstack([library_values(system, smooth, u), rate]))
    else:
        step = float(runs[0][0][1] - runs[0][0][0])
        theta, rate = weak_weights(
            len(runs[0][0]), setting["domains"], setting["half_width"], setting["degree"]
        )
        for v, (_, x, _) in zip(values, runs):
            blocks.append(np.hstack([step * (theta @ v), rate @ x]))
    return np.linalg.qr(np.vstack(blocks), mode="r")


def oracle_error(system, factor, names, score):
    """The error of least squares on the true support."""
    count = len(names)
    found = {}
    for i, (state, equation) in enumerate(system.equations.items()):
        support = [names.index(term) for term in equation]
        solution = np.linalg.lstsq(factor[:, support], factor[:, count + i], rcond=None)[0]
        found[state] = dict(zip(equation, solution))
    return score(found)[0]


def scan(system, seeds_runs, settings, score):
    """(median error over the seeds, setting with its threshold) of the best."""
    ranked = []
    names = system.library_terms
    evaluated = [[library_values(system, x, u) for _, x, u in runs] for runs in seeds_runs]
    for setting in settings:
        factors = [
            triangular_factor(system, setting, runs, values) for runs, values in zip(seeds_runs, evaluated)
        ]
        oracle = np.median([oracle_error(system, f, names, score) for f in factors])
        ranked.append((oracle, len(ranked), setting, factors))
    best = None
    for _, _, setting, factors in sorted(ranked, key=lambda r: r[:2])[:KEPT]:
        for fraction in THRESHOLDS:
            errors = []
            for factor in factors:
                optimizer = stlsq(system, fraction)
                optimizer.fit(factor[:, : len(names)], factor[:, len(names) :])
                errors.append(score(coefficients(system, names, optimizer.coef_))[0])
            median = float(np.median(errors))
            if best is None or median < best[0]:
                best = (median, setting | {"threshold": fraction})
    return best


def best_fit(system, seeds_runs, score, quick=False):
    """The best setting of each form and the results of the better one on every seed.

    `seeds_runs`: per seed the list of (t, x, u); `score(coefficients)` gives (error, support exact).
    Returns `setting`, `errors` and `exact` per seed, and `medians` of the two forms in the scan, the better of
    which differs from the median of `errors` by rounding only. A form that PySINDy cannot fit (the weak form
    of trajectories of unequal length) has no median.
    """
    found = {
        form: scan(system, seeds_runs, settings, score)
        for form, settings in (
            ("strong", strong_settings(quick)),
            ("weak", weak_settings(quick, seeds_runs[0])),
        )
        if settings
    }
    setting = min(found.values(), key=lambda f: f[0])[1]
    results = []
    model = model_of(system, setting, seeds_runs[0], None)
    for runs in seeds_runs:
        model.optimizer = stlsq(system, setting["threshold"])
        fit(model, system, runs)
        names = term_names(system, model.feature_library)
        results.append(score(coefficients(system, names, model.optimizer.coef_)))
    errors = [e for e, _ in results]
    return {
        "setting": setting,
        "errors": [float(e) for e in errors],
        "exact": [bool(x) for _, x in results],
        "medians": {form: m for form, (m, _) in found.items()},
    }
