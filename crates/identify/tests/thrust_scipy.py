#!/usr/bin/env python3
"""Compares thrust models of `touchdown identify` with independent fits of the same forms by SciPy, on measured logs.

    python3 thrust_scipy.py TOUCHDOWN DATA [LOG]

Each log is cut into a part that is fitted and a part that is predicted. Tables of steady levels: every other row. Records over
time: the first six tenths, then the rest. Both fits see the same rows and predict the same rows, in free run from the first
measured thrust. Records over time are compared without and with a free dead time. For eq. (8), SciPy finds the coefficients of the
terms that `touchdown` has chosen, from a start of its own. The second judgement is of the form that `touchdown` chooses without being asked: SciPy fits every form to
the log without a level and predicts that level, for each level; the error of the chosen form is compared with the least.

Prints a row for each log and form, and the greatest ratios. Ends with status 1 if a ratio exceeds 1.05.
"""

import csv
import json
import subprocess
import sys
import tempfile
import tomllib
from pathlib import Path

import numpy as np
from scipy.optimize import least_squares

GRAM = 9.80665e-3
BAR = 1.05
# Errors below this share of the greatest thrust are equal: load cells resolve a thousandth of their range at best.
FINEST = 1e-3
# Dead times that searches start from (s): a search from one falls short where commands are steps.
DEAD_S = [0.0, 0.01, 0.03]


# ---- logs ---------------------------------------------------------------------------------------


def columns(path):
    with open(path, encoding="utf-8-sig") as file:
        rows = list(csv.DictReader(file))
    def of(name):
        return np.array([float(r[name]) if r[name] not in ("", None) else np.nan for r in rows])
    return of


def logs(data):
    """Name, time, throttles (rows by motors), thrust, battery voltage or None, whether it is a record over time."""
    for path in sorted((data / "thrust-5in-props-static").glob("*.csv")):
        of = columns(path)
        s = (of("ESC signal (µs)") - 1000) / 1000
        yield path.stem, of("Time (s)"), s[:, None], GRAM * of("Thrust (gf)"), of("Voltage (V)"), False
    path = data / "thrust-crazyflie21-scale"
    for path in sorted(path.glob("*.csv")):
        of = columns(path)
        t = np.arange(len(of("pwm")), dtype=float)
        yield path.stem, t, (of("pwm") / 65535)[:, None], GRAM * of("weight[g]"), of("vbat[V]"), False
    path = data / "thrust-7in-rcbenchmark-staircase" / "Log_2019-11-09_181347.csv"
    of = columns(path)
    t, s = of("Time (s)"), (of("ESC signal (µs)") - 1000) / 1000
    keep = np.concatenate([[True], t[1:] > np.maximum.accumulate(t)[:-1]]) & np.isfinite(s)
    yield "7in", t[keep], s[keep, None], GRAM * of("Thrust (gf)")[keep], None, True
    for name, low, high in (("log10", 9.0, 42.2), ("log15", 12.0, 53.0)):
        of = columns(data / "flight-crazyflie-1khz-throttle" / f"{name}.csv")
        t = of("t_s")
        keep = (t >= low) & (t <= high)
        motors = np.stack([of(f"m{k}")[keep] / 65535 for k in (1, 2, 3, 4)], axis=1)
        yield name, t[keep], motors, 0.027 * 9.80665 * of("acc_z_g")[keep], None, True


# ---- the forms, in free run ------------------------------------------------------------------------


def lag(t, u, lag_s, dead_s):
    """u, held between samples, behind a dead time and a first-order lag, from its own first value."""
    times = np.concatenate([t, t + dead_s])
    order = np.argsort(times, kind="stable")
    decay = np.exp(-np.diff(times[order], prepend=t[0]) / lag_s).tolist()
    y, levels = [0.0] * len(t), u.tolist()
    now = level = levels[0]
    for k, keep in zip(order.tolist(), decay):
        now = level + (now - level) * keep
        if k < len(t):
            y[k] = now
        else:
            level = levels[k - len(t)]
    return np.array(y)


def static(p, s, u, root):
    x = p[0] + p[1] * s + p[2] * s**2 + (p[3] * s * u if len(p) > 3 else 0.0)
    return x * np.abs(x) if root else x


