# %% [markdown]
# # A landing study
#
# Does a model of the ground effect make landings on a deck at sea softer? Some hundred landings answer, and intervals say how far the answer can be trusted.
#
# The controllers fly with and without two helps. `dynamic` feeds the model's ground effect forward. `observer` estimates every disturbance, without a model.

# %%
import numpy as np
from matplotlib import pyplot as plt
import touchdown as td

sweep = {
    "trials": 150,
    "grid": {"control.controller": ["feedback", "dynamic", "observer", "dynamic+observer"]},
    "random": {"ground_effect_strength": {"kind": "uniform", "min": 0.4, "max": 0.8}},
    "scenario": {"deck": {"kind": "sea"}},
}
study = td.campaign(sweep, "study")
study

# %% [markdown]
# All four fly the same 150 trials: the same seas, starts and vehicles. The strength of the ground effect is drawn for each trial, so no model is exact.
# The folder `study` holds the landings, and the same call with the same folder flies nothing again.
#
# ## Who lands, and how softly
#
# Shares have 95 % intervals of their own: 150 of 150 does not mean that no landing ever fails.

# %%
for point in study.results["points"]:
    landed, speed, time = point["landed"], point["v_l_mps"], point["t_l_s"]
    low, high = landed["ci95"]
    print(f"{point['controller']:17} landed {landed['count']:3} of {point['trials']} ({100 * low:.0f} to {100 * high:.0f} %)   "
          f"touchdown {speed['mean']:.3f} m/s ({speed['ci95'][0]:.3f} to {speed['ci95'][1]:.3f})   in {time['mean']:.1f} s")

# %% figure="Share of the landings over the touchdown speed, a line for each of the four controllers"
fig, (left, right) = plt.subplots(1, 2, sharey=True, figsize=(7.2, 4.2))
study.plot("v_l_mps", left)
study.plot("t_l_s", right)
left.set(xlabel="touchdown speed (m/s)", xlim=(0.0, 0.2))
right.set(xlabel="landing time (s)", ylabel="")
for ax in (left, right):
    ax.get_legend().remove()
fig.legend(*left.get_legend_handles_labels(), loc="outside lower center", ncols=2, fontsize="small");

# %% [markdown]
# ## The same trials in pairs
#
# Trials differ more from each other than controllers do: some seas are rough where others are calm. Pairs remove that. Each trial with the help is compared with
# the same trial without it.

# %%
def pairs(column, controller, without="feedback"):
    rows = {name: [k for k, c in enumerate(study["control.controller"]) if c == name] for name in (controller, without)}
    difference = study[column][rows[controller]] - study[column][rows[without]]
    difference = difference[np.isfinite(difference)]  # both landed
    mean, error = difference.mean(), difference.std(ddof=1) / np.sqrt(difference.size)
    return mean, mean - 1.96 * error, mean + 1.96 * error, difference.size

helps = [("dynamic", "feedback"), ("observer", "feedback"), ("dynamic+observer", "observer")]
for column, unit, factor in (("v_l_mps", "mm/s", 1e3), ("t_l_s", "ms", 1e3)):
    for controller, without in helps:
        mean, low, high, count = pairs(column, controller, without)
        print(f"{column:8} {controller:16} against {without:8} {factor * mean:+6.0f} {unit}, 95 % interval {factor * low:+.0f} to {factor * high:+.0f}, {count} pairs")

# %% figure="Differences of landing time and of touchdown speed in pairs with their 95 percent intervals"
fig, axes = plt.subplots(1, 2, sharey=True, figsize=(7.2, 2.4))
for ax, column, label in zip(axes, ("v_l_mps", "t_l_s"), ("touchdown speed (m/s)", "landing time (s)")):
    for k, (controller, without) in enumerate(helps):
        mean, low, high, _ = pairs(column, controller, without)
        ax.errorbar(mean, -k, xerr=[[mean - low], [high - mean]], fmt="o", capsize=4, color=f"C{k}")
    ax.axvline(0.0, color="k", lw=0.8)
    ax.set(xlabel=f"difference of {label}", ylim=(-2.5, 0.5))
axes[0].set_yticks([0, -1, -2], [f"{a}\nminus {b}" for a, b in helps]);

# %% [markdown]
# The answer to the question is no. With the model a landing takes 0.9 s less, a difference far from zero. The touchdown speeds differ by less than these 150 pairs can show,
# and all of them are low. An observer without any model saves more time. With the observer at work, the model
# saves nothing more, and no touchdown becomes softer.
#
# A study of another deck or vehicle can have another answer: [When does the model pay?](../tutorials/when-the-model-pays.md) has more of them.
#
# ## One landing
#
# Which landing was the hardest touchdown of `dynamic+observer`? It is flown once more for its time series.

# %% figure="Heights of vehicle and deck over time in the landing with the greatest touchdown speed"
speeds = np.where(np.array(study["control.controller"]) == "dynamic+observer", study["v_l_mps"], np.nan)
hardest = int(np.nanargmax(speeds))
print(f"landing {hardest}: {speeds[hardest]:.2f} m/s")
fig, ax = plt.subplots()
study.plot_trace(hardest, ax);
