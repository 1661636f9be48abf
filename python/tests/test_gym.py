"""The vector environment: Gymnasium's checker, bytes, ends."""

from __future__ import annotations

import json
import os
import pickle
import re
import subprocess
import sys
import warnings
from pathlib import Path

import numpy as np
import pytest

gymnasium = pytest.importorskip("gymnasium")
from gymnasium.vector import AutoresetMode  # noqa: E402

import touchdown as td  # noqa: E402
from touchdown.gym import OBSERVATION, LandingVectorEnv, Reward  # noqa: E402


def descend(observation: np.ndarray) -> np.ndarray:
    """A law by hand: sinks at 0.25 m/s less what the ground effect lifts, leans against place and speed."""
    x, y = observation[:, 0], observation[:, 1]
    u, v, w = observation[:, 3], observation[:, 4], observation[:, 5]
    lean = np.clip(np.stack([0.2 * y + 0.25 * v, -0.2 * x - 0.25 * u], axis=1), -0.2, 0.2)
    return np.column_stack([-2.0 * (w + 0.25), lean / 0.25])


def flown(envs: LandingVectorEnv, seed: int, decisions: int) -> tuple[bytes, list[tuple[str, float]]]:
    """All that a run gave, and its ends."""
    observation, _ = envs.reset(seed=seed)
    data, ends = [observation.tobytes()], []
    for _ in range(decisions):
        observation, reward, terminated, truncated, info = envs.step(descend(observation))
        data += [observation.tobytes(), reward.tobytes(), terminated.tobytes(), truncated.tobytes()]
        for k in np.flatnonzero(terminated | truncated):
            ends.append((info["outcome"][k], info["v_l_mps"][k]))
    return b"".join(data), ends


def test_prop_gymnasiums_checker_passes() -> None:
    from gymnasium.utils.env_checker import check_env

    for settings in ({"deck": "paper"}, {"deck": "sea", "action": "thrust"}, {"deck": "heave", "action": "rates"}):
        env = gymnasium.make("touchdown/Landing-v0", **settings).unwrapped
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            # Observations have no bounds, on purpose: physics has none.
            warnings.filterwarnings("ignore", message=".*infinity.*")
            check_env(env, skip_render_check=True)


def test_prop_a_made_vector_has_the_spaces_and_modes_of_gymnasium() -> None:
    envs = gymnasium.make_vec("touchdown/Landing-v0", num_envs=5, deck="heave", action="thrust")
    observation, _ = envs.reset(seed=3)
    assert envs.observation_space.contains(observation) and envs.metadata["autoreset_mode"] == AutoresetMode.NEXT_STEP
    stepped = envs.step(envs.action_space.sample())
    again, _ = envs.reset(seed=3)
    assert np.array_equal(again, observation)
    assert envs.observation_space.contains(stepped[0]) and len(OBSERVATION) == 19
    assert [part.shape for part in stepped[1:4]] == [(5,)] * 3
    gymnasium.wrappers.vector.RecordEpisodeStatistics(envs).reset(seed=3)


@pytest.mark.parametrize("mode", [AutoresetMode.NEXT_STEP, AutoresetMode.SAME_STEP])
def test_prop_same_seed_same_bytes_and_a_law_by_hand_lands(mode: AutoresetMode) -> None:
    settings = {"deck": "paper", "noise_sd": 0.001, "autoreset_mode": mode}
    first, ends = flown(LandingVectorEnv(13, **settings), seed=4, decisions=700)
    assert first == flown(LandingVectorEnv(13, **settings), seed=4, decisions=700)[0]
    assert first != flown(LandingVectorEnv(13, **settings), seed=5, decisions=700)[0]
    landed = [speed for outcome, speed in ends if outcome == "landed"]
    # The law of the Rust test: nine of ten at least, below 0.4 m/s.
    assert len(landed) >= 0.9 * len(ends) > 10 and max(landed) < 0.4, ends


