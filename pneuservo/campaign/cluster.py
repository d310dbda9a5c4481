"""A cluster as the place where samples are run, by dask.distributed."""

from collections.abc import Iterator
from concurrent.futures import CancelledError, Executor
from contextlib import contextmanager

from pneuservo.errors import InputError, PneuservoError

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
        from distributed import Client, KilledWorker
    except ImportError as problem:
        raise InputError(
            "--cluster needs dask.distributed: pip install 'pneuservo[cluster]'"
        ) from problem
    try:
        client = Client(address, timeout=_PATIENCE, set_as_default=False)
    except (OSError, TimeoutError, ValueError, RuntimeError) as problem:
        raise InputError(
            f"--cluster {address}: no scheduler answers ({problem}); start one with "
            "'dask scheduler', workers with 'dask worker ADDRESS', and give its address, such as "
            "tcp://node1:8786"
        ) from problem
    with client:
        try:
            client.wait_for_workers(1, timeout=_PATIENCE)
        except TimeoutError as problem:
            raise InputError(
                f"--cluster {address}: the scheduler has no workers; start them with "
                f"'dask worker {address} --nthreads 1'"
            ) from problem
        threads = sum(client.nthreads().values())
        try:
            yield client.get_executor(pure=False), threads
        except (KilledWorker, CancelledError) as problem:
            reason = problem or "the scheduler is gone"
            raise ClusterError(
                f"--cluster {address}: {reason}. What was done is kept in --out; the same command "
                "goes on"
            ) from problem
