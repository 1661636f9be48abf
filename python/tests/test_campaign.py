"""Campaigns from Python and on many processes: the command's bytes, whoever is killed."""

from __future__ import annotations

import json
import multiprocessing
import os
import shutil
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Callable
from concurrent.futures import Executor, Future, ProcessPoolExecutor, ThreadPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import touchdown as td

unix = pytest.mark.skipif(sys.platform == "win32", reason="signals of Unix")

# 48 landings in 8 blocks of six.
SWEEP: dict[str, Any] = {
    "trials": 24,
    "block": 6,
    "grid": {"control.controller": ["observer", "dynamic+observer"]},
    "random": {"ground_effect_strength": {"kind": "uniform", "min": 0.4, "max": 0.8}},
    "scenario": {"deck": {"kind": "sea"}},
}


def files(folder: Path) -> dict[str, bytes]:
    return {str(p.relative_to(folder)): p.read_bytes() for p in sorted(folder.rglob("*")) if p.is_file()}


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The campaign as one process flies it."""
    out = tmp_path_factory.mktemp("whole") / "campaign"
    told: list[tuple[int, int]] = []
    # One thread: a second of work even in a release build, twenty looks.
    campaign = td.campaign(SWEEP, out, progress=lambda *at: told.append(at), n_jobs=1)
    assert told[-1] == (48, 48) and told == sorted(told) and len(told) > 2
    assert len(campaign["landing"]) == 48 and campaign.folder == str(out)
    assert campaign.trace(3)["position_m"].shape[1] == 3
    return out


def test_xval_the_bytes_are_those_of_the_command(whole: Path, tmp_path: Path) -> None:
    command = os.environ.get("TOUCHDOWN_COMMAND")
    if not command:
        pytest.skip("TOUCHDOWN_COMMAND names no command to compare with")
    run = [command, "campaign", str(whole / "sweep.toml"), "--out", str(tmp_path / "by"), "--quiet"]
    subprocess.run(run, check=True, capture_output=True)
    by = files(tmp_path / "by")
    own = files(whole)
    assert sorted(own) == sorted(name for name in by if not name.startswith(("figures", "report")))
    assert all(by[name] == content for name, content in own.items())
    shutil.copytree(whole, tmp_path / "copy")
    report = td.Campaign.read(tmp_path / "copy").report()
    assert report == str(tmp_path / "copy" / "report.html")
    assert files(tmp_path / "copy") == by
    status = subprocess.run([command, "campaign", "status", str(whole), "--json"], check=True, capture_output=True)
    assert json.loads(status.stdout) == td.campaign_status(whole)


def test_prop_a_campaign_goes_on_where_it_was(whole: Path, tmp_path: Path) -> None:
    class Enough(Exception):
        pass

    def few(there: int, _of: int) -> None:
        if there >= 12:
            raise Enough

    out = tmp_path / "campaign"
    with pytest.raises(Enough):
        td.campaign(SWEEP, out, progress=few, n_jobs=1)
    status = td.campaign_status(out)
    assert 0 < status["blocks_there"] < 8 and not status["complete"] and status["rows"] == 6 * status["blocks_there"]
    with pytest.raises(FileNotFoundError, match="block-0000"):
        td.Campaign.read(out)
    with pytest.raises(td.SindyError, match="resume"):
        td.campaign(SWEEP, out, resume=False)
    with pytest.raises(td.SindyError, match="other settings"):
        td.campaign(SWEEP, out, seed=2)
    assert "results.json" not in files(out)
    campaign = td.campaign(SWEEP, out)
    assert files(out) == files(whole)
    again = td.Campaign.read(out)
    assert again.results == campaign.results == json.loads((out / "results.json").read_text())
    assert np.array_equal(again["v_l_mps"], campaign["v_l_mps"], equal_nan=True)


_INTERRUPTED = """
import os, sys, time, signal, threading, touchdown as td
signal.signal(signal.SIGINT, signal.default_int_handler)
at = []
def interrupt():
    at.append(time.monotonic())
    signal.raise_signal(signal.SIGINT)
