"""Proximal policy optimisation (PPO) that learns to land on a moving deck, in NumPy alone.

    python python/examples/land_ppo.py [--deck paper] [--minutes 4 | --decisions 8000000] [--out policy.json]

One file in the manner of CleanRL: two networks of two hidden layers, generalised advantages, clipped objective, Adam. At the end
the policy and the controller of the scenario fly the same trials, which neither was trained on, on the same plant. The file of --out
flies in landings with sensors:

    touchdown land --space --policy policy.json --out landings
"""

from __future__ import annotations

import argparse
import time

import numpy as np
from gymnasium.vector import AutoresetMode

import touchdown
from touchdown.gym import LandingVectorEnv, Reward

# Width of the hidden layers, landings side by side, decisions in a batch of each, epochs over it, rows of a gradient step.
WIDTH, ENVS, HORIZON, EPOCHS, ROWS = 64, 128, 128, 6, 2048
# Discount and the trace of advantages at 25 decisions a second: half of a reward is left after 5.5 s.
GAMMA, LAMBDA, CLIP, RATE, ENTROPY = 0.995, 0.95, 0.2, 1e-3, 0.002
DECISION_S = 0.04
# Brings each number of an observation to about 1, and what is far from it to the limit.
LIMIT = 10.0
SCALE = np.array([1, 1, 1, 2, 2, 2, 2, 2, 2, 1, 5, 5, 5, 1, 1, 1, 5, 5, 5], dtype=np.float32)


