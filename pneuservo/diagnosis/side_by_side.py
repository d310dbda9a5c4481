"""Pieces of work that do not depend on each other, done at the same time."""

from collections.abc import Callable, Iterable
from concurrent.futures import ThreadPoolExecutor
from typing import TypeVar

Item = TypeVar("Item")
Result = TypeVar("Result")


def side_by_side(work: Callable[[Item], Result], items: Iterable[Item], jobs: int) -> list[Result]:
    """Return what each piece of work gives, in the order of the items.

    Parameters
    ----------
    work : callable
        Takes an item. Most of its time has to go into kernels, which run beside each other in
        threads.
    items : iterable
        What is to be done.
    jobs : int
        So many at a time.

    Examples
    --------
    >>> side_by_side(lambda number: number**2, [1, 2, 3], jobs=2)
    [1, 4, 9]
    """
    if jobs == 1:
        return [work(item) for item in items]
    with ThreadPoolExecutor(jobs) as pool:
        waiting = [pool.submit(work, item) for item in items]
        try:
            return [each.result() for each in waiting]
        except BaseException:
            # After an interrupt only what is already running is waited for.
            for each in waiting:
                each.cancel()
            raise
