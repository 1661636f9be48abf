"""Candidate terms."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from . import _native
from ._errors import fault


class Library:
    """Candidate terms, written as text.

    Parameters
    ----------
    text : str or sequence of str
        Such as ``poly(3) + fourier(2)*u + exp(-x)``: ``poly(degree)``, ``fourier(frequencies)``, ``exp(rate, …)``,
        ``rational(scale, …)``, each over all variables or over those named, and expressions, joined by ``+`` and ``*``. A
        sequence is summed.

    Examples
    --------
    >>> import sindy
    >>> sindy.Library("poly(2, x, v) + u").terms(["x", "v", "u"])
    ['1', 'x', 'v', 'x^2', 'x*v', 'v^2', 'u']
    >>> library = sindy.Library.polynomial(1, "x") * sindy.Library("u") + sindy.Library("sin(x)")
    >>> library.terms(["x", "u"])
    ['u', 'x*u', 'sin(x)']
    """

    def __init__(self, text: str | Sequence[str]) -> None:
        self.text = text if isinstance(text, str) else " + ".join(text)

    @classmethod
    def polynomial(cls, degree: int, *variables: str) -> Library:
        """All monomials up to a degree, of the variables named or of all."""
        return cls(f"poly({', '.join([str(degree), *variables])})")

    @classmethod
    def fourier(cls, frequencies: int, *variables: str) -> Library:
        """Sines and cosines of the first so many multiples, of the variables named or of all."""
        return cls(f"fourier({', '.join([str(frequencies), *variables])})")

    def __add__(self, other: Library) -> Library:
        return Library(f"{self.text} + {other.text}")

    def __mul__(self, other: Library) -> Library:
        return Library(f"({self.text})*({other.text})")

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Library) and self.text == other.text

    def __hash__(self) -> int:
        return hash(self.text)

    def __repr__(self) -> str:
        return f"Library({self.text!r})"

    def build(self, variables: Sequence[str]) -> _native.Library:
        """The library over these variables."""
        return _native.Library.specification(self.text, list(variables))

    def terms(self, variables: Sequence[str]) -> list[str]:
        """The terms over these variables, as text."""
        return self.build(variables).names


def libraries(given: Any, states: Sequence[str], inputs: Sequence[str]) -> list[_native.Library]:
    """One library for all equations, or one for each, from what a user gave."""
    names = [*states, *inputs]

    def one(text: Any) -> _native.Library:
        library = text if isinstance(text, Library) else Library(text)
        return library.build(names)

    if given is None:
        return [one("poly(3)")]
    if isinstance(given, (str, Library)):
        return [one(given)]
    if isinstance(given, Mapping):
        missing = [s for s in states if s not in given]
        other = [s for s in given if s not in states]
        if missing or other:
            raise fault("library", "one for each of " + ", ".join(states), ", ".join(map(str, given)))
        return [one(given[s]) for s in states]
    if isinstance(given, Sequence) and all(isinstance(term, str) for term in given):
        return [one(given)]
    raise fault("library", "a text, a list of texts, a Library, or a table of these by state", type(given).__name__)
