"""Cards on trials that they have not seen."""

from __future__ import annotations

import json
import warnings
from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray
from sindy import SindyWarning, _native
from sindy._errors import fault

from . import _plot
from ._card import Card
from ._table import table_html
from ._trial import Trial

Array = NDArray[np.float64]


@dataclass(frozen=True)
class FreeRun:
    """One card on one trial in free run.

    Attributes
    ----------
    card, trial : str
        Their names.
    seen : bool or None
        Whether the card was fitted to this very file; None where that is not known.
    measured : dict
        Errors of the prediction against the measurement (N): ``mae``, ``rmse``, ``worst``, ``samples``.
    truth, noise_floor : dict or None
        The same against the truth, and of the measurement against the truth, where the log is of the virtual rig.
    time_s, measured_n, predicted_n : array
        The run; rows that are not judged are NaN.
    armed_intervals : list of dict
        Scale and height offset of each armed interval of a flight.
    warnings : list of str
        What a user should know.
    """

    card: str
    trial: str
    seen: bool | None
    measured: dict[str, float]
    truth: dict[str, float] | None
    noise_floor: dict[str, float] | None
    time_s: Array = field(repr=False)
    measured_n: Array = field(repr=False)
    predicted_n: Array = field(repr=False)
    armed_intervals: list[dict[str, Any]] = field(repr=False)
    warnings: list[str] = field(repr=False)

    def plot(self, ax: Any = None) -> Any:
        """Measured and predicted force over time, as matplotlib axes: those that are given, or of a new figure."""
        return _plot.forces(self.time_s, self.measured_n, self.predicted_n, f"{self.card} on {self.trial}", ax)


class FreeRuns(list[FreeRun]):
    """Free runs, a card after the other."""

    def _repr_html_(self) -> str:
        columns: dict[str, list[Any]] = {
            "card": [run.card for run in self],
            "trial": [run.trial for run in self],
            "seen": [run.seen for run in self],
        }
        for key in ("mae", "rmse", "worst"):
            columns[f"{key} N"] = [run.measured[key] for run in self]
        return table_html("Free runs", columns)


def validate(
    cards: Card | Iterable[Card],
    trials: Trial | Iterable[Trial],
    *,
    thrust: Card | None = None,
    scale: float | None = None,
    height_offset_m: float | None = None,
) -> FreeRuns:
    """Judges cards on trials in free run, as the command ``touchdown validate`` does.

    Parameters
    ----------
    cards : Card or sequence of these
        The models.
    trials : Trial or sequence of these
        Of stands, force rigs or flights.
    thrust : Card, optional
        The card of the free-air thrust, which ground-effect cards need.
    scale, height_offset_m : float, optional
        Of flights: held at these values; else free in each armed interval.

    Returns
    -------
    FreeRuns
        A list of `FreeRun`, each card on each trial. What the command warns of is also a `SindyWarning`.
    """
    out = FreeRuns()
    given = [cards] if isinstance(cards, Card) else list(cards)
    logs = [trials] if isinstance(trials, Trial) else list(trials)
    if not given or not logs:
        raise fault("trials" if given else "cards", "at least one", "none")
    for card in given:
        for trial in logs:
            said, *run = _native.validate(
                card._native, trial._native, None if thrust is None else thrust._native, scale, height_offset_m
            )
            free_run = FreeRun(card.name, trial.name, *_parts(json.loads(said), run))
            if free_run.seen:
                text = f"{trial.name} is among the logs that {card.name} was fitted to: its errors there are not those on unseen data"
                warnings.warn(text, SindyWarning, stacklevel=2)
            for text in free_run.warnings:
                warnings.warn(f"{card.name} on {trial.name}: {text}", SindyWarning, stacklevel=2)
            out.append(free_run)
    return out


def _parts(said: dict[str, Any], run: list[Array]) -> list[Any]:
    figures = [said[key] for key in ("seen", "measured", "truth", "noise_floor")]
    return [*figures, *run, said["armed_intervals"], said["warnings"]]
