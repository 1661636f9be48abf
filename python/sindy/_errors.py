"""Errors and warnings."""

from __future__ import annotations

import math
from numbers import Integral
from typing import Any

# Whole numbers of the library have 64 bits.
MOST = 2**64 - 1


class SindyError(ValueError):
    """A fault of the input or the settings.

    Attributes
    ----------
    key : str
        What is wrong: a setting, an argument, a column.
    expected : str
        What is allowed there.
    found : str
        What was given.

    Examples
    --------
    >>> import numpy as np, sindy
    >>> try:
    ...     sindy.SINDy(solver=sindy.STLSQ(threshold=-1.0)).fit(np.ones((9, 1)), 0.1)
    ... except sindy.SindyError as error:
    ...     print(error.key, "|", error.expected, "|", error.found)
    threshold | a finite number, at least 0 | -1
    """

    def __init__(
        self, message: str, key: str = "", expected: str = "", found: str = ""
    ) -> None:
        super().__init__(message)
        self.key = key
        self.expected = expected
        self.found = found

    def __reduce__(self) -> tuple[type[SindyError], tuple[str, str, str, str]]:
        return type(self), (str(self), self.key, self.expected, self.found)


class InternalError(RuntimeError):
    """A defect of the library itself, not a fault of the caller."""


class SindyWarning(UserWarning):
    """What a user should know of a fit."""


def whole(key: str, value: Any, least: int = 0) -> Any:
    """A whole number, as the library takes it; none where none is given."""
    if value is None:
        return None
    if isinstance(value, bool) or not isinstance(value, Integral) or int(value) < least:
        raise fault(key, f"a whole number from {least}", value)
    if int(value) > MOST:
        raise fault(key, f"a whole number up to {MOST}", value)
    return int(value)


def needed(key: str, value: Any, least: int = 0) -> int:
    """A whole number that has to be given."""
    if value is None:
        raise fault(key, f"a whole number from {least}", value)
    return int(whole(key, value, least))


def real(key: str, value: Any) -> float:
    """A finite number, of Python or NumPy."""
    try:
        number = float(value)
    except (TypeError, ValueError):
        number = math.nan
    if not math.isfinite(number) or isinstance(value, (str, bytes)):
        raise fault(key, "a finite number", value)
    return number


def fault(key: str, expected: str, found: object) -> SindyError:
    """The error of a fault in one argument."""
    return SindyError(f"`{key}`: expected {expected}, found {found}", key, expected, str(found))
