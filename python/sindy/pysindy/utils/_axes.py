"""The array with named axes that PySINDy's interface has."""

from __future__ import annotations

from typing import Any

import numpy as np


class AxesArray(np.ndarray[Any, Any]):
    """An array that keeps what it was told about its axes, in `axes`; nothing here heeds it.

    PySINDy's class follows axes through operations. Libraries here always take the last axis for variables, and the one before
    it for time.

    Parameters
    ----------
    input_array : array
    axes : dict
        Indices of axes by name, such as ``{"ax_time": 0, "ax_coord": 1}``.
    """

    axes: dict[str, Any]

    def __new__(cls, input_array: Any, axes: dict[str, Any]) -> AxesArray:
        out = np.asarray(input_array).view(cls)
        out.axes = axes
        return out

    def __array_finalize__(self, obj: Any) -> None:
        self.axes = getattr(obj, "axes", {})
