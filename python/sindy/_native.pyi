from typing import Any

import numpy as np
from numpy.typing import NDArray

_Array = NDArray[np.float64]
_Given = tuple[_Array, _Array, _Array | None, _Array | None]
_Term = tuple[str, float, float | None, float | None]
_Run = tuple[list[float], _Array, str | None]

__version__: str

class Library:
    @staticmethod
    def specification(text: str, variables: list[str]) -> Library: ...
    @staticmethod
    def of_terms(terms: list[str]) -> Library: ...
    @property
    def names(self) -> list[str]: ...
    @property
    def variables(self) -> list[str]: ...
    def to_latex(self) -> list[str]: ...
    def __len__(self) -> int: ...

class Model:
    @staticmethod
    def from_json(text: str) -> Model: ...
    def to_json(self) -> str: ...
    def to_latex(self, digits: int | None = None) -> str: ...
    def to_c(self, name: str) -> str: ...
    def to_rust(self, name: str) -> str: ...
    def text(self, digits: int) -> str: ...
    @property
    def states(self) -> list[str]: ...
    @property
    def inputs(self) -> list[str]: ...
    @property
    def period(self) -> float | None: ...
    @property
    def terms(self) -> list[list[_Term]]: ...
    def predict(self, x: _Array, u: _Array | None = None) -> _Array: ...
    def simulate(
        self,
        start: list[float],
        time: _Array,
        input_time: _Array,
        inputs: _Array | None,
        between_inputs: list[str],
        rtol: float,
        atol: float,
        step: float | None,
        blow_up: float,
    ) -> _Run: ...
    def iterate(self, start: list[float], steps: int, inputs: _Array | None, blow_up: float) -> _Run: ...
    def __reduce__(self) -> tuple[Any, tuple[str]]: ...

def identify(
    states: list[str],
    inputs: list[str],
    trajectories: list[_Given],
    libraries: list[Library],
    settings_json: str,
    jobs: int | None = None,
) -> tuple[Model, str]: ...
def fit_columns(
    states: list[str],
    inputs: list[str],
    groups: list[list[_Array]],
    weighted: bool,
    libraries: list[Library],
    solver_json: str,
    period: float | None = None,
    jobs: int | None = None,
) -> tuple[Model, str]: ...
def fit_slopes(
    states: list[str],
    inputs: list[str],
    trajectories: list[_Given],
    libraries: list[Library],
    smoothing_json: str,
    solver_json: str,
    jobs: int | None = None,
) -> tuple[Model, str]: ...
def fit_weak(
    states: list[str],
    inputs: list[str],
    trajectories: list[_Given],
    libraries: list[Library],
    solver_json: str,
    jobs: int | None = None,
) -> tuple[Model, str]: ...
def slopes(
    states: list[str],
    trajectories: list[_Given],
    smoothing_json: str,
    jobs: int | None = None,
) -> list[tuple[_Array, _Array]]: ...
