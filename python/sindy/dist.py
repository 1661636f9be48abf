"""Identification from many files on many processes or machines, by any executor.

The unit of work is a file. A worker passes once over the rows of its files and sends back their partial sums, some MB
whatever the number of rows. The sums are added in the order of the files, so the model has the bits of one process for every
executor, every number of workers and every order in which they end.

>>> import numpy as np, sindy
>>> from concurrent.futures import ThreadPoolExecutor
>>> def run(k):  # x' = y, y' = -x
...     t = np.arange(0.0, 5.0, 0.01) + k
...     return {"x": np.column_stack([np.sin(t), np.cos(t)]), "t": t}
>>> model = sindy.SINDy("poly(1)", states=["x", "y"])
>>> with ThreadPoolExecutor(2) as executor:
...     sindy.dist.fit(executor, range(8), model, read=run).equations(2)
['1.0*y', '-1.0*x']
"""

from __future__ import annotations

import copy
import os
from collections.abc import Callable, Sequence
from concurrent.futures import Executor
from multiprocessing import parent_process
from pathlib import Path
from typing import Any

from ._errors import SindyError, fault
from ._model import SINDy
from ._partial import PartialSums
from ._solvers import threads
from ._tasks import Driver, RayExecutor, Task, check

__all__ = ["RayExecutor", "fit"]

# Every task carries the names of all files, so their number is limited.
TASKS = 256

Read = Callable[[Any], dict[str, Any]]


class _Table:
    """Reads a file by its name; a class, so that it can be pickled with its settings."""

    def __init__(self, t: Any) -> None:
        self.t = t

    def __call__(self, file: Any) -> dict[str, Any]:
        path = Path(file)
        kind = path.suffix.lower()
        if kind == ".npy":
            import numpy as np

            return {"x": np.load(path, mmap_mode="r"), "t": self.t}
        if kind == ".parquet":
            import pyarrow.parquet

            return {"x": pyarrow.parquet.read_table(path), "t": self.t}
        if kind == ".csv":
            import pyarrow.csv

            return {"x": pyarrow.csv.read_csv(path), "t": self.t}
        raise fault("files", "names that end in .parquet, .csv or .npy, or a function `read`", str(file))


def _read(read: Read, file: Any) -> dict[str, Any]:
    data = read(file)
    if not isinstance(data, dict):
        raise fault("read", "a dict of x, t, u, …, as `SINDy.fit` takes them", type(data).__name__)
    return data


def _named(file: Any, error: SindyError) -> SindyError:
    return SindyError(f"{file}: {error}", error.key, error.expected, error.found)


def _pass(empty: PartialSums, first: int, files: list[Any], read: Read, jobs: int) -> PartialSums:
    """What a worker does: the sums of files from the number `first` on."""
    parent = parent_process()
    sums = copy.copy(empty)
    for number, file in enumerate(files, first):
        if parent is not None and not parent.is_alive():
            os._exit(1)  # It would work on for nobody.
        try:
            sums.add(number, **_read(read, file), n_jobs=jobs)
        except SindyError as error:
            raise _named(file, error) from None
    return sums


def fit(
    executor: Executor | Callable[[], Executor],
    files: Sequence[Any],
    model: SINDy,
    *,
    t: Any = "t",
    read: Read | None = None,
    files_per_task: int | None = None,
    retries: int = 3,
    progress: Callable[[int, int], None] | None = None,
    n_jobs: int = 1,
) -> SINDy:
    """Identifies a model from many files on the workers of an executor.

    The automatic call in one pass, without output error: that of ``sindy fit --stream``.

    Parameters
    ----------
    executor : Executor, or a function that makes one
        As of `touchdown.dist.campaign`.
    files : sequence
        Names of files that the workers see at the same paths, or whatever `read` takes. Each holds whole trajectories. The
        sums are added in this order.
    model : SINDy
        Library, settings, and the names of states and inputs. It is not changed. Known parts, signs and invariants are refused.
    t : str or float
        The column of times, or a step of time.
    read : callable, optional
        Gives the data of a file: a dict of ``x``, ``t``, and if there are any ``u``, ``sample_weight`` and ``groups``, as for
        `SINDy.fit`. For processes it has to be a function of a module. Without it Parquet and CSV are read by pyarrow, and
        ``.npy`` by NumPy.
    files_per_task : int, optional
        Files that a worker gets at a time; one, and more where there would be more than 256 tasks.
    retries : int
        How often a task that fails, by whatever but a fault of the data, is handed out again; and how many executors in
        succession may break without a task done.
    progress : callable, optional
        Called with the number of files that are done and of all files. What it raises ends the call.
    n_jobs : int
        Threads of each task.

    Returns
    -------
    SINDy
        The model of all files, with the bits of one process.
    """
    files = list(files)
    if not files:
        raise fault("files", "at least one", "none")
    each = -(-len(files) // TASKS) if files_per_task is None else files_per_task
    check(executor, files_per_task=(each, 1), retries=(retries, 0))
    load = _Table(t) if read is None else read

    def head(number: int) -> dict[str, Any]:
        return _read(load, files[number])

    empty = PartialSums(model, [str(file) for file in files], head)
    total = copy.copy(empty)
    done = 0

    def told(task: Task, sums: PartialSums | None) -> None:
        nonlocal done
        if sums is not None:
            total.merge(sums)
        done += task[1] - task[0]
        if progress is not None:
            progress(done, len(files))

    jobs = threads(n_jobs) or 1
    driver = Driver(
        executor,
        _pass,
        lambda task: (empty, task[0], files[slice(*task)], load, jobs),
        retries=retries,
        what="files",
        rest="Nothing is kept of a fit that failed",
    )
    whole = False
    try:
        driver.run([(k, min(k + each, len(files))) for k in range(0, len(files), each)], told)
        whole = True
    finally:
        driver.end(whole)
    return total.fit()
