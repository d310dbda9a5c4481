"""A cluster as the place where samples are run, by dask.distributed."""

import logging
from collections.abc import Iterator
from concurrent.futures import CancelledError, Executor
from contextlib import contextmanager
from typing import TYPE_CHECKING

from pneuservo.errors import InputError, PneuservoError

if TYPE_CHECKING:
    from distributed import Client

_SCHEMES = ("tcp", "tls")
# How long is waited for the scheduler to answer, and for a first worker [s].
_PATIENCE = 15


class ClusterError(PneuservoError):
    """The cluster stopped working while samples were run on it."""

    exit_code = 1


@contextmanager
def cluster(address: str) -> Iterator[tuple[Executor, int]]:
    """Yield a pool that runs on a cluster, and how many threads its workers have.

    Parameters
    ----------
    address : str
        Of the scheduler, such as ``tcp://node1:8786``; ``tls://`` with the certificates of dask's
        configuration.

    Raises
    ------
    InputError
        When dask.distributed is not installed, or nothing answers at the address.
    ClusterError
        When the cluster was lost, or a sample ended several workers.

    Notes
    -----
    A sample whose worker is lost is run again on another. Workers need this package, the same
    version; scheduler and workers run whatever a client sends, so that their ports must be open to
    nobody else, or be secured by ``tls://``.
    """
    try:
        from distributed import KilledWorker
    except ImportError as problem:
        raise InputError(
            "--cluster needs dask.distributed: pip install 'pneuservo[cluster]'"
        ) from problem
    with _quiet(), _connected(address) as client:
        try:
            yield client.get_executor(pure=False), sum(client.nthreads().values())
        except (KilledWorker, CancelledError) as problem:
            reason = str(problem) or "the scheduler is gone"
            raise ClusterError(
                f"--cluster {address}: {reason}. What was done is kept in --out; the same command "
                "goes on"
            ) from problem


def _connected(address: str) -> "Client":
    """Return a client of a cluster that has at least one worker."""
    from distributed import Client
    from distributed.comm import parse_address, parse_host_port

    try:
        # A client that fails on this in its making complains again when it is thrown away.
        scheme, place = parse_address(address)
        parse_host_port(place)
        if scheme not in _SCHEMES:
            raise ValueError(f"{scheme}:// is not one of {', '.join(_SCHEMES)}")
        client = Client(address, timeout=_PATIENCE, set_as_default=False)
    except (OSError, TimeoutError, ValueError, RuntimeError) as problem:
        raise InputError(
            f"--cluster {address}: no scheduler answers ({problem}); start one with "
            "'dask scheduler', workers with 'dask worker ADDRESS', and give its address, such as "
            "tcp://node1:8786"
        ) from problem
    try:
        client.wait_for_workers(1, timeout=_PATIENCE)
    except TimeoutError as problem:
        client.close()
        raise InputError(
            f"--cluster {address}: the scheduler has no workers; start them with "
            f"'dask worker {address} --nthreads 1'"
        ) from problem
    return client


@contextmanager
def _quiet() -> Iterator[None]:
    """Keep dask from logging tracebacks of what is reported here in a sentence."""
    loggers = [logging.getLogger(name) for name in ("distributed", "distributed.client")]
    levels = [logger.level for logger in loggers]
    for logger in loggers:
        logger.setLevel(logging.CRITICAL)
    try:
        yield
    finally:
        for logger, level in zip(loggers, levels, strict=True):
            logger.setLevel(level)
