"""Figures as axes of matplotlib, which is imported only when a figure is asked for."""

from __future__ import annotations

import base64
import io
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray
from sindy._errors import fault

Array = NDArray[np.float64]


def axes(ax: Any) -> Any:
    """The axes that were given, or those of a new figure."""
    if ax is not None:
        return ax
    try:
        from matplotlib import pyplot
    except ImportError:
        raise ImportError("figures need matplotlib: pip install matplotlib") from None
    return pyplot.subplots()[1]


def picture(draw: Callable[[Any], Any]) -> str:
    """What is drawn into axes as an image in HTML; nothing without matplotlib."""
    try:
        from matplotlib.figure import Figure
    except ImportError:
        return ""
    figure, data = Figure(figsize=(7.2, 3.4), layout="constrained"), io.BytesIO()
    draw(figure.add_subplot())
    figure.savefig(data, format="svg")
    return f'<img src="data:image/svg+xml;base64,{base64.b64encode(data.getvalue()).decode()}">'


def points(columns: Mapping[str, Any]) -> list[tuple[str, NDArray[np.bool_]]]:
    """The controllers or points of a sweep in the table's order: a label, and which rows are theirs."""
    names = list(columns)
    settings = ["controller"] if "controller" in names else names[names.index("trial") + 1 : names.index("outcome")]
    rows = list(zip(*(columns[name] for name in settings))) if settings else [()] * len(columns["outcome"])
    out = []
    for point in dict.fromkeys(rows):
        values = [f"{value:g}" if isinstance(value, float) else str(value) for value in point]
        label = values[0] if settings == ["controller"] else ", ".join(f"{n} {v}" for n, v in zip(settings, values))
        out.append((label, np.array([row == point for row in rows])))
    return out


def shares(columns: Mapping[str, Any], column: str, ax: Any) -> Any:
    """The share of all landings of each point whose value is at most the abscissa."""
    numbers = [name for name in columns if np.asarray(columns[name]).dtype.kind in "iuf"]
    if column not in numbers:
        raise fault("column", "one of " + ", ".join(numbers), column)
    ax = axes(ax)
    for label, own in points(columns):
        values = np.asarray(columns[column][own], dtype=np.float64)
        finite = np.sort(values[np.isfinite(values)])
        # Landings without a value, such as those that did not land, count in the share and have no place on the abscissa.
        abscissa = np.concatenate([finite[:1], finite])
        share = np.arange(abscissa.size) / values.size
        ax.step(abscissa, share, where="post", label=f"{label} ({finite.size} of {values.size})".strip())
    ax.set(xlabel=column, ylabel="share of the landings", ylim=(0.0, 1.02))
    # More names than these hide the curves.
    if len(ax.lines) <= 8:
        ax.legend(loc="lower right", fontsize="small")
    return ax


def heights(trace: Mapping[str, Any], ax: Any) -> Any:
    """Heights of the vehicle and of the deck over time."""
    ax = axes(ax)
    space = "position_m" in trace
    vehicle = trace["position_m"][:, 2] if space else trace["vehicle_height_m"]
    deck = trace["deck_m"][:, 2] if space else trace["deck_height_m"]
    ax.plot(trace["time_s"], vehicle, label="vehicle")
    ax.plot(trace["time_s"], deck, label="deck")
    ax.set(xlabel="time (s)", ylabel="height (m)")
    ax.legend()
    return ax


def forces(time_s: Array, measured_n: Array, predicted_n: Array, title: str, ax: Any) -> Any:
    """A measured and a predicted force over time."""
    ax = axes(ax)
    ax.plot(time_s, measured_n, label="measured", linewidth=0.8, color="0.6")
    ax.plot(time_s, predicted_n, label="predicted")
    ax.set(xlabel="time (s)", ylabel="force (N)", title=title)
    ax.legend()
    return ax
