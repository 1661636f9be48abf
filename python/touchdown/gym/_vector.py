"""Landings side by side as a vector environment."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass, fields
from typing import Any

import numpy as np
from gymnasium import spaces
from gymnasium.error import ClosedEnvironmentError, ResetNeeded
from gymnasium.vector import AutoresetMode, VectorEnv
from gymnasium.vector.utils import batch_space
from numpy.typing import NDArray
from sindy import _native
from sindy._errors import fault, needed, real, whole

from touchdown._land import _plain

Array = NDArray[np.float64]
Array32 = NDArray[np.float32]

OBSERVATION = (
    ["place_x_m", "place_y_m", "place_z_m"]
    + ["relative_x_mps", "relative_y_mps", "relative_z_mps"]
    + ["velocity_x_mps", "velocity_y_mps", "velocity_z_mps"]
    + ["attitude_w", "attitude_x", "attitude_y", "attitude_z"]
    + ["rate_x_radps", "rate_y_radps", "rate_z_radps"]
    + ["normal_x", "normal_y", "normal_z"]
)
"""Names of an observation's numbers: place and velocity relative to the deck's centre, velocity, attitude (quaternion), rates
about body axes, the deck's normal. World axes, true values."""

# What the columns of an end are.
_V_L, _TILT, _LATERAL, _TOUCH_S, _END_S = range(5)
_ENDS = ("v_l_mps", "tilt_rad", "lateral_m", "touch_s", "end_s")


@dataclass(frozen=True)
class Reward:
    """What a decision is worth. The defaults make a soft landing at the centre worth about 3, a crash about -2.

    Attributes
    ----------
    progress : float
        For each metre nearer to the touchdown point: the centre of the deck at `standing_m`.
    time : float
        Cost of a second.
    effort : float
        Cost of a second with an action of length 1.
    landed, crashed, timed_out : float
        At the end.
    speed : float
        Cost of 1 m/s of speed at the first touch, paid at the end.
    lateral : float
        Cost of 1 m from the centre at the first touch, paid at the end.
    standing_m : float
        Height of the vehicle's reference point when it stands.
    excess : float
        Cost of a second for each m/s of closing speed above its limit, and for each metre of lateral error above its. A policy
        that is to fly in ``touchdown land --space`` has to keep them: there the landing computer aborts.
    within : float
        The limits are this share of those of the landing computer (``control.lander.closing_mps`` and ``lateral_m`` of the
        scenario).
    """

    progress: float = 1.0
    time: float = 0.05
    effort: float = 0.05
    landed: float = 3.0
    crashed: float = -2.0
    timed_out: float = -2.0
    speed: float = 4.0
    lateral: float = 1.0
    standing_m: float = 0.1
    excess: float = 0.0
    within: float = 0.8

    def __post_init__(self) -> None:
        for field in fields(self):
            real(field.name, getattr(self, field.name))
        if self.excess < 0.0:
            raise fault("excess", "a number of at least 0", self.excess)
        if not 0.0 < self.within <= 1.0:
            raise fault("within", "a number above 0, at most 1", self.within)

    def distance_m(self, observation: Array) -> Array:
        """From the touchdown point."""
        place = observation[:, :3].copy()
        place[:, 2] -= self.standing_m
        distance: Array = np.sqrt(np.einsum("ij,ij->i", place, place))
        return distance

    def beyond(self, observation: Array, limits: Mapping[str, Any]) -> Array:
        """By how much closing speed and lateral error exceed their share of the landing computer's limits."""
        height_m = np.maximum(observation[:, 2], 0.0)
        excess: Array = np.zeros(len(observation))
        lateral_m = np.hypot(observation[:, 0], observation[:, 1])
        for key, values in (("closing_mps", -observation[:, 5]), ("lateral_m", lateral_m)):
            limit = limits[key]["at_deck"] + limits[key]["per_m"] * height_m
            excess += np.maximum(values - self.within * limit, 0.0)
        return excess

    def of_end(self, outcome: str, numbers: Array) -> float:
        """At the end of a landing."""
        if outcome == "landed":
            return float(self.landed - self.speed * numbers[_V_L] - self.lateral * numbers[_LATERAL])
        return self.timed_out if outcome == "timed_out" else self.crashed