def test_prop_each_environment_may_have_a_seed_of_its_own() -> None:
    envs = LandingVectorEnv(3, deck="sea")
    both, _ = envs.reset(seed=[4, 9, 4])
    assert np.array_equal(both[0], both[2]) and not np.array_equal(both[0], both[1])
    # The landing of a seed, wherever it is flown; and its next one.
    other, _ = LandingVectorEnv(2, deck="sea").reset(seed=[9, 4])
    assert np.array_equal(other, both[[1, 0]])
    following, _ = envs.reset()
    assert not np.array_equal(following, both) and np.array_equal(following[0], following[2])
    partly, _ = envs.reset(seed=[None, 4, 4])
    assert np.array_equal(partly[1], both[0]) and not np.array_equal(partly[0], both[0])
    with pytest.raises(td.SindyError, match="`seed`: expected a number, or a list of 3, found 2"):
        envs.reset(seed=[1, 2])


def test_prop_a_law_by_hand_lands_by_rates() -> None:
    envs = LandingVectorEnv(13, deck="paper", action="rates")
    observation, _ = envs.reset(seed=4)
    ends: list[tuple[str, float]] = []
    for _ in range(700):
        wanted = descend(observation)
        # Small angles: half of them are in the quaternion. Towards the wanted ones in a fifth of a second; 2 rad/s is 1.
        rates = 2.5 * (0.25 * wanted[:, 1:] - 2.0 * observation[:, 10:12])
        observation, _, terminated, _, info = envs.step(np.column_stack([wanted[:, :1], rates, np.zeros(13)]))
        ends += [(info["outcome"][k], info["v_l_mps"][k]) for k in np.flatnonzero(terminated)]
    landed = [speed for outcome, speed in ends if outcome == "landed"]
    # The same bounds as by attitude, above.
    assert len(landed) >= 0.9 * len(ends) > 10 and max(landed) < 0.4, ends


def test_prop_a_landing_begins_anew_as_its_mode_says() -> None:
    fall = np.tile(np.array([[-1.0, 0.0, 0.0]], dtype=np.float32), (2, 1))
    scenario = {"timeout_s": 0.5}
    for mode in (AutoresetMode.NEXT_STEP, AutoresetMode.SAME_STEP, AutoresetMode.DISABLED):
        envs = LandingVectorEnv(2, deck="still", scenario=scenario, decision_s=0.1, autoreset_mode=mode)
        envs.reset(seed=1)
        for _ in range(20):
            observation, reward, terminated, truncated, info = envs.step(0.0 * fall)
            if truncated.any():
                break
        # It hovered for 0.5 s: cut off, not ended, and nothing touched.
        assert truncated.all() and not terminated.any() and info["outcome"][0] == "timed_out"
        assert np.isnan(info["v_l_mps"]).all() and info["end_s"] == pytest.approx(0.5, abs=0.002)
        height = observation[0, 2]
        if mode == AutoresetMode.SAME_STEP:
            assert info["final_obs"][0][2] != height and not np.array_equal(info["final_obs"][0], observation[0])
        again, reward, terminated, truncated, _ = envs.step(0.0 * fall)
        if mode == AutoresetMode.NEXT_STEP:
            assert again[0, 2] != height and (reward == 0.0).all() and not (terminated | truncated).any()
    crashed = LandingVectorEnv(2, deck="still", autoreset_mode=AutoresetMode.DISABLED)
    crashed.reset(seed=1)
    for _ in range(200):
        _, reward, terminated, _, info = crashed.step(fall)
        if terminated.any():
            break
    (first, *_) = np.flatnonzero(terminated)
    assert info["outcome"][first] == "crashed: speed" and reward[first] < -1.0


def test_prop_settings_are_the_scenarios_and_faults_are_named() -> None:
    envs = LandingVectorEnv(1, deck="sea", scenario={"turbulence": False, "command_delay_s": 0.03})
    assert envs.settings["turbulence"] is False and envs.settings["deck"]["kind"] == "sea"
    for settings, key in [
        ({"deck": "lake"}, "deck"),
        ({"scenario": {"turbulense": True}}, "turbulense"),
        ({"action": "torque"}, "action"),
        ({"action": "rates", "rate_radps": 0.0}, "rate_radps"),
        ({"thrust_range": 1.5}, "thrust_range"),
        ({"decision_s": 0.03}, "decision_s"),
        ({"scenario": {"faults": {"extra_latency_s": 0.1}}}, "faults.extra_latency_s"),
    ]:
        with pytest.raises(td.SindyError) as caught:
            LandingVectorEnv(1, **settings)
        assert caught.value.key == key and caught.value.found, str(caught.value)
    for key, call in [
        ("actions", lambda: envs.step(np.zeros((1, 2), dtype=np.float32))),
        ("actions", lambda: envs.step(np.zeros(7, dtype=np.float32))),
        ("seed", lambda: envs.reset(seed=2**64)),
        ("seed", lambda: envs.reset(seed=[-1])),
        ("num_envs", lambda: LandingVectorEnv(-1)),
        ("num_envs", lambda: LandingVectorEnv(0)),
        ("num_envs", lambda: LandingVectorEnv(None)),
        ("trial", lambda: td.Space("still").land(None)),
    ]:
        with pytest.raises(td.SindyError) as caught:
            call()
        assert caught.value.key == key, str(caught.value)


