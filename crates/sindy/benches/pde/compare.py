"""`sindy pde` beside PySINDy 2.1 on the same fields: python3 compare.py PATH/TO/sindy [seeds]
`python3 compare.py --write ks.npz` writes the chaotic field with 5 % of noise instead,
`python3 compare.py --coloured PATH/TO/sindy [seeds]` has noise that is not white, and libraries without a term of the truth, here alone.

Fields: two solitons of Korteweg and de Vries and Burgers' equation by Cole and Hopf, both in closed form; chaos of Kuramoto and
Sivashinsky, fronts of Fisher and of Allen and Cahn, by NumPy's Fourier transform and Runge and Kutta's method with an integrating
factor. White noise is a share of the field's standard deviation. Both programs get
the same 15 or 16 candidates: derivatives up to the fourth, degree 3. `sindy pde` runs as it is. PySINDy gets its weak library (500
windows, as its examples have) and STLSQ, and of five thresholds the one with the least error, chosen with the truth. `u u_x` there is
half of `(u^2)_x` here. "Silent" counts wrong terms without a warning.

Needs `pip install numpy pysindy==2.1.0`.
"""
import json
import subprocess
import sys
import tempfile
import time
import warnings
from pathlib import Path

import numpy as np

warnings.filterwarnings("ignore")
THRESHOLDS = (0.02, 0.05, 0.1, 0.2, 0.5)
# The candidates of `sindy pde` for one field.
POWERS = ("u", "(u^2)", "(u^3)")
LIBRARY = ["u", "u^2", "u^3", *(p + "_" + d * "x" for p in POWERS for d in range(1, 5))]


def korteweg_de_vries():
    t, x = 0.05 * np.arange(120), 0.2 * np.arange(150)
    grid_t, grid_x = np.meshgrid(t, x, indexing="ij")
    k, l = 1.4, 0.9
    a = np.exp(k * (grid_x - 6) - k**3 * grid_t)
    b = np.exp(l * (grid_x - 13) - l**3 * grid_t)
    ab = ((k - l) / (k + l)) ** 2 * a * b
    f = 1 + a + b + ab
    first = k * a + l * b + (k + l) * ab
    second = k**2 * a + l**2 * b + (k + l) ** 2 * ab
    truth = {"(u^2)_x": -3.0, "u_xxx": -1.0}
    return t, x, 2 * (second / f - (first / f) ** 2), truth


def burgers():
    t, x = 0.05 * np.arange(120), 0.1 * np.arange(160)
    grid_t, grid_x = np.meshgrid(t, x, indexing="ij")
    viscosity, waves = 0.2, ((0.4, 0.3), (0.9, 1.1), (1.5, 2.0))
    decays = [(np.exp(-viscosity * k**2 * grid_t), k * grid_x + c, k) for k, c in waves]
    phi = 3.2 + sum(decay * np.cos(phase) for decay, phase, _ in decays)
    slope = sum(-k * decay * np.sin(phase) for decay, phase, k in decays)
    return t, x, -2 * viscosity * slope / phi, {"(u^2)_x": -0.5, "u_xx": viscosity}


def evolve(start, length, linear, rest, period, frames, substeps):
    """u_t = linear(u) + rest(u) on a ring: `linear` as a function of the wave number, `rest` of wave number and spectrum."""
    n, step = len(start), period / substeps
    k = 2 * np.pi * np.fft.rfftfreq(n, length / n)
    half = np.exp(linear(k) * step / 2)

    def rate(v):
        return step * rest(k, np.fft.irfft(v, n))

    v, out = np.fft.rfft(start), [start]
    for _ in range(frames - 1):
        for _ in range(substeps):
            a = rate(v)
            b = rate(half * (v + a / 2))
            c = rate(half * v + b / 2)
            d = rate(half**2 * v + half * c)
            v = half**2 * v + (half**2 * a + 2 * half * (b + c) + d) / 6
        out.append(np.fft.irfft(v, n))
    return period * np.arange(frames), np.arange(n) * length / n, np.array(out)


def waves(seed, length, n):
    """Six waves on a ring with random phases and sizes."""
    rng, x = np.random.default_rng(seed), np.arange(n) * length / n
    return sum(
        rng.normal() / m**0.5 * np.cos(2 * np.pi * m * x / length + rng.uniform(0, 2 * np.pi)) for m in range(1, 7)
    )


