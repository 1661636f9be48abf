"""Campaigns on many processes or machines, by any executor.

The unit of work is a block of landings, which a worker writes as one Parquet file into a folder that all of them see.
Nothing but the number of the block travels. Blocks are pure functions of the sweep, and appear whole or not at all, so a
block may be flown again, or twice: the bytes are those of one process.

>>> import tempfile, touchdown as td
>>> from concurrent.futures import ThreadPoolExecutor
>>> sweep = {"trials": 3, "block": 1, "scenario": {"timeout_s": 30.0}}
>>> with tempfile.TemporaryDirectory() as folder, ThreadPoolExecutor(2) as executor:
...     td.dist.campaign(executor, sweep, folder)
Campaign(3 landings, 3 landed)
"""

from __future__ import annotations

import os
import time
from collections import Counter, deque
from collections.abc import Callable
from concurrent.futures import BrokenExecutor, Executor, Future
from concurrent.futures import wait as wait_for
from multiprocessing import parent_process
from queue import SimpleQueue
from typing import Any

from sindy import SindyError, _native
from sindy._errors import fault
from sindy._solvers import threads

from ._campaign import Campaign, Progress, _begin, _Begun, _ranges
from ._land import Scenario
from ._trial import Path

__all__ = ["RayExecutor", "campaign"]

# Seconds until a file that a worker has written must be seen here: clients of NFS keep what they know of a folder for up
# to 60 s by default. Half of it would refuse such disks, twice as long only delays the error.
SEEN_WITHIN_S = 60.0

Task = tuple[int, int]


def _fly(folder: str, sha256: str, first: int, end: int, jobs: int) -> None:
    """What a worker does: blocks from `first` to before `end`."""
    parent = parent_process()

    def look(_flown: int) -> None:
        # A worker whose parent was killed would fly on for nobody.
        if parent is not None and not parent.is_alive():
            os._exit(1)

    _native.campaign_fly(folder, sha256, first, end, jobs, look)


class RayExecutor(Executor):
    """Ray as an executor: every call is a task of Ray.

    Parameters
    ----------
    **options
        Those of ``ray.remote``, such as ``num_cpus``, ``max_retries`` or ``resources``. Ray flies the task of a killed
        worker again by itself, by default three times.

    `ray.init` is called if nobody has.
    """

    def __init__(self, **options: Any) -> None:
        import ray

        if not ray.is_initialized():
            ray.init()
        self._ray = ray
        self._options = options
        self._remote: dict[Callable[..., Any], Any] = {}
        self._flying: dict[Future[Any], Any] = {}

    def submit(self, fn: Callable[..., Any], /, *args: Any, **kwargs: Any) -> Future[Any]:
        """Hands a call to Ray."""
        if fn not in self._remote:
            remote = self._ray.remote(fn)
            self._remote[fn] = remote.options(**self._options) if self._options else remote
        ref = self._remote[fn].remote(*args, **kwargs)
        future: Future[Any] = ref.future()
        self._flying[future] = ref
        future.add_done_callback(lambda done: self._flying.pop(done, None))
        return future

    def shutdown(self, wait: bool = True, *, cancel_futures: bool = False) -> None:
        """Ends the executor, not Ray."""
        if cancel_futures:
            for ref in list(self._flying.values()):
                self._ray.cancel(ref, force=True)
        if wait:
            wait_for(list(self._flying))


