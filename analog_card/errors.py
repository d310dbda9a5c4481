"""Exceptions raised by the card."""


class AnalogCardError(Exception):
    """Base of every exception that this package raises on purpose."""


class InputError(AnalogCardError):
    """Something the user gave cannot be used; the message says what, where and what is allowed."""


class SimulationError(AnalogCardError):
    """The circuit simulator could not do what was asked; the message carries its own words."""
