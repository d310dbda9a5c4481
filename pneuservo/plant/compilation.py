"""How the kernels beside the plant are compiled, and where the compiled code is kept."""

from functools import cache
from pathlib import Path

from analog_card.compilation import PACKAGE as CARD_PACKAGE
from analog_card.compilation import compile_kernel, kernel_folder

_PACKAGE = Path(__file__).parent.parent


@cache
def cache_folder() -> Path | None:
    """Return the folder for compiled code, or None when none can be written.

    The card's kernels are taken in by those of the plant, so a change of either makes a new one.
    """
    return kernel_folder(_PACKAGE, CARD_PACKAGE)


def compiled(function):
    """Compile a kernel; see `analog_card.compilation.compile_kernel`."""
    return compile_kernel(function, cache_folder())


def compiled_apart(function):
    """Compile a kernel that stays one piece of code wherever it is called from."""
    return compile_kernel(function, cache_folder(), inline=False)


def compiled_lean(function):
    """Compile a kernel that makes and slices no arrays."""
    return compile_kernel(function, cache_folder(), counted=False)
