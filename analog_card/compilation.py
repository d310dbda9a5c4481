"""How kernels are compiled, and where the compiled code is kept."""

import hashlib
import re
import tempfile
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any

import numba
import platformdirs

from analog_card.kernel import Kernel

PACKAGE = Path(__file__).parent
_COMPILING = {Path(__file__), Path(__file__).with_name("kernel.py")}
_IMPORT = re.compile(r"^from ([\w.]+) import (\([^)]*\)|.*)", re.MULTILINE)
_CONSTANT = re.compile(r"\b[A-Z][A-Z0-9_]+\b")


def kernel_folder(*packages: Path, mark: str = "import compiled") -> Path | None:
    """Return the folder for the compiled code of some packages, or None when none can be written.

    Parameters
    ----------
    packages : Path
        Their folders.
    mark : str, optional
        What a source file that holds kernels contains.

    Notes
    -----
    The folder is named after the content of every source file that holds kernels, the named
    tuples or the constants that they take, of how they are compiled, and the version of the
    compiler. The compiler itself only watches the file a function stands in, so a kernel that
    takes in a function of another file would keep running the old physics after that file changed.
    """
    digest = hashlib.sha256(numba.__version__.encode())
    found = {
        source: source.read_bytes() for package in packages for source in package.rglob("*.py")
    }
    marks = (mark.encode(), b"numba", b"NamedTuple")
    watched = {
        source: content
        for source, content in found.items()
        if any(word in content for word in marks)
    }
    taken = {file for source, content in watched.items() for file in _constants_of(source, content)}
    for source in sorted(watched.keys() | taken | _COMPILING):
        digest.update(found.get(source) or source.read_bytes())
    folder = Path(platformdirs.user_cache_dir("pneuservo")) / digest.hexdigest()[:16]
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=folder):
            pass
    except OSError:
        return None
    return folder


def _constants_of(source: Path, content: bytes) -> list[Path]:
    """Return the files that a source file takes constants from."""
    outside = next(folder for folder in source.parents if not (folder / "__init__.py").exists())
    found = [
        outside / f"{module.replace('.', '/')}.py"
        for module, names in _IMPORT.findall(content.decode())
        if _CONSTANT.search(names)
    ]
    return [constants for constants in found if constants.exists()]


def compile_kernel(
    function: Callable[..., Any],
    folder: Path | None,
    inline: bool = True,
    counted: bool = True,
) -> Kernel:
    """Compile a kernel, keeping the result in a folder if there is one.

    Parameters
    ----------
    function : callable
        A function of numbers, arrays and named tuples that calls nothing but other kernels.
    folder : Path or None
        From `kernel_folder`.
    inline : bool, optional
        Whether a kernel that calls it takes a copy of its code, which nearly doubles the speed
        of a run. Without, code that is large and seldom run is there only once; to hand the 250
        numbers of a servo to it takes as long as a stage of a step.
    counted : bool, optional
        Whether the references to arrays are counted. Without, a kernel cannot make or slice
        arrays, and one that hands many of them on is several times faster.

    Returns
    -------
    Kernel
        Division by zero gives infinity, as in C, instead of an exception. Products and sums may
        be fused and divisions by constants become products; NaN and infinity behave as they
        should.
    """
    options: dict[str, Any] = {
        "error_model": "numpy",
        "fastmath": {"contract", "nsz", "arcp"},
        "forceinline": inline,
        "nogil": True,
        "_nrt": counted,
    }
    return Kernel(function, options, folder)


@cache
def _cache_folder() -> Path | None:
    return kernel_folder(PACKAGE)


def compiled(function: Callable[..., Any]) -> Any:
    """Compile a kernel of this package; see `compile_kernel`."""
    return compile_kernel(function, _cache_folder())
