"""Physics steps of 1 ms a second on one core: `touchdown.gym`, crazyflow on the processor and MuJoCo, one after another in one run.

    pip install '.[gym]' crazyflow mujoco
    python python/benchmarks/side_by_side.py [SECONDS]

What a step contains differs:

- `touchdown.gym`: rigid body, attitude control at 500 Hz, four motors, ground effect of each rotor over a moving deck with the memory of the
  wake, four legs with friction, delay of the command;
- crazyflow: rigid body, attitude control, four motors; no ground effect, no contact;
- MuJoCo: a free body with four spheres as feet over a plane, and four thrusts; no motors, no control, no air.
"""

from __future__ import annotations

import os
import sys
import time
from collections.abc import Callable

# One core for all threads of all of them, before they are imported.
if hasattr(os, "sched_setaffinity"):
    os.sched_setaffinity(0, {min(os.sched_getaffinity(0))})
os.environ["XLA_FLAGS"] = "--xla_cpu_multi_thread_eigen=false intra_op_parallelism_threads=1"
os.environ["JAX_PLATFORMS"] = "cpu"

import numpy as np  # noqa: E402

# 1 ms steps from a decision to the next: 50 decisions a second.
STEPS = 20

MODEL = """
<mujoco><option timestep="0.001" integrator="Euler"/><worldbody><geom type="plane" size="5 5 0.1"/>
<body pos="0 0 1"><freejoint/><inertial pos="0 0 0" mass="1.37" diaginertia="0.012 0.012 0.02"/>
{}</body></worldbody><actuator>{}</actuator></mujoco>
"""


def rate(decide: Callable[[], object], steps: int, seconds: float) -> float:
    """Steps a second of processor time."""
    for _ in range(3):
        decide()
    start, done = time.process_time(), 0
    while (spent := time.process_time() - start) < seconds:
        decide()
        done += steps
    return done / spent


def ours(worlds: int, seconds: float) -> float:
    """The sea of `touchdown.gym`, around a hover."""
    from touchdown.gym import LandingVectorEnv

    envs = LandingVectorEnv(worlds, deck="sea", decision_s=STEPS * 1e-3, autoreset_mode="SameStep")
    envs.reset(seed=1)
    actions = 0.05 * np.random.default_rng(1).standard_normal((worlds, 3)) - np.array([0.01, 0.0, 0.0])
    assert envs.steps_per_decision == STEPS
    return rate(lambda: envs.step(actions), worlds * STEPS, seconds)


def crazyflow(worlds: int, seconds: float) -> float:
    """Its model from first principles, by attitude, hovering."""
    import jax
    from crazyflow.sim import Sim

    sim = Sim(n_worlds=worlds, n_drones=1, freq=1000, attitude_freq=500, device="cpu")
    sim.reset()
    command = np.zeros((worlds, 1, 4))
    command[..., 3] = 0.3

    def decide() -> None:
        sim.attitude_control(command)
        sim.step(STEPS)
        jax.block_until_ready(sim.data)

    return rate(decide, worlds * STEPS, seconds)


def mujoco(worlds: int, seconds: float) -> float:
    """A body that hovers by four thrusts, by MuJoCo's own rollouts in C."""
    import mujoco as mj
    from mujoco.rollout import rollout

    places = [(0.16 * x, 0.16 * y) for x in (1, -1) for y in (1, -1)]
    parts = [f'<geom type="sphere" size="0.02" mass="0" pos="{x} {y} -0.1"/><site name="r{k}" pos="{x} {y} 0"/>' for k, (x, y) in enumerate(places)]
    motors = [f'<motor site="r{k}" gear="0 0 1 0 0 0"/>' for k in range(4)]
    model = mj.MjModel.from_xml_string(MODEL.format("".join(parts), "".join(motors)))
    data = mj.MjData(model)
    mj.mj_step(model, data)
    full = mj.mjtState.mjSTATE_FULLPHYSICS
    state = np.empty(mj.mj_stateSize(model, full))
    mj.mj_getState(model, data, state, full)
    states = np.tile(state, (worlds, 1))
    control = np.full((worlds, STEPS, 4), 1.37 * 9.81 / 4)
    return rate(lambda: rollout(model, [data], states, control), worlds * STEPS, seconds)


def main() -> None:
    """Prints a table."""
    seconds = float(sys.argv[1]) if len(sys.argv) > 1 else 3.0
    print(f"{'':14} {'worlds':>6} {'M steps/s':>10}")
    for measure in (ours, crazyflow, mujoco):
        for worlds in (64, 1024):
            name = "touchdown.gym" if measure is ours else measure.__name__
            try:
                print(f"{name:14} {worlds:6} {measure(worlds, seconds) / 1e6:10.2f}", flush=True)
            except ImportError as error:
                print(f"{name:14} {worlds:6} {'–':>10}  {error}", flush=True)


if __name__ == "__main__":
    main()
