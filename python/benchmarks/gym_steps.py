"""Steps of the physics (1 ms) a second and core of the vector environment, beside the same landings in Rust.

    python python/benchmarks/gym_steps.py [SECONDS]

The figure in Rust, with its own controller: `cargo run --release -p touchdown-sim --example batch_landings`, timed.
"""

from __future__ import annotations

import sys
import time

import numpy as np

from touchdown.gym import LandingVectorEnv


def measure(num_envs: int, deck: str, decision_s: float, seconds: float) -> tuple[float, float]:
    """Physics steps and decisions a second of processor time."""
    envs = LandingVectorEnv(num_envs, deck=deck, decision_s=decision_s, autoreset_mode="SameStep")
    rng = np.random.default_rng(1)
    envs.reset(seed=1)
    # Around hover, with a slow descent: what a policy does, not a fall.
    actions = 0.05 * rng.standard_normal((64, num_envs, 3)) - np.array([0.01, 0.0, 0.0])
    for k in range(20):
        envs.step(actions[k % 64])
    start, decisions = time.process_time(), 0
    while (spent := time.process_time() - start) < seconds:
        envs.step(actions[decisions % 64])
        decisions += 1
    return decisions * num_envs * envs.steps_per_decision / spent, decisions * num_envs / spent


def main() -> None:
    """Prints a table."""
    seconds = float(sys.argv[1]) if len(sys.argv) > 1 else 3.0
    print(f"{'deck':8} {'envs':>5} {'decision':>9} {'M steps/s':>10} {'k decisions/s':>14}")
    for deck in ("paper", "sea"):
        for num_envs in (8, 64, 256, 1024):
            for decision_s in (0.02, 0.1):
                steps, decisions = measure(num_envs, deck, decision_s, seconds)
                print(f"{deck:8} {num_envs:5} {decision_s:8.2f}s {steps / 1e6:10.2f} {decisions / 1e3:14.1f}")


if __name__ == "__main__":
    main()
