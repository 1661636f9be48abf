"""Learned policies that fly in landings with sensors."""

from __future__ import annotations

import json
import os
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray
from sindy import _native
from sindy._errors import fault, real

from ._trial import Path

# Numbers of an observation; `touchdown.gym.OBSERVATION` names them.
_NUMBERS = 19


class Policy:
    """A learned policy: a network from observations of `touchdown.gym` to its actions.

    ``touchdown land --space --policy`` and `touchdown.land` fly it where a real vehicle would: it sees what the landing computer
    estimates from its sensors, and flies the descents. Approach, hover, go-arounds and touchdown remain the computer's.

    Parameters
    ----------
    layers : sequence of (weights, bias, activation)
        From the input to the action. `weights` has a row for each output, as ``torch.nn.Linear.weight`` has; `activation` is
        ``tanh``, ``relu`` or ``linear``. The action is what the last layer gives, within [-1, 1].
    action, decision_s, thrust_range, tilt_rad, rate_radps
        Those of the `touchdown.gym.LandingVectorEnv` that it was trained in.
    offset, scale : float or sequence
        One number for all of an observation, or 19: the input of the first layer is ``(observation - offset) * scale``.
    limit : float, optional
        Inputs beyond ±`limit` count as ±`limit`.

    Examples
    --------
    >>> import numpy as np, touchdown as td
    >>> sink = np.zeros((1, 19))
    >>> sink[0, 5] = -2.0                      # against the vertical velocity relative to the deck
    >>> policy = td.Policy([(sink, [-0.4], "linear")], action="thrust")
    >>> round(float(policy(np.zeros(19))[0]), 6)
    -0.4
    """

    def __init__(
        self,
        layers: Sequence[tuple[ArrayLike, ArrayLike, str]],
        *,
        action: str = "attitude",
        decision_s: float = 0.02,
        thrust_range: float = 0.5,
        tilt_rad: float = 0.25,
        rate_radps: float = 2.0,
        offset: ArrayLike = 0.0,
        scale: ArrayLike = 1.0,
        limit: float | None = None,
    ) -> None:
        ranges = {"thrust_range": thrust_range, "tilt_rad": tilt_rad, "rate_radps": rate_radps}
        settings: dict[str, Any] = {
            "schema": 1,
            "decision_s": real("decision_s", decision_s),
            "action": {"kind": str(action), **{key: real(key, value) for key, value in ranges.items()}},
            "input": {
                "offset": _each("offset", offset),
                "scale": _each("scale", scale),
                "limit": None if limit is None else real("limit", limit),
            },
            "layers": [],
        }
        self._native = _native.Policy(json.dumps(settings), [_layer(k, layer) for k, layer in enumerate(layers)])

    @classmethod
    def read(cls, path: Path) -> Policy:
        """A policy from its file."""
        policy = cls.__new__(cls)
        policy._native = _native.Policy.read(os.fspath(path))
        return policy

    def save(self, path: Path) -> None:
        """Writes the policy as JSON, whole or not at all."""
        self._native.save(os.fspath(path))

    @property
    def settings(self) -> dict[str, Any]:
        """What its file has."""
        out: dict[str, Any] = json.loads(self._native.json())
        return out

    def __call__(self, observations: ArrayLike) -> NDArray[np.float32]:
        """The actions for observations (n, 19), or the action for one (19,), within [-1, 1]."""
        rows = _numbers("observations", observations, 1 if np.ndim(observations) == 1 else 2)
        actions = self._native.actions(np.atleast_2d(rows)).astype(np.float32)
        return actions if rows.ndim == 2 else actions[0]

    def __reduce__(self) -> tuple[Any, ...]:
        return _restored, (self._native.json(),)

    def __repr__(self) -> str:
        settings = self.settings
        widths = [_NUMBERS, *(len(layer["bias"]) for layer in settings["layers"])]
        return f"Policy({' x '.join(map(str, widths))}, {settings['action']['kind']}, every {settings['decision_s']} s)"


def _restored(text: str) -> Policy:
    policy = Policy.__new__(Policy)
    policy._native = _native.Policy.from_json(text)
    return policy


def _numbers(key: str, values: ArrayLike, dimensions: int) -> NDArray[np.float64]:
    """An array of numbers of so many dimensions."""
    try:
        given = np.asarray(values)
        out = np.asarray(given if given.dtype.kind in "biuf" else None, dtype=float)
    except (TypeError, ValueError):
        raise fault(key, "real numbers, rows of one length", type(values).__name__) from None
    if out.ndim != dimensions or given.dtype.kind not in "biuf":
        raise fault(key, f"real numbers in {dimensions} dimensions", f"{given.ndim} of {given.dtype}")
    return np.ascontiguousarray(out)


def _layer(k: int, layer: Any) -> tuple[NDArray[np.float64], NDArray[np.float64], str]:
    """A layer as the library takes it."""
    try:
        weights, bias, activation = layer
    except (TypeError, ValueError):
        raise fault(f"layers.{k}", "weights, bias and activation", type(layer).__name__) from None
    key = f"layers.{k}"
    return _numbers(f"{key}.weights", weights, 2), _numbers(f"{key}.bias", bias, 1), str(activation)


def _each(key: str, values: ArrayLike) -> list[float]:
    """One number for each of an observation."""
    if np.ndim(values) == 0:
        return [real(key, values)] * _NUMBERS
    return [real(key, value) for value in _numbers(key, values, 1).tolist()]


def policy_file(folder: str, policy: Path | Policy | None) -> str | None:
    """The path of a policy, which is written into a folder if it has none."""
    if isinstance(policy, Policy):
        path = os.path.join(folder, "policy.json")
        policy.save(path)
        return path
    return None if policy is None else os.path.abspath(os.fsdecode(policy))
