"""Where the members of a study run: in this process, in processes of this machine, or on a Dask cluster."""

from __future__ import annotations

import logging
import os
import threading
import time
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, CancelledError, Future, wait
from dataclasses import dataclass
from multiprocessing import get_context
from pathlib import Path
from typing import Any, ClassVar, TypeVar

from mol_compactons.errors import InputError, require, shown

logger = logging.getLogger(__name__)

Task = TypeVar("Task")
Made = TypeVar("Made")

MOST_ATTEMPTS = 4
"""How often a member is begun whose process is killed: it runs again at most three times."""

WATCH_SECONDS = 0.2
"""How often somebody is asked whether the study is to end."""

ANSWER_SECONDS = 8
"""How long a scheduler may take to answer."""

ORPHAN_SECONDS = 0.5
"""How often a process that runs members looks whether that of the study is still there."""

THREADS = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "BLIS_NUM_THREADS", "VECLIB_MAXIMUM_THREADS")
"""How numerical libraries are told their number of threads before they are loaded."""

Watch = Callable[[], None]
"""Called now and then; what it raises ends the study."""


def never_ending() -> None:
    """The `Watch` of a study that nobody ends."""


class Lost(str):
    """Why a member has no result though nothing is wrong with its settings."""

    __slots__ = ()


class Engine(ABC):
    """Does one piece of work for each of many tasks."""

    longest_first: ClassVar[bool] = True
    """Whether a study had better give its longest tasks first, so that no worker is left with one at the end."""

    @abstractmethod
    def results(
        self, work: Callable[[Task], Made], tasks: Sequence[Task], watch: Watch = never_ending
    ) -> Iterator[tuple[int, Made | Lost]]:
        """What the work made of each task, with the number of the task, in the order in which they end.

        Parameters
        ----------
        work : callable
            A function of a module, which another process can load; it raises nothing that is expected.
        tasks : sequence
            What it is called with.
        watch : callable, optional
            Called now and then while the work goes on.

        Raises
        ------
        InputError
            If the engine cannot begin.
        """


@dataclass(frozen=True)
class Here(Engine):
    """One task after the other, in this process and thread."""

    longest_first = False

    def results(
        self, work: Callable[[Task], Made], tasks: Sequence[Task], watch: Watch = never_ending
    ) -> Iterator[tuple[int, Made | Lost]]:
        """See `Engine`."""
        for number, task in enumerate(tasks):
            watch()
            yield number, work(task)


@dataclass(frozen=True)
class Processes(Engine):
    """Processes of this machine, each with one numerical thread; one that is killed is replaced.

    Parameters
    ----------
    workers : int, optional
        How many; by default as many as this process may use cores.

    Raises
    ------
    InputError
        If there are to be none.
    """

    workers: int | None = None

    def __post_init__(self) -> None:
        require(self.workers is None or 1 <= self.workers <= 1000, f"workers = {self.workers} must lie between 1 and 1000.")

    @property
    def count(self) -> int:
        """How many processes there are."""
        return self.workers or usable_cores()

    def results(
        self, work: Callable[[Task], Made], tasks: Sequence[Task], watch: Watch = never_ending
    ) -> Iterator[tuple[int, Made | Lost]]:
        """See `Engine`."""
        from pebble import ProcessExpired, ProcessPool

        attempts = [0] * len(tasks)
        waiting, running = list(range(len(tasks)))[::-1], dict[Future[Any], int]()
        workers = min(self.count, max(len(tasks), 1))
        pool = ProcessPool(workers, initializer=_begin, initargs=[os.getpid()], context=get_context("spawn"))
        try:
            while waiting or running:
                while waiting and len(running) < 2 * self.count:
                    number = waiting.pop()
                    attempts[number] += 1
                    running[pool.schedule(work, args=[tasks[number]])] = number
                ended, _ = wait(running, timeout=WATCH_SECONDS, return_when=FIRST_COMPLETED)
                for future in ended:
                    number = running.pop(future)
                    try:
                        yield number, future.result()
                    except ProcessExpired:
                        logger.warning("a process was killed %d times at %s", attempts[number], tasks[number])
                        if attempts[number] < MOST_ATTEMPTS:
                            waiting.append(number)
                        else:
                            yield number, Lost(f"its process was killed {MOST_ATTEMPTS} times; is there enough memory?")
                watch()
            pool.close()
        finally:
            pool.stop()
            pool.join()


def usable_cores() -> int:
    """How many cores this process may use."""
    try:
        return len(os.sched_getaffinity(0))
    except AttributeError:
        return os.cpu_count() or 1


def _begin(study: int) -> None:
    """Begin a process that runs members: one numerical thread, and an end where the process of the study has ended."""
    from threadpoolctl import threadpool_limits

    threadpool_limits(1)  # of the libraries that are loaded; those that come later look at the environment
    os.environ.update(dict.fromkeys(THREADS, "1"))

    def look() -> None:
        while os.getppid() == study:
            time.sleep(ORPHAN_SECONDS)
        os._exit(1)

    threading.Thread(target=look, daemon=True).start()


@dataclass(frozen=True)
class Cluster(Engine):
    """The workers of a Dask cluster.

    Parameters
    ----------
    address : str
        Of its scheduler, as ``tcp://host:8786``, or a file that it wrote.
    """

    address: str

    def results(
        self, work: Callable[[Task], Made], tasks: Sequence[Task], watch: Watch = never_ending
    ) -> Iterator[tuple[int, Made | Lost]]:
        """See `Engine`."""
        client = self._client()
        try:
            from distributed import as_completed
            from distributed.scheduler import KilledWorker

            futures = client.map(work, tasks, pure=False)
            numbers = {future.key: number for number, future in enumerate(futures)}
            if not client.scheduler_info()["workers"]:
                logger.warning("the scheduler %s has no worker yet; the study waits for one", self.address)
            ending = as_completed(futures, loop=client.loop)
            while not ending.is_empty():
                for future in ending.next_batch(block=False):
                    try:
                        yield numbers[future.key], future.result()
                    except KilledWorker as error:
                        yield numbers[future.key], Lost(f"its worker was killed again and again ({error.task})")
                    except CancelledError:
                        raise InputError(
                            f"The scheduler {shown(self.address)} is gone; start it again, and then the study, which goes on."
                        ) from None
                    future.release()
                watch()
                time.sleep(WATCH_SECONDS)
        finally:
            client.close()

    def _client(self) -> Any:
        try:
            from distributed import Client
        except ImportError:
            raise InputError("A cluster needs distributed; install it: pip install 'mol_compactons[dask]'.") from None
        is_file = self.address.endswith(".json")
        known = {"scheduler_file": self.address} if is_file else {"address": self.address}
        try:
            if is_file:
                Path(self.address).read_bytes()  # distributed waits for a file that is not there
            return Client(**known, timeout=ANSWER_SECONDS, set_as_default=False)
        except (OSError, ValueError, TimeoutError):
            raise InputError(
                f"The scheduler {shown(self.address)} does not answer; start it, or correct the address."
            ) from None
