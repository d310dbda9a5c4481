"""What the commands share that run a loop many times: what varies, and where it is run."""

from collections.abc import Iterator, Mapping, Sequence
from concurrent.futures import Executor
from contextlib import contextmanager
from typing import Any

from pneuservo.errors import InputError


def read_given(file: str | None, vary: Sequence[str], given: Mapping[str, Any]) -> dict[str, Any]:
    """Return the settings of a campaign file, with options in place of or beside what it says.

    Parameters
    ----------
    file : str or None
        A campaign file.
    vary : sequence of str
        Axes as options give them, ``NAME=VALUES``.
    given : mapping of str to anything
        The other options by their keys in a campaign file; None and nothing are not given.

    Raises
    ------
    InputError
        When the file cannot be used, or an axis has no name.
    """
    from pneuservo.campaign.plan_file import read_settings

    settings = read_settings(file) if file is not None else {}
    settings |= {key: value for key, value in given.items() if value not in (None, ())}
    settings["vary"] = {**settings.get("vary", {}), **dict(map(_axis, vary))}
    return settings


def require_one_place(address: str | None, jobs: int | None) -> None:
    """Refuse a cluster and processes of this computer at once.

    Raises
    ------
    InputError
        When both are given.
    """
    if address is not None and jobs is not None:
        raise InputError("--cluster and --jobs exclude each other: the cluster has its own workers")


@contextmanager
def place_of(address: str | None, jobs: int | None) -> Iterator[tuple[Executor | None, int]]:
    """Yield the pool to run in, None for processes of this computer, and how many it has.

    Parameters
    ----------
    address : str or None
        Of a cluster.
    jobs : int or None
        Processes of this computer.

    Raises
    ------
    InputError
        When nothing answers at the address.
    """
    if address is None:
        yield None, jobs or 1
        return
    from pneuservo.campaign.cluster import cluster

    with cluster(address) as place:
        yield place


def _axis(text: str) -> tuple[str, str]:
    name, equals, values = text.partition("=")
    if not equals:
        raise InputError(f'--vary {text!r}: write NAME=VALUES, such as "load.mass=1.8, 7 kg"')
    return name.strip(), values
