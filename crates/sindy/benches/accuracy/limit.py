"""What no unbiased method can beat by more than luck: maximum likelihood that knows the true terms.

The error, to first order in the noise, of the output-error fit of the true terms with free initial states, on
the noise of the very same arrays: with J the sensitivities of all samples to coefficients and initial states
(from the variational equations along the runs without noise), weighted by the noise amplitude, it is the
coefficients' part of the least-squares solution of J d = noise. Beside a bar it tells whether a seed's noise
happened to be kind. On long chaotic runs with much noise the first order is optimistic.
"""

import numpy as np
from scipy.integrate import solve_ivp
from scipy.interpolate import CubicSpline

from data import amplitude, noisy
from systems import powers


def sensitivities(system, run):
    """d x / d (coefficients, initial state) along a run: (samples, states, coefficients + states)."""
    states = len(system.states)
    terms = [
        (i, powers(term, system.variables), c)
        for i, equation in enumerate(system.equations.values())
        for term, c in equation.items()
    ]
    row = np.array([i for i, _, _ in terms])
    exponents = np.array([e for _, e, _ in terms])
    coefficients = np.array([c for _, _, c in terms])
    select = np.zeros((states, len(terms)))
    select[row, np.arange(len(terms))] = 1.0
    # d term / d state j = exponent times the monomial with one power of j less.
    lowered = [np.maximum(exponents - np.eye(exponents.shape[1], dtype=int)[j], 0) for j in range(states)]
    inputs = CubicSpline(run.t, run.u) if run.u.size else None

    def rhs(t, y):
        x, s = y[:states], y[states:].reshape(states, -1)
        values = x if inputs is None else np.concatenate([x, inputs(t)])
        monomials = np.prod(values**exponents, axis=1)
        jacobian = np.column_stack(
            [
                select @ (coefficients * exponents[:, j] * np.prod(values**power, axis=1))
                for j, power in enumerate(lowered)
            ]
        )
        rate = jacobian @ s
        rate[:, : len(terms)] += select * monomials
        return np.concatenate([select @ (coefficients * monomials), rate.ravel()])

    start = np.hstack([np.zeros((states, len(terms))), np.eye(states)])
    solution = solve_ivp(
        rhs, (run.t[0], run.t[-1]), np.concatenate([run.x[0], start.ravel()]), t_eval=run.t,
        method="DOP853", rtol=1e-7, atol=1e-9,
    )  # fmt: skip
    return solution.y[states:].T.reshape(len(run.t), states, -1)


def limits(system, seeds):
    """Error of the limit for each seed at 1 % noise; it is proportional to the noise."""
    states, runs = len(system.states), system.runs
    count = sum(len(e) for e in system.equations.values())
    blocks = []
    for k, run in enumerate(runs):
        own = sensitivities(system, run) / amplitude(system, run, 1.0)[:, None]
        block = np.zeros((*own.shape[:2], count + states * len(runs)))
        block[..., :count] = own[..., :count]
        block[..., count + states * k : count + states * (k + 1)] = own[..., count:]
        blocks.append(block.reshape(-1, block.shape[2]))
    matrix = np.vstack(blocks)
    scale = np.linalg.norm(matrix, axis=0)
    solve = np.linalg.pinv(matrix / scale, rcond=1e-14)[:count] / scale[:count, None]
    truth = np.array([c for e in system.equations.values() for c in e.values()])
    errors = []
    for seed in seeds:
        noise = [
            ((x - run.x) / amplitude(system, run, 1.0)).ravel()
            for run, (_, x, _) in zip(runs, noisy(system, 1.0, seed))
        ]
        errors.append(float(np.linalg.norm(solve @ np.concatenate(noise)) / np.linalg.norm(truth)))
    return errors
