"""Kernels as they are called from Python."""

import pytest

from analog_card.kernel import Kernel


def interrupted(cause):
    """Return a kernel whose arguments cannot be unpacked, for a cause."""
    kernel = Kernel(lambda x: x, {}, None)

    def unpack(*arguments):
        try:
            raise cause
        except BaseException as problem:
            raise SystemError("returned a result with an exception set") from problem

    kernel._called = unpack
    return kernel


def test_an_interrupt_while_arguments_are_unpacked_is_an_interrupt():
    with pytest.raises(KeyboardInterrupt):
        interrupted(KeyboardInterrupt())(1.0)


def test_another_error_stays_what_it_is():
    with pytest.raises(SystemError):
        interrupted(ValueError("odd"))(1.0)
