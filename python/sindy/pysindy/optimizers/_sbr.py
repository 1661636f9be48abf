"""Sparse Bayesian regression."""

from __future__ import annotations

import json
import warnings
from numbers import Integral
from typing import Any

import numpy as np
from sklearn.exceptions import ConvergenceWarning

from ... import _native
from ..._data import Array
from ._base import BaseOptimizer

# What `numpyro.infer.MCMC` takes beside these is about its compiler and its progress bar.
IGNORED = {"chain_method", "jit_model_args", "progress_bar"}


class PosteriorDraws:
    """Draws of the posterior, under the names that PySINDy's `SBR` has them by in `numpyro.infer.MCMC`.

    Attributes
    ----------
    num_chains, num_samples : int
        Chains, and draws of each.
    warning : str or None
        What keeps the chains from counting as converged.
    """

    def __init__(self, draws: dict[str, Array], num_chains: int, warning: str | None) -> None:
        self._draws = draws
        self.num_chains = num_chains
        self.num_samples = len(draws["tau"]) // num_chains
        self.warning = warning

    def get_samples(self, group_by_chain: bool = False) -> dict[str, Array]:
        """Draws by name: ``beta`` and ``lambda`` of shape (draws, n_targets, n_terms), ``tau``, ``c_sq`` and ``sigma`` of shape
        (draws,). With `group_by_chain` the first axis is split into (chains, draws of each)."""
        if not group_by_chain:
            return dict(self._draws)
        shape = (self.num_chains, self.num_samples)
        return {name: draws.reshape(shape + draws.shape[1:]) for name, draws in self._draws.items()}


class SBR(BaseOptimizer):
    """Coefficients under the regularised horseshoe prior: the means of their posterior, by Markov chains.

    The model is PySINDy's. With a term j of the target k

    - ``y_k ~ N(X β_k, σ²)``, ``σ ~ Exponential(noise_hyper_lambda)``;
    - ``β_kj ~ N(0, τ² c² λ_kj² / (c² + τ² λ_kj²))``, ``λ_kj ~ HalfCauchy(1)``, ``τ ~ HalfCauchy(sparsity_coef_tau0)``;
    - ``c² ~ InverseGamma(ν/2, ν s²/2)``.

    The sampler is the library's: it reads the sums of the rows, so that any number of rows takes the same time. A
    `ConvergenceWarning` says where R-hat or the effective sample size is not what it should be.

    Parameters
    ----------
    sparsity_coef_tau0 : float
        Median of τ: a smaller one shrinks more.
    slab_shape_nu, slab_shape_s : float
        ν and s: coefficients that are not shrunk have Student's t distribution with ν degrees of freedom and scale s.
    noise_hyper_lambda : float
        Rate of the distribution of σ.
    num_warmup : int
        Steps before the first draw.
    num_samples : int
        Draws of each chain, at least 1.
    mcmc_kwargs : dict, optional
        ``seed`` (0 by default) and ``num_chains`` (1 by default). ``chain_method``, ``jit_model_args`` and ``progress_bar`` are
        there for compatibility.
    nuts_kwargs : dict, optional
        There for compatibility: the sampler has nothing to tune.
    unbias : bool
        Has to be False.
    max_iter, normalize_columns, initial_guess, copy_X
        As for `BaseOptimizer`; the first and the third are there for compatibility.

    Attributes
    ----------
    coef_ : ndarray of shape (n_targets, n_terms)
        Posterior means: shrunk, but not 0.
    mcmc_ : PosteriorDraws
        The draws, by ``mcmc_.get_samples()``; with `normalize_columns` those of normalised columns, as in PySINDy.
    """

    _starts = False

    def __init__(
        self,
        sparsity_coef_tau0: float = 0.1,
        slab_shape_nu: float = 4,
        slab_shape_s: float = 2,
        noise_hyper_lambda: float = 1,
        num_warmup: int = 1000,
        num_samples: int = 5000,
        mcmc_kwargs: dict[str, Any] | None = None,
        nuts_kwargs: dict[str, Any] | None = None,
        unbias: bool = False,
        max_iter: int = 20,
        normalize_columns: bool = False,
        initial_guess: Any = None,
        copy_X: bool = True,
    ) -> None:
        self.sparsity_coef_tau0 = sparsity_coef_tau0
        self.slab_shape_nu = slab_shape_nu
        self.slab_shape_s = slab_shape_s
        self.noise_hyper_lambda = noise_hyper_lambda
        self.num_warmup = num_warmup
        self.num_samples = num_samples
        self.mcmc_kwargs = mcmc_kwargs
        self.nuts_kwargs = nuts_kwargs
        super().__init__(max_iter, normalize_columns, initial_guess, copy_X, unbias)

    def _check(self) -> None:
        super()._check()
        if self.unbias:
            raise ValueError("unbias: expected False, found True: posterior means are not refitted")
        for name in ("sparsity_coef_tau0", "slab_shape_nu", "slab_shape_s", "noise_hyper_lambda"):
            value = getattr(self, name)
            if not 0 < value < np.inf:
                raise ValueError(f"{name}: expected a number above 0, found {value}")
        chains = self._chains()
        for name, value, least in (
            ("num_warmup", self.num_warmup, 0),
            ("num_samples", self.num_samples, 1),
            ("mcmc_kwargs, num_chains", chains["num_chains"], 1),
            ("mcmc_kwargs, seed", chains["seed"], 0),
        ):
            if not isinstance(value, Integral) or not least <= int(value) < 2**64:
                raise ValueError(f"{name}: expected a whole number of at least {least}, found {value}")

    def _chains(self) -> dict[str, Any]:
        given = {"seed": 0, "num_chains": 1} | (self.mcmc_kwargs or {})
        unknown = given.keys() - IGNORED - {"seed", "num_chains"}
        if unknown:
            raise ValueError(f"mcmc_kwargs: expected seed and num_chains, found {', '.join(sorted(unknown))}")
        return given

    def _reduce(self, x: Array, y: Array) -> None:
        chains = self._chains()
        settings = {
            "global_scale": float(self.sparsity_coef_tau0),
            "slab_degrees": float(self.slab_shape_nu),
            "slab_scale": float(self.slab_shape_s),
            "noise_rate": float(self.noise_hyper_lambda),
            "chains": int(chains["num_chains"]),
            "warm_up": int(self.num_warmup),
            "draws": int(self.num_samples),
            "seed": int(chains["seed"]),
        }
        squares = [float(s) for s in np.sum(y**2, axis=0)]
        targets, scales, warning = _native.sample_horseshoe(x.T @ x, x.T @ y, squares, len(x), json.dumps(settings))
        if warning is not None:
            warnings.warn(f"SBR: {warning}", ConvergenceWarning)
        self.coef_ = np.array([means for means, _, _ in targets])
        draws = {
            "beta": np.stack([beta.T for _, beta, _ in targets], axis=1),
            "lambda": np.stack([local.T for _, _, local in targets], axis=1),
        }
        draws |= {name: np.array(values) for name, values in zip(("tau", "c_sq", "sigma"), scales)}
        self.mcmc_ = PosteriorDraws(draws, int(chains["num_chains"]), warning)
