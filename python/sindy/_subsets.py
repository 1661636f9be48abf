"""Best subsets and what is proven of them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any


@dataclass(frozen=True)
class Subset:
    """The best terms of one number.

    Attributes
    ----------
    coefficients : dict of float
        By term, by least squares.
    residual_sum : float
        Sum of squares of the residual, in the target's unit squared.
    lower_bound : float
        No subset of as many terms has a residual sum below this.
    gap : float
        What of the residual is not proven, as a share: 0 where the subset is proven.
    outcome : str
        ``optimal``, or why nothing is proven.
    """

    coefficients: dict[str, float]
    residual_sum: float
    lower_bound: float
    gap: float
    outcome: str

    @property
    def terms(self) -> list[str]:
        """The terms."""
        return list(self.coefficients)

    @property
    def proven(self) -> bool:
        """Whether no subset of as many terms is better."""
        return self.outcome == "optimal"


class Subsets(list[Subset]):
    """The best subset of every number of terms, that number its index.

    Attributes
    ----------
    outcome : str
        ``optimal`` if all of them are proven, or why not.
    nodes : int
        Nodes of the search.
    ridge : float
        Ridge on the scaled statistics during the search: 0 but for libraries that are nearly singular.
    """

    def __init__(self, said: dict[str, Any]) -> None:
        sizes = said["sizes"]
        super().__init__(
            Subset(
                dict(zip(one["terms"], one["coefficients"])),
                one["residual_sum"],
                one["lower_bound"],
                one["gap"],
                one["outcome"],
            )
            for one in sizes
        )
        self.outcome: str = said["outcome"]
        self.nodes: int = said["nodes"]
        self.ridge: float = said["ridge"]

    @property
    def proven(self) -> bool:
        """Whether all of them are proven."""
        return self.outcome == "optimal"


@dataclass(frozen=True)
class Certificate:
    """Given terms beside the best subset of as many terms.

    Attributes
    ----------
    coefficients : dict of float
        By term, by least squares.
    residual_sum : float
        Sum of squares of the residual.
    best : Subset
        The best subset of as many terms.
    """

    coefficients: dict[str, float]
    residual_sum: float
    best: Subset

    @property
    def is_best(self) -> bool:
        """Whether these terms are the best of their number, and that is proven."""
        return self.best.proven and set(self.coefficients) == set(self.best.coefficients)

    @property
    def excess(self) -> float:
        """By what share the residual could be less with other terms, at most: 0 for the best."""
        if self.is_best or self.residual_sum == 0.0:
            return 0.0
        return 1.0 - self.best.lower_bound / self.residual_sum
