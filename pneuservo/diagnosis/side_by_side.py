"""Pieces of work that do not depend on each other, done at the same time."""

from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from contextvars import ContextVar, copy_context
from typing import TypeVar

Item = TypeVar("Item")
Result = TypeVar("Result")

_AT_A_TIME = ContextVar("pieces of work done at a time", default=1)


@contextmanager
def at_a_time(jobs: int) -> Iterator[None]:
    """Have so many pieces of work done at a time while the context lasts.

    Parameters
    ----------
    jobs : int
        One and more. Work that is done beside other work does its own pieces one by one.
    """
    before = _AT_A_TIME.set(jobs)
    try:
        yield
    finally:
        _AT_A_TIME.reset(before)


def side_by_side(work: Callable[[Item], Result], items: Iterable[Item]) -> list[Result]:
    """Return what each piece of work gives, in the order of the items.

    Parameters
    ----------
    work : callable
        Takes an item. Most of its time has to go into kernels, which run beside each other in
        threads.
    items : iterable
        What is to be done, as many at a time as `at_a_time` says; one where it says nothing.

    Examples
    --------
    >>> with at_a_time(2):
    ...     side_by_side(lambda number: number**2, [1, 2, 3])
    [1, 4, 9]
    """
    items, jobs = list(items), _AT_A_TIME.get()
    if jobs == 1 or len(items) < 2:
        return [work(item) for item in items]

    def alone(item: Item) -> Result:
        with at_a_time(1):
            return work(item)

    with ThreadPoolExecutor(jobs) as pool:
        # A thread has a context of its own: without this one's, numpy would warn there of what is
        # to be passed over here.
        waiting = [pool.submit(copy_context().run, alone, item) for item in items]
        try:
            return [each.result() for each in waiting]
        except BaseException:
            # After an interrupt only what is already running is waited for.
            for each in waiting:
                each.cancel()
            raise
