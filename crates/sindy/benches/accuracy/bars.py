"""What the automatic choice must reach."""

# System -> noise in percent -> (largest median error, whether the support must be exact for every seed).
FIXED = {
    "lorenz": {1: (5e-4, True), 5: (3e-3, True), 10: (8e-3, True), 20: (4e-2, False)},
    "vanderpol": {1: (6e-4, True), 5: (4e-3, True), 10: (1.5e-2, True), 20: (5e-2, True)},
    "lotkavolterra": {1: (3e-4, True), 5: (3e-3, True), 10: (5e-3, True), 20: (1.2e-2, False)},
}
# Equation (12) at any noise: this times PySINDy's weak form on the same arrays.
GROUND_EFFECT_RATIO = 1.05
# All `dysts_` systems and seeds together: noise -> (largest median error, percent of exact supports).
DYSTS = {0.1: (1.2e-4, 95.0), 1: (1.2e-3, 85.0), 5: (5e-2, 55.0)}
