"""From the behaviour wanted to the settings of the four potentiometers, and back."""

import math
from dataclasses import asdict, dataclass, replace

from analog_card.design import Design, Turned
from analog_card.design_file import load_design
from analog_card.errors import InputError
from analog_card.figures import CardFigures, card_figures
from analog_card.quantities import as_text
from analog_card.settings import (
    boundary_layer_at,
    boundary_layer_setting,
    displacement_setting,
    level_setting,
    velocity_setting,
)


@dataclass(frozen=True)
class SurfaceWeights:
    """What the settings of a card amount to, in the terms of the sliding surface.

    Attributes
    ----------
    displacement : float
        State weight c1 [1/s2].
    velocity : float
        State weight c2 [1/s].
    acceleration : float
        State weight c3; 1 by convention.
    boundary_layer : float
        Surface value at which the output reaches its level [m/s2].
    level : float
        Largest output [V].
    """

    displacement: float
    velocity: float
    acceleration: float
    boundary_layer: float
    level: float


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

    def to_dict(self) -> dict[str, object]:
        """Return everything as plain values in SI units, for JSON."""
        return {
            "settling_time": self.settling_time,
            "damping": self.damping,
            "natural_frequency": self.natural_frequency,
            "weights": asdict(self.weights),
            "potentiometers": {item.name: asdict(item) for item in self.potentiometers},
            "figures": asdict(self.figures),
        }


def state_weights(settling_time: float, damping: float) -> tuple[float, float]:
    """Return the state weights c1 [1/s2] and c2 [1/s] of a sliding surface with c3 = 1.

    Parameters
    ----------
    settling_time : float
        Settling time of the sliding motion, 4/(damping wn) [s].
    damping : float
        Its damping ratio.

    Notes
    -----
    Thesis (7.3), (7.4): c1 = wn^2, c2 = 2 zeta wn.

    Examples
    --------
    >>> [round(weight, 1) for weight in state_weights(0.07, 1.0)]
    [3265.3, 114.3]
    """
    frequency = 4 / (damping * settling_time)
    return frequency**2, 2 * damping * frequency


def tune(
    settling_time: float,
    damping: float = 1.0,
    boundary_layer: float = 5.0,
    level: float = 5.0,
    design: Design | None = None,
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
    _require_possible(settling_time, damping, boundary_layer, level)
    design = design or load_design()
    weights = SurfaceWeights(*state_weights(settling_time, damping), 1.0, boundary_layer, level)
    turned = Turned(
        displacement_weight=displacement_setting(weights.displacement, design),
        velocity_weight=velocity_setting(weights.velocity, design),
        boundary_layer=boundary_layer_setting(boundary_layer, design),
        level=level_setting(level, design),
    )
    asked = (
        f"tuned for settling time {as_text(settling_time, 's', 6)}, damping {damping:g}, "
        f"boundary layer {boundary_layer:g} m/s2, level {as_text(level, 'V', 6)}"
    )
    return Tuning(settling_time, damping, weights, _turned(design, turned, asked))


def weights_from_settings(design: Design) -> SurfaceWeights:
    """Return what the settings of a card amount to: the inverse of `tune`.

    Parameters
    ----------
    design : Design
        A card with its settings.

    Returns
    -------
    SurfaceWeights
        State weights (for c3 = 1), boundary layer and level.

    Examples
    --------
    >>> weights = weights_from_settings(load_design())
    >>> round(weights.displacement, 1), round(weights.velocity, 2)
    (3265.3, 114.29)
    """
    figures = card_figures(design)
    unit = figures.weight_acceleration * figures.rc_acceleration
    return SurfaceWeights(
        displacement=figures.weight_displacement / (unit * figures.rc_velocity),
        velocity=figures.weight_velocity / unit,
        acceleration=1.0,
        boundary_layer=boundary_layer_at(design.turned.boundary_layer, design),
        level=figures.level,
    )


def _turned(design: Design, turned: Turned, source: str) -> Design:
    sources = dict.fromkeys((f"turned.{name}" for name in vars(turned)), source)
    return replace(design, turned=turned, sources={**design.sources, **sources})


def _require_possible(
    settling_time: float, damping: float, boundary_layer: float, level: float
) -> None:
    for name, value, unit in (
        ("settling time", settling_time, " s"),
        ("damping", damping, ""),
        ("boundary layer", boundary_layer, " m/s2"),
        ("level", level, " V"),
    ):
        if not (math.isfinite(value) and value > 0):
            raise InputError(f"{name}: {value:g}{unit} is not greater than 0")
    if damping > 1:
        raise InputError(
            f"damping: {damping:g} is above 1, where 4/(damping wn) is no settling time any more; "
            "use 1 and a longer settling time"
        )
