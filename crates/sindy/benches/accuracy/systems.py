"""The systems of the accuracy table: equations, trajectories without noise, library and noise rule.

Every system is an ordinary differential equation whose right-hand side is a polynomial of its states and
inputs. Its coefficients are the truth against which a fit is measured; the same coefficients are what is
integrated, so that the two cannot disagree (`dysts` systems are integrated by `dysts` itself and their
coefficients are checked against its right-hand side).
"""

import re
import warnings
from dataclasses import dataclass, field
from itertools import combinations_with_replacement

import numpy as np
import sympy
from scipy.integrate import solve_ivp

warnings.filterwarnings("ignore", message="Numba not installed")
warnings.filterwarnings("ignore", message="The following arguments have no effect")
import dysts.flows

DYSTS = [
    "Aizawa", "BurkeShaw", "ChenLee", "Hadley", "Lorenz84",
    "LuChen", "QiChen", "Rucklidge", "SprottB", "WangSun",
]  # fmt: skip
DYSTS_HELD_OUT = [
    "SprottC", "Halvorsen", "Dadras", "ShimizuMorioka", "MooreSpiegel", "HyperRossler", "Finance",
]  # fmt: skip

STD_LEVELS = [1.0, 5.0, 10.0, 20.0]
RMS_LEVELS = [0.1, 1.0, 5.0]


@dataclass
class Trajectory:
    """One run: `t` (n,), `x` (n, states), `u` (n, inputs)."""

    t: np.ndarray
    x: np.ndarray
    u: np.ndarray


@dataclass
class System:
    """A problem of the table. `equations[state][term]` is the true coefficient, terms written `x^2*y`."""

    name: str
    states: list
    inputs: list
    degree: int
    equations: dict
    levels: list
    noise_rule: str  # "std": percent of each state's standard deviation; "rms": of each trajectory's RMS
    terms: list = None  # the library where it is not all monomials up to `degree`
    runs: list = field(default_factory=list)

    @property
    def variables(self):
        return self.states + self.inputs

    @property
    def library(self):
        """The library as the command takes it: a specification or a list of terms."""
        return self.terms if self.terms is not None else f"poly({self.degree})"

    @property
    def library_terms(self):
        return self.terms if self.terms is not None else monomials(self.variables, self.degree)


def monomials(variables, degree):
    """Names of all monomials up to `degree`, `1` first."""
    names = ["1"]
    for d in range(1, degree + 1):
        for chosen in combinations_with_replacement(variables, d):
            names.append(
                "*".join(v if (p := chosen.count(v)) == 1 else f"{v}^{p}" for v in variables if v in chosen)
            )
    return names


def powers(term, variables):
    """Exponents of a monomial written `x^2*y`, in the order of `variables`."""
    found = dict.fromkeys(variables, 0)
    if term.strip() != "1":
        for factor in term.replace("**", "^").split("*"):
            match = re.fullmatch(r"\s*(\w+?)\s*(?:\^\s*(\d+))?\s*", factor)
            if match is None or match[1] not in found:
                raise ValueError(f"term `{term}` is not a monomial of {variables}")
            found[match[1]] += int(match[2] or 1)
    return tuple(found[v] for v in variables)


def evaluate(term, columns, variables):
    """A monomial's value on columns (n, variables)."""
    value = np.ones(len(columns))
    for column, power in zip(columns.T, powers(term, variables)):
        value = value * column**power
    return value


def integrate(system, start, t, inputs=None):
    """The system from `start` at the times `t`: Dormand-Prince 8(5,3), relative tolerance 1e-12.

    `inputs` maps a time or an array of times to the inputs, shape (inputs,) or (n, inputs).
    """
    compiled = [
        [(c, powers(term, system.variables)) for term, c in system.equations[s].items()]
        for s in system.states
    ]

    def rhs(time, x):
        values = list(x) if inputs is None else [*x, *inputs(time)]
        out = []
        for equation in compiled:
            total = 0.0
            for c, exponents in equation:
                for v, p in zip(values, exponents):
                    if p:
                        c = c * v**p
                total += c
            out.append(total)
        return out

    solution = solve_ivp(rhs, (t[0], t[-1]), start, t_eval=t, method="DOP853", rtol=1e-12, atol=1e-13)
    if not solution.success:
        raise RuntimeError(f"{system.name}: {solution.message}")
    u = np.empty((len(t), 0)) if inputs is None else np.asarray(inputs(t)).T
    return Trajectory(t, solution.y.T.copy(), u)


