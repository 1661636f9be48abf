"""Single landings in six degrees of freedom."""

from __future__ import annotations

import tempfile
import tomllib
from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

from sindy import _native
from sindy._errors import fault, needed, whole

from . import _plot
from ._card import Card
from ._land import Landings, Scenario, _given, card_files
from ._policy import Policy, policy_file
from ._table import table_html
from ._trial import Path


class Landing(Mapping[str, Any]):
    """One landing: its row of the table by the names of the columns (NaN or none where absent).

    Attributes
    ----------
    trial : int
        Which trial of the seed it is.
    outcome : str
        ``landed``, ``crashed``, ``tipped_over``, ``given_up`` or ``timed_out``; why stands in the column ``why``.
    """

    def __init__(self, native: _native.SpaceLandings, trial: int) -> None:
        self._all = Landings(native)
        self.trial = trial
        self.outcome = str(self["outcome"])

    def __getitem__(self, column: str) -> Any:
        value = self._all[column][0]
        return value.item() if isinstance(value, np.generic) else value

    def __iter__(self) -> Iterator[str]:
        return iter(self._all)

    def __len__(self) -> int:
        return len(self._all)

    @property
    def landed(self) -> bool:
        """Whether it landed."""
        return self.outcome == "landed"

    def trace(self) -> dict[str, Any]:
        """Its time series: arrays by name, vectors as (n, 3) or (n, 4). It is flown once more for it."""
        return self._all.trace(0)

    def plot_trace(self, ax: Any = None) -> Any:
        """The heights of vehicle and deck over time, as matplotlib axes."""
        return _plot.heights(self.trace(), ax)

    def _repr_html_(self) -> str:
        return _plot.picture(self.plot_trace) + table_html(repr(self), self._all)

    def __repr__(self) -> str:
        speed = self["v_l_mps"]
        touched = f", V_L {speed:.3f} m/s" if speed == speed else ""
        return f"Landing(trial {self.trial}: {self.outcome}{touched})"


class Space:
    """A vehicle, its deck and its weather in six degrees of freedom, whose landings are flown one by one.

    Parameters
    ----------
    deck : str, optional
        The scenario's name: ``still``, ``paper``, ``strong``, ``heave``, ``sea``; with a fault over the paper's deck
        ``tag_lost``, ``range_missing``, ``late``, ``late_unknown``, ``rotor``, ``gust``, ``nan``. By default what `settings` say.
    settings : path or mapping, optional
        The keys of ``touchdown settings campaign``, over the deck's: a TOML file, or nested dictionaries.
    thrust, empirical, dynamic : Card, optional
        The models that the controller flies with; a model without a card is the built-in one.
    controller : str, optional
        By default the scenario's.
    policy : path or Policy, optional
        A learned policy that flies the descents in the place of a controller.
    seed : int, optional
        Of all trials; by default that of `settings`, or 1.
    deck_acceleration : bool
        Whether the deck's acceleration is fed forward.

    Notes
    -----
    Trial *k* is the landing that `touchdown.land` with ``space=True`` flies in row *k* for the same scenario and seed.

    Examples
    --------
    >>> import touchdown as td
    >>> sea = td.Space("sea", {"scenario": {"turbulence": True}}, seed=3)
    >>> landing = sea.land(7)
    >>> landing.outcome, landing["v_l_mps"] < 0.3, landing.trace()["position_m"].shape[1]
    ('landed', True, 3)
    """

    def __init__(
        self,
        deck: str | None = None,
        settings: Scenario | None = None,
        *,
        thrust: Card | None = None,
        empirical: Card | None = None,
        dynamic: Card | None = None,
        controller: str | None = None,
        policy: Path | Policy | None = None,
        seed: int | None = None,
        deck_acceleration: bool = True,
    ) -> None:
        if policy is not None and controller is not None:
            raise fault("controller", "none beside a policy", controller)
        file, keys = _given(settings)
        self._policy = policy is not None
        with tempfile.TemporaryDirectory() as folder:
            paths = card_files(folder, thrust, empirical, dynamic)
            learned = policy_file(folder, policy)
            number = whole("seed", seed)
            self._native = _native.Space(deck, file, keys, paths, controller, learned, number, deck_acceleration)

    def land(self, trial: int = 0) -> Landing:
        """Flies the landing of a trial, whose vehicle, start, deck, air and noise are drawn from the seed."""
        number = needed("trial", trial)
        return Landing(self._native.land(number), number)

    @property
    def scenario(self) -> dict[str, Any]:
        """The scenario that is flown, with every key."""
        return tomllib.loads(self._native.scenario_toml())

    def __repr__(self) -> str:
        scenario = self.scenario
        controller = "policy" if self._policy else scenario["control"]["controller"]
        return f"Space({scenario['deck']['kind']!r} deck, {controller})"
