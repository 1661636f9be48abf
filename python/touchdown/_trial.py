"""Trials: logs as named columns over time."""

from __future__ import annotations

import os
import warnings
from collections.abc import Iterable, Iterator
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray
from sindy import SindyWarning, _native
from sindy._data import table, vector
from sindy._errors import fault

from ._table import Columns

Array = NDArray[np.float64]
Path = str | os.PathLike[str]


class Trial(Columns):
    """A recorded run: ``time_s`` and channels whose names end in their unit (``thrust_n``, ``height_m``), gaps as NaN.

    Parameters
    ----------
    columns : mapping or table
        Columns by name, ``time_s`` among them: a dictionary of arrays, or a table of pandas, polars or Arrow.
    name : str
        What messages call it.
    """

    def __init__(self, columns: Any, name: str = "trial") -> None:
        frame = table(columns)
        given: dict[str, ArrayLike]
        if frame is not None:
            given = {n: frame.column(n) for n in frame.names}
        else:
            given = dict(columns)
        if "time_s" not in given:
            raise fault("columns", "a column time_s", ", ".join(given) or "none")
        rows = int(np.size(given["time_s"]))
        own = {n: vector(n, values, rows) for n, values in given.items()}
        time = own.pop("time_s")
        self._native = _native.Trial.from_columns(name, time, list(own.items()))

    @classmethod
    def _of(cls, native: _native.Trial) -> Trial:
        out = cls.__new__(cls)
        out._native = native
        return out

    @property
    def name(self) -> str:
        """The name: that of the file."""
        return self._native.name

    @property
    def time_s(self) -> Array:
        """Times."""
        return self["time_s"]

    @property
    def warnings(self) -> list[str]:
        """What reading it found."""
        return self._native.warnings

    def __getitem__(self, channel: str) -> Array:
        if channel not in self:
            raise KeyError(channel)
        return self._native.channel(channel)

    def __contains__(self, channel: object) -> bool:
        return channel == "time_s" or channel in self._native.channels

    def __iter__(self) -> Iterator[str]:
        return iter(["time_s", *self._native.channels])

    def __len__(self) -> int:
        return 1 + len(self._native.channels)

    def __repr__(self) -> str:
        return f"Trial({self.name!r}, {len(self._native)} rows, {', '.join(self)})"


def read(paths: Path | Iterable[Path], map: Path | None = None) -> list[Trial]:
    """Reads logs: CSV, Parquet, PX4 ULog, ArduPilot DataFlash, MCAP, bags of ROS 1. The content decides the format.

    Parameters
    ----------
    paths : path or sequence of these
        The logs.
    map : path, optional
        How channels follow from the columns: a TOML file, or ``px4``, ``ardupilot``, ``ros`` or ``fly``. Without one a
        table needs our channel names, and a log with topics is read by the built-in map that fits it.

    Returns
    -------
    list of Trial
        One for each log. What readers warn of is also a `SindyWarning`.
    """
    given = [paths] if isinstance(paths, (str, os.PathLike)) else list(paths)
    out = []
    for path in given:
        trial = Trial._of(_native.Trial.read(os.fspath(path), None if map is None else os.fspath(map)))
        for text in trial.warnings:
            warnings.warn(text, SindyWarning, stacklevel=2)
        out.append(trial)
    return out
