"""Controllers of a single axis: dataclasses that become a compiled law beside the plant."""

import math
from collections.abc import Mapping
from dataclasses import asdict, dataclass, replace
from typing import Any, ClassVar

from analog_card.behaviour import CardBehaviour, Imperfections
from analog_card.design import Design
from analog_card.figures import CardFigures, card_figures
from analog_card.tuning import state_weights
from pneuservo.errors import InputError
from pneuservo.plant.control_law import CARD_TAPS, TRUE_STATES, ControlLaw
from pneuservo.rigs import Rig


@dataclass(frozen=True)
class SlidingMode:
    """Sliding mode with the true velocity and acceleration.

    Parameters
    ----------
    settling_time : float, optional
        4/(damping wn) of the sliding surface [s].
    damping : float, optional
        Damping ratio of the sliding surface [-].
    boundary_layer : float, optional
        Half width of the boundary layer; 0 gives an ideal relay [m/s^2].
    level : float, optional
        Largest output [V].

    Notes
    -----
    Equations (6.43), (7.1), (7.3) and (7.4) of the thesis: c1 = wn^2, c2 = 2 damping wn, c3 = 1.
    The boundary layer is printed there as 5000 m/s^2, which can only be 5000 mm/s^2.

    Examples
    --------
    >>> c1, c2, c3 = SlidingMode(settling_time=0.07, damping=1.0).weights
    >>> round(c1, 1), round(c2, 3), c3
    (3265.3, 114.286, 1.0)
    """

    kind: ClassVar[str] = "sliding-mode"
    settling_time: float = 0.07
    damping: float = 1.0
    boundary_layer: float = 5.0
    level: float = 5.0

    def __post_init__(self) -> None:
        """Refuse values that make no controller."""
        for name in ("settling_time", "damping", "level"):
            _require(self.kind, name, getattr(self, name), above=0.0)
        _require(self.kind, "boundary_layer", self.boundary_layer, at_least=0.0)

    @property
    def weights(self) -> tuple[float, float, float]:
        """Return c1 [1/s^2], c2 [1/s] and c3 [-]."""
        return (*state_weights(self.settling_time, self.damping), 1.0)

    def law(self, rig: Rig) -> ControlLaw:
        """Return the law as the kernels take it."""
        relay = self.boundary_layer == 0.0
        gain = math.inf if relay else self.level / self.boundary_layer
        return _law_of_true_states(self.weights, gain, self.level, rig)


@dataclass(frozen=True)
class Proportional:
    """Proportional control of the displacement, on transducer volts.

    Parameters
    ----------
    gain : float, optional
        Output per transducer voltage; the thesis calls 1 well behaved and 3.4 oscillating [V/V].
    level : float, optional
        Largest output [V].
    """

    kind: ClassVar[str] = "proportional"
    gain: float = 1.0
    level: float = 5.0

    def __post_init__(self) -> None:
        """Refuse values that make no controller."""
        _require(self.kind, "level", self.level, above=0.0)
        _require(self.kind, "gain", self.gain, at_least=0.0)

    def law(self, rig: Rig) -> ControlLaw:
        """Return the law as the kernels take it."""
        return _law_of_true_states((_sensitivity(rig), 0.0, 0.0), self.gain, self.level, rig)


@dataclass(frozen=True)
class StateFeedback:
    """Feedback of displacement, velocity and acceleration, on transducer volts.

    Parameters
    ----------
    gain : float, optional
        Of the displacement error [V/V].
    velocity_gain : float, optional
        Of the velocity; negative feeds it back positively [s].
    acceleration_gain : float, optional
        Of the acceleration [s^2].
    level : float, optional
        Largest output [V].

    Notes
    -----
    u = S (Kp (xd - x) - Kv v - Ka a) with the transducer gain S. The defaults are those of table
    5.5 of the thesis, extension at mid-stroke, settling time 0.4 s and damping 0.4.
    """

    kind: ClassVar[str] = "state-feedback"
    gain: float = 0.2407
    velocity_gain: float = -0.0379
    acceleration_gain: float = 0.0002
    level: float = 5.0

    def __post_init__(self) -> None:
        """Refuse values that make no controller."""
        _require(self.kind, "level", self.level, above=0.0)
        _require(self.kind, "gain", self.gain, at_least=0.0)
        _require(self.kind, "velocity_gain", self.velocity_gain)
        _require(self.kind, "acceleration_gain", self.acceleration_gain)

    def law(self, rig: Rig) -> ControlLaw:
        """Return the law as the kernels take it."""
        gains = (self.gain, self.velocity_gain, self.acceleration_gain)
        return _law_of_true_states(gains, _sensitivity(rig), self.level, rig)


