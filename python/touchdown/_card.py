"""Model cards."""

from __future__ import annotations

import json
import os
from html import escape
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray
from sindy import _native

from ._table import cell
from ._trial import Path, Trial


class Card:
    """One identified model: terms with coefficients, errors and units, validity, scores, provenance.

    Attributes
    ----------
    fit : dict
        Of a card that was just identified: ``rmse``, ``rmse_unit``, ``rows_used``, ``lag_s``, ``forms``, ``warnings``.

    Examples
    --------
    >>> import touchdown as td
    >>> card = td.Card.from_toml('''
    ... schema = 1
    ... name = "stand"
    ... kind = "thrust"
    ... form = "first_order"
    ... status = "fitted"
    ... equation = "(7)"
    ... [vehicle]
    ... name = "a quadrotor"
    ... [validity]
    ... outside = "clamp"
    ... [provenance]
    ... source = "an example"
    ... [[terms]]
    ... of = "c0"
    ... expression = "1"
    ... value = 5.0
    ... unit = "N^0.5"
    ... [[terms]]
    ... of = "c1"
    ... expression = "1"
    ... value = -0.5
    ... unit = "N^0.5"
    ... [[terms]]
    ... of = "T_m"
    ... expression = "1"
    ... value = 0.05
    ... unit = "s"
    ... ''')
    >>> card
    Card('stand', thrust, first_order, 3 terms)
    >>> card.thrust_at_rest([0.3, 0.5])
    array([1., 4.])
    >>> card.to_latex(2).count("&=")
    2
    """

    def __init__(self, native: _native.Card, fit: dict[str, Any] | None = None) -> None:
        self._native = native
        self.fit = fit or {}

    @classmethod
    def load(cls, path: Path) -> Card:
        """Reads a card."""
        return cls(_native.Card.load(os.fspath(path)))

    @classmethod
    def from_toml(cls, text: str) -> Card:
        """The card of a text."""
        return cls(_native.Card.from_toml(text))

    def save(self, path: Path) -> None:
        """Writes the card, whole or not at all."""
        self._native.save(os.fspath(path))

    def to_toml(self) -> str:
        """The card as text, which reads back to the bit."""
        return self._native.to_toml()

    def to_dict(self) -> dict[str, Any]:
        """All that it holds, as plain objects."""
        out: dict[str, Any] = json.loads(self._native.to_json())
        return out

    @property
    def terms(self) -> list[dict[str, Any]]:
        """Coefficients with ``of``, ``expression``, ``value``, ``std_error``, ``ci95`` and ``unit``."""
        out: list[dict[str, Any]] = self.to_dict()["terms"]
        return out

    @property
    def warnings(self) -> list[str]:
        """What a user must know before relying on it."""
        out: list[str] = self.to_dict()["warnings"]
        return out

    @property
    def name(self) -> str:
        """The name."""
        return str(self.to_dict()["name"])

    @property
    def kind(self) -> str:
        """``thrust`` or ``ground_effect``."""
        return str(self.to_dict()["kind"])

    @property
    def form(self) -> str:
        """The form of its equations."""
        return str(self.to_dict()["form"])

    def to_latex(self, digits: int = 4) -> str:
        """The equations in LaTeX (``aligned``), coefficients with so many significant digits."""
        return self._native.to_latex(digits)

    def thrust_at_rest(self, throttle: ArrayLike) -> NDArray[np.float64]:
        """The thrust (N) that throttles hold, by the model that flies; for thrust cards."""
        given = np.asarray(throttle, dtype=np.float64)
        return self._native.at_rest(np.ascontiguousarray(given).reshape(-1)).reshape(given.shape)

    def predict(self, trial: Any, thrust: Card | None = None) -> NDArray[np.float64]:
        """The thrust, or the ground-effect force, over a trial in free run (N).

        Parameters
        ----------
        trial : Trial, mapping or table
            Where inputs come from.
        thrust : Card, optional
            For a ground-effect card, that of the free-air thrust.
        """
        given = trial if isinstance(trial, Trial) else Trial(trial)
        return self._native.predict(given._native, None if thrust is None else thrust._native)

    def __repr__(self) -> str:
        card = self.to_dict()
        return f"Card({card['name']!r}, {card['kind']}, {card['form']}, {len(card['terms'])} terms)"

    def _repr_latex_(self) -> str:
        return f"$\\displaystyle {self.to_latex()}$"

    def _repr_html_(self) -> str:
        keys = ("of", "expression", "value", "std_error", "unit")
        rows = "".join("<tr>" + "".join(cell(term.get(k)) for k in keys) + "</tr>" for term in self.terms)
        head = "".join(f"<th>{k}</th>" for k in keys)
        return f"<table><caption>{escape(repr(self))}</caption><tr>{head}</tr>{rows}</table>"
