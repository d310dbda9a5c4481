"""How the kernels of the servo with effects are compiled."""

from functools import cache
from pathlib import Path

from analog_card.compilation import compile_kernel, kernel_folder

_PLANT = Path(__file__).parent.parent


@cache
def _cache_folder() -> Path | None:
    # Every file counts: places and defaults stand in files without kernels.
    return kernel_folder(_PLANT, mark="")


def compiled(function):
    """Compile a kernel that makes no arrays; see `analog_card.compilation.compile_kernel`."""
    return compile_kernel(function, _cache_folder(), counted=False)


def compiled_apart(function):
    """Compile one that also stays one piece of code wherever it is called from."""
    return compile_kernel(function, _cache_folder(), inline=False, counted=False)


def compiled_whole(function):
    """Compile a kernel that makes arrays."""
    return compile_kernel(function, _cache_folder())
