"""The accuracy table: PySINDy's best setting, found with the truth, beside `sindy fit`'s automatic choice.

Makes the data, gives both programs the very same arrays, prints the table and says which bars are met. Exit
status 0 either way; see README.md.
"""

import argparse
import hashlib
import json
import os
import sys
import time
from concurrent.futures import ProcessPoolExecutor, as_completed
from functools import lru_cache
from pathlib import Path

# One thread for each program; before NumPy is imported.
for variable in ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ[variable] = "1"

import numpy as np

import bars
import data
import limit
import ours
import pysindy_best
import systems
from score import Score


@lru_cache(maxsize=4)
def system_of(name):
    return systems.catalogue()[name]()


@lru_cache(maxsize=4)
def limits_of(name, seeds):
    return limit.limits(system_of(name), seeds)


def pysindy_key(system, seeds_runs, options):
    """A digest of all that decides PySINDy's result."""
    digest = hashlib.sha256(repr(pysindy_best.grid(options.quick, seeds_runs[0])).encode())
    digest.update(f"{system.library} {system.equations}".encode())
    for run in (run for runs in seeds_runs for run in runs):
        for part in run:
            digest.update(np.ascontiguousarray(part).tobytes())
    return digest.hexdigest()


def pysindy_result(system, level, seeds_runs, options):
    """PySINDy's best, from an earlier run if arrays, grid and version are the same."""
    key = pysindy_key(system, seeds_runs, options)
    quick = "-quick" if options.quick else f"-{options.seeds}"
    file = Path(options.work) / "pysindy" / f"{system.name}-{level:g}{quick}.json"
    if file.exists() and not options.fresh:
        kept = json.loads(file.read_text())
        if kept["key"] == key:
            return kept
    result = pysindy_best.best_fit(system, seeds_runs, Score(system), options.quick) | {"key": key}
    file.parent.mkdir(parents=True, exist_ok=True)
    scratch = file.with_suffix(f".{os.getpid()}")
    scratch.write_text(json.dumps(result, indent=1) + "\n")
    scratch.replace(file)
    return result


def run_case(name, level, options):
    """One system at one noise level, all seeds."""
    system = system_of(name)
    seeds = range(2 if options.quick else options.seeds)
    seeds_runs = [data.noisy(system, level, seed) for seed in seeds]
    case = {"system": name, "level": level, "pysindy": None, "ours": None, "limit": None}
    if options.limit:
        case["limit"] = [level * error for error in limits_of(name, seeds)]
    if "pysindy" in options.programs:
        case["pysindy"] = pysindy_result(system, level, seeds_runs, options)
    if "ours" in options.programs:
        root = Path(options.work) / "data"
        data.write_truth(root, system)
        case["ours"] = []
        for seed, runs in zip(seeds, seeds_runs):
            folder = data.case_folder(root, system, level, seed)
            files = data.write_runs(folder, system, runs)
            case["ours"].append(
                ours.run(options.sindy, system, files, folder / "terms.txt", Score(system), options.timeout)
            )
    return case


def our_median(case):
    return float(np.median([r["error"] for r in case["ours"]]))


def our_exact(case):
    return sum(r["exact"] for r in case["ours"])


def number(value):
    return "no model" if not np.isfinite(value) else f"{value:.1e}"


def setting_text(setting):
    if setting["form"] == "weak":
        text = f"weak, half-width {setting['half_width']}, p {setting['degree']}"
    elif setting["window"] == 1:
        text = "strong, no smoothing"
    else:
        text = f"strong, window {setting['window']}, order {setting['order']}"
    return f"{text}, threshold {setting['threshold']:g} of the smallest"


def bar_of(case):
    """(bar on the median, whether every support must be exact); None where there is no bar."""
    name = case["system"]
    if name in bars.FIXED:
        return bars.FIXED[name][case["level"]]
    if name == "ground_effect" and case["pysindy"]:
        return bars.GROUND_EFFECT_RATIO * case["pysindy"]["medians"]["weak"], False
    return None


def row_of(case):
    row = [case["system"], f"{case['level']:g} %"]
    row.append("-" if case["limit"] is None else number(np.median(case["limit"])))
    if (best := case["pysindy"]) is not None:
        row += [
            number(np.median(best["errors"])),
            f"{sum(best['exact'])}/{len(best['exact'])}",
            setting_text(best["setting"]),
        ]
    else:
        row += ["-", "-", "-"]
    bar = bar_of(case)
    row.append("-" if bar is None else number(bar[0]) + (", exact" if bar[1] else ""))
    if case["ours"] is None:
        return [*row, "-", "-", "-", "-"]
    runs = case["ours"]
    row += [
        number(our_median(case)),
        f"{our_exact(case)}/{len(runs)}",
        f"{np.median([r['cpu_s'] for r in runs]):.2f}",
    ]
    if bar is None:
        return [*row, "-"]
    met = our_median(case) <= bar[0] and (not bar[1] or our_exact(case) == len(runs))
    return [*row, "met" if met else "NOT MET"]