def kuramoto_sivashinsky():
    n, length = 128, 22 * np.pi
    x = np.arange(n) * length / n
    t, x, u = evolve(
        np.cos(x / 11) * (1 + np.sin(x / 11)), length, lambda k: k**2 - k**4,
        lambda k, u: -0.5j * k * np.fft.rfft(u**2), 0.5, 320, 25,
    )
    # From t = 60 on it is chaotic.
    return t[:-120], x, u[120:], {"(u^2)_x": -0.5, "u_xx": -1.0, "u_xxxx": -1.0}


def fisher():
    start = 0.3 * np.clip(0.5 + 0.15 * waves(1, 40, 128), 0.02, None)
    t, x, u = evolve(start, 40, lambda k: -0.5 * k**2, lambda k, u: np.fft.rfft(u - u**2), 0.05, 160, 2)
    return t, x, u, {"u_xx": 0.5, "u": 1.0, "u^2": -1.0}


def allen_cahn():
    start = 0.4 * waves(3, 20, 128)
    t, x, u = evolve(start, 20, lambda k: -0.2 * k**2, lambda k, u: np.fft.rfft(u - u**3), 0.04, 150, 2)
    return t, x, u, {"u_xx": 0.2, "u": 1.0, "u^3": -1.0}


def with_noise(u, share, seed):
    return u + share * u.std() * np.random.default_rng(seed).standard_normal(u.shape)


def correlated(u, level, memory, axis, random):
    """Noise with this standard deviation, of which each sample is `memory` times its neighbour along `axis` and a part of its own."""
    draws = np.moveaxis(random.standard_normal(u.shape), axis, 0)
    for k in range(1, len(draws)):
        draws[k] = memory * draws[k - 1] + (1 - memory**2) ** 0.5 * draws[k]
    return u + level * np.moveaxis(draws, 0, axis)


# Noise that is not white: name, share of the field's standard deviation, draws. Student's t has the share as its scale.
NOISES = {
    "memory 0.5 in time": (0.02, lambda u, level, random: correlated(u, level, 0.5, 0, random)),
    "memory 0.8 in time": (0.03, lambda u, level, random: correlated(u, level, 0.8, 0, random)),
    "memory 0.95 in time": (0.02, lambda u, level, random: correlated(u, level, 0.95, 0, random)),
    "memory 0.8 in space": (0.02, lambda u, level, random: correlated(u, level, 0.8, 1, random)),
    "Student's t, 3": (0.02, lambda u, level, random: u + level * random.standard_t(3, u.shape)),
    "Student's t, 1.5": (0.01, lambda u, level, random: u + level * random.standard_t(1.5, u.shape)),
}


def coloured(command, seeds, fields):
    """Noise that is not white. Of `none` results `u_t = 0` is one although a model of the front explains most."""
    print("| field | noise | exact | silent | none | error |")
    print("| --- | --- | --- | --- | --- | --- |")
    for name, make in fields.items():
        t, x, u, truth = make()
        for noise, (share, draw) in NOISES.items():
            rows = []
            for seed in range(seeds):
                found, doubted, _ = ours(command, t, x, draw(u, share * u.std(), np.random.default_rng(seed)))
                exact, error = judge(found, truth)
                rows.append((exact, not exact and not doubted, not found, error))
            exact, silent, none, error = zip(*rows)
            print(f"| {name} | {noise} | {sum(exact)}/{seeds} | {sum(silent)} | {sum(none)} | {np.median(error):.1e} |", flush=True)
    print("\n| field | library | noise | warned | none |")
    print("| --- | --- | --- | --- | --- |")
    for name, make in fields.items():
        t, x, u, truth = make()
        for missing in truth:
            library = [term for term in LIBRARY if term != missing]
            for noise in ("none", *NOISES):
                rows = []
                for seed in range(seeds if noise != "none" else 1):
                    share, draw = NOISES.get(noise, (0.0, None))
                    noisy = draw(u, share * u.std(), np.random.default_rng(seed)) if draw else u
                    found, doubted, _ = ours(command, t, x, noisy, library)
                    rows.append((doubted, not found))
                doubted, none = zip(*rows)
                print(f"| {name} | without {missing} | {noise} | {sum(doubted)}/{len(rows)} | {sum(none)} |", flush=True)


