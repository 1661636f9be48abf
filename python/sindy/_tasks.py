"""Tasks on the workers of an executor."""

from __future__ import annotations

import time
from collections import Counter, deque
from collections.abc import Callable
from concurrent.futures import BrokenExecutor, Executor, Future
from concurrent.futures import wait as wait_for
from queue import Empty, SimpleQueue
from typing import Any, Generic, TypeVar

from ._errors import SindyError, fault, needed

# From the first number to before the second.
Task = tuple[int, int]
T = TypeVar("T")

# A silence of so many times the longest task yet, for its size, and of at least so many seconds, is a worker that hangs. Twice
# would hand out tasks that are merely the longest; a short floor those of workers that are only being started.
SILENCE = 3.0
LEAST_SILENCE_S = 10.0


def check(executor: object, **least: tuple[int, int]) -> None:
    """Refuses what is no executor, and numbers below the least that they may be."""
    for name, (value, lowest) in least.items():
        needed(name, value, lowest)
    if not (isinstance(executor, Executor) or callable(executor)):
        raise fault("executor", "an executor, or a function that makes one", type(executor).__name__)


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


def _timed(call: Callable[..., T], *args: Any) -> tuple[float, T]:
    """Seconds that a call takes on its worker, and its result."""
    begun = time.monotonic()
    result = call(*args)
    return time.monotonic() - begun, result


class Driver(Generic[T]):
    """Hands out tasks, and hands them out again where workers fail or hang.

    Where no task ends for three times as long as the longest took, for its size, and for at least ten seconds, those that
    are out are handed out once more. The first result of a task counts, so tasks have to be pure functions.

    Parameters
    ----------
    executor : Executor, or a function that makes one
    call, arguments : callable
        What a worker calls, and with what for a task.
    retries : int
        How often a task may fail, and how many executors in succession may break without a task done.
    what : str
        What tasks are of, for errors.
    rest : str
        What remains of tasks that were done, for errors.
    done : callable, optional
        Whether a task whose executor broke is done nevertheless.
    """

    def __init__(
        self,
        executor: Executor | Callable[[], Executor],
        call: Callable[..., T],
        arguments: Callable[[Task], tuple[Any, ...]],
        *,
        retries: int,
        what: str,
        rest: str,
        done: Callable[[Task], bool] = lambda _: False,
    ) -> None:
        self._make = None if isinstance(executor, Executor) else executor
        self._executor = executor if isinstance(executor, Executor) else executor()
        self._call, self._arguments, self._done = call, arguments, done
        self._retries, self._what, self._rest = retries, what, rest
        self._failures: Counter[Task] = Counter()
        self._breaks = 0
        self._flying: dict[Future[tuple[float, T]], Task] = {}
        self._ended: SimpleQueue[Future[tuple[float, T]]] = SimpleQueue()
        self._again: set[Task] = set()
        self._hangs = False
        # What each task that is done took on its worker.
        self.seconds: dict[Task, float] = {}

    def run(self, tasks: list[Task], told: Callable[[Task, T | None], None]) -> None:
        """Until all tasks are done; `told` of each and its result, which is none where it was lost with an executor."""
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
                try:
                    ended = self._ended.get(timeout=self._patience_s())
                except Empty:
                    todo.extend(self._once_more())
                    continue
                if ended not in self._flying:
                    continue  # Of an executor that broke, or of a task whose other flight was faster.
                task = self._flying.pop(ended)
                try:
                    seconds, result = ended.result()
                except SindyError:
                    raise  # A fault of the input is one on every worker.
                except BrokenExecutor as error:
                    broken = error
                    todo.append(task)
                except Exception as error:
                    if task in self._flying.values():
                        continue  # Its other flight goes on.
                    self._failures[task] += 1
                    if self._failures[task] > self._retries:
                        what = f"{self._what} {task[0]} to before {task[1]}"
                        raise self._gives_up(what, self._failures[task], error) from error
                    todo.append(task)
                    continue
                else:
                    self._breaks = 0
                    self.seconds[task] = seconds
                    self._drop(task)
                    told(task, result)
                    continue
            # All tasks of a broken executor fail with it; some may be done.
            lost, self._flying = set(self._flying.values()).difference(todo), {}
            for task in sorted(lost):
                if self._done(task):
                    told(task, None)
                else:
                    todo.append(task)
            self._renew(broken)

    def _patience_s(self) -> float | None:
        """How long no task may end before those that are out are handed out once more."""
        if not self.seconds or self._again.issuperset(self._flying.values()):
            return None
        # Tasks may be larger than those that are done: those that were timed, for instance, have one block.
        slowest_s = max(seconds / (end - first) for (first, end), seconds in self.seconds.items())
        largest = max(end - first for first, end in self._flying.values())
        return max(LEAST_SILENCE_S, SILENCE * slowest_s * largest)

    def _once_more(self) -> list[Task]:
        """The tasks that are out, but those that were handed out twice."""
        tasks = sorted(set(self._flying.values()) - self._again)
        self._again.update(tasks)
        return tasks

    def _drop(self, task: Task) -> None:
        """Forgets the other flight of a task that is done."""
        for future in [future for future, other in self._flying.items() if other == task]:
            del self._flying[future]
            self._hangs |= not future.cancel()

    def _submit(self, task: Task) -> None:
        future = self._executor.submit(_timed, self._call, *self._arguments(task))
        self._flying[future] = task
        future.add_done_callback(self._ended.put)

    def _renew(self, broken: BrokenExecutor) -> None:
        if self._make is None:
            raise RuntimeError(
                f"the executor is broken ({broken}): a worker was killed. Give a function that makes executors, such as "
                f"`lambda: ProcessPoolExecutor(4)`, and a new one goes on. {self._rest}"
            ) from broken
        self._breaks += 1
        if self._breaks > self._retries:
            raise self._gives_up("executors", self._breaks, broken) from broken
        self._executor.shutdown(wait=False, cancel_futures=True)
        self._executor = self._make()

    def _gives_up(self, what: str, times: int, error: Exception) -> RuntimeError:
        return RuntimeError(
            f"{what} failed {times} times in all, the last time with {error!r}. {self._rest}"
        )

    def end(self, whole: bool) -> None:
        """Nothing more is begun; what this driver made is ended."""
        for future in self._flying:
            future.cancel()
        if self._make is not None:
            # Nobody waits for a worker that hangs.
            self._executor.shutdown(wait=whole and not self._hangs, cancel_futures=True)