def aggregate_rows(cases):
    """The `dysts_` systems together, and the held-out ones for comparison: medians over systems and seeds."""
    rows = []
    for prefix, label in (("dysts_", "dysts, together"), ("heldout_", "held out, together")):
        for level in sorted({c["level"] for c in cases if c["system"].startswith(prefix)}):
            chosen = [c for c in cases if c["system"].startswith(prefix) and c["level"] == level]
            row = [f"{label} ({len(chosen)})", f"{level:g} %"]
            of_limit = [e for c in chosen for e in c["limit"] or []]
            row.append(number(np.median(of_limit)) if of_limit else "-")
            if chosen[0]["pysindy"]:
                exact = [x for c in chosen for x in c["pysindy"]["exact"]]
                row += [
                    number(np.median([e for c in chosen for e in c["pysindy"]["errors"]])),
                    f"{100 * np.mean(exact):.0f} %",
                    "the best of each system",
                ]
            else:
                row += ["-", "-", "-"]
            bar = bars.DYSTS.get(level) if prefix == "dysts_" else None
            row.append("-" if bar is None else f"{number(bar[0])}, {bar[1]:g} % exact")
            if chosen[0]["ours"] is None:
                rows.append([*row, "-", "-", "-", "-"])
                continue
            runs = [r for c in chosen for r in c["ours"]]
            median = np.median([r["error"] for r in runs])
            exact = 100 * np.mean([r["exact"] for r in runs])
            row += [number(median), f"{exact:.0f} %", f"{np.median([r['cpu_s'] for r in runs]):.2f}"]
            if bar is None or len(chosen) != len(systems.DYSTS):
                rows.append([*row, "-"])
            else:
                rows.append([*row, "met" if median <= bar[0] and exact >= bar[1] else "NOT MET"])
    return rows


HEADER = [
    "system", "noise", "limit", "PySINDy", "exact", "its best setting, found with the truth",
    "bar", "ours", "exact", "CPU s", "met",
]  # fmt: skip


def print_table(rows):
    widths = [max(len(r[i]) for r in [HEADER, *rows]) for i in range(len(HEADER))]
    for row in [HEADER, ["-" * w for w in widths], *rows]:
        print("| " + " | ".join(cell.ljust(w) for cell, w in zip(row, widths)) + " |")


def chosen_systems(only):
    names = list(systems.catalogue())
    if only is None:
        return names
    wanted = only.split(",")
    chosen = [n for n in names if any(n == w or n.startswith(w + "_") for w in wanted)]
    unknown = [w for w in wanted if not any(n == w or n.startswith(w + "_") for n in names)]
    if unknown:
        sys.exit(f"--only: unknown {', '.join(unknown)}; known: dysts, heldout, {', '.join(names)}")
    return chosen


def arguments():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--only", help="systems or groups, comma-separated: lorenz,dysts,heldout")
    parser.add_argument("--quick", action="store_true", help="2 seeds and 2 settings: a trial of the script")
    parser.add_argument("--seeds", type=int, default=len(data.SEEDS), help="seeds 0, 1, ... (bars: 5)")
    parser.add_argument("--limit", action="store_true", help="also what maximum likelihood would reach")
    parser.add_argument("--programs", default="pysindy,ours", help="which to run (default both)")
    parser.add_argument("--sindy", default="sindy", help="the binary of crates/sindy-cli")
    parser.add_argument("--work", default="target/accuracy", help="folder of data and PySINDy's results")
    parser.add_argument("--fresh", action="store_true", help="fit PySINDy again though its results are kept")
    parser.add_argument("--jobs", type=int, default=1, help="cases at the same time")
    parser.add_argument("--timeout", type=float, default=600.0, help="seconds for one call of sindy")
    parser.add_argument("--json", help="file for all results")
    options = parser.parse_args()
    options.programs = options.programs.split(",")
    if unknown := set(options.programs) - {"pysindy", "ours"}:
        parser.error(f"--programs: expected pysindy, ours or both, found {', '.join(sorted(unknown))}")
    return options


def main():
    options = arguments()
    order = [
        (name, level)
        for name in chosen_systems(options.only)
        for level in (systems.RMS_LEVELS if is_rms(name) else systems.STD_LEVELS)
    ]
    start, cases = time.monotonic(), {}
    with ProcessPoolExecutor(max_workers=options.jobs) as pool:
        futures = {pool.submit(run_case, *key, options): key for key in order}
        for done in as_completed(futures):
            case = cases[futures[done]] = done.result()
            row = row_of(case)
            print(
                f"[{len(cases)}/{len(order)}, {time.monotonic() - start:.0f} s] {row[0]} {row[1]}: "
                f"PySINDy {row[3]}, ours {row[7]} {row[10]}",
                file=sys.stderr, flush=True,
            )  # fmt: skip
    ordered = [cases[key] for key in order]
    print_table([row_of(c) for c in ordered] + aggregate_rows(ordered))
    if options.quick:
        print("\n--quick: 2 seeds and a grid of two settings; the bars hold for the full run only.")
    for case in ordered:
        for seed, result in enumerate(case["ours"] or []):
            if not np.isfinite(result["error"]):
                print(f"{case['system']} {case['level']:g} %, seed {seed}: {result['note']}")
    if options.json:
        Path(options.json).write_text(json.dumps(ordered, indent=1) + "\n")


def is_rms(name):
    return name.startswith("dysts_") or name in {f"heldout_{n.lower()}" for n in systems.DYSTS_HELD_OUT}


if __name__ == "__main__":
    main()