counts = [0]
def count():
    while True:
        counts[0] += 1
        time.sleep(0.001)
threading.Thread(target=count, daemon=True).start()
threading.Timer(1.5, interrupt).start()
try:
    td.campaign({"trials": 3000, "block": 100}, sys.argv[1])
    print("finished")
except KeyboardInterrupt:
    print(time.monotonic() - at[0], counts[0])
sys.stdout.flush()
os._exit(0)
"""


@unix
def test_prop_ctrl_c_stops_a_campaign_and_others_may_run_meanwhile(tmp_path: Path) -> None:
    done = subprocess.run([sys.executable, "-c", _INTERRUPTED, str(tmp_path)], capture_output=True, text=True, timeout=300)
    said = done.stdout.split()
    assert said and said[0] != "finished", done.stderr
    # 0.2 s is what is promised; a loaded machine may schedule late. The other thread counts once a millisecond at most; with
    # the interpreter's lock held it would count no further than some.
    assert float(said[0]) < 1.0 and int(said[1]) > 100, said


def _dies(marker: str, fn: Callable[..., Any], *args: Any) -> Any:
    """The first call is killed in its middle, with the process that runs it; `marker` says what it had written by then."""
    try:
        os.close(os.open(marker, os.O_CREAT | os.O_EXCL))
    except FileExistsError:
        return fn(*args)
    folder, first = args[1], args[3]

    def die() -> None:
        block = Path(folder) / "landings" / f"block-{first:06}.parquet"
        Path(marker).write_text(f"{block.exists()} {os.getpid()}")
        os.kill(os.getpid(), signal.SIGKILL)

    # Six landings take 0.15 s in a release build (400 took 10 s of one core); on a machine three times as fast they go on, too.
    threading.Timer(0.03, die).start()
    fn(*args)
    # Had it been faster than that, it would be killed all the same, and the test would say that it was late.
    time.sleep(60.0)
    raise AssertionError("not killed")


class Dying(Executor):
    """An executor whose first worker is killed by SIGKILL in the middle of its block."""

    def __init__(self, of: Executor, marker: Path) -> None:
        self.of = of
        self.marker = str(marker)

    def submit(self, fn: Callable[..., Any], /, *args: Any, **kwargs: Any) -> Future[Any]:
        return self.of.submit(_dies, self.marker, fn, *args, **kwargs)

    def shutdown(self, wait: bool = True, *, cancel_futures: bool = False) -> None:
        self.of.shutdown(wait, cancel_futures=cancel_futures)


def _killed_in_the_middle(marker: Path) -> bool:
    written, pid = marker.read_text().split()
    return written == "False" and int(pid) != os.getpid()


@unix
@pytest.mark.parametrize("start", ["spawn", "fork"])
def test_prop_a_killed_process_changes_no_byte(whole: Path, tmp_path: Path, start: str) -> None:
    made: list[ProcessPoolExecutor] = []

    def make() -> Executor:
        made.append(ProcessPoolExecutor(2, mp_context=multiprocessing.get_context(start)))
        return Dying(made[-1], tmp_path / "marker")

    told: list[tuple[int, int]] = []
    out = tmp_path / "campaign"
    campaign = td.dist.campaign(make, SWEEP, out, progress=lambda *at: told.append(at))
    assert _killed_in_the_middle(tmp_path / "marker") and len(made) == 2
    assert files(out) == files(whole)
    assert told[0] == (0, 48) and told[-1] == (48, 48) and told == sorted(told)
    assert len(campaign["landing"]) == 48
    # Complete: no worker is asked.
    td.dist.campaign(lambda: pytest.fail("made"), SWEEP, out)


@unix
def test_prop_an_executor_that_is_broken_says_how_to_go_on(whole: Path, tmp_path: Path) -> None:
    out = tmp_path / "campaign"
    with ProcessPoolExecutor(1, mp_context=multiprocessing.get_context("spawn")) as pool:
        with pytest.raises(RuntimeError, match="Give a function that makes executors") as raised:
            td.dist.campaign(Dying(pool, tmp_path / "marker"), SWEEP, out)
        assert isinstance(raised.value.__cause__, BrokenProcessPool)
    with ProcessPoolExecutor(2, mp_context=multiprocessing.get_context("spawn")) as pool:
        td.dist.campaign(pool, SWEEP, out, blocks_per_task=3)
    assert files(out) == files(whole)


class Failing(Executor):
    """Fails some calls, and runs the others in place."""

    def __init__(self, failures: dict[int, int]) -> None:
        self.failures = failures
        self.calls: list[tuple[int, int]] = []

    def submit(self, fn: Callable[..., Any], /, *args: Any, **kwargs: Any) -> Future[Any]:
        future: Future[Any] = Future()
        first, end = args[3], args[4]
        self.calls.append((first, end))
        if self.failures.get(first, 0) > 0:
            self.failures[first] -= 1
            future.set_exception(OSError("the disk is away"))
        else:
            future.set_result(fn(*args, **kwargs))
        return future


def test_prop_tasks_are_tried_again_so_many_times(whole: Path, tmp_path: Path) -> None:
    out = tmp_path / "campaign"
    shutil.copytree(whole, out)
    for block in (3, 5):
        (out / "landings" / f"block-{block:06}.parquet").unlink()
    never = Failing({3: 99})
    with pytest.raises(RuntimeError, match=r"blocks 3 to before 4 failed 3 times in all.*the disk is away"):
        td.dist.campaign(never, SWEEP, out, retries=2)
    assert never.calls.count((3, 4)) == 3
    assert td.campaign_status(out)["missing"] == [[3, 4]]
    seldom = Failing({3: 3})
    td.dist.campaign(seldom, SWEEP, out)
    # What is there is not flown again.
    assert seldom.calls == [(3, 4)] * 4
    assert files(out) == files(whole)
    with pytest.raises(td.SindyError, match="an executor"):
        td.dist.campaign(3, SWEEP, out)  # type: ignore[arg-type]
    # A fault of the sweep is not tried again, and nothing is begun.
    with pytest.raises(td.SindyError, match="timeout_s"):
        td.dist.campaign(never, {"scenario": {"timeout_s": -1.0}}, tmp_path / "none")
    assert not (tmp_path / "none").exists()


class Hanging(Executor):
    """An executor whose first call goes on only when the test is over."""

    def __init__(self, of: Executor) -> None:
        self.of = of
        self.over = threading.Event()
        self.calls: list[tuple[int, int]] = []

    def submit(self, fn: Callable[..., Any], /, *args: Any, **kwargs: Any) -> Future[Any]:
        self.calls.append((args[3], args[4]))
        if len(self.calls) > 1:
            return self.of.submit(fn, *args, **kwargs)

        def hangs() -> Any:
            self.over.wait()
            return fn(*args, **kwargs)

        return self.of.submit(hangs)


def test_prop_a_task_of_a_worker_that_hangs_is_handed_out_once_more(
    whole: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    # Blocks take 0.2 s: a test need not wait for ten seconds.
    monkeypatch.setattr("sindy._tasks.LEAST_SILENCE_S", 0.5)
    out = tmp_path / "campaign"
    with ThreadPoolExecutor(2) as pool:
        hanging = Hanging(pool)
        try:
            told: list[int] = []
            td.dist.campaign(hanging, SWEEP, out, progress=lambda there, _: told.append(there))
            # The eight blocks, and the first one again; other slow ones may be handed out twice as well, none thrice.
            assert hanging.calls[0] == (0, 1) and hanging.calls[8:].count((0, 1)) == 1
            assert all(hanging.calls.count(task) <= 2 for task in hanging.calls)
            assert told[-1] == 48 and len(told) == 9
            assert files(out) == files(whole)
        finally:
            hanging.over.set()
    # The late flight has the same bytes.
    assert files(out) == files(whole)


def test_prop_tasks_are_sized_by_time(tmp_path: Path) -> None:
    sweep = SWEEP | {"block": 1}
    calls = Failing({})
    td.dist.campaign(calls, sweep, tmp_path / "long", task_s=1e6)
    timed = [(0, 1), (12, 13), (24, 25), (36, 37)]
    assert calls.calls == [*timed, (1, 12), (13, 24), (25, 36), (37, 48)]
    short = Failing({})
    td.dist.campaign(short, sweep, tmp_path / "short", task_s=1e-6)
    assert short.calls[:4] == timed and sorted(short.calls) == [(k, k + 1) for k in range(48)]
    assert files(tmp_path / "long") == files(tmp_path / "short")
    for bad in [{"task_s": 0.0}, {"task_s": float("nan")}, {"task_s": 1.0, "blocks_per_task": 2}]:
        with pytest.raises(td.SindyError, match="`task_s`: expected seconds above 0"):
            td.dist.campaign(calls, sweep, tmp_path / "none", **bad)  # type: ignore[arg-type]


_PARENT = """
import sys, time, threading, os, touchdown as td
from concurrent.futures import ProcessPoolExecutor
import multiprocessing

