"""What a card cannot do as it is soldered and turned, and how finely it can be turned."""

import math
from dataclasses import dataclass, replace

from analog_card.design import Design
from analog_card.figures import card_figures
from analog_card.noise import card_noise
from analog_card.settings import boundary_layer_at, largest_weights
from analog_card.surface_weights import weights_from_settings

# What the piston of the thesis' rig reaches, (7.12) and section 9.2 [m/s], [m/s2].
LARGEST_VELOCITY, LARGEST_ACCELERATION = 0.356, 82.0
# A layer within three standard deviations of the noise is switched through by the noise.
NOISE_MARGIN = 3.0
_SMALL = 1e-4


@dataclass(frozen=True)
class Limit:
    """One thing that a card can only do so far.

    Attributes
    ----------
    quantity, unit : str
        What, and its SI unit.
    wanted : float
        What is asked of it [unit].
    lowest, highest : float
        What it can [unit].
    reason : str
        What sets the limit.
    """

    quantity: str
    unit: str
    wanted: float
    lowest: float
    highest: float
    reason: str

    @property
    def holds(self) -> bool:
        """Whether what is asked is within the limit."""
        # A setting at its end is still one.
        margin = 1e-9 * max(abs(self.lowest), abs(self.wanted))
        return self.lowest - margin <= self.wanted <= self.highest + margin

    def to_dict(self) -> dict[str, object]:
        """Return the limit as plain values for JSON, None where there is no limit."""
        values = {name: vars(self)[name] for name in ("wanted", "lowest", "highest")}
        finite = {name: v if math.isfinite(v) else None for name, v in values.items()}
        return {"quantity": self.quantity, "unit": self.unit, **finite} | {
            "holds": self.holds,
            "reason": self.reason,
        }


@dataclass(frozen=True)
class Sensitivity:
    """What a potentiometer does where it stands.

    Attributes
    ----------
    name, quantity, unit : str
        ``P1`` to ``P4``, what it sets, and the SI unit of that.
    per_turn : float
        Change of the quantity with one turn upwards [unit].
    relative : float
        Relative change of the quantity over the relative change of the travel in use [-].
    """

    name: str
    quantity: str
    unit: str
    per_turn: float
    relative: float


def limits(design: Design, wanted: dict[str, float]) -> tuple[Limit, ...]:
    """Return what a card can reach, and why not more.

    Parameters
    ----------
    design : Design
        The card with its settings.
    wanted : dict of str to float
        ``c1`` [1/s2], ``c2`` [1/s], ``boundary_layer`` [m/s2] and ``level`` [V].

    Returns
    -------
    tuple of Limit
        Ranges of the four potentiometers, the settling time that follows, saturation of both taps
        and of the surface amplifier, noise.

    Notes
    -----
    The taps have to carry 0.356 m/s and 82 m/s2, what the piston of the thesis' rig reaches.
    """
    figures, parts = card_figures(design), design.soldered
    swing, noise = figures.surface_limit, card_noise(design).voltage("surface")
    c1, c2 = largest_weights(design)
    damping = wanted["c2"] / (2 * math.sqrt(wanted["c1"])) if wanted["c1"] > 0 else math.inf
    settling = 8 / wanted["c2"] if wanted["c2"] > 0 else math.inf
    slowest = min(damping, 1.0) * math.sqrt(c1)
    # Without damping no settling time is reached; with P2 at zero there is none.
    shortest = max(8 / c2, 4 / slowest if slowest > 0 else math.inf)
    narrowest, widest = (boundary_layer_at(travel, design) for travel in (1.0, 0.0))
    per_velocity = figures.transducer_gain * figures.rc_velocity
    per_acceleration = per_velocity * figures.rc_acceleration
    layer, volts = wanted["boundary_layer"], f"saturates at {swing:g} V"
    none = math.inf
    return (
        Limit("c1", "1/s2", wanted["c1"], 0.0, c1, "range of P1 into displacement_resistance"),
        Limit("c2", "1/s", wanted["c2"], 0.0, c2, "range of P2 into velocity_resistance"),
        Limit("settling time", "s", settling, shortest, none, "ranges of P1 and P2"),
        Limit("boundary layer", "m/s2", layer, narrowest, widest, "range of P3"),
        Limit("boundary layer", "m/s2", layer, 0.0, swing / figures.surface_scale,
              f"surface amplifier {volts}"),
        Limit("boundary layer", "m/s2", layer, NOISE_MARGIN * noise / figures.surface_scale, none,
              f"{NOISE_MARGIN:g} times the noise of the surface voltage, op-amps and resistors"),
        Limit("level", "V", wanted["level"], 0.0, parts.output_limiter.clamp_level,
              "range of P4 behind the clamp"),
        Limit("velocity", "m/s", LARGEST_VELOCITY, 0.0, swing / per_velocity,
              f"velocity tap {volts}"),
        Limit("acceleration", "m/s2", LARGEST_ACCELERATION, 0.0, swing / per_acceleration,
              f"acceleration tap {volts}"),
    )  # fmt: skip


def sensitivities(design: Design, turns: float = 10.0) -> tuple[Sensitivity, ...]:
    """Return what each potentiometer does where it stands.

    Parameters
    ----------
    design : Design
        The card with its settings.
    turns : float, optional
        Of each potentiometer from end to end.

    Returns
    -------
    tuple of Sensitivity
        P1 to P4.

    Examples
    --------
    >>> from analog_card.design_file import load_design
    >>> p2 = sensitivities(load_design())[1]
    >>> round(p2.per_turn, 1), round(p2.relative, 2)  # of c2 = 114.3; unloaded: 15.7 and 1
    (16.7, 1.06)
    """
    names = (
        ("P1", "displacement_weight", "displacement", "c1", "1/s2"),
        ("P2", "velocity_weight", "velocity", "c2", "1/s"),
        ("P3", "boundary_layer", "boundary_layer", "boundary layer", "m/s2"),
        ("P4", "level", "level", "level", "V"),
    )
    found = []
    for name, setting, weight, quantity, unit in names:
        fraction = getattr(design.turned, setting)

        def at(travel: float, setting: str = setting, weight: str = weight) -> float:
            turned = replace(design.turned, **{setting: travel})
            return float(getattr(weights_from_settings(replace(design, turned=turned)), weight))

        low, high = max(fraction - _SMALL, 0.0), min(fraction + _SMALL, 1.0)
        slope = (at(high) - at(low)) / (high - low)
        value = at(fraction)
        relative = slope * fraction / value if value > 0 else 1.0
        found.append(Sensitivity(name, quantity, unit, slope / turns, relative))
    return tuple(found)
