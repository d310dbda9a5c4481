"""The last few results of something that takes long to work out."""

from collections.abc import Callable, Hashable
from threading import Lock

from pneuservo.arrays import Array


class Recent:
    """Results by what they were asked for with; those not asked for longest go first.

    Parameters
    ----------
    kept : int, optional
        So many.

    Examples
    --------
    >>> import numpy as np
    >>> recent = Recent(kept=1)
    >>> recent.get("one", lambda: np.ones(1)), recent.get("one", lambda: np.zeros(1))
    (array([1.]), array([1.]))
    """

    def __init__(self, kept: int = 8):
        self._kept, self._lock = kept, Lock()
        self._results: dict[Hashable, Array] = {}

    def get(self, asked: Hashable, make: Callable[[], Array]) -> Array:
        """Return a result, worked out unless it is among the last few.

        Parameters
        ----------
        asked : hashable
            What it depends on.
        make : callable
            Works it out.
        """
        with self._lock:
            known = self._results.pop(asked, None)
            if known is not None:
                self._results[asked] = known
                return known
        made = make()
        with self._lock:
            self._results[asked] = made
            while len(self._results) > self._kept:
                self._results.pop(next(iter(self._results)))
        return made
