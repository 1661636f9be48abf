"""One case on PySINDy's side: python measure.py CASE DIRECTORY REPEATS. Prints one JSON object.

Seconds are CPU time (user and system) of this process, the smallest of the repeats; memory is the growth of
the resident peak over what the data and the imports hold, in the first of them.
"""

import json
import sys
import time
import warnings
from pathlib import Path

import numpy as np
import pysindy as ps
from scipy.linalg.blas import dsyrk
from sklearn.exceptions import ConvergenceWarning
from sklearn.metrics import mean_squared_error

# The same grid as on the other side.
THRESHOLDS = [0.01 * 1.5**k for k in range(20)]
NUS = [10.0 ** (-2 + 0.5 * k) for k in range(10)]
GROUND_INPUTS = ["s", "z", "v_p", "v_q"]


def megabytes(field):
    for line in Path("/proc/self/status").read_text().splitlines():
        if line.startswith(field):
            return int(line.split()[1]) / 1024.0
    return float("nan")


def measure(work, repeats):
    """Seconds, extra peak memory in MB, and what the last repeat returned."""
    before = megabytes("VmRSS")
    Path("/proc/self/clear_refs").write_text("5")
    seconds, peak, result = [], None, None
    for _ in range(repeats):
        start = time.process_time()
        result = work()
        seconds.append(time.process_time() - start)
        if peak is None:
            peak = megabytes("VmHWM") - before
    return min(seconds), peak, result


def converged(work):
    """What `work` returns, and whether it did so without a warning that it had not converged."""
    with warnings.catch_warnings(record=True) as seen:
        warnings.simplefilter("always")
        result = work()
    return result, not any(issubclass(w.category, ConvergenceWarning) for w in seen)


def lorenz(folder, optimizer, rows=None, repeats=1):
    x = np.load(folder / "lorenz.npy")[:rows].copy()

    def fit():
        model = ps.SINDy(optimizer=optimizer(), feature_library=ps.PolynomialLibrary(degree=5))
        return model.fit(x, t=0.002)

    seconds, extra, (model, good) = measure(lambda: converged(fit), repeats)
    return seconds, extra, {"coefficients": model.coefficients().tolist(), "converged": good}


def ground_library():
    """The eleven terms of the paper, each a function of (f, s, z, v_p, v_q)."""
    terms = {
        "1": lambda f, s, z, p, q: np.ones_like(f),
        "f": lambda f, s, z, p, q: f,
        "s": lambda f, s, z, p, q: s,
        "z": lambda f, s, z, p, q: z,
        "v_p": lambda f, s, z, p, q: p,
        "v_q": lambda f, s, z, p, q: q,
        "s^2": lambda f, s, z, p, q: s * s,
        "v_p*v_q": lambda f, s, z, p, q: p * q,
        "z^2": lambda f, s, z, p, q: z * z,
        "v_p^2": lambda f, s, z, p, q: p * p,
        "v_q^2": lambda f, s, z, p, q: q * q,
    }
    return ps.CustomLibrary(
        library_functions=list(terms.values()),
        function_names=[lambda *_, name=name: name for name in terms],
    )


def ground(path):
    data = np.load(path)
    x = [np.ascontiguousarray(k[:, :1]) for k in data]
    u = [np.ascontiguousarray(k[:, 1:]) for k in data]
    return x, u


def ground_fit(x, u, **settings):
    model = ps.SINDy(optimizer=ps.SR3(**settings), feature_library=ground_library())
    return model.fit(x, t=0.01, u=u)


def ground_case(path, repeats):
    x, u = ground(path)
    seconds, extra, (model, good) = measure(lambda: converged(lambda: ground_fit(x, u)), repeats)
    return seconds, extra, {"coefficients": model.coefficients().tolist(), "converged": good}


def grid(folder):
    x, u = ground(folder / "ground_small.npy")

    def search():
        table = []
        for nu in NUS:
            for threshold in THRESHOLDS:
                settings = {"reg_weight_lam": threshold**2 / (2 * nu), "relax_coeff_nu": nu, "unbias": True}
                errors, all_good = [], True
                for k in range(len(x)):
                    rest = [i for i in range(len(x)) if i != k]
                    model, good = converged(
                        lambda: ground_fit([x[i] for i in rest], [u[i] for i in rest], **settings)
                    )
                    all_good &= good
                    errors.append(model.score(x[k], t=0.01, u=u[k], metric=mean_squared_error))
                table.append([float(np.sqrt(np.mean(errors))), all_good])
        return table

    seconds, extra, table = measure(search, 1)
    return seconds, extra, {"table": table}


def bagging(folder):
    def optimizer():
        return ps.EnsembleOptimizer(ps.STLSQ(threshold=0.1, alpha=0.05), bagging=True, n_models=100)

    np.random.seed(1)
    return lorenz(folder, optimizer, rows=100_000)


def simulate(folder):
    x = np.load(folder / "lorenz.npy")[:2000].copy()
    model = ps.SINDy(optimizer=ps.STLSQ(threshold=0.1), feature_library=ps.PolynomialLibrary(degree=5))
    model.fit(x, t=0.002)
    # The true coefficients, so that both sides integrate the same equations.
    names = model.get_feature_names()
    truth = {"x0": [-10, 28, 0], "x1": [10, -1, 0], "x2": [0, 0, -8 / 3], "x0 x2": [0, -1, 0], "x0 x1": [0, 0, 1]}
    model.optimizer.coef_ = np.array([truth.get(name, [0, 0, 0]) for name in names], dtype=float).T
    time = 0.01 * np.arange(3001)
    seconds, extra, states = measure(lambda: model.simulate(np.array([-8.0, 7.0, 27.0]), time), 1)
    return seconds, extra, {"states": states[::100].tolist()}


def smooth(folder, repeats):
    y = np.load(folder / "signal.npy")[:, None]
    method = ps.SmoothedFiniteDifference(smoother_kws={"window_length": 11, "polyorder": 3})
    seconds, extra, slope = measure(lambda: method._differentiate(y, 0.001), repeats)
    error = slope[100:-100, 0] - np.cos(0.001 * np.arange(len(y)))[100:-100]
    return seconds, extra, {"slope_rms_error": float(np.sqrt(np.mean(error**2)))}


def product(folder, repeats):
    """OpenBLAS's product of a library that is stored already."""
    x = np.load(folder / "lorenz.npy")
    theta = np.asfortranarray(ps.PolynomialLibrary(degree=5).fit_transform(x))
    seconds, extra, _ = measure(lambda: dsyrk(1.0, theta, trans=1), repeats)
    return seconds, extra, {}


def main():
    case, folder, repeats = sys.argv[1], Path(sys.argv[2]), int(sys.argv[3])
    stlsq = lambda: ps.STLSQ(threshold=0.1, alpha=0.05)  # noqa: E731
    run = {
        "lorenz_stlsq": lambda: lorenz(folder, stlsq, repeats=repeats),
        "lorenz_sr3": lambda: lorenz(folder, ps.SR3, repeats=repeats),
        "ground_small": lambda: ground_case(folder / "ground_small.npy", repeats),
        "ground_large": lambda: ground_case(folder / "ground_large.npy", repeats),
        "grid": lambda: grid(folder),
        "bagging": lambda: bagging(folder),
        "simulate": lambda: simulate(folder),
        "smooth": lambda: smooth(folder, repeats),
        "product": lambda: product(folder, repeats),
    }[case]
    seconds, extra, result = run()
    print(json.dumps({"seconds": seconds, "extra_mb": extra, **result}))


if __name__ == "__main__":
    main()
