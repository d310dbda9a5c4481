"""From the behaviour wanted to the settings of the four potentiometers, and back."""

import math
from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass, replace

from analog_card.design import Design
from analog_card.design_file import load_design
from analog_card.errors import InputError
from analog_card.figures import CardFigures, card_figures
from analog_card.plain_json import plain_json
from analog_card.quantities import as_text
from analog_card.reach import Limit, limits, sensitivities
from analog_card.settings import (
    boundary_layer_setting,
    displacement_setting,
    level_setting,
    velocity_setting,
)
from analog_card.surface_weights import SurfaceWeights, state_weights, weights_from_settings


@dataclass(frozen=True)
class Potentiometer:
    """One setting: what it is for, where to turn it, and what an ohmmeter shows there.

    Attributes
    ----------
    name, setting : str
        ``P1`` to ``P4``, and the name of what it sets in the design's ``turned``.
    fraction : float
        Fraction of travel, 0 to 1.
    resistance : float
        Between wiper and the lower end of the track; for P3 the resistance left in [ohm].
    """

    name: str
    setting: str
    fraction: float
    resistance: float


@dataclass(frozen=True)
class Tuning:
    """A card turned to a given behaviour.

    Attributes
    ----------
    settling_time, damping : float
        What was asked for [s], [1].
    weights : SurfaceWeights
        State weights, boundary layer and level.
    design : Design
        The card with its new settings.
    """

    settling_time: float
    damping: float
    weights: SurfaceWeights
    design: Design

    @property
    def natural_frequency(self) -> float:
        """Natural frequency of the sliding motion [rad/s]."""
        return math.sqrt(self.weights.displacement)

    @property
    def figures(self) -> CardFigures:
        """Nominal figures of the card at these settings."""
        return card_figures(self.design)

    @property
    def potentiometers(self) -> tuple[Potentiometer, ...]:
        """The four settings."""
        parts = self.design.soldered
        tracks = {
            "displacement_weight": parts.surface_amplifier.displacement_potentiometer,
            "velocity_weight": parts.surface_amplifier.velocity_potentiometer,
            "boundary_layer": parts.boundary_layer_amplifier.potentiometer,
            "level": parts.output_limiter.potentiometer,
        }
        fractions = vars(self.design.turned)
        return tuple(
            Potentiometer(f"P{number}", name, fractions[name], fractions[name] * track)
            for number, (name, track) in enumerate(tracks.items(), 1)
        )

    @property
    def achieved(self) -> dict[str, float]:
        """What the settings amount to: c1 [1/s2], c2 [1/s], boundary_layer [m/s2], level [V]."""
        weights = weights_from_settings(self.design)
        return {
            "c1": weights.displacement,
            "c2": weights.velocity,
            "boundary_layer": weights.boundary_layer,
            "level": weights.level,
        }

    @property
    def limits(self) -> tuple[Limit, ...]:
        """What the card can reach, and why not more."""
        return limits(self.design, self.achieved)

    def to_dict(self, turns: float = 10.0) -> dict[str, object]:
        """Return everything as plain values in SI units, for JSON.

        Parameters
        ----------
        turns : float, optional
            Of each potentiometer from end to end.
        """
        return {
            "settings": {
                item.name: {"fraction": item.fraction, "ohm": item.resistance}
                for item in self.potentiometers
            },
            "achieved": self.achieved,
            "limits": [limit.to_dict() for limit in self.limits],
            "sensitivity": {item.name: asdict(item) for item in sensitivities(self.design, turns)},
            "settling_time": plain_json(self.settling_time),
            "damping": plain_json(self.damping),
            "natural_frequency": self.natural_frequency,
            "weights": asdict(self.weights),
            "potentiometers": {item.name: asdict(item) for item in self.potentiometers},
            "figures": asdict(self.figures),
        }


def tune(
    settling_time: float,
    damping: float = 1.0,
    boundary_layer: float = 5.0,
    level: float = 5.0,
    design: Design | None = None,
    transducer_gain: float | None = None,
) -> Tuning:
    """Find the settings that give a sliding motion, a boundary layer and an output level.

    Parameters
    ----------
    settling_time : float
        Settling time of the sliding motion, 4/(damping wn) [s].
    damping : float, optional
        Damping ratio of the sliding motion, above 0 up to 1.
    boundary_layer : float, optional
        Surface value at which the output reaches its level [m/s2].
    level : float, optional
        Largest output [V].
    design : Design, optional
        The card; without it the recommended one.
    transducer_gain : float, optional
        Volts of the transducer for each metre; without it the design's [V/m].

    Returns
    -------
    Tuning
        The card with the settings found, and what they amount to.

    Raises
    ------
    InputError
        When a value is out of range or a potentiometer cannot reach its setting with the parts
        of this card.

    Notes
    -----
    Thesis (7.3), (7.4): c1 = wn^2, c2 = 2 zeta wn, c3 = 1, Tsett = 4/(zeta wn). With
    zeta = 1 the motion enters a 2 % band after 5.83/wn, 1.46 times this settling time.

    Examples
    --------
    >>> tuning = tune(0.07)
    >>> [round(item.fraction, 3) for item in tuning.potentiometers]
    [0.482, 0.727, 0.151, 0.725]
    """
    design = with_transducer_gain(design or load_design(), transducer_gain)
    turned = retune(
        design,
        settling_time=settling_time,
        damping=damping,
        boundary_layer=boundary_layer,
        level=level,
    )
    weights = SurfaceWeights(*state_weights(settling_time, damping), 1.0, boundary_layer, level)
    return Tuning(settling_time, damping, weights, turned)


