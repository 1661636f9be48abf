"""Coefficient error and support of a found model against the truth."""

import numpy as np

from systems import powers


class Score:
    """Measures coefficients of a system: 2-norm of their error over 2-norm of the truth, all equations
    together, and whether exactly the true terms are there."""

    def __init__(self, system):
        self.system = system
        self.truth = self.keyed(system.equations)
        self.norm = np.linalg.norm(list(self.truth.values()))

    def keyed(self, equations):
        out = {}
        for state, equation in equations.items():
            if state not in self.system.states:
                raise ValueError(f"equation of `{state}`, which is no state")
            for term, coefficient in equation.items():
                if coefficient != 0.0:
                    key = (state, powers(term, self.system.variables))
                    out[key] = out.get(key, 0.0) + coefficient
        return out

    def __call__(self, equations):
        """(error, support exact) of `equations[state][term]`."""
        found = self.keyed(equations)
        missing = set(self.system.states) - set(equations)
        if missing:
            raise ValueError(f"no equation of {sorted(missing)}")
        difference = [
            found.get(k, 0.0) - self.truth.get(k, 0.0) for k in sorted(found.keys() | self.truth.keys())
        ]
        return float(np.linalg.norm(difference) / self.norm), found.keys() == self.truth.keys()
