"""Landings: of the vertical vehicle, and in six degrees of freedom."""

from __future__ import annotations

import json
import os
import tempfile
import warnings
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray
from sindy import SindyWarning, _native
from sindy._errors import fault, whole
from sindy._solvers import threads

from . import _plot
from ._card import Card
from ._policy import Policy, policy_file
from ._table import Table, as_column
from ._trial import Path

Scenario = Path | Mapping[str, Any]


class Landings(Table):
    """The table of landings, a row each, as columns by name: arrays of numbers (NaN where absent) and of texts (None where
    absent).

    Attributes
    ----------
    results : dict
        Figures of every controller or point, with the keys of the command's ``results.json``.
    scenario : str
        What was flown, as TOML.
    """

    def __init__(self, native: _native.SpaceLandings | _native.VerticalLandings) -> None:
        super().__init__(native.columns())
        self.results: dict[str, Any] = json.loads(native.results())
        # Landings in space are flown again for their series; those of the vertical vehicle keep theirs.
        self._vertical = native if isinstance(native, _native.VerticalLandings) else None
        self._space = native if isinstance(native, _native.SpaceLandings) else None
        self._traces = native.traces() if isinstance(native, _native.VerticalLandings) else {}
        self.scenario = native.sweep_toml() if isinstance(native, _native.SpaceLandings) else native.scenario_toml()

    @property
    def landed(self) -> NDArray[np.bool_]:
        """Whether each landing landed."""
        return np.asarray(self["outcome"] == "landed", dtype=bool)

    def trace(self, landing: int) -> dict[str, Any]:
        """The time series of one landing by its row: arrays by name, vectors as (n, 3) or (n, 4),
        texts such as the phase as ``object``.

        In six degrees of freedom the landing is flown once more for it.
        """
        row = whole("landing", landing)
        if self._space is None and row not in self._traces:
            raise fault("landing", "a landing that keeps its series: one of the first `traces` of its controller", row)
        series = self._traces[row] if self._space is None else self._space.trace(row)
        return {name: as_column(values) for name, values in series.items()}

    def plot(self, column: str = "v_l_mps", ax: Any = None) -> Any:
        """The distribution of a column, a line for each controller or point of the sweep.

        A line ends at the share of landings that have a value there: of ``v_l_mps``, those that touched down.

        Parameters
        ----------
        column : str
            A column of numbers; by default the speed at touchdown.
        ax : matplotlib axes, optional
            Where to draw; else a new figure.

        Returns
        -------
        matplotlib axes
        """
        return _plot.shares(self, column, ax)

    def plot_trace(self, landing: int, ax: Any = None) -> Any:
        """The heights of vehicle and deck in one landing (see `trace`), as matplotlib axes."""
        return _plot.heights(self.trace(landing), ax)

    def report(self, folder: Path | None = None, *, n_jobs: int | None = None) -> str:
        """Writes ``report.html`` and ``figures/`` into a folder, as the command does; the report's path.

        The worst landings in space are flown once more for it, and ``sweep.toml`` and the files that it names stand beside it.
        The settings of the vertical vehicle name no cards: those that were given have no file.
        """
        if folder is None:
            raise fault("folder", "the folder for the report", None)
        at = os.fsdecode(folder)
        if self._space is not None:
            self._space.report(at, threads(n_jobs))
        elif self._vertical is not None:
            self._vertical.report(at)
        else:
            raise fault("landings", "vertical landings as `land` returned them, for copies have no report", "a copy")
        return os.path.join(os.path.abspath(at), "report.html")

    def __getstate__(self) -> dict[str, Any]:
        return {**self.__dict__, "_vertical": None}

    def _repr_html_(self) -> str:
        drawn = _plot.picture(lambda ax: self.plot(ax=ax)) if len(self.landed) else ""
        return drawn + super()._repr_html_()

    def __repr__(self) -> str:
        return f"Landings({len(self.landed)} landings, {int(self.landed.sum())} landed)"


def _given(scenario: Scenario | None) -> tuple[str | None, str | None]:
    """A file, or keys in JSON."""
    if scenario is None:
        return None, None
    if isinstance(scenario, Mapping):
        return None, json.dumps(dict(scenario), default=_plain)
    return os.fspath(scenario), None