def times(n, step):
    return np.arange(n) * step


def lorenz():
    s = System(
        "lorenz", ["x", "y", "z"], [], 3,
        {"x": {"x": -10.0, "y": 10.0}, "y": {"x": 28.0, "y": -1.0, "x*z": -1.0},
         "z": {"z": -8 / 3, "x*y": 1.0}},
        STD_LEVELS, "std",
    )  # fmt: skip
    s.runs = [integrate(s, [-8.0, 7.0, 27.0], times(5000, 0.002))]
    return s


def vanderpol():
    s = System(
        "vanderpol", ["x", "y"], [], 3,
        {"x": {"y": 1.0}, "y": {"x": -1.0, "y": 2.0, "x^2*y": -2.0}},
        STD_LEVELS, "std",
    )  # fmt: skip
    s.runs = [integrate(s, [1.0, 0.0], times(5000, 0.01))]
    return s


def lotkavolterra():
    s = System(
        "lotkavolterra", ["x", "y"], [], 3,
        {"x": {"x": 2 / 3, "x*y": -4 / 3}, "y": {"y": -1.0, "x*y": 1.0}},
        STD_LEVELS, "std",
    )  # fmt: skip
    s.runs = [integrate(s, [1.8, 1.3], times(5000, 0.01))]
    return s


def ground_effect():
    """Equation (12): the same trajectories as `sindy::problems::ground_effect`; noise on f only."""
    s = System(
        "ground_effect", ["f"], ["s", "z", "v_p", "v_q"], 2,
        {"f": {"1": 0.804, "f": -0.088, "s": -3.912, "z": 0.586, "v_p": 1.051, "v_q": -1.049,
               "s^2": 4.854, "v_p*v_q": 1.103, "z^2": -2.504, "v_p^2": -0.535, "v_q^2": -0.562}},
        STD_LEVELS, "std",
    )  # fmt: skip
    s.terms = list(s.equations["f"])
    for k in range(5):
        a, wa, b, wb = 0.10 + 0.01 * k, 0.9 + 0.13 * k, 0.05, 2.1 - 0.19 * k
        c, wc = 0.04 + 0.015 * k, 1.6 + 0.23 * k

        def inputs(t, k=k, a=a, wa=wa, b=b, wb=wb, c=c, wc=wc):
            throttle = (
                0.45 + 0.02 * k + 0.08 * np.sin((0.7 + 0.11 * k) * t + k)
                + 0.04 * np.sin((2.3 + 0.17 * k) * t)
            )  # fmt: skip
            q = 0.35 + a * np.sin(wa * t + k) + b * np.sin(wb * t)
            p = c * np.sin(wc * t + 2 * k)
            v_q = a * wa * np.cos(wa * t + k) + b * wb * np.cos(wb * t)
            v_p = c * wc * np.cos(wc * t + 2 * k)
            return np.array([throttle, q - p, v_p, v_q])

        s.runs.append(integrate(s, [0.4 + 0.2 * k], times(3000, 0.01), inputs))
    return s


def dysts_system(name, prefix="dysts_"):
    """A system of `dysts` with its default parameters: five runs of 1000 points, 100 a period.

    The runs begin on the attractor, 10 periods apart on one long run from the package's initial condition
    after 10 periods of transient.
    """
    model = getattr(dysts.flows, name)()
    rhs = getattr(model._rhs, "py_func", model._rhs)
    states = list(rhs.__code__.co_varnames[: model.dimension])
    symbols = sympy.symbols(states)
    # Parameters as rationals, so that expansion loses nothing before the final conversion.
    parameters = [sympy.nsimplify(float(p), rational=True) for p in model.param_list]
    equations = {}
    for state, expression in zip(states, rhs(*symbols, 0, *parameters)):
        polynomial = sympy.Poly(sympy.nsimplify(sympy.expand(expression), rational=True), *symbols)
        equations[state] = {
            name_of(exponents, states): float(c) for exponents, c in polynomial.terms() if c != 0
        }
    s = System(prefix + name.lower(), states, [], 4, equations, RMS_LEVELS, "rms")
    degree = max(sum(powers(t, states)) for e in equations.values() for t in e)
    if degree > s.degree:
        raise ValueError(f"{name} has degree {degree}")
    settings = {"resample": True, "method": "DOP853", "return_times": True}
    _, guide = model.make_trajectory(601, pts_per_period=10, rtol=1e-9, atol=1e-9, **settings)
    t, x = model.make_trajectory(
        1000, pts_per_period=100, init_cond=guide[100:600:100], rtol=1e-12, atol=1e-12, **settings
    )
    if x.shape != (5, 1000, len(states)):
        raise RuntimeError(f"{name}: runs of shape {x.shape}")
    s.runs = [Trajectory(t, run, np.empty((len(t), 0))) for run in x]
    ours = derivative(s, x[0])
    theirs = np.array([rhs(*row, 0, *model.param_list) for row in x[0]])
    # Both are the same polynomial in doubles: equal but for rounding of its largest terms.
    if not np.allclose(ours, theirs, rtol=1e-10, atol=1e-10 * np.abs(theirs).max()):
        raise RuntimeError(f"{name}: the expanded polynomial is not the right-hand side")
    return s


