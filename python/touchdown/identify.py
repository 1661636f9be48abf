"""Identification of thrust and ground effect."""

from __future__ import annotations

import json
import os
import warnings
from collections.abc import Iterable
from typing import Any

from sindy import SindyWarning, _native

from ._card import Card
from ._trial import Path, Trial


def _trials(given: Trial | Iterable[Trial]) -> list[_native.Trial]:
    return [t._native for t in ([given] if isinstance(given, Trial) else given)]


def _card(found: tuple[_native.Card, str]) -> Card:
    card = Card(found[0], json.loads(found[1]))
    for text in card.fit["warnings"]:
        warnings.warn(text, SindyWarning, stacklevel=3)
    return card


def _path(report: Path | None) -> str | None:
    return None if report is None else os.fspath(report)


def thrust(
    trials: Trial | Iterable[Trial], settings: dict[str, Any] | None = None, report: Path | None = None
) -> Card:
    """One thrust card from all trials together.

    Parameters
    ----------
    trials : Trial or sequence of these
        Of stands (with ``thrust_n``), or of flights.
    settings : dict, optional
        Those of ``touchdown settings identify``, as nested dictionaries.
    report : path, optional
        An HTML file for the report: figures, coefficients with intervals, warnings. It needs no other file.

    Examples
    --------
    >>> import warnings, numpy as np, touchdown as td
    >>> t = np.arange(0.0, 60.0, 0.02)
    >>> s = 0.5 + 0.2 * np.sin(0.5 * t) * np.sin(0.13 * t)
    >>> trial = td.Trial({"time_s": t, "throttle": s, "thrust_n": 20.0 * s**2})
    >>> with warnings.catch_warnings():
    ...     warnings.simplefilter("ignore")
    ...     card = td.identify.thrust(trial)
    >>> bool(abs(card.predict(trial) - trial["thrust_n"]).max() < 0.05)
    True
    """
    return _card(_native.identify_thrust(_trials(trials), json.dumps(settings or {}), _path(report)))


def ground_effect(
    trials: Trial | Iterable[Trial],
    thrust: Card | None = None,
    form: str = "lag",
    settings: dict[str, Any] | None = None,
    report: Path | None = None,
) -> Card:
    """One ground-effect card from all trials together.

    Parameters
    ----------
    trials : Trial or sequence of these
        Of force rigs (with ``thrust_n`` and ``height_m``), or of flights.
    thrust : Card, optional
        The free-air thrust: needed for rigs, used for flights where they need it.
    form : str
        The form for rigs; the data of flights decide theirs.
    settings : dict, optional
        As for `thrust`.
    report : path, optional
        As for `thrust`.
    """
    free_air = None if thrust is None else thrust._native
    given = (_trials(trials), free_air, form, json.dumps(settings or {}), _path(report))
    return _card(_native.identify_ground_effect(*given))
