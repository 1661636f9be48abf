"""Identification from many files on many processes: the bits of one, whoever does what."""

from __future__ import annotations

import copy
import json
import multiprocessing
import os
import pickle
import subprocess
from concurrent.futures import Executor, Future, ProcessPoolExecutor, ThreadPoolExecutor
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow
import pyarrow.parquet
import pytest
from systems import driven

import sindy
from sindy._tasks import Driver

MODEL = sindy.SINDy("poly(2)", states=["x", "v"], inputs=["u"])


@pytest.fixture(scope="module")
def files(tmp_path_factory: pytest.TempPathFactory) -> list[str]:
    """x' = v, v' = -2 x - 0.4 v + u with noise, cut into six files of different lengths."""
    folder = tmp_path_factory.mktemp("runs")
    t, x, u = driven()
    x = x + 1e-3 * np.random.default_rng(5).normal(size=x.shape)
    names = []
    for k, rows in enumerate(np.array_split(np.arange(len(t)), [100, 350, 380, 900, 1200])):
        columns = {"t": t[rows], "x": x[rows, 0], "v": x[rows, 1], "u": u[rows, 0]}
        names.append(str(folder / f"run{k}.parquet"))
        pyarrow.parquet.write_table(pyarrow.table(columns), names[-1])
    return names


def data(file: str) -> dict[str, Any]:
    return {"x": pyarrow.parquet.read_table(file), "t": "t"}


def one_process(files: list[str]) -> sindy.SINDy:
    sums = sindy.PartialSums(MODEL, files, lambda k: data(files[k]))
    for k, file in enumerate(files):
        sums.add(k, **data(file))
    return sums.fit()


def same(a: sindy.SINDy, b: sindy.SINDy) -> bool:
    return a.to_json() == b.to_json() and a.equations_ == b.equations_ and a.candidates_ == b.candidates_


@pytest.mark.parametrize("workers", [1, 3])
@pytest.mark.parametrize("kind", ["threads", "processes"])
def test_prop_every_executor_gives_the_bits_of_one_process(files: list[str], kind: str, workers: int) -> None:
    expected = one_process(files)
    assert [len(terms) for terms in expected.model_.terms] == [1, 3]
    spawn = multiprocessing.get_context("spawn")
    made: Executor = ThreadPoolExecutor(workers) if kind == "threads" else ProcessPoolExecutor(workers, mp_context=spawn)
    told: list[tuple[int, int]] = []
    with made as executor:
        found = sindy.dist.fit(executor, files, MODEL, progress=lambda *at: told.append(at))
        pairs = sindy.dist.fit(executor, files, MODEL, files_per_task=4)
    assert same(found, expected) and same(pairs, expected)
    assert told == [(k, 6) for k in range(1, 7)]
    assert found.data_["trajectories"] == 6


def test_prop_every_division_gives_the_same_bits(files: list[str]) -> None:
    expected = one_process(files)
    empty = sindy.PartialSums(MODEL, files, lambda k: data(files[k]))
    rng = np.random.default_rng(3)
    for _ in range(10):
        parts = [copy.copy(empty) for _ in range(3)]
        for k in rng.permutation(len(files)):
            parts[rng.integers(3)].add(int(k), **data(files[k]))
        first, *others = (pickle.loads(pickle.dumps(part)) for part in parts)
        for part in others:
            first.merge(part)
        assert first.missing == [] and same(first.fit(), expected)
    assert empty.rows == 0 and empty.missing == files


def test_xval_the_bits_are_those_of_the_command(files: list[str]) -> None:
    command = os.environ.get("SINDY_COMMAND")
    if not command:
        pytest.skip("SINDY_COMMAND names no command to compare with")
    args = [command, "fit", *files, "--states", "x,v", "--inputs", "u", "--library", "poly(2)", "--stream", "--json"]
    said = json.loads(subprocess.run(args, check=True, capture_output=True).stdout)
    own = one_process(files)
    for state, terms in zip(["x", "v"], own.model_.terms):
        theirs = [(term["term"], term["coefficient"], term["std_error"]) for term in said["equations"][state]]
        assert theirs == [term[:3] for term in terms]


def dies(file: str) -> dict[str, Any]:
    if file.endswith("run3.parquet") and multiprocessing.parent_process() is not None:
        os._exit(1)
    return data(file)


def fails(file: str) -> dict[str, Any]:
    if file.endswith("run3.parquet") and multiprocessing.parent_process() is not None:
        raise OSError(f"{file}: the disk is away")
    return data(file)


class Dying:
    """Kills the first worker that reads the fourth file."""

    def __init__(self, folder: Path) -> None:
        self.mark = folder / "died"

    def __call__(self, file: str) -> dict[str, Any]:
        if file.endswith("run3.parquet") and multiprocessing.parent_process() is not None and not self.mark.exists():
            self.mark.write_text("")
            os._exit(1)
        return data(file)


