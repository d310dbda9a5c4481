"""A compiled kernel: code that other kernels take in, and a way to call it from Python."""

import functools
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numba


class Kernel:
    """A compiled function of numbers, arrays and named tuples, which cannot call itself.

    Parameters
    ----------
    function : callable
        What is compiled, for each set of types that it is called with.
    options : dict
        For the compiler.
    folder : Path or None
        Where the compiled code is kept, if anywhere.

    Notes
    -----
    Most kernels are only ever taken in by others. What unpacks Python's objects for a kernel,
    named tuples of named tuples above all, takes longer to compile than the kernel itself, so
    this is done when a kernel is first called from Python and not before, and it is compiled once
    more then: those of the servo with effects take two fifths of the time (30 instead of 72 s).
    """

    def __init__(
        self, function: Callable[..., Any], options: dict[str, Any], folder: Path | None
    ) -> None:
        functools.update_wrapper(self, function)
        alone = {**options, "no_cfunc_wrapper": True}
        # Apart, for the one must never be found in place of the other.
        taken_in, called = (folder and folder / name for name in ("taken-in", "called"))
        self._taken_in = _dispatcher(function, {**alone, "no_cpython_wrapper": True}, taken_in)
        self._called = _dispatcher(function, alone, called)

    def __call__(self, *arguments: Any) -> Any:
        """Return what the function returns.

        Raises
        ------
        KeyboardInterrupt
            When the user interrupts it; while arguments are unpacked it comes as another error.
        """
        try:
            return self._called(*arguments)
        except SystemError as problem:
            if _is_interrupt(problem):
                raise KeyboardInterrupt from problem
            raise

    @property
    def _numba_type_(self) -> Any:
        """Return what the compiler takes it for in another kernel."""
        return self._taken_in._numba_type_

    def __reduce__(self) -> str:
        """Return the name under which another process finds it."""
        name: str = self.__qualname__  # type: ignore[attr-defined]
        return name


def _is_interrupt(problem: BaseException | None) -> bool:
    """Return whether an error is, or was caused by, an interrupt."""
    while problem is not None:
        if isinstance(problem, KeyboardInterrupt):
            return True
        problem = problem.__cause__ or problem.__context__
    return False


def _dispatcher(function: Callable[..., Any], options: dict[str, Any], folder: Path | None) -> Any:
    if folder is None:
        return numba.njit(**options)(function)
    # The compiler reads the folder here; other users of it in this process keep their own.
    config: Any = numba.config
    before = config.CACHE_DIR
    config.CACHE_DIR = str(folder)
    try:
        return numba.njit(cache=True, **options)(function)
    finally:
        config.CACHE_DIR = before
