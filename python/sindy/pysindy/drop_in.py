"""Imports of ``pysindy`` after this one give ``sindy.pysindy``, those of its modules as well.

``import sindy.pysindy.drop_in`` as the first line of a script or notebook is the only change. PySINDy need not be installed.
Where it is, the same process cannot import it any more.

Examples
--------
>>> import sindy.pysindy.drop_in
>>> from pysindy.utils import lorenz
>>> import pysindy as ps
>>> ps.SINDy.__module__
'sindy.pysindy._core'
"""

from __future__ import annotations

import sys

_LAYER = __name__.rpartition(".")[0]


def _register() -> None:
    """Enters the layer's modules under PySINDy's names."""
    theirs = sys.modules.get("pysindy")
    if theirs is not None and theirs is not sys.modules[_LAYER]:
        raise ImportError(f"{__name__}: expected to be imported before pysindy, found pysindy imported from {theirs.__file__}")
    for name, module in list(sys.modules.items()):
        if name == _LAYER or name.startswith(f"{_LAYER}."):
            sys.modules["pysindy" + name.removeprefix(_LAYER)] = module


_register()
