# %% [markdown]
# # Lorenz with noise
#
# Equations come back from noisy samples. Nobody tells the library how to smooth, which threshold to take, or how many terms there are.

# %%
import numpy as np
import sindy
from matplotlib import pyplot as plt
from scipy.integrate import solve_ivp

def lorenz(t, s):
    x, y, z = s
    return [10.0 * (y - x), x * (28.0 - z) - y, x * y - 8.0 / 3.0 * z]

t = np.arange(0.0, 10.0, 0.005)
truth = solve_ivp(lorenz, (0.0, 10.0), [-8.0, 7.0, 27.0], t_eval=t, rtol=1e-10, atol=1e-10).y.T
noise = 0.05 * truth.std(axis=0)  # 5 % of each state's standard deviation
x = truth + noise * np.random.default_rng(1).normal(size=truth.shape)

# %% [markdown]
# ## The equations
#
# The candidates are all products of `x`, `y` and `z` up to degree 3: 20 terms for each of three equations.

# %%
model = sindy.SINDy("poly(3)", states=["x", "y", "z"]).fit(x, t)
model

# %% [markdown]
# The terms are the true seven. How large is the error of each coefficient?

# %%
names = model.get_feature_names()
for state, coefficients, errors in zip("xyz", model.coef_, model.std_error_):
    for k in np.flatnonzero(coefficients):
        print(f"{state}'  {names[k]:>5}  {coefficients[k]:8.3f} ± {errors[k]:.3f}")

# %% [markdown]
# ± is one standard error. It should cover the distance from the true value in two of three cases: the truth is -10 and 10, then 28, -1 and -1, then 1 and -2.667.
#
# ## Why these terms?
#
# The front holds the best model found of each size. Errors are in units of the noise: 1 means that the residual is noise and nothing else.

# %%
print(model.choice_.method)
for equation in model.equations_:
    for point in equation["front"][:5]:
        mark = "<- chosen" if point["chosen"] else ""
        print(f"{equation['state']}'  {len(point['terms'])} terms  error {point['error']:8.3f}  {mark}")

# %% [markdown]
# ## A run of the model
#
# Lorenz is chaotic: the smallest error of a coefficient grows by a factor of e about every 1.1 s. So the model follows the truth for some seconds, and
# keeps its shape after that.

# %% figure="The state x of the truth, of the noisy samples and of the model over time; the model follows for the first seconds"
run = model.simulate(truth[0], t)
fig, ax = plt.subplots()
ax.plot(t[::5], x[::5, 0], ".", ms=2, color="0.7", label="samples")
ax.plot(t, truth[:, 0], label="truth")
ax.plot(run.t, run.x[:, 0], "--", label="model")
ax.set(xlabel="time (s)", ylabel="x", xlim=(0.0, 12.5))
ax.legend(loc="upper right");

# %% [markdown]
# ## What a model becomes
#
# `to_sympy()`, `to_callable()` for SciPy, `to_c()`, `to_rust()` and `to_json()`; the last reads back to the bit.

# %%
right_hand_side = model.to_callable()
print(np.round(right_hand_side(0.0, truth[0]), 1), np.round(lorenz(0.0, truth[0]), 1))
assert sindy.SINDy.from_json(model.to_json()).equations(17) == model.equations(17)
