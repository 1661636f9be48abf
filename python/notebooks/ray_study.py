# %% [markdown]
# # A hundred thousand landings on Ray
#
# When is a landing over a rough sea soft? One seed and a few landings do not say. This study flies 100 000 landings over seas of six heights with two controllers,
# on a local Ray cluster, and kills a worker with `SIGKILL` on the way.
#
# A cluster of many machines differs by one line: `ray.init(address="auto")` joins it. The folder has to be on a disk that all workers see.

# %%
import logging
import os
import shutil
import signal
import time
from pathlib import Path

import numpy as np
import ray
import touchdown as td
from matplotlib import pyplot as plt

LANDINGS = int(os.environ.get("LANDINGS", 100_000))  # fewer for a quick look
heights = [0.1, 0.2, 0.3, 0.4, 0.5, 0.6]
sweep = {
    "trials": LANDINGS // (2 * len(heights)),
    "block": 50,
    "grid": {"control.controller": ["observer", "dynamic+observer"], "deck.spectrum.significant_height_m": heights},
    "scenario": {"deck": {"kind": "sea"}},
}
ray.init(num_cpus=2, include_dashboard=False, log_to_driver=False, logging_level=logging.ERROR);

# %% [markdown]
# The campaign looks after every task. At a third of the landings, one of Ray's workers is killed: its task is lost in its middle, and Ray flies it again.
# The time below is that of a machine that was busy with other work.

# %%
killed = []
begun = time.monotonic()

def look(there, landings):
    if there < landings / 3 or killed:
        return
    busy = [int(stat.parent.name) for stat in Path("/proc").glob("[0-9]*/cmdline") if b"ray::_timed" in stat.read_bytes()]
    for pid in busy[:1]:
        os.kill(pid, signal.SIGKILL)
        killed.append((pid, there))

study = td.dist.campaign(td.dist.RayExecutor(num_cpus=1), sweep, "study", task_s=5.0, progress=look)
seconds = time.monotonic() - begun
print(f"{len(study['landing'])} landings, {int(study.landed.sum())} landed; killed in their middle: {len(killed)} worker")

# %%
print(f"{seconds / 60:.0f} minutes, {len(study['landing']) / seconds:.0f} landings a second on {int(ray.cluster_resources()['CPU'])} processors")

# %% [markdown]
# ## What it shows
#
# Rare events need many landings. The share that does not land, and the hardest touch of a hundred, have intervals here that a study of a thousand cannot give.

# %% figure="Touchdown speed over the height of the sea for the two controllers: median and the 99th percentile of the landings"
fig, ax = plt.subplots()
lost = {}
controllers, seas, speeds = np.asarray(study["control.controller"]), study["deck.spectrum.significant_height_m"], study["v_l_mps"]
for name, colour in [("observer", "C0"), ("dynamic+observer", "C1")]:
    rows = [(controllers == name) & (seas == height) for height in heights]
    for share, style in [(50, "-"), (99, "--")]:
        ax.plot(heights, [np.nanpercentile(speeds[row], share) for row in rows], style, color=colour, label=f"{name}, {share} %")
    lost[name] = [f"{(~study.landed[row]).sum()} of {row.sum()}" for row in rows]
ax.set(xlabel="significant height of the sea (m)", ylabel="touchdown speed (m/s)", ylim=(0.0, None))
ax.legend();

# %% [markdown]
# In the median both are equally soft. Of the hundredth hardest touch the observer alone was softer, which nobody sees in a hundred landings: a model that counts all lift at once takes away the brake that rising lift gives. The study was flown before descents counted rising lift late ([Calm seas](../theory/control.md#calm-seas)). Of 1000 landings since then in each of four of these seas, the hundredth hardest touches differ by no more than their intervals.

# %%
for name, counts in lost.items():
    print(f"{name:17}not landed: {', '.join(counts)}")

# %% [markdown]
# ## The same bytes
#
# A block does not depend on who flies it. Blocks around the kill, and others over the whole study, are taken out of a copy, and flown once more by this
# process alone.

# %%
at = killed[0][1] // sweep["block"]
last = LANDINGS // sweep["block"] - 1
blocks = sorted({*range(at, min(at + 10, last)), *np.linspace(0, last, 10).astype(int).tolist()})
files = [f"landings/block-{block:06}.parquet" for block in blocks]
shutil.copytree("study", "again")
for file in files:
    Path("again", file).unlink()
td.campaign(sweep, "again")
assert all(Path("again", file).read_bytes() == Path("study", file).read_bytes() for file in [*files, "results.json"])
print("results.json and", len(files), "blocks: the same bytes")
ray.shutdown()