def name_of(exponents, variables):
    factors = [v if p == 1 else f"{v}^{p}" for v, p in zip(variables, exponents) if p]
    return "*".join(factors) or "1"


def derivative(system, columns):
    """The true right-hand side on columns (n, variables), shape (n, states)."""
    return np.column_stack(
        [
            sum(c * evaluate(term, columns, system.variables) for term, c in equation.items())
            for equation in system.equations.values()
        ]
    )


def held_out():
    """Systems that no bar names: they show whether the automatic choice is tuned to those that are named."""

    def simple(name, states, equations, starts, n, step, inputs=None):
        s = System("heldout_" + name, states, ["u"] if inputs else [], 3, equations, STD_LEVELS, "std")
        lengths = n if isinstance(n, list) else [n] * len(starts)
        s.runs = [integrate(s, start, times(length, step), inputs) for start, length in zip(starts, lengths)]
        return s

    return {
        "heldout_rossler": lambda: simple(
            "rossler", ["x", "y", "z"],
            {"x": {"y": -1.0, "z": -1.0}, "y": {"x": 1.0, "y": 0.2},
             "z": {"1": 0.2, "z": -5.7, "x*z": 1.0}},
            [[-6.0, 3.0, 0.03]], 5000, 0.01,
        ),
        "heldout_duffing": lambda: simple(
            "duffing", ["x", "v"],
            {"x": {"v": 1.0}, "v": {"x": 1.0, "v": -0.3, "x^3": -1.0, "u": 1.0}},
            [[1.0, 0.0], [-0.5, 0.5], [0.2, -0.3]], [2000, 2500, 3000], 0.01,
            lambda t: np.array([0.5 * np.cos(1.2 * t) + 0.1 * np.sin(2.9 * t)]),
        ),
        "heldout_softening": lambda: simple(
            "softening", ["x", "v"],
            {"x": {"v": 1.0}, "v": {"x": -1.0, "x^3": 1 / 6, "v": -0.25}},
            [[1.8, 0.0], [-1.0, 1.0], [0.5, -1.5]], 2000, 0.01,
        ),
        "heldout_cubic": lambda: simple(
            "cubic", ["x", "y"],
            {"x": {"x^3": -0.1, "y^3": 2.0}, "y": {"x^3": -2.0, "y^3": -0.1}},
            [[2.0, 0.0]], 2500, 0.01,
        ),
        "heldout_fitzhughnagumo": lambda: simple(
            "fitzhughnagumo", ["v", "w"],
            {"v": {"1": 0.5, "v": 1.0, "v^3": -1 / 3, "w": -1.0},
             "w": {"1": 0.056, "v": 0.08, "w": -0.064}},
            [[-1.0, 1.0]], 5000, 0.05,
        ),
        "heldout_linear": lambda: simple(
            "linear", ["x", "y", "z"],
            {"x": {"x": -0.1, "y": 2.0}, "y": {"x": -2.0, "y": -0.1}, "z": {"z": -0.3}},
            [[2.0, 0.0, 1.0], [0.0, -1.0, 2.0]], 2000, 0.01,
        ),
    } | {
        f"heldout_{name.lower()}": (lambda name=name: dysts_system(name, "heldout_"))
        for name in DYSTS_HELD_OUT
    }  # fmt: skip


def catalogue():
    """Name -> function that makes the system, in the order of the table."""
    return (
        {f.__name__: f for f in (lorenz, vanderpol, lotkavolterra, ground_effect)}
        | {f"dysts_{n.lower()}": (lambda n=n: dysts_system(n)) for n in DYSTS}
        | held_out()
    )
