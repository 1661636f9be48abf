"""The best terms of a given number."""

from __future__ import annotations

import time
import warnings
from typing import Any

import numpy as np
from sklearn.exceptions import ConvergenceWarning

from ..._data import Array
from ._base import BaseOptimizer


class MIOSR(BaseOptimizer):
    """The terms of a given number with the smallest ridge error, by branch and bound: no solver of others is needed.

    Constraints are not there.

    Parameters
    ----------
    target_sparsity : int, optional
        Terms of all equations together.
    group_sparsity : list of int, optional
        Terms of each equation at most; with ``target_sparsity=None`` exactly these numbers are searched.
    alpha : float
        Ridge.
    regression_timeout : float
        Seconds for each equation; after them the best found so far is taken, with a warning.
    constraint_lhs, constraint_rhs
        Have to be None.
    constraint_order, verbose
        There for compatibility.
    normalize_columns, copy_X, initial_guess, unbias
        As for `BaseOptimizer`.
    """

    _starts = False

    def __init__(
        self,
        target_sparsity: int | None = 5,
        group_sparsity: Any = None,
        alpha: float = 0.01,
        regression_timeout: float = 10,
        constraint_lhs: Any = None,
        constraint_rhs: Any = None,
        constraint_order: str = "target",
        normalize_columns: bool = False,
        copy_X: bool = True,
        initial_guess: Any = None,
        verbose: bool = False,
        unbias: bool = False,
    ) -> None:
        self.target_sparsity = target_sparsity
        self.group_sparsity = group_sparsity
        self.alpha = alpha
        self.regression_timeout = regression_timeout
        self.constraint_lhs = constraint_lhs
        self.constraint_rhs = constraint_rhs
        self.constraint_order = constraint_order
        self.verbose = verbose
        super().__init__(20, normalize_columns, initial_guess, copy_X, unbias)

    def _check(self) -> None:
        size = self.target_sparsity
        if size is not None and (not isinstance(size, (int, np.integer)) or size < 1):
            raise ValueError(f"target_sparsity: expected a whole number of at least 1, found {size}")
        if size is None and self.group_sparsity is None:
            raise ValueError("target_sparsity, group_sparsity: expected one of them, found neither")
        if self.alpha < 0:
            raise ValueError(f"alpha: expected at least 0, found {self.alpha}")
        if self.constraint_order not in ("target", "feature"):
            raise ValueError(f"constraint_order: expected target or feature, found {self.constraint_order}")
        if self.constraint_lhs is not None or self.constraint_rhs is not None:
            raise ValueError("constraint_lhs, constraint_rhs: expected None; ConstrainedSR3 has constraints")

    def _reduce(self, x: Array, y: Array) -> None:
        terms, targets = x.shape[1], y.shape[1]
        most = [terms] * targets if self.group_sparsity is None else [min(int(n), terms) for n in self.group_sparsity]
        if len(most) != targets:
            raise ValueError(f"group_sparsity: expected {targets} numbers, found {len(most)}")
        total = sum(most) if self.target_sparsity is None else int(self.target_sparsity)
        gram = x.T @ x + self.alpha * np.eye(terms)
        fronts = []
        for i in range(targets):
            search = _Search(gram, x.T @ y[:, i], min(most[i], total), time.monotonic() + self.regression_timeout)
            search.run()
            if search.late:
                warnings.warn(f"MIOSR: no proof in {self.regression_timeout} s; the best found is taken", ConvergenceWarning)
            fronts.append(search.best)
        self.coef_ = np.zeros((targets, terms))
        for i, size in enumerate(_shares([[gain for gain, _ in front] for front in fronts], total)):
            kept = list(fronts[i][size][1])
            if kept:
                self.coef_[i, kept] = np.linalg.solve(gram[np.ix_(kept, kept)], x[:, kept].T @ y[:, i])


def _shares(gains: list[list[float]], total: int) -> list[int]:
    """How many terms each equation gets so that the sum of gains is largest."""
    best: list[tuple[float, list[int]]] = [(0.0, [])] * (total + 1)
    for front in gains:
        step = []
        for have in range(total + 1):
            options = [(best[have - n][0] + front[n], [*best[have - n][1], n]) for n in range(min(have, len(front) - 1) + 1)]
            step.append(max(options, key=lambda option: option[0]))
        best = step
    return best[total][1]


class _Search:
    """Branch and bound over supports: the largest decrease ``bᵀ G⁻¹ b`` for every number of terms up to a largest one."""

    def __init__(self, gram: Array, right: Array, largest: int, end: float) -> None:
        self.gram, self.right, self.largest, self.end = gram, right, largest, end
        self.best: list[tuple[float, tuple[int, ...]]] = [(0.0, ())] * (largest + 1)
        self.late = False

    def gain(self, support: list[int]) -> float:
        """The decrease of the squared error by these terms."""
        if not support:
            return 0.0
        right = self.right[support]
        block = self.gram[np.ix_(support, support)]
        try:
            return float(right @ np.linalg.solve(block, right))
        except np.linalg.LinAlgError:  # equal columns without ridge
            return float(right @ np.linalg.lstsq(block, right, rcond=None)[0])

    def keep(self, support: list[int]) -> None:
        gain = self.gain(support)
        if gain > self.best[len(support)][0]:
            self.best[len(support)] = (gain, tuple(support))

    def run(self) -> None:
        """A greedy start in both directions, then the proof."""
        count = len(self.right)
        chosen: list[int] = []
        for _ in range(self.largest):
            rest = [k for k in range(count) if k not in chosen]
            chosen = [*chosen, max(rest, key=lambda k: self.gain([*chosen, k]))]
            self.keep(chosen)
        kept = list(range(count))
        while len(kept) > 1:
            kept = max(([k for k in kept if k != gone] for gone in kept), key=self.gain)
            if len(kept) <= self.largest:
                self.keep(kept)
        # Terms in the order in which they matter, so that good supports come first.
        order = sorted(range(count), key=lambda k: -self.gain([k]))
        self.branch([], order)

    def branch(self, taken: list[int], free: list[int]) -> None:
        """Supports that hold `taken` and any of `free`."""
        if self.late or not free or len(taken) == self.largest:
            return
        if time.monotonic() > self.end:
            self.late = True
            return
        bound = self.gain([*taken, *free])
        sizes = range(len(taken) + 1, min(self.largest, len(taken) + len(free)) + 1)
        if all(bound <= self.best[n][0] for n in sizes):
            return
        first, rest = free[0], free[1:]
        self.keep([*taken, first])
        self.branch([*taken, first], rest)
        self.branch(taken, rest)
