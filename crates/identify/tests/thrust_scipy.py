#!/usr/bin/env python3
"""Compares thrust models of `touchdown identify` with independent fits of the same forms by SciPy, on measured logs.

    python3 thrust_scipy.py TOUCHDOWN DATA [--table]

Each log is cut into a part that is fitted and a part that is predicted. Tables of steady levels: every other row. Records over
time: the first six tenths, then the rest. Both fits see the same rows and predict the same rows, in free run from the first
measured thrust. The second judgement is of the form that `touchdown` chooses without being asked: SciPy fits every form to
the log without a level and predicts that level, for each level; the error of the chosen form is compared with the least.

Prints a row for each log and form, and the greatest ratios. Ends with status 1 if a ratio exceeds 1.05.
"""

import csv
import json
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np
from scipy.optimize import least_squares

GRAM = 9.80665e-3
BAR = 1.05
# Errors below this share of the greatest thrust are equal: load cells resolve a thousandth of their range at best.
FINEST = 1e-3


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
    edges = t + dead_s
    times = np.concatenate([t, edges])
    order = np.argsort(times, kind="stable")
    y, now, level = np.empty(len(t)), u[0], u[0]
    last = t[0]
    for k in order:
        dt = times[k] - last
        now = level + (now - level) * np.exp(-dt / lag_s)
        last = times[k]
        if k < len(t):
            y[k] = now
        else:
            level = u[k - len(t)]
    return y


def static(p, s, u, root):
    x = p[0] + p[1] * s + p[2] * s**2 + (p[3] * s * u if len(p) > 3 else 0.0)
    return x * np.abs(x) if root else x


class Form:
    """A form by its name: `predict(p, t, motors, volts, first thrust)`, and a start of the search."""

    def __init__(self, name, battery):
        self.name, self.battery = name, battery
        self.lagged = name in ("first_order", "lagged_motors")

    def start(self, s, thrust):
        top = max(np.nanmax(thrust), 1e-3)
        if self.name == "first_order":
            return np.array([0.0, np.sqrt(top), np.log(0.05)])
        if self.name == "lagged_motors":
            return np.array([0.0, 0.1, 0.1, np.log(0.05)]) * top
        scale = np.sqrt(top) if self.name == "static_sqrt" else top
        return np.array([0.0, scale, 0.0] + [0.0] * self.battery)

    def predict(self, p, t, motors, volts, first, dead_s=0.0):
        s = motors.mean(axis=1)
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
        return least_squares(residual, start, method="lm" if rows.sum() >= len(start) else "trf", max_nfev=400).x


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
        # SciPy's fits have no dead time; both have the same parameters.
        self.settings.write_text('[thrust]\ndead_time = "none"\n')

    def call(self, *args):
        done = subprocess.run([self.program, *map(str, args)], capture_output=True, text=True, check=False)
        return json.loads(done.stdout) if done.returncode in (0, 3) and done.stdout else None, done.stderr

    def fit(self, log, form=None, battery=False):
        """The card's path and the object of identify; None and the reason where it refuses."""
        card = self.folder / "card.toml"
        card.unlink(missing_ok=True)
        args = ["identify", "thrust", log, "--quiet", "--json", "--rotors", "1", "--out", card]
        if form:
            args += ["--form", form, "--settings", self.settings]
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
    names = ["first_order"] + (["lagged_motors"] if timed else []) if timed else ["static_sqrt", "static_thrust"]
    return [Form(n, b) for n in names for b in ([False, True] if battery and not timed else [False])]


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
    worst = {}
    print(f"{'log':22} {'form':26} {'SciPy N':>9} {'ours N':>9} {'ratio':>6}")
    with tempfile.TemporaryDirectory() as folder:
        touchdown = Touchdown(program, folder)
        seen_log, unseen_log, whole_log = (Path(folder) / f"{n}.csv" for n in ("seen", "unseen", "whole"))
        for name, t, motors, thrust, volts, timed in logs(data):
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
            for form in forms(timed, volts is not None):
                label = form.name + (" with battery" if form.battery else "")
                p = form.fit(t[a], motors[a], thrust[a], u(a))
                theirs = rmse(form.predict(p, t[b], motors[b], u(b), mean_at_start(t[b], thrust[b])), thrust[b])
                card, found = touchdown.fit(seen_log, form.name, form.battery)
                if card is None:
                    print(f"{name:22} {label:26} {theirs:9.5f} {'–':>9} refused: {found[:90]}")
                    continue
                ours = touchdown.rmse(card, unseen_log)
                ratio = max(ours, finest) / max(theirs, finest)
                worst.setdefault("same form", []).append((ratio, f"{name} {label}"))
                print(f"{name:22} {label:26} {theirs:9.5f} {ours:9.5f} {ratio:6.3f}")
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