class _Driver:
    """Hands out blocks, and hands them out again where workers fail."""

    def __init__(self, executor: Executor | Callable[[], Executor], begun: _Begun, retries: int, jobs: int) -> None:
        self._make = None if isinstance(executor, Executor) else executor
        self._executor = executor if isinstance(executor, Executor) else executor()
        self._begun, self._retries, self._jobs = begun, retries, jobs
        self._failures: Counter[Task] = Counter()
        self._breaks = 0
        self._flying: dict[Future[None], Task] = {}
        self._ended: SimpleQueue[Future[None]] = SimpleQueue()

    def fly(self, tasks: list[Task], told: Callable[[Task], None]) -> None:
        """Until all tasks are done; `told` of each."""
        todo = deque(tasks)
        while todo or self._flying:
            broken: BrokenExecutor | None = None
            try:
                while todo:
                    self._submit(todo[0])
                    todo.popleft()
            except BrokenExecutor as error:
                broken = error
            if broken is None:
                ended = self._ended.get()
                if ended not in self._flying:
                    continue  # Of an executor that broke.
                task = self._flying.pop(ended)
                try:
                    ended.result()
                    self._breaks = 0
                    told(task)
                    continue
                except SindyError:
                    raise  # A fault of the sweep is one on every worker.
                except BrokenExecutor as error:
                    broken = error
                    todo.append(task)
                except Exception as error:
                    self._failures[task] += 1
                    if self._failures[task] > self._retries:
                        raise self._gives_up(f"blocks {task[0]} to before {task[1]}", self._failures[task], error) from error
                    todo.append(task)
                    continue
            # All tasks of a broken executor fail with it; some may be done.
            lost, self._flying = list(self._flying.values()), {}
            for task in lost:
                if all(self._begun.has(block) for block in range(*task)):
                    told(task)
                else:
                    todo.append(task)
            self._renew(broken)

    def _submit(self, task: Task) -> None:
        begun = self._begun
        future = self._executor.submit(_fly, begun.folder, begun.sha256, *task, self._jobs)
        self._flying[future] = task
        future.add_done_callback(self._ended.put)

    def _renew(self, broken: BrokenExecutor) -> None:
        if self._make is None:
            raise RuntimeError(
                f"the executor is broken ({broken}): a worker was killed. Give a function that makes executors, such as "
                "`lambda: ProcessPoolExecutor(4)`, and a new one goes on. The blocks that were flown are in "
                f"{self._begun.folder}; the same call flies the others"
            ) from broken
        self._breaks += 1
        if self._breaks > self._retries:
            raise self._gives_up("executors", self._breaks, broken) from broken
        self._executor.shutdown(wait=False, cancel_futures=True)
        self._executor = self._make()

    def _gives_up(self, what: str, times: int, error: Exception) -> RuntimeError:
        return RuntimeError(
            f"{what} failed {times} times in all, the last time with {error!r}. The blocks that were flown are in "
            f"{self._begun.folder}; the same call flies the others"
        )

    def end(self, whole: bool) -> None:
        """Nothing more is begun; what this driver made is ended."""
        for future in self._flying:
            future.cancel()
        if self._make is not None:
            self._executor.shutdown(wait=whole, cancel_futures=True)


def campaign(
    executor: Executor | Callable[[], Executor],
    sweep: Scenario,
    out: Path,
    *,
    trials: int | None = None,
    seed: int | None = None,
    blocks_per_task: int = 1,
    retries: int = 3,
    progress: Progress | None = None,
    n_jobs: int = 1,
) -> Campaign:
    """Flies a campaign on the workers of an executor. The folder has the bytes of `touchdown.campaign`.

    Parameters
    ----------
    executor : Executor, or a function that makes one
        Any of ``concurrent.futures``' kind. Tested are ``ProcessPoolExecutor``, ``dask.distributed.Client.get_executor()``
        and `RayExecutor`; Parsl and mpi4py have such executors too. A process pool breaks when a worker is killed, and a function can make a new one; what
        it makes is ended here, an executor that is given is not.
    sweep, trials, seed
        As of `touchdown.campaign`.
    out : path
        The folder, on a disk that the workers see at the same path. Blocks that are there are not flown again.
    blocks_per_task : int
        Blocks that a worker gets at a time. A task of some seconds is long enough for all executors; `block` in the sweep
        sets the landings of a block.
    retries : int
        How often a task that fails, by whatever but a fault of the sweep, is handed out again; and how many executors in
        succession may break without a task done.
    progress : callable, optional
        Called with the landings that are there and those of the campaign, after every task. What it raises ends the
        campaign.
    n_jobs : int
        Threads of each task.
    """
    for name, value, least in (("blocks_per_task", blocks_per_task, 1), ("retries", retries, 0)):
        if value < least:
            raise fault(name, f"at least {least}", value)
    if not (isinstance(executor, Executor) or callable(executor)):
        raise fault("executor", "an executor, or a function that makes one", type(executor).__name__)
    # A pool of threads of its own, which ends with the call: workers may be forked from this process.
    cores = os.cpu_count() or 1
    begun = _begin(sweep, out, trials, seed, True, cores)
    there = begun.there()

    def told(task: Task | None = None) -> None:
        nonlocal there
        there += sum(begun.rows(block) for block in range(*task)) if task else 0
        if progress is not None:
            progress(there, begun.landings)

    told()
    if begun.missing:
        driver = _Driver(executor, begun, retries, threads(n_jobs) or 1)
        whole = False
        try:
            driver.fly(_ranges(begun.missing, blocks_per_task), told)
            whole = True
        finally:
            driver.end(whole)
    _until_seen(begun)
    return begun.read(cores)


def _until_seen(begun: _Begun) -> None:
    """Waits until the blocks that workers have written are seen here."""
    end = time.monotonic() + SEEN_WITHIN_S
    while missing := [block for block in begun.missing if not begun.has(block)]:
        if time.monotonic() > end:
            raise RuntimeError(
                f"{len(missing)} blocks that workers have written, such as {missing[0]}, are not in {begun.folder}: is it on "
                "a disk that all workers see at the same path?"
            )
        time.sleep(0.2)
