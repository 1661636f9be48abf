"""The paper's experiments: runs of ``touchdown reproduce``."""

from __future__ import annotations

import csv
import json
import os
from collections.abc import Callable
from typing import Any

import numpy as np
from sindy import _native
from sindy._errors import fault, whole
from sindy._solvers import threads

from ._campaign import _place
from ._card import Card
from ._land import Scenario, _given
from ._table import Table
from ._trial import Path, Trial, read

Stages = Callable[[str, int, int], object]

_TEXTS = ("experiment", "method", "case", "how", "outcome", "why", "abort_reasons")


class Reproduction:
    """A run of the paper's experiments, read from its folder.

    Attributes
    ----------
    folder : str
        Where its files are.
    results : dict
        All figures: ``results.json``.
    """

    def __init__(self, folder: Path) -> None:
        self.folder = os.path.abspath(os.fspath(folder))
        path = self._path("results.json")
        if not os.path.isfile(path):
            raise fault("folder", "a folder of `touchdown reproduce` with its results.json", self.folder)
        with open(path, encoding="utf-8") as file:
            self.results: dict[str, Any] = json.load(file)

    def _path(self, *names: str) -> str:
        return os.path.join(self.folder, *names)

    @property
    def landings(self) -> Table:
        """Each landing of the vertical vehicle, on the ground and on the deck: ``experiment``, ``method``, ``outcome``, …"""
        return _table(self._path("landings.csv"))

    @property
    def sea(self) -> Table:
        """Each landing in six degrees of freedom: ``case``, ``how``, ``outcome``, …"""
        return _table(self._path("sea.csv"))

    @property
    def errors(self) -> Table:
        """Errors (N) of each model on each kind of validation trial: ``experiment``, ``data``, ``model``, ``trial``,
        ``mae_n``, ``worst_n``, ``raw_mae_n``."""
        of = {
            "thrust": ("plate_removed", "plate_present"),
            "ground_effect": ("paper_data", "rich_data"),
        }
        rows = [
            {"experiment": experiment, "data": data, "model": model, "trial": trial, **figures}
            for experiment, sets in of.items()
            for data in sets
            for model, trials in self.results[experiment][data].items()
            for trial, figures in trials.items()
        ]
        return Table({name: [_number(row[name]) for row in rows] for name in rows[0]})

    @property
    def cards(self) -> dict[str, Card]:
        """Each identified model by its name, and the paper's two as ``paper-eq11`` and ``paper-eq12``."""
        names = sorted(os.listdir(self._path("cards")))
        return {os.path.splitext(name)[0]: Card.load(self._path("cards", name)) for name in names}

    @property
    def trial_sets(self) -> list[str]:
        """The sets of trials that the virtual rig recorded."""
        return sorted(os.listdir(self._path("trials")))

    def trials(self, of: str) -> list[Trial]:
        """The trials of one set."""
        if of not in self.trial_sets:
            raise fault("of", "one of " + ", ".join(self.trial_sets), of)
        return read([self._path("trials", of, name) for name in sorted(os.listdir(self._path("trials", of)))])

    @property
    def figures(self) -> dict[str, str]:
        """Each figure as SVG, by its name. A PNG of each lies beside it in ``figures/``."""
        names = sorted(os.listdir(self._path("figures")))
        return {stem: _text(self._path("figures", name)) for name in names for stem, end in [os.path.splitext(name)] if end == ".svg"}

    @property
    def report(self) -> str:
        """The path of the report, which needs no other file."""
        return self._path("report.html")

    @property
    def html(self) -> str:
        """The report as one HTML document."""
        return _text(self.report)

    @property
    def settings(self) -> str:
        """What redoes the run, as TOML."""
        return _text(self._path("settings.toml"))

    def __repr__(self) -> str:
        quick = ", quick" if self.results["quick"] else ""
        return f"Reproduction(seed {self.results['seed']}, {self.results['trials']} landings of each method{quick})"


def reproduce(
    out: Path,
    settings: Scenario | None = None,
    *,
    quick: bool = False,
    trials: int | None = None,
    seed: int | None = None,
    progress: Stages | None = None,
    n_jobs: int | None = None,
) -> Reproduction:
    """Runs the paper's experiments as the command ``touchdown reproduce`` does: the same files, with the same bytes.

    Parameters
    ----------
    out : path
        The folder. Its ``results.json`` is written last.
    settings : path or mapping, optional
        The keys of ``touchdown settings reproduce``: a TOML file, or nested dictionaries.
    quick : bool
        Fewer rig trials, and without `settings` fewer landings.
    trials, seed : int, optional
        Landings of each method, and the seed of all random numbers; those of the settings if not given.
    progress : callable, optional
        Called with the stage, its steps that are done and its steps, some twenty times a second. What it raises ends the
        run.
    n_jobs : int, optional
        Threads; the bytes are the same for any number.

    Returns
    -------
    Reproduction
        `results`, tables, cards, trials, figures and the report. ``Reproduction(folder)`` reads it again.
    """
    file, keys = _given(settings)
    folder = _place(out)
    trials, seed = whole("trials", trials, 1), whole("seed", seed)
    _native.reproduce(file, keys, folder, quick, trials, seed, threads(n_jobs), progress)
    return Reproduction(folder)


def _text(path: str) -> str:
    with open(path, encoding="utf-8", newline="") as file:
        return file.read()


def _number(value: Any) -> Any:
    return np.nan if value is None else value


def _table(path: str) -> Table:
    """A table of the folder: its texts are None where absent, its numbers NaN; numbers without any are integers."""
    with open(path, encoding="utf-8", newline="") as file:
        rows = csv.reader(file)
        names = next(rows)
        columns = dict(zip(names, zip(*rows)))
    return Table({name: _cells(name, values) for name, values in columns.items()})


def _cells(name: str, cells: tuple[str, ...]) -> list[Any]:
    if name in _TEXTS:
        return [cell or None for cell in cells]
    if all(cell.lstrip("-").isdigit() for cell in cells):
        return [int(cell) for cell in cells]
    return [float(cell) if cell else np.nan for cell in cells]
