"""Where the ngspice shared library is."""

import ctypes
import ctypes.util
import os
import sys
from pathlib import Path

from analog_card.errors import SimulationError


def ngspice_library() -> str:
    """Return the name or path under which the ngspice shared library loads.

    Looked for in this order: the environment variable ``NGSPICE_LIBRARY``, the virtual
    environment (where set-up unpacks it when it may not install), the system's own places.

    Returns
    -------
    str
        A name or path that the dynamic loader accepts.

    Raises
    ------
    SimulationError
        When none of them loads.
    """
    named = os.environ.get("NGSPICE_LIBRARY")
    unpacked = sorted(map(str, Path(sys.prefix, "ngspice").glob("usr/lib/*/libngspice.so.*")))
    brewed = [f"{prefix}/lib/libngspice.dylib" for prefix in ("/opt/homebrew", "/usr/local")]
    found = ctypes.util.find_library("ngspice")
    system = [found] if found else []
    for candidate in [named] if named else [*unpacked, *system, "libngspice.so.0", *brewed]:
        try:
            ctypes.CDLL(candidate)
        except OSError:
            continue
        return candidate
    wanted = f"NGSPICE_LIBRARY={named} does not load" if named else "it was not found"
    raise SimulationError(
        f"the ngspice shared library is needed and {wanted}; "
        "install it (Debian, Ubuntu: apt install libngspice0; macOS: brew install libngspice) "
        "or set NGSPICE_LIBRARY to its full path"
    )


if __name__ == "__main__":
    print(ngspice_library())
