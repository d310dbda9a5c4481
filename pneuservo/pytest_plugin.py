"""What pytest finds of this package by itself: the fixture ``closed_loop``."""

from collections.abc import Callable
from typing import Any

import pytest


@pytest.fixture(scope="session")
def closed_loop() -> Callable[..., Any]:
    """Return `pneuservo.testing.close_loop`, which simulates a closed loop.

    Session-wide, so that a fixture of any scope can run a loop once for many tests.
    """
    # pytest loads this file in every project that has the package installed: nothing heavy above.
    from pneuservo.testing import close_loop

    return close_loop
