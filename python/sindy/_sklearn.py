"""What scikit-learn asks of an estimator, without importing it before it asks."""

from __future__ import annotations

import copy
import inspect
from typing import Any, TypeVar

from ._errors import fault

Self = TypeVar("Self", bound="Estimator")


class Estimator:
    """Parameters, cloning and metadata routing in scikit-learn's way.

    Every parameter of ``__init__`` is an attribute of the same name.
    """

    @classmethod
    def _names(cls) -> list[str]:
        return [name for name in inspect.signature(cls).parameters]

    def get_params(self, deep: bool = True) -> dict[str, Any]:
        """The parameters by name; those of the solver as ``solver__…``."""
        out = {name: getattr(self, name) for name in self._names()}
        if deep:
            for name, value in list(out.items()):
                if hasattr(value, "get_params"):
                    out |= {f"{name}__{k}": v for k, v in value.get_params().items()}
        return out

    def set_params(self: Self, **params: Any) -> Self:
        """Sets parameters by name."""
        own = self._names()
        inner: dict[str, dict[str, Any]] = {}
        for name, value in params.items():
            outer, _, rest = name.partition("__")
            if outer not in own:
                raise fault("set_params", "one of " + ", ".join(own), name)
            if rest:
                inner.setdefault(outer, {})[rest] = value
            else:
                setattr(self, outer, value)
        for outer, values in inner.items():
            part = getattr(self, outer)
            if not hasattr(part, "set_params"):
                raise fault("set_params", f"a `{outer}` with parameters", part)
            part.set_params(**values)
        return self

    def __repr__(self) -> str:
        signature = inspect.signature(type(self)).parameters
        changed = [f"{n}={getattr(self, n)!r}" for n, p in signature.items() if getattr(self, n) is not p.default]
        return f"{type(self).__name__}({', '.join(changed)})"

    def _request(self: Self, method: str, given: dict[str, Any]) -> Self:
        allowed = [n for n in inspect.signature(getattr(self, method)).parameters if n != "x"]
        for name in given:
            if name not in allowed:
                raise fault(f"set_{method}_request", "one of " + ", ".join(allowed), name)
        requests: dict[str, dict[str, Any]] = copy.deepcopy(getattr(self, "_metadata_requests", {}))
        requests.setdefault(method, {}).update(given)
        self._metadata_requests = requests
        self._metadata_request = self.get_metadata_routing()
        return self

    def set_fit_request(self: Self, **given: bool | str | None) -> Self:
        """Which of ``t``, ``u``, ``x_dot``, … a meta-estimator is to pass to `fit`."""
        return self._request("fit", given)

    def set_score_request(self: Self, **given: bool | str | None) -> Self:
        """Which of ``t``, ``u``, ``x_dot``, … a meta-estimator is to pass to `score`."""
        return self._request("score", given)

    def set_predict_request(self: Self, **given: bool | str | None) -> Self:
        """Which arguments a meta-estimator is to pass to `predict`."""
        return self._request("predict", given)

    def get_metadata_routing(self) -> Any:
        """The requests as scikit-learn's own object."""
        from sklearn.utils.metadata_routing import MetadataRequest

        kept = getattr(self, "_metadata_request", None)
        requests = getattr(self, "_metadata_requests", None)
        if requests is None and kept is not None:  # a clone
            return copy.deepcopy(kept)
        routing = MetadataRequest(owner=type(self).__name__)
        for method in ("fit", "score", "predict"):
            names = [n for n in inspect.signature(getattr(self, method)).parameters if n != "x"]
            given = (requests or {}).get(method, {})
            for name in names:
                getattr(routing, method).add_request(param=name, alias=given.get(name))
        return routing

    def __sklearn_tags__(self) -> Any:
        from sklearn.utils import InputTags, RegressorTags, Tags, TargetTags

        return Tags(
            estimator_type=None,
            target_tags=TargetTags(required=False),
            transformer_tags=None,
            regressor_tags=RegressorTags(),
            classifier_tags=None,
            input_tags=InputTags(allow_nan=True),
        )
