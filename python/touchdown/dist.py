"""Campaigns on many processes or machines, by any executor.

The unit of work is a block of landings, which a worker writes as one Parquet file into a folder that all of them see, or
into object storage.
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
from collections.abc import Callable
from concurrent.futures import Executor
from multiprocessing import parent_process
from statistics import median

from sindy import _native
from sindy._errors import fault
from sindy._solvers import threads
from sindy._tasks import Driver, RayExecutor, Task, check

from ._campaign import Campaign, Progress, _begin, _Begun, _ranges
from ._land import Scenario
from ._trial import Path

__all__ = ["RayExecutor", "campaign"]

# Seconds until a file that a worker has written must be seen here: clients of NFS keep what they know of a folder for up
# to 60 s by default. Half of it would refuse such disks, twice as long only delays the error.
SEEN_WITHIN_S = 60.0

# Blocks that are timed where tasks are sized by time: points of a campaign take different times, and four differ from the
# mean of all by half of what one does. More would be flown as tasks that are too short.
TIMED = 4


def _fly(folder: str, sha256: str, first: int, end: int, jobs: int) -> None:
    """What a worker does: blocks from `first` to before `end`."""
    parent = parent_process()

    def look(_flown: int) -> None:
        # A worker whose parent was killed would fly on for nobody.
        if parent is not None and not parent.is_alive():
            os._exit(1)

    _native.campaign_fly(folder, sha256, first, end, jobs, look)


def campaign(
    executor: Executor | Callable[[], Executor],
    sweep: Scenario,
    out: Path,
    *,
    trials: int | None = None,
    seed: int | None = None,
    blocks_per_task: int = 1,
    task_s: float | None = None,
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
        The folder, on a disk that the workers see at the same path, or an address in object storage as of
        `touchdown.campaign`, whose keys the workers have in their environment. Blocks that are there are not flown again.
    blocks_per_task : int
        Blocks that a worker gets at a time. A task of some seconds is long enough for all executors; `block` in the sweep
        sets the landings of a block.
    task_s : float, optional
        Seconds that a task is to take, instead of `blocks_per_task`: four blocks, spread over the campaign, are flown one a
        task and timed, the others are shared out by their median.
    retries : int
        How often a task that fails, by whatever but a fault of the sweep, is handed out again; and how many executors in
        succession may break without a task done. A task of a worker that hangs is handed out once more: where none has
        ended for three times as long as the longest took, for its size, and for ten seconds.
    progress : callable, optional
        Called with the landings that are there and those of the campaign, after every task. What it raises ends the
        campaign.
    n_jobs : int
        Threads of each task.
    """
    check(executor, blocks_per_task=(blocks_per_task, 1), retries=(retries, 0))
    if task_s is not None and not (0.0 < task_s < float("inf") and blocks_per_task == 1):
        raise fault("task_s", "seconds above 0, without blocks_per_task", task_s)
    # A pool of threads of its own, which ends with the call: workers may be forked from this process.
    cores = os.cpu_count() or 1
    begun = _begin(sweep, out, trials, seed, True, cores)
    there = begun.there()

    def told(task: Task | None = None, _result: None = None) -> None:
        nonlocal there
        there += sum(begun.rows(block) for block in range(*task)) if task else 0
        if progress is not None:
            progress(there, begun.landings)

    told()
    if begun.missing:
        jobs = threads(n_jobs) or 1
        driver = Driver(
            executor,
            _fly,
            lambda task: (begun.folder, begun.sha256, *task, jobs),
            retries=retries,
            what="blocks",
            rest=f"The blocks that were flown are in {begun.folder}; the same call flies the others",
            done=lambda task: begun.seen().issuperset(range(*task)),
        )
        whole = False
        try:
            missing = begun.missing
            if task_s is not None:
                timed = missing[:: max(1, len(missing) // TIMED)][:TIMED]
                driver.run(_ranges(timed, 1), told)
                missing = sorted(set(missing).difference(timed))
                blocks_per_task = _blocks_per_task(list(driver.seconds.values()), task_s)
            driver.run(_ranges(missing, blocks_per_task), told)
            whole = True
        finally:
            driver.end(whole)
    _until_seen(begun)
    return begun.read(cores)


def _blocks_per_task(block_s: list[float], task_s: float) -> int:
    """Blocks that take about `task_s`, by the times of some. One where no time is known: their workers were killed."""
    return max(1, round(task_s / max(median(block_s), 1e-3))) if block_s else 1


def _until_seen(begun: _Begun) -> None:
    """Waits until the blocks that workers have written are seen here."""
    end = time.monotonic() + SEEN_WITHIN_S
    while missing := sorted(set(begun.missing) - begun.seen()):
        if time.monotonic() > end:
            raise RuntimeError(
                f"{len(missing)} blocks that workers have written, such as {missing[0]}, are not in {begun.folder}: is it on "
                "a disk that all workers see at the same path?"
            )
        time.sleep(0.2)
