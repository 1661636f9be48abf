"""One landing as an environment."""

from __future__ import annotations

from typing import Any

import numpy as np
from gymnasium import Env
from gymnasium.vector import AutoresetMode

from ._vector import Array32, LandingVectorEnv


class LandingEnv(Env[Array32, Array32]):
    """One landing on a moving deck: `LandingVectorEnv` with one environment, and its settings.

    Examples
    --------
    >>> import gymnasium, touchdown.gym
    >>> env = gymnasium.make("touchdown/Landing-v0", deck="still", action="thrust")
    >>> observation, info = env.reset(seed=1)
    >>> observation.shape, env.action_space.shape
    ((19,), (1,))
    """

    metadata = {"render_modes": []}

    def __init__(self, render_mode: str | None = None, **settings: Any) -> None:
        self.render_mode = render_mode
        self._envs = LandingVectorEnv(1, render_mode=render_mode, autoreset_mode=AutoresetMode.DISABLED, **settings)
        self.observation_space = self._envs.single_observation_space
        self.action_space = self._envs.single_action_space

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[Array32, dict[str, Any]]:
        """Begins a landing: the first trial of a seed, else the next one."""
        super().reset(seed=seed)
        observation, _ = self._envs.reset(seed=seed)
        return observation[0], {}

    def step(self, action: Array32) -> tuple[Array32, float, bool, bool, dict[str, Any]]:
        """Flies up to the next decision. At the end, ``info`` holds ``outcome`` and the numbers of the first touch."""
        given = np.asarray(action, dtype=np.float32).reshape(1, -1)
        observation, reward, terminated, truncated, info = self._envs.step(given)
        own = {key: values[0] for key, values in info.items() if not key.startswith("_")}
        return observation[0], float(reward[0]), bool(terminated[0]), bool(truncated[0]), own

    def close(self) -> None:
        """Ends the environment: it takes no further step."""
        self._envs.close()
