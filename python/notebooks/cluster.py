# %% [markdown]
# # A cluster
#
# Workers of a cluster die. This page kills one in the middle of a campaign, and compares every byte with a campaign of one process.
#
# The cluster is a pool of two processes. An executor of Dask, Ray or Slurm [takes its place](../how-to/campaign.md#in-python-on-ray-dask-or-any-executor) without another change.

# %%
import hashlib
import multiprocessing
import os
import signal
import time
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path

import numpy as np
import touchdown as td
from matplotlib import pyplot as plt

sweep = {"trials": 150, "block": 10, "grid": {"control.controller": ["feedback", "dynamic+observer"]}, "scenario": {"deck": {"kind": "sea"}}}

pools = []

def pool():
    pools.append(ProcessPoolExecutor(2, mp_context=multiprocessing.get_context("spawn")))
    return pools[-1]

# %% [markdown]
# The unit of work is a block of landings. A worker gets a block's number and writes one Parquet file into a folder that all workers see.
#
# A pool of processes is broken when a worker is killed. So `campaign` gets a function that makes a pool, and not a pool.

# %%
said = []

def look(there, landings):
    said.append((time.monotonic(), there))
    if there >= 100 and len(pools) == 1:
        victim = next(iter(pools[0]._processes))
        os.kill(victim, signal.SIGKILL)

killed = td.dist.campaign(pool, sweep, "killed", progress=look)
print(killed, "by", len(pools), "pools")

# %% [markdown]
# The second pool flew what the first one had left. Blocks appear whole or not at all, so a half-written one is never read.

# %% figure="Landings that are there over time: a pause where the worker was killed and a second pool started, then all 300"
fig, ax = plt.subplots(figsize=(7.2, 2.8))
at, there = np.array(said).T
ax.step(at - at[0], there, where="post")
ax.axhline(100, color="C3", ls=":", label="a worker is killed")
ax.set(xlabel="time (s)", ylabel="landings that are there")
ax.legend();

# %% [markdown]
# ## The same bytes
#
# One process flies the campaign once more.

# %%
alone = td.campaign(sweep, "alone")

def bytes_of(folder):
    files = sorted(file for file in Path(folder, "landings").glob("*.parquet"))
    return {file.name: hashlib.sha256(file.read_bytes()).hexdigest() for file in files}

assert bytes_of("killed") == bytes_of("alone")
assert Path("killed/results.json").read_bytes() == Path("alone/results.json").read_bytes()
print(len(bytes_of("alone")), "blocks and results.json: the same bytes")

# %% [markdown]
# Each landing depends on the settings, the seed and its place in the list, and on nothing else. So no clock, worker or order of work can change it.

# %% figure="Share of the landings over the touchdown speed for the two controllers of the campaign"
killed.plot().set(xlabel="touchdown speed (m/s)", xlim=(0.0, 0.2));

# %% [markdown]
# ## Equations from many files
#
# `sindy.dist.fit` works in the same way on data. Each worker passes once over its files and sends back sums, some MB for any number of rows. They are added in the order
# of the files, so the model has the bits of one process too.

# %%
import sindy
from concurrent.futures import ThreadPoolExecutor

def pendulum(k):  # x' = v, v' = -2 x - 0.4 v, from 12 starts
    t = np.arange(0.0, 10.0, 0.01)
    w = np.sqrt(2.0 - 0.04)
    x = np.exp(-0.2 * t) * np.cos(w * t + k)
    v = np.exp(-0.2 * t) * (-0.2 * np.cos(w * t + k) - w * np.sin(w * t + k))
    return np.column_stack([x, v]) + 1e-3 * np.random.default_rng(k).normal(size=(t.size, 2))

for k in range(12):
    np.save(f"run{k:02}.npy", pendulum(k))
files = sorted(str(file) for file in Path.cwd().glob("run*.npy"))
model = sindy.SINDy("poly(3)", states=["x", "v"])

with pool() as processes, ThreadPoolExecutor(1) as one:
    many = sindy.dist.fit(processes, files, model, t=0.01)
    single = sindy.dist.fit(one, files, model, t=0.01)
assert many.to_json() == single.to_json()
many

# %% [markdown]
# More: [Run a campaign on many machines](../how-to/campaign.md), [Identify from many files, on many machines](../how-to/many-files.md).