def judge(found, truth):
    """Whether the terms are the true ones, and the relative error of all coefficients (2-norm)."""
    names = set(found) | set(truth)
    error = sum((found.get(n, 0.0) - truth.get(n, 0.0)) ** 2 for n in names)
    return set(found) == set(truth), (error / sum(c**2 for c in truth.values())) ** 0.5


def ours(command, t, x, u, library=()):
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "field.npz"
        np.savez(path, t=t, x=x, u=u)
        begun = time.perf_counter()
        terms = [part for term in library for part in ("--term", term)]
        run = subprocess.run([command, "--quiet", "--json", "pde", path, *terms], check=True, capture_output=True)
        spent = time.perf_counter() - begun
    found = json.loads(run.stdout)
    terms = {term["term"]: term["coefficient"] for term in found["equations"]["u"]}
    return terms, bool(found["warnings"]), spent


def pysindy(t, x, u, truth):
    import pysindy as ps

    grid = np.asarray(np.meshgrid(x, t, indexing="ij")).transpose(1, 2, 0)
    names = {"u": "u", "u_1": "u_x", "u_11": "u_xx", "u_111": "u_xxx", "u_1111": "u_xxxx", "uu_1": "(u^2)_x"}
    best = None
    begun = time.perf_counter()
    for threshold in THRESHOLDS:
        np.random.seed(0)
        library = ps.WeakPDELibrary(
            function_library=ps.PolynomialLibrary(degree=3, include_bias=False),
            derivative_order=4, spatiotemporal_grid=grid, is_uniform=True, K=500,
        )
        model = ps.SINDy(feature_library=library, optimizer=ps.STLSQ(threshold=threshold, alpha=1e-5))
        model.fit(u.T[:, :, None], t=t, feature_names=["u"])
        row = zip(model.get_feature_names(), model.coefficients()[0])
        found = {names.get(n, n): 0.5 * c if n == "uu_1" else c for n, c in row if c != 0}
        result = judge(found, truth)
        if best is None or result[1] < best[1]:
            best = result
    return best, (time.perf_counter() - begun) / len(THRESHOLDS)


def main():
    if sys.argv[1] == "--write":
        t, x, u, _ = kuramoto_sivashinsky()
        np.savez(sys.argv[2], t=t, x=x, u=with_noise(u, 0.05, 0))
        return
    fields = {
        "Korteweg-de Vries": korteweg_de_vries, "Kuramoto-Sivashinsky": kuramoto_sivashinsky, "Burgers": burgers,
        "Fisher": fisher, "Allen-Cahn": allen_cahn,
    }
    if sys.argv[1] == "--coloured":
        coloured(sys.argv[2], int(sys.argv[3]) if len(sys.argv) > 3 else 3, fields)
        return
    command, seeds = sys.argv[1], int(sys.argv[2]) if len(sys.argv) > 2 else 3
    print("| field | noise | exact here | silent | error here | exact PySINDy, best threshold | error | s here | s PySINDy, a fit |")
    print("| --- | --- | --- | --- | --- | --- | --- | --- | --- |")
    for name, make in fields.items():
        t, x, u, truth = make()
        for share in (0.0, 0.01, 0.05, 0.2, 0.5):
            rows = []
            for seed in range(seeds):
                noisy = with_noise(u, share, seed)
                found, doubted, spent = ours(command, t, x, noisy)
                other, other_spent = pysindy(t, x, noisy, truth)
                exact, error = judge(found, truth)
                rows.append((exact, not exact and not doubted, error, spent, *other, other_spent))
            exact, silent, error, spent, other, other_error, other_spent = zip(*rows)
            print(
                f"| {name} | {100 * share:g} % | {sum(exact)}/{seeds} | {sum(silent)} | {np.median(error):.1e} | {sum(other)}/{seeds} "
                f"| {np.median(other_error):.1e} | {np.median(spent):.2f} | {np.median(other_spent):.2f} |",
                flush=True,
            )


if __name__ == "__main__":
    main()