class LandingVectorEnv(VectorEnv[Array32, Array32, NDArray[Any]]):
    """Landings on a moving deck, side by side in the lanes of the processor's vectors.

    The plant is the whole vehicle in six degrees of freedom at 1 kHz: motors, ground effect of each rotor over the finite plate,
    legs with friction, turbulence and wind, the attitude control (500 Hz) and the delay of commands (``command_delay_s``). Sensors
    are ideal: observations are the truth, with `noise_sd` added. A landing ends as in `touchdown.land`: rotors stop at the first
    touch, and the vehicle is watched for ``watch_s``, in which actions do nothing.

    Parameters
    ----------
    num_envs : int
        Landings side by side; multiples of the lanes (8 with AVX-512, 4 with AVX2) waste none.
    deck : str
        The scenario's name: ``still``, ``paper``, ``strong``, ``heave``, ``sea``.
    scenario : mapping, optional
        Keys of ``[scenario]`` in a sweep over it: deck, wind, turbulence, spread of vehicles and starts, delays, time limits.
    action : str
        ``attitude``: thrust, roll and pitch; ``rates``: thrust, and rates about the body's x, y and z; ``thrust``: thrust alone,
        upright. Each in [-1, 1].
    decision_s : float
        Time between two decisions, a multiple of 0.02 s up to 1 s.
    thrust_range : float
        Thrust is weight (1 + `thrust_range` a).
    tilt_rad : float
        Roll and pitch at an action of 1.
    rate_radps : float
        Rates at an action of 1. The rate control follows up to 3.84 rad/s (yaw 3.49).
    reward : Reward, optional
        What a decision is worth.
    noise_sd : float or sequence
        Standard deviation of white noise on each number of an observation.
    autoreset_mode : gymnasium.vector.AutoresetMode
        When the next landing begins.

    Notes
    -----
    Environment *i* flies the trials *i*, *i + num_envs*, ... of the seed. Same seed and actions from a `reset` on give the same bytes. Every call
    releases the interpreter's lock; one environment uses one core.
    """

    def __init__(
        self,
        num_envs: int = 8,
        *,
        deck: str = "paper",
        scenario: Mapping[str, Any] | None = None,
        action: str = "attitude",
        decision_s: float = 0.02,
        thrust_range: float = 0.5,
        tilt_rad: float = 0.25,
        rate_radps: float = 2.0,
        reward: Reward | None = None,
        noise_sd: float | Any = 0.0,
        autoreset_mode: AutoresetMode = AutoresetMode.NEXT_STEP,
        render_mode: str | None = None,
    ) -> None:
        sizes = {"attitude": 3, "rates": 4, "thrust": 1}
        if not isinstance(action, str) or action not in sizes:
            raise fault("action", f"one of {', '.join(sizes)}", action)
        if render_mode is not None:
            raise fault("render_mode", "none", render_mode)
        num_envs = needed("num_envs", num_envs, 1)
        if not isinstance(deck, str):
            raise fault("deck", "the name of a deck", deck)
        if not (scenario is None or isinstance(scenario, Mapping)):
            raise fault("scenario", "keys and values", type(scenario).__name__)
        if not (reward is None or isinstance(reward, Reward)):
            raise fault("reward", "a `Reward`", reward)
        keys = None if scenario is None else json.dumps(dict(scenario), default=_plain)
        ranges = {"thrust_range": thrust_range, "tilt_rad": tilt_rad, "rate_radps": rate_radps}
        command = json.dumps({"kind": action, **{key: real(key, value) for key, value in ranges.items()}})
        self._native = _native.Commanded(deck, keys, command, num_envs, real("decision_s", decision_s))
        self.num_envs = num_envs
        self._size = sizes[action]
        self.metadata = {"render_modes": [], "autoreset_mode": AutoresetMode(autoreset_mode)}
        self.single_observation_space = spaces.Box(-np.inf, np.inf, (len(OBSERVATION),), np.float32)
        self.single_action_space = spaces.Box(-1.0, 1.0, (sizes[action],), np.float32)
        self.observation_space = batch_space(self.single_observation_space, num_envs)
        self.action_space = batch_space(self.single_action_space, num_envs)
        self.reward = reward or Reward()
        self._limits = self.settings["control"]["lander"]
        self.decision_s = decision_s
        self.steps_per_decision = self._native.steps
        try:
            self._noise_sd = np.broadcast_to(np.asarray(noise_sd, dtype=float), (len(OBSERVATION),))
        except (TypeError, ValueError):
            raise fault("noise_sd", f"a number, or {len(OBSERVATION)}", noise_sd) from None
        # Single precision has numbers up to 3e38; noise of a thousandth of it is none that anyone means.
        if not ((self._noise_sd >= 0.0) & (self._noise_sd < 1e35)).all():
            raise fault("noise_sd", "finite numbers of at least 0", noise_sd)
        self._noisy = bool(np.any(self._noise_sd != 0.0))
        self._seeds = [0] * num_envs
        self._trials = np.arange(num_envs)
        # From a trial of an environment to its next.
        self._stride = num_envs
        self._waiting = np.zeros(num_envs, dtype=bool)
        self._begun = False
        self._distance_m = np.zeros(num_envs)

    def reset(
        self, *, seed: int | list[int | None] | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Array32, dict[str, Any]]:
        """Begins a landing in every environment.

        Parameters
        ----------
        seed : int or list of int, optional
            One number for all environments, which share out its trials, or one for each environment, which then flies the
            trials of its own seed. Without one, and where the list has none, the next trials of the last seed begin.
        options : dict, optional
            ``reset_mask``: the environments to begin anew, with `AutoresetMode.DISABLED`.
        """
        mask = None if options is None else options.get("reset_mask")
        if isinstance(seed, list):
            self._seed_each([whole("seed", of_one) for of_one in seed])
        elif seed is not None:
            seed = needed("seed", seed)
            super().reset(seed=seed)
            self._seeds = [seed] * self.num_envs
            self._trials = np.arange(self.num_envs)
            self._stride = self.num_envs
        if self.closed:
            raise ClosedEnvironmentError("reset after close")
        if mask is None:
            self._native.clear()
            self._begun = True
        which = np.arange(self.num_envs) if mask is None else np.flatnonzero(mask)
        truth = self._begin(which)
        return self._seen(truth), {}

    def _seed_each(self, seeds: list[int | None]) -> None:
        """A seed for each environment, or none for those that go on."""
        if len(seeds) != self.num_envs:
            raise fault("seed", f"a number, or a list of {self.num_envs}", len(seeds))
        known = [seed for seed in seeds if seed is not None]
        if not known:
            return
        super().reset(seed=known[0])
        self._stride = 1
        for place, seed in enumerate(seeds):
            if seed is not None:
                self._seeds[place] = seed
                self._trials[place] = 0

    def _begin(self, which: NDArray[np.int64]) -> Array:
        """The next trials at these places; gives the truth of all."""
        places: dict[int, list[int]] = {}
        for place in which.tolist():
            places.setdefault(self._seeds[place], []).append(place)
        for seed, of_seed in places.items():
            self._native.begin(of_seed, self._trials[of_seed].tolist(), seed)
        self._trials[which] += self._stride
        self._waiting[which] = False
        truth = self._native.observe()
        self._distance_m[which] = self.reward.distance_m(truth[which])
        return truth

    def _seen(self, truth: Array) -> Array32:
        if self._noisy:
            truth = truth + self._noise_sd * self.np_random.standard_normal(truth.shape)
        return truth.astype(np.float32)

    def step(
        self, actions: Array32
    ) -> tuple[Array32, NDArray[np.float64], NDArray[np.bool_], NDArray[np.bool_], dict[str, Any]]:
        """Flies up to the next decision.

        Where a landing has ended, ``info`` holds ``outcome`` and the numbers of its first touch (``v_l_mps``, ``tilt_rad``,
        ``lateral_m``, ``touch_s``) and ``end_s``, each with its mask ``_outcome``, ...; with `AutoresetMode.SAME_STEP` also
        ``final_obs``, and the same under ``final_info``.
        """
        given = np.asarray(actions, dtype=float)
        if given.shape != (self.num_envs, self._size):
            raise fault("actions", f"an array of {self.num_envs} x {self._size}", f"shape {given.shape}")
        if np.isnan(given).any():
            raise fault("actions", "numbers", "NaN")
        if self.closed:
            raise ClosedEnvironmentError("step after close")
        if not self._begun:
            raise ResetNeeded("step before the first reset")
        given = np.clip(given, -1.0, 1.0)
        waiting = self._waiting.copy()
        places, outcomes, numbers, states = self._native.fly(given)
        truth = self._native.observe()
        truth[places] = states
        distance_m = self.reward.distance_m(truth)
        of, dt = self.reward, self.decision_s
        reward = of.progress * (self._distance_m - distance_m) - of.time * dt
        if of.effort:
            reward -= of.effort * dt * np.sqrt(np.einsum("ij,ij->i", given, given))
        if of.excess:
            reward -= of.excess * dt * of.beyond(truth, self._limits)
        self._distance_m = distance_m
        terminated, truncated = np.zeros(self.num_envs, dtype=bool), np.zeros(self.num_envs, dtype=bool)
        info: dict[str, Any] = {}
        if places:
            ended = np.asarray(places)
            reward[ended] += [of.of_end(name, row) for name, row in zip(outcomes, numbers)]
            timed_out = np.asarray([name == "timed_out" for name in outcomes])
            terminated[ended], truncated[ended] = ~timed_out, timed_out
            info = self._said(ended, outcomes, numbers)
        reward[waiting] = 0.0
        mode = self.metadata["autoreset_mode"]
        if mode == AutoresetMode.SAME_STEP and places:
            final = np.full(self.num_envs, None, dtype=object)
            for place, row in zip(places, self._seen(truth)[ended]):
                final[place] = row
            over = terminated | truncated
            info |= {"final_obs": final, "_final_obs": over, "final_info": dict(info), "_final_info": over}
            truth = self._begin(ended)
        elif mode == AutoresetMode.NEXT_STEP:
            if waiting.any():
                begun = np.flatnonzero(waiting)
                truth[begun] = self._begin(begun)[begun]
            self._waiting[places] = True
        return self._seen(truth), reward, terminated, truncated, info

    def _said(self, ended: NDArray[np.int64], outcomes: list[str], numbers: Array) -> dict[str, Any]:
        """What the ends are, in Gymnasium's way: an array and a mask for each key."""
        mask = np.zeros(self.num_envs, dtype=bool)
        mask[ended] = True
        named = np.full(self.num_envs, None, dtype=object)
        named[ended] = outcomes
        info: dict[str, Any] = {"outcome": named, "_outcome": mask}
        for k, key in enumerate(_ENDS):
            values = np.full(self.num_envs, np.nan)
            values[ended] = numbers[:, k]
            info[key], info[f"_{key}"] = values, mask
        return info

    def by_controller(self, trials: int, seed: int) -> dict[str, Any]:
        """The same trials flown by the scenario's own controller (``control.controller``) on the same plant and the true state.

        Returns
        -------
        dict
            ``outcome``, and arrays of ``v_l_mps``, ``tilt_rad``, ``lateral_m``, ``touch_s``, ``end_s``: a row a trial.
        """
        outcomes, numbers = self._native.by_controller(trials, seed)
        return {"outcome": outcomes, **{key: numbers[:, k] for k, key in enumerate(_ENDS)}}

    @property
    def settings(self) -> dict[str, Any]:
        """The scenario that is flown, with every key."""
        out: dict[str, Any] = json.loads(self._native.scenario())
        return out