def test_prop_what_cannot_be_flown_is_refused() -> None:
    from gymnasium.error import ClosedEnvironmentError, ResetNeeded

    envs = LandingVectorEnv(2, deck="still")
    still = np.zeros((2, 3), dtype=np.float32)
    with pytest.raises(ResetNeeded):
        envs.step(still)
    envs.reset(seed=1)
    before = envs.step(still)[0]
    bad = still.copy()
    bad[1, 2] = np.nan
    with pytest.raises(td.SindyError, match="actions.*NaN"):
        envs.step(bad)
    # Nothing was flown: the next decision is that of environments that never saw it.
    others = LandingVectorEnv(2, deck="still")
    others.reset(seed=1)
    assert others.step(still)[0].tobytes() == before.tobytes()
    assert others.step(still)[0].tobytes() == envs.step(still)[0].tobytes()
    envs.close()
    for call in (lambda: envs.step(still), lambda: envs.reset(seed=1)):
        with pytest.raises(ClosedEnvironmentError):
            call()


def hand(**settings: object) -> td.Policy:
    """The law by hand as a policy of one layer; its lean is not limited."""
    weights = np.zeros((3, 19))
    weights[0, 5] = -2.0
    weights[1, [1, 4]], weights[2, [0, 3]] = [0.8, 1.0], [-0.8, -1.0]
    return td.Policy([(weights, [-0.5, 0.0, 0.0], "linear")], **settings)


def test_xval_numpy_a_policy_is_the_network_of_its_layers(tmp_path: Path) -> None:
    rng = np.random.default_rng(5)
    sizes = [19, 32, 7, 4]
    shapes = list(zip(sizes[1:], sizes[:-1]))
    layers = [(rng.normal(size=shape) / 4, rng.normal(size=shape[0])) for shape in shapes]
    kinds = ["tanh", "relu", "tanh"]
    offset, scale = rng.normal(size=19), rng.uniform(0.5, 3.0, 19)
    given = [(w, b, kind) for (w, b), kind in zip(layers, kinds)]
    policy = td.Policy(given, action="rates", offset=offset, scale=scale, limit=1.5)
    seen = rng.normal(size=(50, 19))
    x = np.clip((seen - offset) * scale, -1.5, 1.5)
    for (w, b), kind in zip(layers, kinds):
        x = np.tanh(x @ w.T + b) if kind == "tanh" else np.maximum(x @ w.T + b, 0.0)
    # Actions have single precision: half of 1.2e-7 of 1.
    assert np.abs(policy(seen) - x).max() < 1e-7 and policy(seen).dtype == np.float32
    assert np.array_equal(policy(seen[3]), policy(seen)[3])
    policy.save(tmp_path / "p.json")
    again = td.Policy.read(tmp_path / "p.json")
    assert again.settings == policy.settings and pickle.loads(pickle.dumps(policy)).settings == policy.settings
    assert repr(policy) == "Policy(19 x 32 x 7 x 4, rates, every 0.02 s)"


