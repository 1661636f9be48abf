# %% [markdown]
# # Your thrust log
#
# From a log of throttle and thrust to a model card. The log can be of a thrust stand, with columns `time_s`, `throttle` and `thrust_n`;
# other names need a [map](../how-to/map.md). Here the virtual rig writes the log, with a load cell's noise, latency and resolution.

# %% language="sh"
# touchdown rig --out rig

# %%
from pathlib import Path
from matplotlib import pyplot as plt
import numpy as np
import touchdown as td

trials = td.read(sorted(Path("rig/thrust_training").glob("*.csv")))
print(len(trials), "logs;", trials[0])

# %% figure="Throttle and thrust of one log over time: a ramp of the throttle, and the noisy thrust that follows it"
fig, (top, bottom) = plt.subplots(2, sharex=True)
top.plot(trials[0]["time_s"], trials[0]["throttle"])
bottom.plot(trials[0]["time_s"], trials[0]["thrust_n"], linewidth=0.6)
top.set(ylabel="throttle", title=trials[0].name)
bottom.set(ylabel="thrust (N)", xlabel="time (s)");

# %% [markdown]
# ## A card
#
# One model is fitted to all logs together. A card shows itself as a table: terms, values, standard errors, units.

# %%
card = td.identify.thrust(trials)
card

# %% [markdown]
# The same as equations. `s` is the throttle, `x` the square root of the thrust `T`: motors need time to follow.

# %%
from IPython.display import Latex

Latex(f"$${card.to_latex(3)}$$")

# %% [markdown]
# ## A simpler model
#
# Eq. (7) of the paper is a motor lag over a straight line. Is that enough?

# %%
simple = td.identify.thrust(trials, {"thrust": {"form": "first_order"}})
simple

# %% [markdown]
# Logs that neither model has seen decide. Each model runs free: it starts from the first sample and never sees the measured thrust again.

# %%
unseen = td.read(sorted(Path("rig/thrust_validation").glob("*.csv")))
for model in (card, simple):
    for run in td.validate(model, unseen):
        print(f"{model.form:12} {run.trial:10} RMSE {run.measured['rmse']:.3f} N, worst {run.measured['worst']:.2f} N")

# %% figure="Measured and predicted thrust on an unseen log: the library form lies on the measurement, the first-order form misses it"
fig, axes = plt.subplots(2, sharex=True, figsize=(7.2, 5.0))
for ax, model in zip(axes, (card, simple)):
    td.validate(model, unseen[0])[0].plot(ax)
    ax.set_title(model.form)

# %% [markdown]
# The noise of this load cell is 0.03 N, so the first model is near the floor. The straight line is not: the battery of this vehicle sags under load.
#
# ## Use it
#
# The card knows the range of its data, and keeps the hash of every log. It is a TOML file that `touchdown land` and the landing computer read.

# %%
card.save("thrust.toml")
again = td.Card.load("thrust.toml")
throttle = np.array([0.3, 0.5, 0.7])
print(again.thrust_at_rest(throttle).round(2), "N at throttles", throttle)

# %% [markdown]
# More: [Thrust stand: from a log to a card](../tutorials/thrust-stand.md), [Thrust](../theory/thrust.md).
