"""Environments of landings for learning, over the SIMD lanes of the simulator.

>>> import gymnasium, touchdown.gym
>>> envs = gymnasium.make_vec("touchdown/Landing-v0", num_envs=8, deck="paper")
>>> observation, info = envs.reset(seed=1)
>>> observation.shape
(8, 19)
>>> observation, reward, terminated, truncated, info = envs.step(envs.action_space.sample())
"""

from gymnasium import register

from ._env import LandingEnv
from ._vector import OBSERVATION, LandingVectorEnv, Reward

# The vehicle lands or crashes, or the scenario's own `timeout_s` truncates: Gymnasium counts no steps.
register(
    "touchdown/Landing-v0",
    entry_point="touchdown.gym:LandingEnv",
    vector_entry_point="touchdown.gym:LandingVectorEnv",
    disable_env_checker=True,
)

__all__ = ["OBSERVATION", "LandingEnv", "LandingVectorEnv", "Reward"]