def _plain(value: Any) -> Any:
    """Numbers and arrays of NumPy, and paths, as JSON has them."""
    if isinstance(value, (np.generic, np.ndarray)):
        return value.tolist()
    if isinstance(value, os.PathLike):
        return os.fspath(value)
    raise fault("scenario", "numbers, texts, lists and dictionaries", type(value).__name__)


def card_files(folder: str, thrust: Card | None, empirical: Card | None, dynamic: Card | None) -> list[str | None]:
    """Writes the cards that are given into a folder: their paths."""
    paths: list[str | None] = []
    for name, card in (("thrust", thrust), ("empirical", empirical), ("dynamic", dynamic)):
        path = os.path.join(folder, f"{name}.toml")
        if card is not None:
            card.save(path)
        paths.append(None if card is None else path)
    return paths


def land(
    scenario: Scenario | None = None,
    *,
    thrust: Card | None = None,
    empirical: Card | None = None,
    dynamic: Card | None = None,
    controllers: Sequence[str] = (),
    policy: Path | Policy | None = None,
    trials: int | None = None,
    seed: int | None = None,
    space: bool = False,
    deck_acceleration: bool = True,
    traces: int = 5,
    n_jobs: int | None = None,
) -> Landings:
    """Flies landings as the command ``touchdown land`` does: the same figures for the same scenario, cards and seed.

    Parameters
    ----------
    scenario : path or mapping, optional
        The keys of ``touchdown settings land`` (with `space`, of ``touchdown settings campaign``): a TOML file, or nested
        dictionaries. Without it, the paper's oscillating deck.
    thrust, empirical, dynamic : Card, optional
        The models that the controllers fly with. The vertical vehicle needs `thrust`; `empirical` (form ``empirical``) and
        `dynamic` (any ground-effect form) are for the controllers of these names. In space a model without a card is the
        built-in one.
    controllers : sequence of str, optional
        Default: for the vertical vehicle those whose cards are given, in space the scenario's.
    policy : path or Policy, optional
        In space, a learned policy whose descents are flown beside those of the controllers, as controller ``policy``.
    trials, seed : int, optional
        Those of the scenario if not given.
    space : bool
        Six degrees of freedom with all sensors, in place of the vertical vehicle.
    deck_acceleration : bool
        Whether the deck's acceleration is fed forward.
    traces : int
        Landings of each controller whose time series are kept (vertical vehicle).
    n_jobs : int, optional
        Threads; the results are the same for any number.

    Examples
    --------
    >>> import touchdown as td
    >>> landings = td.land({"scenario": {"timeout_s": 30.0}}, space=True, trials=2, seed=3)
    >>> landings
    Landings(2 landings, 2 landed)
    >>> sorted(landings)[:3]
    ['abort_reasons', 'aborts', 'before_descent_s']
    >>> landings.trace(0)["position_m"].shape[1]
    3
    """
    file, keys = _given(scenario)
    jobs = threads(n_jobs)
    trials, seed, traces = whole("trials", trials, 1), whole("seed", seed), whole("traces", traces)
    names = [controllers] if isinstance(controllers, str) else list(controllers)
    if not space:
        if policy is not None:
            raise fault("policy", "none without `space=True`", type(policy).__name__)
        if thrust is None:
            raise fault("thrust", "the thrust card that the controllers fly with", "none")
        if not names and file is None and not (isinstance(scenario, Mapping) and "controllers" in scenario):
            names = ["feedback", "imbc", "ssc"]
            names += [name for name, card in (("empirical", empirical), ("dynamic", dynamic)) if card is not None]
        flown = _native.land_vertically(
            file,
            keys,
            thrust._native,
            None if empirical is None else empirical._native,
            None if dynamic is None else dynamic._native,
            names,
            trials,
            seed,
            deck_acceleration,
            traces,
            jobs,
        )
        for text in flown.warnings:
            warnings.warn(text, SindyWarning, stacklevel=2)
        return Landings(flown)
    # A sweep names its cards by their files.
    with tempfile.TemporaryDirectory() as folder:
        paths = card_files(folder, thrust, empirical, dynamic)
        learned = policy_file(folder, policy)
        return Landings(_native.land_in_space(file, keys, paths, names, learned, trials, seed, deck_acceleration, jobs))