def test_prop_a_policy_flies_in_its_environment_and_in_landings_with_sensors(tmp_path: Path) -> None:
    policy = hand(decision_s=0.04)
    envs = LandingVectorEnv(10, deck="paper", decision_s=0.04, autoreset_mode=AutoresetMode.SAME_STEP)
    observation, _ = envs.reset(seed=4)
    ends: list[str] = []
    while len(ends) < 20:
        observation, _, terminated, truncated, info = envs.step(policy(observation))
        ends += list(info["outcome"][terminated | truncated]) if "outcome" in info else []
    landings = td.land(space=True, policy=policy, controllers=["observer"], trials=10, seed=4)
    own = landings["control.controller"] == "policy"
    assert own.sum() == 10 and (~own).sum() == 10
    # Nine of ten as of the law by hand above, on the truth and on estimates.
    assert ends.count("landed") >= 18 and landings.landed[own].sum() >= 9
    policy.save(tmp_path / "p.json")
    by_file = td.land(space=True, policy=tmp_path / "p.json", controllers=["observer"], trials=10, seed=4)
    assert np.array_equal(by_file["v_l_mps"], landings["v_l_mps"], equal_nan=True)
    space = td.Space("paper", policy=policy, seed=4)
    assert space.land(3)["v_l_mps"] == landings["v_l_mps"][own][3]
    assert pickle.loads(pickle.dumps(space)).land(3)["v_l_mps"] == space.land(3)["v_l_mps"]
    # 0.7 m at 0.25 m/s at most, from 0.15 m below the hover at the lowest.
    assert (landings["t_l_s"][own][landings.landed[own]] > 2.2).all()


def test_prop_the_example_learns_to_land_and_the_command_flies_what_it_learned(tmp_path: Path) -> None:
    example = Path(__file__).parents[1] / "examples" / "land_ppo.py"
    file, out = tmp_path / "policy.json", tmp_path / "out"
    given = ["--decisions", "600000", "--trials", "60", "--out", str(file)]
    learned = subprocess.run([sys.executable, example, *given], capture_output=True, text=True, check=True)
    landed = re.search(r"policy +landed (\d+) of 60", learned.stdout)
    # Untrained it hovers, and lands none; 450 000 decisions were seen to land 95 %.
    assert landed and int(landed[1]) >= 45, learned.stdout + learned.stderr
    command = os.environ.get("TOUCHDOWN_COMMAND")
    if not command:
        pytest.skip("TOUCHDOWN_COMMAND names no command")
    run = [command, "--quiet", "land", "--space", "--json", "--trials", "10", "--policy", str(file), "--out", str(out)]
    flown = json.loads(subprocess.run(run, capture_output=True, text=True, check=False).stdout)
    by_command = {point["controller"]: point["outcomes"] for point in flown["points"]}
    here = td.land(space=True, policy=file, trials=10)
    outcomes = here["outcome"][here["control.controller"] == "policy"]
    assert by_command["policy"] == dict(zip(*np.unique(outcomes.astype(str), return_counts=True)))


def test_prop_landings_tell_which_trials_a_drawn_policy_flew(tmp_path: Path) -> None:
    hand().save(tmp_path / "p.json")
    drawn = {"control.controller": {"kind": "choice", "of": ["policy", "observer"]}}
    sweep = {"policy": str(tmp_path / "p.json"), "random": drawn, "trials": 12}
    landings = td.land(sweep, space=True)
    flew = landings["control.controller"] == "policy"
    assert 0 < flew.sum() < 12 and landings.results["points"][0]["controller"] == "drawn"
    alone = td.land({"trials": 12}, space=True, policy=tmp_path / "p.json", controllers=["observer"])
    own = alone["control.controller"] == "policy"
    expected = np.where(flew, alone["v_l_mps"][own], alone["v_l_mps"][~own])
    assert np.array_equal(landings["v_l_mps"], expected, equal_nan=True)


def test_prop_excess_is_what_exceeds_the_landing_computers_limits() -> None:
    fall = np.tile(np.array([[-1.0, 0.0, 0.0]], dtype=np.float32), (2, 1))
    envs = [LandingVectorEnv(2, deck="still", reward=Reward(excess=excess, within=0.5)) for excess in (0.0, 3.0)]
    firsts = [env.reset(seed=1)[0] for env in envs]
    assert np.array_equal(*firsts)
    costs = []
    for _ in range(20):
        (seen, plain, *_), (_, costly, *_) = (env.step(fall) for env in envs)
        limits = 0.35 + seen[:, 2], 0.10 + 0.25 * seen[:, 2]
        beyond = np.maximum(-seen[:, 5] - 0.5 * limits[0], 0) + np.maximum(np.hypot(seen[:, 0], seen[:, 1]) - 0.5 * limits[1], 0)
        # Observations have single precision; a decision takes 0.02 s.
        assert np.abs(plain - costly - 3.0 * 0.02 * beyond).max() < 1e-7
        costs.append((plain - costly).max())
    # It sinks with half of gravity: at 0.4 s with 2 m/s, 1.5 m/s beyond the half of the limit; at 0.1 s not beyond it.
    assert costs[-1] > 0.05 > 5.0 * costs[3]


