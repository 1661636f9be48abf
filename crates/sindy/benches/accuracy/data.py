"""Noise on the trajectories, and the files that both programs read: the very same arrays."""

import json
import zlib
from pathlib import Path

import numpy as np

SEEDS = range(5)


def noisy(system, level, seed):
    """The runs with noise of `level` percent: a list of (t, x, u).

    Normally distributed, independent, on the states only. Rule "std": percent of each state's standard
    deviation over all runs. Rule "rms": percent of the root mean square of each run over its states, one
    amplitude for all states of a run.
    """
    # One stream per system and seed: the noise of two levels differs in its amplitude only.
    rng = np.random.default_rng([seed, zlib.crc32(system.name.encode())])
    pooled = np.std(np.vstack([run.x for run in system.runs]), axis=0)
    out = []
    for run in system.runs:
        scale = pooled if system.noise_rule == "std" else np.sqrt(np.mean(run.x**2))
        out.append((run.t, run.x + 0.01 * level * scale * rng.standard_normal(run.x.shape), run.u))
    return out


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


def write_system(root, system):
    """All noise levels and seeds of a system, its truth, and its runs without noise in `clean/`."""
    write_truth(root, system)
    write_runs(Path(root) / system.name / "clean", system, [(r.t, r.x, r.u) for r in system.runs])
    for level in system.levels:
        for seed in SEEDS:
            write_runs(case_folder(root, system, level, seed), system, noisy(system, level, seed))