class Form:
    """A form by its name: `predict(p, t, motors, volts, first thrust)`, and a start of the search. The last parameter is the dead
    time where it is free."""

    def __init__(self, name, battery, dead=False):
        self.name, self.battery, self.dead = name, battery, dead
        self.lagged = name in ("first_order", "lagged_motors")

    def start(self, s, thrust):
        top = max(np.nanmax(thrust), 1e-3)
        if self.name == "first_order":
            return np.array([0.0, np.sqrt(top), np.log(0.05)])
        if self.name == "lagged_motors":
            return np.array([0.0, 0.1, 0.1, np.log(0.05)]) * top
        scale = np.sqrt(top) if self.name == "static_sqrt" else top
        return np.array([0.0, scale, 0.0] + [0.0] * self.battery)

    def predict(self, p, t, motors, volts, first):
        s = motors.mean(axis=1)
        p, dead_s = (p[:-1], max(p[-1], 0.0)) if self.dead else (p, 0.0)
        if self.name in ("static_sqrt", "static_thrust"):
            return static(p, s, volts, self.name == "static_sqrt")
        lag_s = np.exp(p[-1])
        if self.name == "first_order":
            target = p[0] + p[1] * s
            x = lag(t, target, lag_s, dead_s)
            x = x + (np.sqrt(max(first, 0.0)) - target[0]) * np.exp(-(t - t[0]) / lag_s)
            return x * np.abs(x)
        total = 0.0
        for k in range(motors.shape[1]):
            u = lag(t, motors[:, k], lag_s, dead_s)
            total = total + p[0] + p[1] * u + p[2] * u**2
        return total

    def root(self, p, motors, volts):
        return static(p, motors.mean(axis=1), volts, False)

    def fit(self, t, motors, thrust, volts):
        rows = np.isfinite(thrust)
        first = mean_at_start(t, thrust)

        def residual(p):
            if self.name == "static_sqrt":
                # The form is one of √T, and its residuals are those of √T.
                return self.root(p, motors, volts)[rows] - np.sqrt(np.maximum(thrust, 0.0))[rows]
            return (self.predict(p, t, motors, volts, first) - thrust)[rows]

        start = self.start(motors.mean(axis=1), thrust)
        starts = [np.append(start, d) for d in DEAD_S] if self.dead else [start]
        method = "lm" if rows.sum() >= len(starts[0]) else "trf"
        fits = [least_squares(residual, start, method=method, max_nfev=400) for start in starts]
        return min(fits, key=lambda fit: fit.cost).x


class Library:
    """Eq. (8), x' = Θ(x, s) ξ with T = x |x|, of given terms, by Runge and Kutta's method with the command held."""

    def __init__(self, terms):
        words = [compile(t.replace("^", "**"), t, "eval") for t in terms]
        names = {"exp": np.exp, "sin": np.sin, "cos": np.cos, "sqrt": np.sqrt}
        self.terms = lambda x, s: [np.broadcast_to(eval(w, {**names, "x": x, "s": s}), np.shape(x)) for w in words]

    def run(self, p, t, s, first):
        """x of every row, for one or many sets of coefficients (columns)."""
        p = np.atleast_2d(p.T).T
        x = np.full(p.shape[1], np.sqrt(max(first, 0.0)))
        out = np.empty((len(t), p.shape[1]))
        slope = lambda x, u: sum(c * term for c, term in zip(p, self.terms(np.clip(x, -9.0, 9.0), u)))
        out[0] = x
        for k in range(len(t) - 1):
            h, u = t[k + 1] - t[k], s[k]
            a = slope(x, u)
            b = slope(x + 0.5 * h * a, u)
            c = slope(x + 0.5 * h * b, u)
            x = np.clip(x + h / 6 * (a + 2 * b + 2 * c + slope(x + h * c, u)), -9.0, 9.0)
            out[k + 1] = x
        return out

    def predict(self, p, t, motors, volts, first):
        x = self.run(p, t, motors.mean(axis=1), first)[:, 0]
        return x * np.abs(x)

    def start(self, t, motors, thrust):
        """The terms that come nearest to the first-order lag that SciPy finds in the log."""
        lag = Form("first_order", False)
        c1, c0, log_lag = lag.fit(t, motors, thrust, None)
        s, x = motors.mean(axis=1), np.sqrt(np.maximum(thrust, 0.0))
        rows = np.isfinite(thrust)
        s, x = s[rows], x[rows]
        # Off the record's own states as well: on them alone the terms are collinear.
        s, x = np.tile(s, 3), np.concatenate([x, 0.9 * x, 1.1 * x])
        theta = np.stack(self.terms(x, s), axis=1)
        return np.linalg.lstsq(theta, (c1 + c0 * s - x) / np.exp(log_lag), rcond=1e-6)[0]

    def fit(self, t, motors, thrust, _):
        rows, s, first = np.isfinite(thrust), motors.mean(axis=1), mean_at_start(t, thrust)
        residual = lambda p: (self.predict(p, t, motors, None, first) - thrust)[rows]

        def slopes(p):
            steps = 1e-6 * np.maximum(np.abs(p), 1e-2)
            x = self.run(np.column_stack([p, p[:, None] + np.diag(steps)]), t, s, first)[rows]
            y = x * np.abs(x)
            return (y[:, 1:] - y[:, :1]) / steps

        start = self.start(t, motors, thrust)
        return least_squares(residual, start, jac=slopes, x_scale="jac", max_nfev=25).x


