"""Tables: columns by name, and what other packages make of them."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from html import escape
from typing import Any

import numpy as np
from numpy.typing import NDArray

# Rows that a notebook shows; the rest are counted.
SHOWN = 20


def _texts(values: Any) -> list[Any] | None:
    """The texts of a column, None where absent; None for a column of numbers."""
    return values.tolist() if values.dtype == object else None


class Columns(Mapping[str, Any]):
    """Arrays by name, and what other packages make of them."""

    def to_pandas(self) -> Any:
        """A data frame of pandas."""
        import pandas

        return pandas.DataFrame(dict(self))

    def to_polars(self) -> Any:
        """A data frame of polars."""
        import polars

        # Without the type, a column whose texts are all absent would have none.
        texts = {name: _texts(values) for name, values in self.items()}
        typed = {n: self[n] if t is None else polars.Series(n, t, dtype=polars.String) for n, t in texts.items()}
        return polars.DataFrame(typed)

    def to_arrow(self) -> Any:
        """A table of Arrow."""
        import pyarrow

        texts = {name: _texts(values) for name, values in self.items()}
        return pyarrow.table({n: self[n] if t is None else pyarrow.array(t, pyarrow.string()) for n, t in texts.items()})

    def _repr_html_(self) -> str:
        return table_html(repr(self), self)


class Table(Columns):
    """A table as columns by name: arrays of numbers, NaN where absent, and of texts (``object``), None where absent.

    Examples
    --------
    >>> from touchdown import Table
    >>> table = Table({"outcome": ["landed", "crashed", "landed"], "v_l_mps": [0.1, 0.9, 0.2]})
    >>> table["v_l_mps"][table["outcome"] == "landed"]
    array([0.1, 0.2])
    """

    def __init__(self, columns: Mapping[str, Any]) -> None:
        self._columns = {name: as_column(values) for name, values in columns.items()}

    def __getitem__(self, column: str) -> NDArray[Any]:
        return self._columns[column]

    def __iter__(self) -> Iterator[str]:
        return iter(self._columns)

    def __len__(self) -> int:
        return len(self._columns)

    def __repr__(self) -> str:
        rows = len(next(iter(self._columns.values()), ()))
        return f"Table({rows} rows, {', '.join(self._columns)})"


def as_column(values: Any) -> NDArray[Any]:
    """A column as an array. Texts of NumPy's own kind have a fixed width and no absent value."""
    array = np.asarray(values)
    return array if array.dtype.kind in "biuf" else np.asarray(values, dtype=object)


def cell(value: Any) -> str:
    """A value as a cell of a table in HTML."""
    text = "" if value is None or value != value else f"{value:.5g}" if isinstance(value, float) else str(value)
    return f"<td>{escape(text)}</td>"


def table_html(caption: str, columns: Mapping[str, Any]) -> str:
    """A table in HTML."""
    head = "".join(f"<th>{escape(name)}</th>" for name in columns)
    rows = max((len(values) for values in columns.values()), default=0)
    body = "".join(
        "<tr>" + "".join(cell(values[k]) for values in columns.values()) + "</tr>" for k in range(min(rows, SHOWN))
    )
    more = f"<p>and {rows - SHOWN} rows more</p>" if rows > SHOWN else ""
    return f"<table><caption>{escape(caption)}</caption><tr>{head}</tr>{body}</table>{more}"
