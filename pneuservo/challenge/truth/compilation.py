"""How the kernels of the truth are compiled: apart from the plant's."""

from functools import cache
from pathlib import Path

from analog_card.compilation import compile_kernel, kernel_folder


@cache
def _cache_folder() -> Path | None:
    return kernel_folder(Path(__file__).parent, mark="import truth_kernel")


def truth_kernel(function):
    """Compile a kernel of the truth; see `analog_card.compilation.compile_kernel`."""
    return compile_kernel(function, _cache_folder())