def mean_at_start(t, thrust):
    known = np.isfinite(thrust)
    near = known & (t <= t[0] + 0.1)
    return float(np.mean(thrust[near])) if near.any() else float(thrust[known][0])


def rmse(predicted, thrust):
    rows = np.isfinite(thrust)
    return float(np.sqrt(np.mean((predicted - thrust)[rows] ** 2)))


# ---- touchdown --------------------------------------------------------------------------------------


def write(path, t, motors, thrust, volts):
    names = ["time_s"] + (["throttle"] if motors.shape[1] == 1 else [f"throttle_{k + 1}" for k in range(4)])
    table = [t, *motors.T]
    if volts is not None:
        names.append("battery_v")
        table.append(volts)
    names.append("thrust_n")
    table.append(thrust)
    with open(path, "w", encoding="utf-8") as file:
        file.write(",".join(names) + "\n")
        for row in zip(*table):
            file.write(",".join("" if np.isnan(v) else repr(float(v)) for v in row) + "\n")


class Touchdown:
    def __init__(self, program, folder):
        self.program, self.folder = program, Path(folder)
        self.settings = self.folder / "settings.toml"
        # Both fits have the same parameters.
        self.settings.write_text('[thrust]\ndead_time = "none"\n')
        self.with_dead_time = self.folder / "dead.toml"
        self.with_dead_time.write_text('[thrust]\ndead_time = "estimate"\n')

    def call(self, *args):
        done = subprocess.run([self.program, *map(str, args)], capture_output=True, text=True, check=False)
        return json.loads(done.stdout) if done.returncode in (0, 3) and done.stdout else None, done.stderr

    def fit(self, log, form=None, battery=False, dead=False):
        """The card's path and the object of identify; None and the reason where it refuses."""
        card = self.folder / "card.toml"
        card.unlink(missing_ok=True)
        args = ["identify", "thrust", log, "--quiet", "--json", "--rotors", "1", "--out", card]
        if form:
            args += ["--form", form, "--settings", self.with_dead_time if dead else self.settings]
        if battery:
            args.append("--battery")
        found, reason = self.call(*args)
        return (card, found) if found and card.exists() else (None, reason.strip())

    def rmse(self, card, log):
        found, reason = self.call("validate", card, log, "--quiet", "--json")
        if not found:
            raise SystemExit(f"validate: {reason}")
        return found["results"][0]["measured"]["rmse"]


def parts(t, timed):
    """Rows that are fitted, and those that are predicted."""
    if timed:
        cut = int(0.6 * len(t))
        return np.arange(cut), np.arange(cut, len(t))
    return np.arange(0, len(t), 2), np.arange(1, len(t), 2)


def forms(timed, battery):
    if timed:
        return [Form(n, False, d) for n in ("first_order", "lagged_motors") for d in (False, True)]
    return [Form(n, b) for n in ("static_sqrt", "static_thrust") for b in ([False, True] if battery else [False])]