class Network:
    """tanh layers with their gradient and Adam."""

    def __init__(self, sizes: list[int], last: float, rng: np.random.Generator) -> None:
        self.weights: list[np.ndarray] = []
        for k, (a, b) in enumerate(zip(sizes[:-1], sizes[1:])):
            gain = last if k == len(sizes) - 2 else 1.0
            self.weights += [(gain * rng.standard_normal((a, b)) / np.sqrt(a)).astype(np.float32), np.zeros(b, np.float32)]
        self.moments = [(np.zeros_like(w), np.zeros_like(w)) for w in self.weights]
        self.steps = 0

    def __call__(self, x: np.ndarray) -> list[np.ndarray]:
        """The values of all layers; the last is the output."""
        layers = [x]
        for k in range(0, len(self.weights), 2):
            x = layers[-1] @ self.weights[k] + self.weights[k + 1]
            layers.append(np.tanh(x) if k + 2 < len(self.weights) else x)
        return layers

    def descend(self, layers: list[np.ndarray], gradient: np.ndarray, rate: float) -> None:
        """A step of Adam down a gradient with respect to the output."""
        gradients: list[np.ndarray] = []
        for k in range(len(self.weights) - 2, -1, -2):
            before = layers[k // 2]
            gradients = [before.T @ gradient, gradient.sum(0), *gradients]
            gradient = (gradient @ self.weights[k].T) * (1.0 - before**2)
        norm = np.sqrt(sum(float((g**2).sum()) for g in gradients))
        self.steps += 1
        for w, g, (first, second) in zip(self.weights, gradients, self.moments):
            g = g * min(1.0, 0.5 / (norm + 1e-8))
            first += 0.1 * (g - first)
            second += 0.001 * (g**2 - second)
            scale = np.sqrt(1.0 - 0.999**self.steps) / (1.0 - 0.9**self.steps)
            w -= rate * scale * first / (np.sqrt(second) + 1e-8)


def features(observation: np.ndarray) -> np.ndarray:
    """Observations as the networks take them."""
    return np.clip(observation * SCALE, -LIMIT, LIMIT)


class Policy:
    """A Gaussian over actions, its spread the same everywhere, and a value."""

    def __init__(self, actions: int, rng: np.random.Generator) -> None:
        self.mean = Network([len(SCALE), WIDTH, WIDTH, actions], 0.01, rng)
        self.value = Network([len(SCALE), WIDTH, WIDTH, 1], 1.0, rng)
        self.log_sd = Network([1, actions], 0.0, rng)
        self.log_sd.weights[1] -= 1.0

    def written(self) -> touchdown.Policy:
        """The mean, as `touchdown land --space` flies it."""
        weights = self.mean.weights
        kinds = ["tanh"] * (len(weights) // 2 - 1) + ["linear"]
        layers = [(w.T, b, kind) for w, b, kind in zip(weights[::2], weights[1::2], kinds)]
        return touchdown.Policy(layers, decision_s=DECISION_S, scale=SCALE, limit=LIMIT)

    def spread(self) -> np.ndarray:
        """Logarithm of the standard deviation."""
        return self.log_sd.weights[1]

    def log_density(self, mean: np.ndarray, action: np.ndarray) -> np.ndarray:
        """Of actions, but for a constant."""
        z = (action - mean) / np.exp(self.spread())
        return -0.5 * (z**2).sum(1) - self.spread().sum()

    def learn(self, rows: tuple[np.ndarray, ...], rate: float) -> None:
        """One gradient step on rows of features, actions, densities, advantages, returns."""
        x, action, old, advantage, target = rows
        layers = self.mean(x)
        sd = np.exp(self.spread())
        z = (action - layers[-1]) / sd
        ratio = np.exp(self.log_density(layers[-1], action) - old)
        clipped = ((advantage > 0) & (ratio > 1 + CLIP)) | ((advantage < 0) & (ratio < 1 - CLIP))
        pull = np.where(clipped, 0.0, -ratio * advantage)[:, None].astype(np.float32) / len(x)
        self.mean.descend(layers, pull * z / sd, rate)
        spread = (pull * (z**2 - 1.0)).sum(0, keepdims=True) - ENTROPY
        self.log_sd.descend([np.zeros((1, 1), np.float32), spread], spread, rate)
        values = self.value(x)
        self.value.descend(values, (values[-1] - target[:, None]) / len(x), rate)


def train(envs: LandingVectorEnv, policy: Policy, minutes: float, most: int | None, rng: np.random.Generator) -> None:
    """Learns for so many minutes of wall-clock time, or decisions: these give the same policy again."""
    n, size = envs.num_envs, envs.single_action_space.shape[0]
    observation, _ = envs.reset(seed=1)
    start, decisions, shown, ends = time.monotonic(), 0, 0.0, []
    while True:
        spent = time.monotonic() - start
        share = spent / (60.0 * minutes) if most is None else decisions / most
        if share >= 1.0:
            break
        x = np.empty((HORIZON, n, len(SCALE)), np.float32)
        actions, old = np.empty((HORIZON, n, size), np.float32), np.empty((HORIZON, n), np.float32)
        rewards, values = np.empty((HORIZON, n), np.float32), np.empty((HORIZON + 1, n), np.float32)
        last = np.empty((HORIZON, n), bool)
        for t in range(HORIZON):
            x[t] = features(observation)
            mean = policy.mean(x[t])[-1]
            values[t] = policy.value(x[t])[-1][:, 0]
            actions[t] = mean + np.exp(policy.spread()) * rng.standard_normal(mean.shape)
            old[t] = policy.log_density(mean, actions[t])
            observation, reward, terminated, truncated, info = envs.step(actions[t])
            rewards[t], last[t] = reward, terminated | truncated
            for k in np.flatnonzero(truncated):
                # A landing that was cut off has a future.
                rewards[t, k] += GAMMA * policy.value(features(info["final_obs"][k][None]))[-1][0, 0]
            ends += [(info["outcome"][k], info["v_l_mps"][k]) for k in np.flatnonzero(last[t])]
        values[HORIZON] = policy.value(features(observation))[-1][:, 0]
        advantages, trace = np.empty_like(rewards), np.zeros(n, np.float32)
        for t in reversed(range(HORIZON)):
            on = ~last[t]
            trace = rewards[t] + GAMMA * on * values[t + 1] - values[t] + GAMMA * LAMBDA * on * trace
            advantages[t] = trace
        flat = [a.reshape(HORIZON * n, *a.shape[2:]) for a in (x, actions, old, advantages, advantages + values[:-1])]
        flat[3] = (flat[3] - flat[3].mean()) / (flat[3].std() + 1e-8)
        rate = RATE * max(0.05, 1.0 - share)
        for _ in range(EPOCHS):
            for rows in np.array_split(rng.permutation(HORIZON * n), HORIZON * n // ROWS):
                policy.learn(tuple(a[rows] for a in flat), rate)
        decisions += HORIZON * n
        if spent - shown > 15.0 and ends:
            landed = [speed for outcome, speed in ends if outcome == "landed"]
            percent, speed = 100 * len(landed) / len(ends), np.mean(landed) if landed else np.nan
            print(f"{spent:5.0f} s  {decisions:9d} decisions  landed {percent:5.1f} %  V_L {speed:.3f} m/s", flush=True)
            shown, ends = spent, []


def judge(deck: str, policy: Policy, trials: int, seed: int) -> None:
    """The policy's mean and the scenario's controllers, on the same trials."""
    envs = LandingVectorEnv(trials, deck=deck, decision_s=DECISION_S, autoreset_mode=AutoresetMode.DISABLED)
    observation, _ = envs.reset(seed=seed)
    open_ends, ends = np.ones(trials, bool), []
    while open_ends.any():
        observation, _, terminated, truncated, info = envs.step(policy.mean(features(observation))[-1])
        for k in np.flatnonzero((terminated | truncated) & open_ends):
            ends.append((info["outcome"][k], info["v_l_mps"][k], info["lateral_m"][k], info["touch_s"][k]))
        open_ends &= ~(terminated | truncated)
    show("policy", ends)
    for controller in ("feedback", "dynamic", "dynamic+observer"):
        own = LandingVectorEnv(1, deck=deck, scenario={"control": {"controller": controller}})
        flown = own.by_controller(trials, seed)
        show(controller, list(zip(flown["outcome"], flown["v_l_mps"], flown["lateral_m"], flown["touch_s"])))


def show(name: str, ends: list[tuple[str, float, float, float]]) -> None:
    """A line of figures."""
    landed = np.array([end[1:] for end in ends if end[0] == "landed"]).reshape(-1, 3)
    speed, worst, lateral, touch = [np.nan] * 4
    if len(landed):
        speed, worst = landed[:, 0].mean(), landed[:, 0].max()
        lateral, touch = landed[:, 1].mean(), landed[:, 2].mean()
    share = f"landed {len(landed)} of {len(ends)}"
    print(f"{name:17} {share:20} V_L {speed:.3f} (worst {worst:.3f}) m/s, {lateral:.3f} m off centre, after {touch:.1f} s")


def main() -> None:
    """Trains, judges, writes."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--deck", default="paper")
    parser.add_argument("--minutes", type=float, default=4.0)
    parser.add_argument("--decisions", type=int, help="in place of --minutes")
    parser.add_argument("--trials", type=int, default=400)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--out")
    given = parser.parse_args()
    rng = np.random.default_rng(given.seed)
    # Landings that hover on are cut off: most of what is learned is in the descent.
    scenario = {"timeout_s": 15.0}
    mode = AutoresetMode.SAME_STEP
    # Faster than the landing computer allows would be no landing of `touchdown land --space`.
    envs = LandingVectorEnv(
        ENVS, deck=given.deck, scenario=scenario, decision_s=DECISION_S, autoreset_mode=mode, reward=Reward(excess=5.0)
    )
    policy = Policy(envs.single_action_space.shape[0], rng)
    train(envs, policy, given.minutes, given.decisions, rng)
    judge(given.deck, policy, given.trials, seed=1000 + given.seed)
    if given.out:
        policy.written().save(given.out)


if __name__ == "__main__":
    main()
