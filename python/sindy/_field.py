"""Partial differential equations from fields on a grid."""

from __future__ import annotations

import json
import warnings
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from . import _native
from ._data import Array, floats
from ._errors import SindyWarning, fault
from ._solvers import dumps, threads

Measurement = tuple[list[Any], list[tuple[str, Array]]]


class PDE:
    """The equations behind fields that were measured on a grid of time and space: ``u_t = 0.1*u_xx - 0.5*(u^2)_x``.

    Weak form with windows from the data; the bias of white noise is taken away. No derivative of the data is needed.

    Parameters
    ----------
    degree : int
        Highest degree of products of fields, 1 to 8.
    order : int, optional
        Highest order of derivatives in space: 4 in one dimension, 2 in more.
    terms : sequence of str, optional
        Candidates in place of all those of ``degree`` and ``order``: ``"1"``, ``"u^2*v"``, ``"u_xx"``, ``"(u^2)_x"``.
    time_order : {1, 2}
        Order of the derivative in time on the left side; 2 for waves.
    half_widths : sequence of float, optional
        Half-widths of the windows along the axes, time first, in their units. From the data by default.
    n_jobs : int, optional
        Threads; as many as processors by default.

    Attributes
    ----------
    terms_ : dict
        For each field a list of its terms: ``term``, ``coefficient``, ``std_error``, ``interval`` (95 %), ``inclusion``.
    quality_ : dict
        For each field ``noise``, ``misfit`` (residual over that which noise explains), ``unexplained``, ``front``.
    windows_, independent_ : int, float
        Windows without missing samples, and about how many of them are independent.
    warnings_ : list of str
        What qualifies the numbers. Each was also a `SindyWarning`.

    Examples
    --------
    >>> import numpy as np, sindy
    >>> t, x = np.arange(0, 3, 0.05), np.arange(0, 8, 0.1)
    >>> T, X = np.meshgrid(t, x, indexing="ij")
    >>> u = np.exp(-0.1 * T) * np.sin(X) + np.exp(-0.4 * T) * np.cos(2 * X)
    >>> model = sindy.PDE(degree=2, order=3).fit(u, {"t": t, "x": x})
    >>> model.print()
    u_t = 0.100*u_xx
    """

    def __init__(
        self,
        *,
        degree: int = 3,
        order: int | None = None,
        terms: Sequence[str] | None = None,
        time_order: int = 1,
        half_widths: Sequence[float] | None = None,
        n_jobs: int | None = None,
    ) -> None:
        self.degree, self.order, self.terms = degree, order, terms
        self.time_order, self.half_widths, self.n_jobs = time_order, half_widths, n_jobs

    def fit(self, fields: Any, axes: Any) -> PDE:
        """Finds the equations.

        Parameters
        ----------
        fields : dict of arrays, array, or a list of these
            Values by field name, with one axis of the array for each of ``axes`` in their order; an array alone is ``u``.
            NaN marks missing samples. A list holds several measurements of the same fields.
        axes : dict, or a list of these
            Coordinates by axis name, or the step from point to point; the axis of time first. One dict serves all
            measurements.
        """
        measured = list(fields) if isinstance(fields, (list, tuple)) else [fields]
        each = list(axes) if isinstance(axes, (list, tuple)) else [axes] * len(measured)
        if len(each) != len(measured):
            raise fault("axes", f"one dict, or one for each of {len(measured)} measurements", len(each))
        settings = {
            "degree": self.degree,
            "order": self.order,
            "terms": None if self.terms is None else [str(term) for term in self.terms],
            "time_order": self.time_order,
            "half_widths": None if self.half_widths is None else [float(width) for width in self.half_widths],
        }
        data = [_measurement(one, own) for one, own in zip(measured, each)]
        model = _native.identify_fields(data, dumps(settings), threads(self.n_jobs))
        said = json.loads(model.to_json())
        names = [equation["field"] for equation in said["equations"]]
        self.model_ = model
        self.terms_ = {name: equation["terms"] for name, equation in zip(names, said["equations"])}
        self.quality_ = dict(zip(names, said["fits"]))
        self.half_widths_: list[list[float]] = said["half_widths"]
        self.windows_: int = said["windows"]
        self.independent_: float = said["independent"]
        self.warnings_: list[str] = said["warnings"]
        for text in self.warnings_:
            warnings.warn(text, SindyWarning, stacklevel=2)
        return self

    def _fitted(self) -> _native.FieldEquations:
        model: _native.FieldEquations | None = getattr(self, "model_", None)
        if model is None:
            raise fault("model", "equations (call `fit` first)", "none")
        return model

    def equations(self, precision: int = 3) -> list[str]:
        """One line for each field."""
        if not isinstance(precision, int) or precision < 1:
            raise fault("precision", "a number of digits of at least 1", repr(precision))
        return self._fitted().text(precision)

    def print(self, precision: int = 3, **options: Any) -> None:
        """Prints the equations; options are those of Python's own `print`."""
        print("\n".join(self.equations(precision)), **options)

    def _repr_markdown_(self) -> str | None:
        if getattr(self, "model_", None) is None:
            return None
        lines = [f"    {line}" for line in self.equations(5)]
        lines += ["", "| field | term | coefficient | ± | 95 % |", "| --- | --- | --- | --- | --- |"]
        for field, terms in self.terms_.items():
            for term in terms:
                low, high = term["interval"]
                numbers = f"{term['coefficient']:.5g} | {term['std_error']:.2g} | {low:.5g} to {high:.5g}"
                lines.append(f"| {field} | `{term['term']}` | {numbers} |")
        lines += [""] + [f"- {text}" for text in self.warnings_]
        return "\n".join(lines)


def _measurement(fields: Any, axes: Any) -> Measurement:
    if not isinstance(axes, Mapping):
        raise fault("axes", "a dict of coordinates or steps by name, time first", type(axes).__name__)
    named = fields if isinstance(fields, Mapping) else {"u": fields}
    if not named:
        raise fault("fields", "at least one field", "none")
    arrays = {str(name): floats(str(name), values, "an array of numbers") for name, values in named.items()}
    shape = next(iter(arrays.values())).shape
    if len(shape) != len(axes):
        raise fault("axes", f"one for each of the {len(shape)} dimensions of the fields", ", ".join(map(str, axes)))
    for name, array in arrays.items():
        if array.shape != shape:
            raise fault(name, f"the shape of the other fields, {shape}", array.shape)
    along: list[Any] = []
    for (name, given), points in zip(axes.items(), shape):
        values = floats(str(name), given, "coordinates, or the step from point to point")
        if values.ndim == 0:
            along.append((str(name), float(values), points))
        elif values.shape == (points,):
            along.append((str(name), values.tolist()))
        else:
            raise fault(str(name), f"{points} coordinates, or a step", f"an array of shape {values.shape}")
    return along, [(name, np.ascontiguousarray(array).reshape(-1)) for name, array in arrays.items()]
