"""Columns by name as tables of other packages."""

from __future__ import annotations

from collections.abc import Mapping
from html import escape
from typing import Any

# Rows that a notebook shows; the rest are counted.
SHOWN = 20


def frame_pandas(columns: Mapping[str, Any]) -> Any:
    """A data frame of pandas."""
    import pandas

    return pandas.DataFrame(dict(columns))


def frame_polars(columns: Mapping[str, Any]) -> Any:
    """A data frame of polars."""
    import polars

    return polars.DataFrame(dict(columns))


def table_arrow(columns: Mapping[str, Any]) -> Any:
    """A table of Arrow."""
    import pyarrow

    return pyarrow.table(dict(columns))


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