def test_prop_policies_that_do_not_fit_are_refused(tmp_path: Path) -> None:
    layer = (np.zeros((3, 19)), np.zeros(3), "tanh")
    (tmp_path / "text.json").write_text("learned")
    for key, call in [
        ("layers.0.weights.0", lambda: td.Policy([(np.zeros((3, 18)), np.zeros(3), "tanh")])),
        ("layers.0.weights", lambda: td.Policy([layer], action="rates")),
        ("layers.1.weights.0", lambda: td.Policy([layer, (np.zeros((3, 4)), np.zeros(3), "tanh")])),
        ("layers", lambda: td.Policy([])),
        ("layers.0.weights.0", lambda: td.Policy([(np.full((3, 19), np.nan), np.zeros(3), "tanh")])),
        ("layers.0.weights", lambda: td.Policy([(np.zeros(19), np.zeros(1), "tanh")], action="thrust")),
        ("layers.0.weights", lambda: td.Policy([(1j * np.zeros((3, 19)), np.zeros(3), "tanh")])),
        ("layers.0.weights", lambda: td.Policy([([[1.0, 2.0], [3.0]], np.zeros(2), "tanh")])),
        ("layers.0.activation", lambda: td.Policy([(*layer[:2], "cubic")])),
        ("layers.0", lambda: td.Policy([layer[:2]])),
        ("action.kind", lambda: td.Policy([layer], action="torque")),
        ("scale", lambda: td.Policy([layer], scale=np.inf)),
        ("input.scale", lambda: td.Policy([layer], scale=[1.0, 2.0])),
        ("action.tilt_rad", lambda: td.Policy([layer], tilt_rad=2.0)),
        ("decision_s", lambda: td.Policy([layer], decision_s=0.0)),
        ("decision_s", lambda: td.Policy([layer], decision_s=np.nan)),
        ("limit", lambda: td.Policy([layer], limit="wide")),
        ("within", lambda: Reward(within=np.nan)),
        ("excess", lambda: Reward(excess=-1.0)),
        ("noise_sd", lambda: LandingVectorEnv(1, noise_sd=-1.0)),
        ("noise_sd", lambda: LandingVectorEnv(1, noise_sd=[0.1] * 18)),
        ("reward", lambda: LandingVectorEnv(1, reward={"excess": 1.0})),
        ("scenario", lambda: LandingVectorEnv(1, scenario=3)),
        ("decision_s", lambda: LandingVectorEnv(1, decision_s=2.0)),
        ("decision_s", lambda: LandingVectorEnv(1, decision_s=None)),
        ("tilt_rad", lambda: LandingVectorEnv(1, tilt_rad=np.inf)),
        ("observations", lambda: td.Policy([layer])(np.zeros((1, 1, 19)))),
        ("policy", lambda: td.land(policy=td.Policy([layer]), thrust=None)),
        ("policy.decision_s", lambda: td.land(space=True, policy=td.Policy([layer], decision_s=0.005), trials=1)),
        ("controller", lambda: td.Space("paper", policy=td.Policy([layer]), controller="observer")),
        ("observations", lambda: td.Policy([layer])(np.zeros(18))),
    ]:
        with pytest.raises(td.SindyError) as caught:
            call()
        assert caught.value.key == key and caught.value.found, (key, caught.value.key, str(caught.value))
    with pytest.raises(td.SindyError, match=r"text\.json: setting `policy`: expected a policy in JSON"):
        td.Policy.read(tmp_path / "text.json")
    td.Policy([layer]).save(tmp_path / "p.json")
    (tmp_path / "p.json").write_text((tmp_path / "p.json").read_text().replace("tanh", "gelu"))
    with pytest.raises(td.SindyError) as caught:
        td.Policy.read(tmp_path / "p.json")
    assert caught.value.key == "layers[0].activation" and "`tanh`" in caught.value.expected, str(caught.value)
    assert "gelu" in caught.value.found
    # Numbers of NumPy are numbers.
    assert LandingVectorEnv(1, scenario={"timeout_s": np.float32(9.0)}).settings["timeout_s"] == 9.0
    td.Policy([layer], decision_s=np.float32(0.03), limit=np.float32(10), thrust_range=np.float64(0.4))
    with pytest.raises(FileNotFoundError):
        td.Policy.read(tmp_path / "absent.json")
