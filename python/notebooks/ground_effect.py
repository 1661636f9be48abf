# %% [markdown]
# # Ground effect from flights
#
# Near the ground the same throttle gives more thrust. Flight logs show how much more: throttle, accelerometer and height are enough, without a force sensor.
#
# The logs of this page are of simulated landings, written as PX4 writes them.

# %% language="sh"
# touchdown land --space --trials 20 --seed 3 --ulog logs --out landings > said.txt
# touchdown land --space --trials 3 --seed 2 --ulog unseen --out landings-unseen > said.txt

# %%
import warnings
from pathlib import Path

import numpy as np
import touchdown as td
from matplotlib import pyplot as plt

warnings.simplefilter("ignore", td.SindyWarning)  # those of the fit are shown below
flights = td.read(sorted(Path("logs").glob("*.ulg")))
print(len(flights), "flights with", ", ".join(flights[0]))

# %% [markdown]
# ## Identify
#
# Two numbers of the vehicle are known. The mass turns specific force into newtons, and the ground effect goes with the rotor radius.

# %%
vehicle = {"flight": {"mass_kg": 1.37, "rotor_radius_m": 0.12}}
thrust = td.identify.thrust(flights, vehicle)
ground = td.identify.ground_effect(flights, thrust, settings=vehicle)
for term in ground.terms:
    print(f"{term['expression']}  {term['value']:.2f} ± {term['std_error']:.2f}")

# %% [markdown]
# The first three numbers weigh three curves of height; then come the damping of a climb (s/m) and the lag of the wake (s), where the logs show them. `T` is the thrust far from the ground and `f` the additional force.

# %%
from IPython.display import Latex

Latex(f"$${ground.to_latex(2)}$$")

# %% [markdown]
# A fit reports what its data do not contain. These warnings are part of the result, and the card keeps their full text:

# %%
for text in ground.warnings:
    print("-", text.split(":")[0])

# %% [markdown]
# A landing passes each height once. So these logs do not tell how long the air takes to follow, and the fit refuses that number.
# [Fly so that the logs identify a model](../how-to/record.md) says which flights would show it.
#
# ## Is it true?
#
# This vehicle is simulated, so its true ground effect is known: landings of the simulator have it in their time series. On a real vehicle nobody has this figure.

# %% figure="Additional thrust in percent over height: points of the simulator's truth in twenty landings, and the identified curve through them down to the lowest height of the data"
landings = td.land(space=True, trials=20, seed=3)
heights, extra = [], []
for k in range(20):
    run = landings.trace(k)
    flying = run["feet_n"].sum(axis=1) == 0.0
    heights.append(run["relative_m"][flying, 2])
    extra.append(100.0 * run["ground_effect_n"][flying] / run["rotor_n"][flying].sum(axis=1))
card = ground.to_dict()
low, high = card["validity"]["inputs"]["z"]
z = np.linspace(low, high, 200)
curve = sum(term["value"] / (1.0 + (z / length) ** 2) for term, length in zip(ground.terms, card["constants"].values()))
fig, ax = plt.subplots()
ax.plot(np.concatenate(heights)[::7], np.concatenate(extra)[::7], ".", ms=2, color="0.7", label="truth, 20 landings")
ax.plot(z, 100.0 * curve, label="identified from the logs")
ax.set(xlabel="height (m)", ylabel="additional thrust (%)", xlim=(0.0, 1.0), ylim=(-3.0, 16.0))
ax.legend();

# %% [markdown]
# Close to the ground, where it matters most, the curve goes through the points. Between 0.3 and 0.7 m it lies below them, by about two percent of the thrust.
# There the vehicles descend. The true force depends on the sink rate too: at 0.75 m a hover has 1 %, a descent 3 %. The curve shows height alone.
#
# ## Judge it on other flights
#
# Three flights that the fit has not seen: each card predicts the force from throttle and height alone.

# %%
unseen = td.read(sorted(Path("unseen").glob("*.ulg")))
runs = td.validate(ground, unseen, thrust=thrust)
for run in runs:
    print(f"{run.trial}  RMSE {run.measured['rmse']:.2f} N of about 13.4 N")

# %% figure="Measured and predicted force over time in an unseen landing"
fig, ax = plt.subplots()
runs[0].plot(ax);

# %% [markdown]
# The prediction misses the same force here, while the vehicle descends. The last rise, at the touchdown, is right.
#
# More: [Flight logs: ground effect without a force sensor](../tutorials/flight-logs.md), [Ground effect](../theory/ground-effect.md).
