"""Settings of the automatic call, and what is refused before a fit."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from ._derivative import Differentiator
from ._errors import fault
from ._solvers import Solver
from ._weak import WeakForm

if TYPE_CHECKING:
    from ._model import SINDy

# Parameters that are lists of texts, with what an entry looks like. Settings of the same name add to them.
TEXTS = {
    "known": "x' = v",
    "signs": "v': v < 0",
    "conserve": "v^2/2 - cos(x)",
    "constraints": "[x': y] = -[y': x]",
    "diffusion": "poly(2)",
}

# Parameters of the automatic call with their defaults, which leave the settings of the same name as they are.
SCALARS: dict[str, bool | str] = {"stable": False, "noise": "automatic"}


def _texts(model: SINDy, name: str) -> list[str]:
    out: list[str] = []
    for given in (getattr(model, name), (model.settings or {}).get(name)):
        if given is None:
            continue
        many = given.ndim == 1 if isinstance(given, np.ndarray) else isinstance(given, Sequence)
        if isinstance(given, str) or not many or not all(isinstance(text, str) for text in given):
            raise fault(name, f'a list of texts such as "{TEXTS[name]}", or none', repr(given))
        out += map(str, given)
    return out


def _changed(model: SINDy) -> dict[str, Any]:
    """Those of `SCALARS` that are not the default, parameters before settings."""
    own = {name: type(default)(getattr(model, name)) for name, default in SCALARS.items()}
    given = {name: value for name, value in (model.settings or {}).items() if name in SCALARS}
    given |= {name: value for name, value in own.items() if value != SCALARS[name]}
    return {name: value for name, value in given.items() if value != SCALARS[name]}


def check(model: SINDy, other: str | None = None) -> None:
    """Refuses settings that the library does not see, or sees as another kind.

    `other` names what replaces the automatic call in memory, beside a solver.
    """
    if model.solver is not None and not isinstance(model.solver, Solver):
        raise fault("solver", "a solver such as STLSQ(), or none", repr(model.solver))
    if not isinstance(model.discrete, (bool, np.bool_)):
        raise fault("discrete", "True or False", repr(model.discrete))
    if model.settings is not None and not isinstance(model.settings, dict):
        raise fault("settings", "a dict, or none", type(model.settings).__name__)
    if model.solver is not None and model.settings:
        found = ", ".join(map(str, model.settings))
        raise fault("settings", "none with a solver: they are of the automatic call", found)
    if model.solver is not None and model.method != "automatic":
        raise fault("method", "`automatic` with a solver: it is of the automatic call", repr(model.method))
    beside_a_solver = (Differentiator, WeakForm) if model.solver is not None else ()
    if not isinstance(model.smoothing, (str, dict, *beside_a_solver)):
        expected = "a text, a dict, a method of differentiation or a weak form" if beside_a_solver else "a text or a dict"
        raise fault("smoothing", expected, repr(model.smoothing))
    other = "a solver" if model.solver is not None else other
    for name in TEXTS:
        given = _texts(model, name)
        if given and other is not None:
            raise fault(name, f"none with {other}: only the automatic call in memory heeds them", ", ".join(given))
    if not isinstance(model.stable, (bool, np.bool_)):
        raise fault("stable", "True or False", repr(model.stable))
    if not isinstance(model.noise, str):
        raise fault("noise", "a text such as `process`", repr(model.noise))
    for name, value in _changed(model).items():
        if other is not None:
            expected = f"{SCALARS[name]} with {other}: only the automatic call in memory heeds it"
            raise fault(name, expected, repr(value))


def automatic(model: SINDy) -> dict[str, Any]:
    """The settings of the automatic call."""
    out = {**(model.settings or {}), **{name: _texts(model, name) for name in TEXTS}}
    return out | _changed(model) | {"discrete": bool(model.discrete), "method": model.method, "smoothing": model.smoothing}
