"""Runs both sides, each case in processes of its own, compares what they found, and prints the table.

Called by run.sh. The exit status is 1 if the two sides found different models where PySINDy converged, else 0, whether
or not the bars are met.
"""

import argparse
import json
import os
import subprocess
import sys
from pathlib import Path

import numpy as np

HERE = Path(__file__).parent

# Case, text, how many times faster at least, most extra memory in MB, and how both sides are run: processes and
# repeats in each.
CASES = [
    ("lorenz_stlsq", "Lorenz, degree 5, 10^6, STLSQ", 40, 64, (2, 1), (3, 5)),
    ("lorenz_sr3", "Lorenz, degree 5, 10^6, SR3", 25, 64, (2, 1), (3, 5)),
    ("ground_small", "11 terms, 15 000, SR3", 100, None, (3, 7), (3, 50)),
    ("ground_large", "11 terms, 10^7, SR3", 60, 64, (2, 1), (3, 5)),
    ("grid", "20 lambda x 10 nu, 5 folds, 15 000", 2000, None, (1, 1), (3, 20)),
    ("bagging", "bagging of 100, Lorenz, degree 5, 10^5", 50, None, (1, 1), (3, 3)),
    ("simulate", "simulate 30 s at 100 Hz, Lorenz, degree 5", 5000, None, (1, 1), (3, 20)),
    ("smooth", "Savitzky-Golay and derivative, 3 x 10^6", 3, None, (3, 3), (3, 5)),
    ("product", "library and Gram, 10^6, against dsyrk on a stored library", 1, None, (2, 5), (3, 5)),
]


def run(command, processes):
    """The process with the fewest CPU seconds."""
    results = []
    for _ in range(processes):
        done = subprocess.run(command, stdout=subprocess.PIPE, check=True)
        results.append(json.loads(done.stdout))
    best = min(results, key=lambda r: r["seconds"])
    best["extra_mb"] = min(r["extra_mb"] for r in results)
    return best


def agreement(case, theirs, ours):
    """Whether the two sides found the same, in words."""
    if "coefficients" in theirs:
        a, b = np.array(theirs["coefficients"]), np.array(ours["coefficients"])
        terms = f"{np.count_nonzero(a)} and {np.count_nonzero(b)} terms"
        if ((a != 0) == (b != 0)).all():
            return f"same support ({terms}), coefficients within {abs(a - b).max():.0e}"
        if not theirs["converged"]:
            return f"{terms}; PySINDy did not converge, and warns of it"
        return f"DIFFERENT SUPPORTS: {terms}"
    if case == "grid":
        pairs = [(a, b) for (a, good), b in zip(theirs["table"], ours["table"]) if good]
        same = sum(abs(a - b) <= 1e-6 * a + 1e-9 for a, b in pairs)
        return f"same held-out error at {same} of the {len(pairs)} points where PySINDy converged, of 200"
    if case == "simulate":
        gap = abs(np.array(theirs["states"]) - np.array(ours["states"])).max(axis=1)
        return f"states within {gap[:11].max():.0e} up to 10 s, {gap[:21].max():.0e} up to 20 s"
    if case == "smooth":
        errors = [r["slope_rms_error"] for r in (theirs, ours)]
        return "error of the slope {:.2f} and {:.2f} rms".format(*errors)
    return ""


def main():
    arguments = argparse.ArgumentParser(description=__doc__)
    arguments.add_argument("--ours", required=True, help="our side's program")
    arguments.add_argument("--data", required=True, help="folder of the data")
    arguments.add_argument("--only", help="cases, separated by commas")
    arguments.add_argument("--runs", type=int, default=1, help="times the processes of each case")
    arguments = arguments.parse_args()
    only = arguments.only.split(",") if arguments.only else None
    rows, notes = [], []
    for case, text, bar, memory, (their_runs, their_repeats), (our_runs, our_repeats) in CASES:
        if only and case not in only:
            continue
        print(f"{case} ...", file=sys.stderr, flush=True)
        python = [sys.executable, HERE / "measure.py", case, arguments.data, str(their_repeats)]
        theirs = run(python, their_runs * arguments.runs)
        ours = run([arguments.ours, case, arguments.data, str(our_repeats)], our_runs * arguments.runs)
        ratio = theirs["seconds"] / ours["seconds"]
        met = ratio >= bar and (memory is None or ours["extra_mb"] <= memory)
        rows.append(
            (
                text,
                f"{theirs['seconds']:.4g}",
                f"{ours['seconds']:.4g}",
                f"{ratio:,.1f}" if ratio < 10 else f"{ratio:,.0f}",
                f"{bar}" + (f", {memory} MB" if memory else ""),
                f"{theirs['extra_mb']:.0f}",
                f"{ours['extra_mb']:.1f}",
                "met" if met else "NOT MET",
            )
        )
        if found := agreement(case, theirs, ours):
            notes.append(f"{text}: {found}")
    if not only or "threads" in only:
        print("threads ...", file=sys.stderr, flush=True)
        free = {k: v for k, v in os.environ.items() if k != "RAYON_NUM_THREADS"}
        command = [arguments.ours, "threads", arguments.data, str(15 * arguments.runs)]
        found = json.loads(subprocess.run(command, stdout=subprocess.PIPE, check=True, env=free).stdout)
        one, two = found["seconds"]
        met = one / two >= 1.7 and found["identical"]
        rows.append(
            (
                "Lorenz, 10^6, STLSQ, ours: 1 thread, 2 threads (wall time)",
                f"{one:.4g}",
                f"{two:.4g}",
                f"{one / two:.2f}",
                "1.7, identical",
                "",
                "",
                "met" if met else "NOT MET",
            )
        )
        one, two = found["busiest"]
        notes.append(
            f"threads: results {'identical' if found['identical'] else 'DIFFERENT'}; CPU time of the busiest thread "
            f"{one:.4g} s and {two:.4g} s, ratio {one / two:.2f} (what two idle cores would show, but for waiting)"
        )
    head = ("case", "PySINDy, s", "ours, s", "ratio", "bar", "PySINDy, extra MB", "ours", "")
    widths = [max(len(row[k]) for row in [head, *rows]) for k in range(len(head))]
    for row in [head, tuple("-" * w for w in widths), *rows]:
        print("| " + " | ".join(cell.ljust(w) for cell, w in zip(row, widths)) + " |")
    print()
    for note in notes:
        print(note)
    sys.exit(any("DIFFERENT" in note for note in notes))


if __name__ == "__main__":
    main()
