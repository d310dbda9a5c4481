"""Exceptions raised by the servo package."""


class PneuservoError(Exception):
    """Base of every exception that this package raises on purpose."""

    exit_code = 2


class InputError(PneuservoError):
    """Something the user gave cannot be used; the message says what, where and what is allowed."""


class FitError(PneuservoError):
    """A fit failed; the message says what was tried."""

    exit_code = 3
