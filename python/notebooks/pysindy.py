# %% [markdown]
# # Moving from PySINDy
#
# A script for PySINDy runs after one changed line: the import. This page shows such a script, what differs on purpose, and what the library's own estimator does
# that the script cannot.

# %%
import numpy as np
from matplotlib import pyplot as plt
from scipy.integrate import solve_ivp

from sindy import pysindy as ps  # was: import pysindy as ps

def lorenz(t, s):
    x, y, z = s
    return [10.0 * (y - x), x * (28.0 - z) - y, x * y - 8.0 / 3.0 * z]

t = np.arange(0.0, 10.0, 0.002)
x = solve_ivp(lorenz, (0.0, 10.0), [-8.0, 8.0, 27.0], t_eval=t, rtol=1e-12, atol=1e-12).y.T

model = ps.SINDy(optimizer=ps.STLSQ(threshold=0.1), feature_library=ps.PolynomialLibrary(degree=2))
model.fit(x, t=t, feature_names=["x", "y", "z"])
model.print()

# %% [markdown]
# Names, signatures, defaults and the printed equations are those of PySINDy 2.1. So are libraries that are added together, functions of NumPy as terms,
# and `score`, `predict` and `simulate`.

# %%
library = ps.PolynomialLibrary(degree=2) + ps.FourierLibrary(n_frequencies=1)
mixed = ps.SINDy(optimizer=ps.STLSQ(threshold=0.5), feature_library=library).fit(x, t=t, feature_names=["x", "y", "z"])
print(len(mixed.get_feature_names()), "candidates")
mixed.print(precision=2)
print("R²", round(mixed.score(x, t=t), 4))

# %% [markdown]
# How far does this go? `python/conformance/run.py` runs PySINDy's own tests against this layer, and compares them with a list of expected outcomes. The counts are in
# [Use it from Python](../how-to/python.md#scripts-written-for-pysindy).
#
# ## What differs on purpose
#
# Some behaviour of PySINDy is not copied. This is one case of [the list](../how-to/python.md#scripts-written-for-pysindy).
# An ensemble that is fitted again has the models of the last fit; PySINDy adds them to those of the fits before.

# %%
u = np.sin(3.0 * t)
driven = solve_ivp(lambda t, s: [s[1], -2.0 * s[0] - 0.4 * s[1] + np.sin(3.0 * t)], (0.0, 10.0), [1.0, 0.0], t_eval=t, rtol=1e-10).y.T
np.random.seed(1)
ensemble = ps.EnsembleOptimizer(ps.STLSQ(threshold=0.1), bagging=True, n_models=5)
oscillator = ps.SINDy(optimizer=ensemble, feature_library=ps.PolynomialLibrary(degree=1))
for _ in range(2):
    oscillator.fit(driven, t=t, u=u, feature_names=["x", "v", "u"])
oscillator.print()
print(len(ensemble.coef_list), "models")

# %% [markdown]
# Kinds that are not there fail at once, before any data are read:

# %%
try:
    ps.ParameterizedLibrary
except AttributeError as error:
    print(error)

# %% [markdown]
# ## With noise, the threshold decides
#
# Now the samples have noise of 5 % of each state's standard deviation. The right model has seven terms. Which threshold finds it?

# %%
rng = np.random.default_rng(1)
noisy = x + 0.05 * x.std(axis=0) * rng.normal(size=x.shape)
truth = np.zeros((3, 10))  # 1, x, y, z, x², x y, x z, y², y z, z²
truth[0, 1:3], truth[1, [1, 2, 6]], truth[2, [3, 5]] = (-10.0, 10.0), (28.0, -1.0, -1.0), (-8.0 / 3.0, 1.0)
thresholds = np.geomspace(0.02, 0.9, 20)

def fit(threshold, slopes):
    script = ps.SINDy(optimizer=ps.STLSQ(threshold=threshold), feature_library=ps.PolynomialLibrary(degree=2), differentiation_method=slopes)
    return script.fit(noisy, t=t).coefficients()

plain = [fit(k, ps.FiniteDifference()) for k in thresholds]
smoothed = [fit(k, ps.SmoothedFiniteDifference(smoother_kws={"window_length": 61})) for k in thresholds]

# %% [markdown]
# `sindy.SINDy` has no threshold to choose. It chooses smoothing and terms from the data, and its scores ask for no truth.

# %%
import sindy

own = sindy.SINDy("poly(2)", states=["x", "y", "z"]).fit(noisy, t)
own

# %% figure="Number of terms and relative error of the coefficients over the threshold, for plain and for smoothed differences, with those of sindy.SINDy as a line; only a range of thresholds gives the seven true terms"
fig, (top, bottom) = plt.subplots(2, sharex=True, figsize=(7.2, 4.6))
for label, found in (("STLSQ, differences", plain), ("STLSQ, smoothed over 61 samples", smoothed)):
    top.semilogx(thresholds, [np.count_nonzero(c) for c in found], ".-", label=label)
    bottom.loglog(thresholds, [np.linalg.norm(c - truth) / np.linalg.norm(truth) for c in found], ".-")
top.axhline(np.count_nonzero(own.coef_), color="k", ls="--", label="sindy.SINDy")
bottom.axhline(np.linalg.norm(own.coef_ - truth) / np.linalg.norm(truth), color="k", ls="--")
top.set(ylabel="terms")
bottom.set(ylabel="error of coefficients", xlabel="threshold")
top.legend();

# %% [markdown]
# Without smoothing no threshold of this range gives the right model. With a window that someone has to choose, a range of thresholds does.
# With the truth at hand that range is easy to see; with measurements alone nobody marks it.
#
# Each coefficient of the estimator has a standard error:

# %%
for state, coefficients, errors in zip("xyz", own.coef_, own.std_error_):
    print(f"{state}'  " + "   ".join(f"{c:.2f} ± {e:.2f} {n}" for c, e, n in zip(coefficients, errors, own.get_feature_names()) if c))

# %% [markdown]
# So a move has two steps: the import first, and the estimator where noise makes the choice hard. It keeps scikit-learn's protocol, so searches and pipelines
# [work with it too](../how-to/python.md#with-scikit-learn).
