"""Noise on the trajectories, and the files that both programs read: the very same arrays."""

import json
import zlib
from pathlib import Path

import numpy as np

SEEDS = range(5)  # those of the bars


def amplitude(system, run, level):
    """Standard deviation of the noise of `level` percent on each state of a run, shape (states,).

    Rule "std": percent of each state's standard deviation over all runs. Rule "rms": percent of the root mean
    square of the run over its states, one amplitude for all of them.
    """
    if system.noise_rule == "std":
        scale = np.std(np.vstack([r.x for r in system.runs]), axis=0)
    else:
        scale = np.full(len(system.states), np.sqrt(np.mean(run.x**2)))
    return 0.01 * level * scale


def noisy(system, level, seed):
    """The runs with normally distributed, independent noise of `level` percent on the states: (t, x, u) each."""
    # One stream per system and seed: the noise of two levels differs in its amplitude only.
    rng = np.random.default_rng([seed, zlib.crc32(system.name.encode())])
    return [
        (run.t, run.x + amplitude(system, run, level) * rng.standard_normal(run.x.shape), run.u)
        for run in system.runs
    ]


def case_folder(root, system, level, seed):
    return Path(root) / system.name / f"{level:g}" / str(seed)


def write_runs(folder, system, runs):
    """`traj0.csv`, `traj1.csv`, ... with header `t,states,inputs` and 17 significant digits."""
    folder.mkdir(parents=True, exist_ok=True)
    header = ",".join(["t", *system.states, *system.inputs])
    files = []
    for i, (t, x, u) in enumerate(runs):
        files.append(folder / f"traj{i}.csv")
        np.savetxt(files[-1], np.column_stack([t, x, u]), "%.17g", ",", header=header, comments="")
    return files


def write_truth(root, system):
    folder = Path(root) / system.name
    folder.mkdir(parents=True, exist_ok=True)
    truth = {
        "states": system.states,
        "inputs": system.inputs,
        "library": system.library,
        "equations": system.equations,
        "noise_rule": system.noise_rule,
        "noise_percent": system.levels,
    }
    (folder / "truth.json").write_text(json.dumps(truth, indent=2) + "\n")


def write_system(root, system, seeds=SEEDS):
    """All noise levels and seeds of a system, its truth, and its runs without noise in `clean/`."""
    write_truth(root, system)
    write_runs(Path(root) / system.name / "clean", system, [(r.t, r.x, r.u) for r in system.runs])
    for level in system.levels:
        for seed in seeds:
            write_runs(case_folder(root, system, level, seed), system, noisy(system, level, seed))
