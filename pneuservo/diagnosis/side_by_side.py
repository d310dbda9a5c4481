"""Pieces of work that do not depend on each other, done at the same time."""

from collections import deque
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import Future, ThreadPoolExecutor, wait
from contextlib import contextmanager
from contextvars import ContextVar, copy_context
from dataclasses import dataclass
from threading import Semaphore
from typing import TypeVar

from threadpoolctl import threadpool_limits

Item = TypeVar("Item")
Result = TypeVar("Result")

_THREADS = 16
"""For each piece that is done at a time, for what waits for its own pieces keeps its thread."""


@dataclass(frozen=True)
class _Helpers:
    """Threads that may help, and how many more may work now."""

    threads: ThreadPoolExecutor
    free: Semaphore


_HELPERS: ContextVar[_Helpers | None] = ContextVar("who may help with pieces of work", default=None)


@contextmanager
def at_a_time(jobs: int) -> Iterator[None]:
    """Have so many pieces of work done at a time while the context lasts.

    Parameters
    ----------
    jobs : int
        One and more, however pieces of work are divided into further ones.
    """
    # The matrices of fits are tall and narrow: threads of the library's would only wait.
    with (
        ThreadPoolExecutor(_THREADS * jobs) as threads,
        threadpool_limits(limits=1, user_api="blas"),
    ):
        before = _HELPERS.set(_Helpers(threads, Semaphore(jobs - 1)) if jobs > 1 else None)
        try:
            yield
        finally:
            _HELPERS.reset(before)


def side_by_side(work: Callable[[Item], Result], items: Iterable[Item]) -> list[Result]:
    """Return what each piece of work gives, in the order of the items.

    Parameters
    ----------
    work : callable
        Takes an item. Most of its time has to go into kernels, which run beside each other in
        threads.
    items : iterable
        What is to be done, as many at a time as `at_a_time` says; one where it says nothing.

    Notes
    -----
    Whoever asks works too, and is helped whenever someone is free: the pieces of one long piece
    are shared out as soon as those beside it are done.

    Examples
    --------
    >>> with at_a_time(2):
    ...     side_by_side(lambda number: number**2, [1, 2, 3])
    [1, 4, 9]
    """
    items, helpers = list(items), _HELPERS.get()
    if helpers is None or len(items) < 2:
        return [work(item) for item in items]
    left, found, called = deque(enumerate(items)), {}, []

    def take_one() -> None:
        try:
            place, item = left.popleft()
        except IndexError:
            # Another one was faster.
            return
        found[place] = work(item)

    def help_out() -> None:
        try:
            while left:
                take_one()
        except BaseException:
            left.clear()
            raise
        finally:
            helpers.free.release()

    try:
        while left:
            if len(left) > 1 and helpers.free.acquire(blocking=False):
                # A thread has a context of its own: without this one's, numpy would warn there of
                # what is to be passed over here.
                called.append(helpers.threads.submit(copy_context().run, help_out))
            take_one()
        _wait_for(called, helpers)
    except BaseException:
        # After an interrupt only what is already running is waited for.
        left.clear()
        wait(called)
        raise
    return [found[place] for place in range(len(items))]


def _wait_for(called: list[Future[None]], helpers: _Helpers) -> None:
    """Wait for those who help, who may be helped meanwhile.

    Raises
    ------
    BaseException
        Whatever their work has raised.
    """
    if any(not each.done() for each in called):
        helpers.free.release()
        try:
            wait(called)
        finally:
            helpers.free.acquire()
    for each in called:
        each.result()