def watch():
    while not (pids := [p.pid for p in multiprocessing.active_children()]) or not os.path.exists(sys.argv[1] + "/sweep.toml"):
        time.sleep(0.01)
    time.sleep(2.0)
    print(*pids, flush=True)

if __name__ == "__main__":
    threading.Thread(target=watch, daemon=True).start()
    make = lambda: ProcessPoolExecutor(1, mp_context=multiprocessing.get_context("spawn"))
    td.dist.campaign(make, {"trials": 100000, "block": 100000}, sys.argv[1])
"""


@pytest.mark.skipif(sys.platform != "linux", reason="reads /proc")
def test_prop_workers_end_with_their_parent(tmp_path: Path) -> None:
    script = tmp_path / "parent.py"
    script.write_text(_PARENT)
    parent = subprocess.Popen([sys.executable, str(script), str(tmp_path / "out")], stdout=subprocess.PIPE, text=True)
    assert parent.stdout is not None
    pids = [int(pid) for pid in parent.stdout.readline().split()]
    parent.kill()
    parent.wait()
    assert pids

    def flies(pid: int) -> bool:
        """Whether the process takes processor time."""
        try:
            before = Path(f"/proc/{pid}/stat").read_text().rsplit(")", 1)[1].split()
            time.sleep(0.3)
            after = Path(f"/proc/{pid}/stat").read_text().rsplit(")", 1)[1].split()
        except OSError:
            return False
        return int(after[11]) - int(before[11]) > 5

    end = time.monotonic() + 20.0
    while any(flies(pid) for pid in pids):
        assert time.monotonic() < end, "a worker flies on for nobody"


@unix
def test_prop_a_killed_worker_of_dask_changes_no_byte(whole: Path, tmp_path: Path) -> None:
    distributed = pytest.importorskip("distributed")
    out = tmp_path / "campaign"
    with distributed.LocalCluster(
        n_workers=2, threads_per_worker=1, processes=True, dashboard_address=None
    ) as cluster, distributed.Client(cluster) as client:
        td.dist.campaign(Dying(client.get_executor(), tmp_path / "marker"), SWEEP, out)
    assert _killed_in_the_middle(tmp_path / "marker")
    assert files(out) == files(whole)


@unix
def test_prop_a_killed_worker_of_ray_changes_no_byte(
    whole: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    # Otherwise it writes a token into the home of whoever runs the tests.
    monkeypatch.setenv("RAY_AUTH_MODE", "disabled")
    # Where its workers find this file.
    monkeypatch.setenv("PYTHONPATH", os.pathsep.join([str(Path(__file__).parent), os.environ.get("PYTHONPATH", "")]))
    ray = pytest.importorskip("ray")
    out = tmp_path / "campaign"
    ray.init(num_cpus=2, include_dashboard=False, log_to_driver=False, configure_logging=False)
    try:
        td.dist.campaign(Dying(td.dist.RayExecutor(num_cpus=1), tmp_path / "marker"), SWEEP, out)
    finally:
        ray.shutdown()
    assert _killed_in_the_middle(tmp_path / "marker")
    assert files(out) == files(whole)
