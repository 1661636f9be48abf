"""Terms of a quadratic library, and when a quadratic part keeps the energy."""

from __future__ import annotations

from collections.abc import Iterable
from itertools import combinations, permutations
from typing import Any

import numpy as np

from ..._data import Array
from ..feature_library import PolynomialLibrary

# A term of a library: its place, and the exponent of each state.
Term = tuple[int, Any]


def _places(polyterms: list[Term]) -> tuple[dict[int, int], dict[int, int], dict[frozenset[int], int]]:
    """The places of linear terms by their state, of squares by their state, and of products by their two states."""
    linear, squares, products = {}, {}, {}
    for place, exponents in polyterms:
        states = [int(k) for k in np.flatnonzero(exponents)]
        if np.sum(exponents) == 1:
            linear[states[0]] = place
        elif np.sum(exponents) == 2 and len(states) == 1:
            squares[states[0]] = place
        elif np.sum(exponents) == 2:
            products[frozenset(states)] = place
    return linear, squares, products


def _energy_rows(
    n_tgts: int,
    n_terms: int,
    pure_terms: dict[int, int],
    mixed_terms: dict[frozenset[int], int],
    monomials: Iterable[tuple[int, int, int]],
) -> Array:
    """For cubic monomials ``x_i x_j x_k``, their coefficients in the growth of energy ``Σ x_t x_t'``, linear in the model's.

    State t times its own equation has the monomial where that equation has the term of the two other states.
    """
    rows = []
    for monomial in monomials:
        row = np.zeros((n_terms, n_tgts))
        for target in set(monomial):
            others = list(monomial)
            others.remove(target)
            place = pure_terms.get(others[0]) if others[0] == others[1] else mixed_terms.get(frozenset(others))
            if place is not None:
                row[place, target] = 1.0
        rows.append(row)
    return np.array(rows).reshape(-1, n_terms, n_tgts)


def _antisymm_double_constraint(
    n_tgts: int, n_terms: int, pure_terms: dict[int, int], mixed_terms: dict[frozenset[int], int]
) -> Array:
    """The rows of ``x_i² x_j``."""
    monomials = [(i, i, j) for i, j in permutations(range(n_tgts), 2)]
    return _energy_rows(n_tgts, n_terms, pure_terms, mixed_terms, monomials)


def _antisymm_triple_constraints(n_tgts: int, n_terms: int, mixed_terms: dict[frozenset[int], int]) -> Array:
    """The rows of ``x_i x_j x_k`` with three different states."""
    return _energy_rows(n_tgts, n_terms, {}, mixed_terms, combinations(range(n_tgts), 3))


def _make_constraints(n_tgts: int, **kwargs: Any) -> tuple[Array, Array]:
    """Right sides and rows, of shape (n_constraints, n_terms, n_targets), of a quadratic part that keeps the energy.

    ``kwargs`` are those of `PolynomialLibrary`.
    """
    library = PolynomialLibrary(2, **kwargs).fit(np.zeros((1, n_tgts)))
    polyterms = list(enumerate(library.powers_))
    _, squares, products = _places(polyterms)
    cubes = _energy_rows(n_tgts, len(polyterms), squares, products, [(i, i, i) for i in range(n_tgts)])
    doubles = _antisymm_double_constraint(n_tgts, len(polyterms), squares, products)
    triples = _antisymm_triple_constraints(n_tgts, len(polyterms), products)
    rows = np.concatenate([cubes, doubles, triples])
    rows = rows[rows.any(axis=(1, 2))]  # a library without squares has none for the cubes
    return np.zeros(len(rows)), rows


def _symmetric(matrix: Array) -> Array:
    """The symmetric part in the first two axes."""
    return np.asarray((matrix + np.swapaxes(matrix, 0, 1)) / 2)
