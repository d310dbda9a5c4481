"""The two-link manipulator of appendix A1: its numbers, and its torques linear in them."""

import math
import tomllib
from dataclasses import dataclass, replace
from functools import cache
from importlib.resources import files
from typing import Any

import numpy as np

from pneuservo.arrays import Array
from pneuservo.errors import InputError
from pneuservo.manipulator.linkage import Link, Linkage, linkage_of

Pair = tuple[float, float]

GRAVITY = 9.81


@dataclass(frozen=True)
class Manipulator:
    """An inverted double pendulum with a motor in each joint.

    Parameters
    ----------
    masses : pair of float
        Of the links [kg].
    inertias : pair of float
        Of the links about their centres of gravity [kg m^2].
    centres : pair of float
        From each joint to the centre of gravity of its link [m].
    length : float
        From the first joint to the second [m].
    frictions : pair of float
        Viscous, of the joints [N m s/rad].
    actuator_gains : pair of float
        Torque per voltage, without dynamics [N m/V].

    Raises
    ------
    InputError
        When a value is not positive; friction may be 0.

    Examples
    --------
    >>> nominal().varied(0.3).masses
    (13.0, 13.0)
    """

    masses: Pair
    inertias: Pair
    centres: Pair
    length: float
    frictions: Pair
    actuator_gains: Pair

    def __post_init__(self) -> None:
        """Refuse what no manipulator can have."""
        for name in ("masses", "inertias", "centres", "actuator_gains"):
            for value in getattr(self, name):
                _require(name, value, value > 0.0, "greater than 0")
        _require("length", self.length, self.length > 0.0, "greater than 0")
        for value in self.frictions:
            _require("frictions", value, value >= 0.0, "0 or more")

    def varied(self, share: float, lengths: bool = True) -> "Manipulator":
        """Return the worst case within a tolerance: heavier, longer, and less damped.

        Parameters
        ----------
        share : float
            Of the nominal values, from -1 to 1 [-].
        lengths : bool, optional
            Whether length and centres vary as well.

        Notes
        -----
        Table A1.1 of the thesis at 0.3: what makes the links harder to move goes up, and
        friction, which would hide it, down.
        """
        more, less = 1.0 + share, 1.0 - share
        longer = more if lengths else 1.0
        return replace(
            self,
            masses=_scaled(self.masses, more),
            inertias=_scaled(self.inertias, more),
            centres=_scaled(self.centres, longer),
            length=self.length * longer,
            frictions=_scaled(self.frictions, less),
        )

    @property
    def linkage(self) -> Linkage:
        """Return the two links as the kernels take them."""
        (m1, m2), (j1, j2), (lc1, lc2) = self.masses, self.inertias, self.centres
        return linkage_of([Link(m1, j1, lc1, self.length), Link(m2, j2, lc2, 0.0, carrier=0)])

    @property
    def parameters(self) -> Array:
        """Return p = [m1, m2, J1, J2, k1, k2], in SI."""
        return np.array([*self.masses, *self.inertias, *self.frictions])

    def regressor(self, angles: Array, rates: Array, accelerations: Array) -> Array:
        """Return W of the torques W p, which depends on the lengths only.

        Parameters
        ----------
        angles, rates, accelerations : (2,) array
            Of the joints, the second relative to the first link [rad], [rad/s], [rad/s^2].

        Returns
        -------
        (2, 6) array
            Torque per parameter, in SI.

        Notes
        -----
        Equation (A1.18) of the thesis: M(theta) theta'' + N(theta, theta') = W p with N the
        torques of velocity, friction and gravity.
        """
        (lc1, lc2), l1, g = self.centres, self.length, GRAVITY
        (q1, q2), (v1, v2), (a1, a2) = angles, rates, accelerations
        sine, cosine = math.sin(q2), math.cos(q2)
        sine_1, sine_12 = math.sin(q1), math.sin(q1 + q2)
        product = l1 * lc2
        mass_2 = (
            (l1 * l1 + lc2 * lc2 + 2.0 * product * cosine) * a1
            + (lc2 * lc2 + product * cosine) * a2
            - product * sine * (v2 * v2 + 2.0 * v1 * v2)
            - g * (l1 * sine_1 + lc2 * sine_12)
        )
        elbow = (
            (lc2 * lc2 + product * cosine) * a1
            + lc2 * lc2 * a2
            + product * sine * v1 * v1
            - g * lc2 * sine_12
        )
        return np.array(
            [
                [lc1 * lc1 * a1 - g * lc1 * sine_1, mass_2, a1, a1 + a2, v1, 0.0],
                [0.0, elbow, 0.0, a1 + a2, 0.0, v2],
            ]
        )


@cache
def nominal() -> Manipulator:
    """Return the manipulator with the nominal values of table A1.1."""
    table = _document()["manipulator"]
    return Manipulator(
        masses=tuple(table["masses"]),
        inertias=tuple(table["inertias"]),
        centres=tuple(table["centres"]),
        length=table["length"],
        frictions=tuple(table["frictions"]),
        actuator_gains=tuple(table["actuator_gains"]),
    )


@cache
def bounds() -> Array:
    """Return the bounds of table A1.3 on `Manipulator.parameters`.

    Returns
    -------
    (2, 6) array
        Lower and upper, in SI.
    """
    table = _document()["bounds"]
    pairs = [*table["masses"], *table["inertias"], *table["frictions"]]
    return np.array(pairs).T


@cache
def printed_state_feedback() -> Array:
    """Return the gain matrix (A1.12), on [theta1, theta1', theta2, theta2'] [V/rad], [V s/rad]."""
    return np.array(_document()["state_feedback"]["gain"])


@cache
def _document() -> dict[str, Any]:
    text = (files("pneuservo.manipulator") / "manipulator.toml").read_text(encoding="utf-8")
    return tomllib.loads(text)


def _scaled(pair: Pair, factor: float) -> Pair:
    return pair[0] * factor, pair[1] * factor


def _require(name: str, value: float, possible: bool, allowed: str) -> None:
    if not (possible and math.isfinite(value)):
        raise InputError(f"manipulator: {name} is {value:g}; it has to be {allowed}")
