"""Simulations."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from ._data import Array


@dataclass
class Run:
    """A simulation.

    Attributes
    ----------
    t : ndarray
        The times that were reached.
    x : ndarray
        The states there, one row for each time.
    outcome : str
        ``finished``, or why the run ended early.
    """

    t: Array
    x: Array
    outcome: str

    @property
    def finished(self) -> bool:
        """Whether all times were reached."""
        return self.outcome == "finished"

    def __array__(self, dtype: Any = None, copy: bool | None = None) -> Array:
        return np.asarray(self.x, dtype=dtype)

    @classmethod
    def of(cls, row: tuple[list[float], Array, str | None]) -> Run:
        """What the library returns: times, states, and why it ended early."""
        return cls(np.asarray(row[0]), row[1], row[2] or "finished")
