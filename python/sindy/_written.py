"""What a model becomes: text, LaTeX, code, SymPy, functions."""

from __future__ import annotations

from collections.abc import Callable
from numbers import Integral
from typing import Any

import numpy as np

from . import _export, _native
from ._errors import fault


class Written:
    """The writing half of `SINDy`."""

    def _fitted(self) -> _native.Model:
        raise NotImplementedError

    def equations(self, precision: int = 3) -> list[str]:
        """The right-hand sides as text."""
        if not isinstance(precision, Integral) or precision < 1:
            raise fault("precision", "a number of digits of at least 1", repr(precision))
        lines = self._fitted().text(int(precision)).splitlines()
        return [line.split(" = ", 1)[1] for line in lines]

    def print(self, precision: int = 3, **options: Any) -> None:
        """Prints the equations; options are those of Python's own `print`."""
        print(self._fitted().text(precision), end=options.pop("end", ""), **options)

    def to_json(self) -> str:
        """The model in JSON: reads back exactly, also in the command ``sindy`` and in Rust."""
        return self._fitted().to_json()

    def to_latex(self, precision: int | None = 3) -> str:
        """The equations in LaTeX."""
        return self._fitted().to_latex(precision)

    def _repr_latex_(self) -> str | None:
        return None if getattr(self, "model_", None) is None else f"$${self.to_latex()}$$"

    def to_c(self, name: str = "rhs") -> str:
        """A function in C99."""
        return self._fitted().to_c(name)

    def to_rust(self, name: str = "rhs") -> str:
        """A function in Rust."""
        return self._fitted().to_rust(name)

    def to_sympy(self) -> list[Any]:
        """One SymPy expression for each state, over real symbols."""
        return _export.to_sympy(self._fitted())

    def to_callable(self, xp: Any = np) -> Callable[..., Any]:
        """The right-hand side as a function ``f(t, x, u=())``, for SciPy's ``solve_ivp`` or, with ``xp=jax.numpy``, for JAX.

        ``x`` has one entry for each state: numbers, or arrays of one shape.
        """
        return _export.to_callable(self._fitted(), xp)
