"""Processes of this computer that share work, and end with the one that started them."""

import multiprocessing
import os
import signal
import threading
from collections.abc import Iterator
from concurrent.futures import Executor, ProcessPoolExecutor
from contextlib import contextmanager
from multiprocessing.connection import wait
from typing import Literal


@contextmanager
def processes(
    jobs: int, finish: bool = False, start: Literal["spawn", "fork"] = "spawn"
) -> Iterator[Executor]:
    """Yield a pool of processes of this computer, which end with this one.

    Parameters
    ----------
    jobs : int
        How many.
    finish : bool, optional
        Whether what they have begun is finished when the program is interrupted.
    start : str, optional
        How they start: a forked one begins sooner, but would share a simulator with this one.
    """
    context = multiprocessing.get_context(start)
    with ProcessPoolExecutor(
        jobs, mp_context=context, initializer=_begin, initargs=(finish,)
    ) as pool:
        yield pool


def _begin(finish: bool) -> None:
    """Have this process end when the one that started it has, also by a signal."""
    if finish:
        signal.signal(signal.SIGINT, signal.SIG_IGN)

    def watch(sentinel: int) -> None:
        wait([sentinel])
        os._exit(1)

    parent = multiprocessing.parent_process()
    if parent is not None:
        threading.Thread(target=watch, args=(parent.sentinel,), daemon=True).start()