def retune(design: Design, **goals: float) -> Design:
    """Turn a card to some goals; the potentiometers of the others stay where they stand.

    Parameters
    ----------
    design : Design
        A card with its settings.
    **goals : float
        Any of ``settling_time``, ``damping``, ``boundary_layer`` and ``level``, as `tune` takes
        them. Of settling time and damping the one that is left out is that of the card.

    Returns
    -------
    Design
        The card with the settings found.

    Raises
    ------
    InputError
        As `tune`.

    Examples
    --------
    >>> turned = retune(load_design(), level=4.0).turned
    >>> round(turned.level, 3), turned.boundary_layer == load_design().turned.boundary_layer
    (0.58, True)
    """
    if {"settling_time", "damping"} & goals.keys():
        now = read_settings(design)
        # A card may be turned to more than 1, which is no damping that can be asked for.
        damping = min(now.damping, 1.0)
        goals = {"settling_time": now.settling_time, "damping": damping, **goals}
    _require_possible(goals)
    settings = {}
    if "damping" in goals:
        displacement, velocity = state_weights(goals["settling_time"], goals["damping"])
        settings["displacement_weight"] = displacement_setting(displacement, design)
        settings["velocity_weight"] = velocity_setting(velocity, design)
    if "boundary_layer" in goals:
        settings["boundary_layer"] = boundary_layer_setting(goals["boundary_layer"], design)
    if "level" in goals:
        settings["level"] = level_setting(goals["level"], design)
    asked = ", ".join(f"{_in_words(name)} {_WRITTEN[name](goals[name])}" for name in goals)
    sources = dict.fromkeys((f"turned.{name}" for name in settings), f"tuned for {asked}")
    return replace(
        design,
        turned=replace(design.turned, **settings),
        sources={**design.sources, **sources},
    )


def read_settings(design: Design) -> Tuning:
    """Return what a card as it is turned amounts to, in the terms it was tuned in.

    Parameters
    ----------
    design : Design
        A card with its settings.

    Returns
    -------
    Tuning
        With the settling time and the damping of its sliding motion.

    Notes
    -----
    Thesis (7.3), (7.4) the other way round: damping c2/(2 sqrt(c1)), settling time 8/c2.

    Examples
    --------
    >>> tuning = read_settings(load_design())
    >>> round(tuning.settling_time, 4), round(tuning.damping, 4)
    (0.07, 1.0)
    """
    weights = weights_from_settings(design)
    c1, c2 = weights.displacement, weights.velocity
    return Tuning(
        settling_time=8 / c2 if c2 > 0 else math.inf,
        damping=c2 / (2 * math.sqrt(c1)) if c1 > 0 else math.inf,
        weights=weights,
        design=design,
    )


def with_transducer_gain(design: Design, gain: float | None) -> Design:
    """Return a card on a transducer of another gain, with the same full scale in metres.

    Parameters
    ----------
    design : Design
        The card.
    gain : float or None
        Volts for each metre; None leaves the design as it is [V/m].

    Raises
    ------
    InputError
        When it is not greater than 0.
    """
    if gain is None:
        return design
    if not (math.isfinite(gain) and gain > 0):
        raise InputError(f"transducer gain: {gain:g} V/m is not greater than 0")
    voltage = gain * design.transducer.full_scale_displacement
    return replace(design, transducer=replace(design.transducer, full_scale_voltage=voltage))


_WRITTEN: dict[str, Callable[[float], str]] = {
    "settling_time": lambda value: as_text(value, "s", 6),
    "damping": lambda value: f"{value:g}",
    "boundary_layer": lambda value: f"{value:g} m/s2",
    "level": lambda value: as_text(value, "V", 6),
}
"""How each goal is written."""


def _in_words(goal: str) -> str:
    return goal.replace("_", " ")


def _require_possible(goals: Mapping[str, float]) -> None:
    for name, value in goals.items():
        if not (math.isfinite(value) and value > 0):
            raise InputError(f"{_in_words(name)}: {_WRITTEN[name](value)} is not greater than 0")
    if goals.get("damping", 1.0) > 1:
        raise InputError(
            f"damping: {goals['damping']:g} is above 1, where 4/(damping wn) is no settling time "
            "any more; use 1 and a longer settling time"
        )