@dataclass(frozen=True)
class AnalogueCard:
    """The behavioural analogue card on the rig's displacement transducer.

    Parameters
    ----------
    figures : CardFigures
        Gains, filters and limits, from `analog_card.figures.card_figures` or stated outright. The
        transducer is the rig's; an infinite output gain makes the card a relay.
    behaviour : CardBehaviour, optional
        The card with its op-amps, offsets, limits and tolerances, simulated instead of the
        figures; see `card_of`.

    Notes
    -----
    By its figures each differentiator is -s RC/((1 + s/w1)(1 + s/w2)), equation (9.3) of the
    thesis. Op-amp dynamics and offsets are left out; they lower the limit cycle of a relay card by
    2 to 5 %, and are in its behaviour.

    Examples
    --------
    >>> from analog_card.tuning import tune
    >>> card = AnalogueCard(tune(settling_time=0.07, boundary_layer=5.0).figures)
    >>> round(card.figures.output_gain * card.figures.surface_scale, 3)
    1.0
    """

    kind: ClassVar[str] = "analogue-card"
    figures: CardFigures
    behaviour: CardBehaviour | None = None

    def __post_init__(self) -> None:
        """Refuse figures that make no card."""
        figures = self.figures
        breaks = (*figures.velocity_breaks, *figures.acceleration_breaks)
        _require(self.kind, "rc_velocity", figures.rc_velocity, above=0.0)
        _require(self.kind, "rc_acceleration", figures.rc_acceleration, above=0.0)
        for frequency in breaks:
            _require(self.kind, "break frequency", frequency, above=0.0)
        _require(self.kind, "surface_limit", figures.surface_limit, at_least=0.0)
        _require(self.kind, "level", figures.level, at_least=0.0)
        if figures.output_gain != math.inf:
            _require(self.kind, "output_gain", figures.output_gain, at_least=0.0)

    def law(self, rig: Rig) -> ControlLaw:
        """Return the law as the kernels take it."""
        figures = self.figures
        velocity_lags, acceleration_lags = (
            [1.0 / (2.0 * math.pi * frequency) for frequency in breaks]
            for breaks in (figures.velocity_breaks, figures.acceleration_breaks)
        )
        return ControlLaw(
            source=CARD_TAPS,
            weight_displacement=float(figures.weight_displacement),
            weight_velocity=float(figures.weight_velocity),
            weight_acceleration=float(figures.weight_acceleration),
            surface_limit=float(figures.surface_limit),
            gain=float(figures.output_gain),
            level=float(figures.level),
            sensitivity=_sensitivity(rig),
            velocity_time_constant=float(figures.rc_velocity),
            velocity_lag_1=velocity_lags[0],
            velocity_lag_2=velocity_lags[1],
            acceleration_time_constant=float(figures.rc_acceleration),
            acceleration_lag_1=acceleration_lags[0],
            acceleration_lag_2=acceleration_lags[1],
        )


def card_of(
    design: Design,
    imperfections: Imperfections | None = None,
    elements: Mapping[str, float] | None = None,
    relay: bool = False,
) -> AnalogueCard:
    """Return a card as a controller, with what is chosen of its imperfections.

    Parameters
    ----------
    design : Design
        The card.
    imperfections : Imperfections, optional
        What of the real card it has; without it all. With none it is the card by its figures.
    elements : mapping of str to float, optional
        Values of elements that differ from the design's, by their names in
        `analog_card.behaviour_elements.nominal_elements`.
    relay : bool, optional
        Whether the feedback of the boundary-layer amplifier is opened.

    Returns
    -------
    AnalogueCard
        The controller.

    Examples
    --------
    >>> from analog_card.behaviour import Imperfections
    >>> from analog_card.design_file import load_design
    >>> card_of(load_design(), Imperfections.none()) == AnalogueCard(card_figures(load_design()))
    True
    """
    figures = card_figures(design)
    if relay:
        figures = replace(figures, output_gain=math.inf)
    with_ = imperfections or Imperfections()
    if not with_.any and not elements:
        return AnalogueCard(figures)
    return AnalogueCard(figures, CardBehaviour(design, elements or {}, with_, relay))


Controller = SlidingMode | Proportional | StateFeedback | AnalogueCard
CONTROLLERS: dict[str, type[Controller]] = {
    controller.kind: controller
    for controller in (SlidingMode, Proportional, StateFeedback, AnalogueCard)
}


def controller_settings(controller: Controller) -> dict[str, Any]:
    """Return the settings of a controller as plain values, for documents.

    Parameters
    ----------
    controller : Controller
        Any of this module.

    Returns
    -------
    dict of str to anything
        By the names of its parameters; of a behavioural card's design only the title.

    Examples
    --------
    >>> controller_settings(Proportional(gain=2.0))
    {'gain': 2.0, 'level': 5.0}
    """
    settings = asdict(controller)
    if isinstance(controller, AnalogueCard) and controller.behaviour is not None:
        settings["behaviour"]["design"] = controller.behaviour.design.title
    return settings


def _sensitivity(rig: Rig) -> float:
    return rig["sensor.displacement.range"] / rig["piston.stroke"]


def _law_of_true_states(
    weights: tuple[float, float, float], gain: float, level: float, rig: Rig
) -> ControlLaw:
    return ControlLaw(
        source=TRUE_STATES,
        weight_displacement=float(weights[0]),
        weight_velocity=float(weights[1]),
        weight_acceleration=float(weights[2]),
        surface_limit=math.inf,
        gain=float(gain),
        level=float(level),
        sensitivity=_sensitivity(rig),
        velocity_time_constant=0.0,
        velocity_lag_1=1.0,
        velocity_lag_2=1.0,
        acceleration_time_constant=0.0,
        acceleration_lag_1=1.0,
        acceleration_lag_2=1.0,
    )


def _require(
    kind: str,
    name: str,
    value: float,
    above: float = -math.inf,
    at_least: float = -math.inf,
) -> None:
    if math.isfinite(value) and value > above and value >= at_least:
        return
    allowed = f"greater than {above:g}" if math.isfinite(above) else "a finite number"
    if math.isfinite(at_least):
        allowed = f"{at_least:g} or more"
    raise InputError(f"{kind}: {name} is {value:g}; it has to be {allowed}")