def compare(touchdown, name, form, rows, files, worst):
    """One form of one log: `rows` are those that are fitted and those that are predicted, as SciPy takes them."""
    seen, (t, motors, thrust, volts) = rows
    library = form == "library"
    label = "library" if library else form.name + (" with battery" if form.battery else "") + (" dead time" if form.dead else "")
    card, found = touchdown.fit(files[0], form if library else form.name, not library and form.battery, not library and form.dead)
    if card is None:
        print(f"{name:22} {label:26} {'–':>9} {'–':>9} refused: {found[:90]}")
        return
    ours = touchdown.rmse(card, files[1])
    if library:
        terms = [term["expression"] for term in tomllib.loads(card.read_text())["terms"] if term["of"] == "x'"]
        form = Library(terms)
    p = form.fit(*seen)
    theirs = rmse(form.predict(p, t, motors, volts, mean_at_start(t, thrust)), thrust)
    finest = FINEST * max(np.nanmax(seen[2]), np.nanmax(thrust))
    ratio = max(ours, finest) / max(theirs, finest)
    worst.setdefault("same form", []).append((ratio, f"{name} {label}"))
    print(f"{name:22} {label:26} {theirs:9.5f} {ours:9.5f} {ratio:6.3f}", flush=True)


def held_out(form, t, motors, thrust, volts):
    """Error of SciPy's fits on levels that they have not seen, each of up to twenty parts in turn."""
    places = np.arange(len(t)) * min(20, len(t)) // len(t)
    errors = []
    for part in range(places.max() + 1):
        seen = places != part
        u = volts[seen] if volts is not None else None
        p = form.fit(t[seen], motors[seen], thrust[seen], u)
        u = volts[~seen] if volts is not None else None
        errors.append(form.predict(p, t[~seen], motors[~seen], u, 0.0) - thrust[~seen])
    return float(np.sqrt(np.mean(np.concatenate(errors) ** 2)))


def main():
    program, data = sys.argv[1], Path(sys.argv[2])
    only = sys.argv[3] if len(sys.argv) > 3 else None
    worst = {}
    print(f"{'log':22} {'form':26} {'SciPy N':>9} {'ours N':>9} {'ratio':>6}")
    with tempfile.TemporaryDirectory() as folder:
        touchdown = Touchdown(program, folder)
        seen_log, unseen_log, whole_log = (Path(folder) / f"{n}.csv" for n in ("seen", "unseen", "whole"))
        for name, t, motors, thrust, volts, timed in logs(data):
            if only and name != only:
                continue
            # Levels at which a rotor stands are no steady thrust of it; a fit leaves them out.
            if not timed:
                keep = thrust >= 0.1 if np.nanmax(thrust) > 1.0 else thrust >= 0.01
                t, motors, thrust = t[keep], motors[keep], thrust[keep]
                volts = volts[keep] if volts is not None else None
            finest = FINEST * np.nanmax(thrust)
            a, b = parts(t, timed)
            u = lambda rows: volts[rows] if volts is not None else None
            write(seen_log, t[a], motors[a], thrust[a], u(a))
            write(unseen_log, t[b], motors[b], thrust[b], u(b))
            rows = [(t[k], motors[k], thrust[k], u(k)) for k in (a, b)]
            for form in forms(timed, volts is not None) + (["library"] if timed else []):
                compare(touchdown, name, form, rows, (seen_log, unseen_log), worst)
            if timed:
                continue
            write(whole_log, t, motors, thrust, volts)
            card, found = touchdown.fit(whole_log)
            if card is None:
                print(f"{name:22} chosen: refused: {found[:90]}")
                continue
            chosen = next(f for f in found["forms"] if f["chosen"])
            errors = {(f.name, f.battery): held_out(f, t, motors, thrust, volts) for f in forms(timed, True)}
            own = errors[(chosen["form"], chosen["battery"])]
            best, least = min(errors.items(), key=lambda e: e[1])
            ratio = max(own, finest) / max(least, finest)
            worst.setdefault("chosen form", []).append((ratio, f"{name} {chosen['form']} battery {chosen['battery']}"))
            mark = "" if ratio <= BAR else f"  best {best}"
            print(f"{name:22} {'chosen ' + chosen['form']:26} {least:9.5f} {own:9.5f} {ratio:6.3f}{mark}")
    failed = False
    for what, ratios in worst.items():
        ratios.sort(reverse=True)
        above = [r for r in ratios if r[0] > BAR]
        failed |= bool(above)
        print(f"{what}: {len(ratios)} comparisons, {len(above)} above {BAR}; greatest {ratios[0][0]:.3f} ({ratios[0][1]}), "
              f"median {np.median([r[0] for r in ratios]):.3f}")
    sys.exit(1 if failed else 0)


if __name__ == "__main__":
    main()