def test_prop_workers_that_fail_are_one_clear_error(files: list[str], tmp_path: Path) -> None:
    spawn = multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(2, mp_context=spawn) as executor:
        with pytest.raises(RuntimeError, match="files 3 to before 4 failed 2 times in all.*the disk is away"):
            sindy.dist.fit(executor, files, MODEL, read=fails, retries=1)
        with pytest.raises(RuntimeError, match="the executor is broken.*Give a function"):
            sindy.dist.fit(executor, files, MODEL, read=dies)
    made = lambda: ProcessPoolExecutor(2, mp_context=spawn)
    with pytest.raises(RuntimeError, match="executors failed 2 times in all"):
        sindy.dist.fit(made, files, MODEL, read=dies, retries=1)
    # One worker is killed, once: a new pool goes on.
    found = sindy.dist.fit(made, files, MODEL, read=Dying(tmp_path))
    assert (tmp_path / "died").exists() and same(found, one_process(files))


def test_prop_a_larger_task_has_more_time() -> None:
    with ThreadPoolExecutor(2) as executor:
        driver: Driver[None] = Driver(executor, lambda *_: None, lambda task: task, retries=0, what="", rest="")
        assert driver._patience_s() is None, "before a task was timed"
        # A block took 2 s. Then 50 blocks of one task have 100 s, and three times as much counts as a hang.
        driver.seconds[(0, 1)] = 2.0
        driver._flying[Future()] = (1, 51)
        assert driver._patience_s() == 300.0
        # The slowest block counts, not the longest task; a small task has ten seconds at least.
        driver.seconds[(51, 61)] = 5.0
        driver._flying = {Future(): (61, 62)}
        assert driver._patience_s() == 10.0


def test_prop_bad_input_names_the_file(files: list[str], tmp_path: Path) -> None:
    bad = tmp_path / "bad.parquet"
    pyarrow.parquet.write_table(pyarrow.table({"t": [0.0, 2.0, 1.0], "x": [1.0] * 3, "v": [1.0] * 3, "u": [1.0] * 3}), bad)
    with ThreadPoolExecutor(2) as executor:
        # Behind the rows that decide, and among them.
        many = {"x": np.zeros((60_000, 2)) + np.sin(np.arange(60_000))[:, None], "t": 0.1, "u": np.zeros((60_000, 1))}
        with pytest.raises(sindy.SindyError, match=r"bad.parquet: time does not increase at sample 2"):
            sindy.dist.fit(executor, ["long", str(bad)], MODEL, read=lambda f: many if f == "long" else data(f))
        with pytest.raises(sindy.SindyError, match="`files`: expected at least one"):
            sindy.dist.fit(executor, [], MODEL)
        with pytest.raises(sindy.SindyError, match=r"end in .parquet, .csv or .npy"):
            sindy.dist.fit(executor, ["a.txt"], MODEL)
        with pytest.raises(sindy.SindyError, match="`read`: expected a dict"):
            sindy.dist.fit(executor, files, MODEL, read=lambda _: 1)  # type: ignore[arg-type, return-value]
        with pytest.raises(sindy.SindyError, match="`solver`: expected none"):
            sindy.dist.fit(executor, files, sindy.SINDy(solver=sindy.STLSQ()))
        with pytest.raises(sindy.SindyError, match="`executor`: expected an executor"):
            sindy.dist.fit(3, files, MODEL)  # type: ignore[arg-type]
    sums = sindy.PartialSums(MODEL, files, lambda k: data(files[k])).add(1, **data(files[1]))
    with pytest.raises(sindy.SindyError, match="partial sums: expected those of all 6 sources, found none of 5"):
        sums.fit()
    with pytest.raises(sindy.SindyError, match="each source once"):
        sums.add(1, **data(files[1]))
    other = sindy.PartialSums(sindy.SINDy("poly(3)", states=["x", "v"], inputs=["u"]), files, lambda k: data(files[k]))
    with pytest.raises(sindy.SindyError, match="partial sums: terms: expected"):
        sums.merge(other)


def test_prop_dask_gives_the_bits_of_one_process(files: list[str]) -> None:
    distributed = pytest.importorskip("distributed")
    with distributed.LocalCluster(
        n_workers=2, threads_per_worker=1, processes=True, dashboard_address=None
    ) as cluster, distributed.Client(cluster) as client:
        found = sindy.dist.fit(client.get_executor(), files, MODEL)
    assert same(found, one_process(files))


def test_prop_ray_gives_the_bits_of_one_process(
    files: list[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    # Otherwise it writes a token into the home of whoever runs the tests.
    monkeypatch.setenv("RAY_AUTH_MODE", "disabled")
    # Where its workers find this file.
    monkeypatch.setenv("PYTHONPATH", os.pathsep.join([str(Path(__file__).parent), os.environ.get("PYTHONPATH", "")]))
    ray = pytest.importorskip("ray")
    ray.init(num_cpus=2, include_dashboard=False, log_to_driver=False, configure_logging=False)
    try:
        found = sindy.dist.fit(sindy.dist.RayExecutor(num_cpus=1), files, MODEL)
    finally:
        ray.shutdown()
    assert same(found, one_process(files))
