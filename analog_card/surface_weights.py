"""The terms of the sliding surface: from a behaviour, and from the settings of a card."""

from dataclasses import dataclass

from analog_card.design import Design
from analog_card.errors import InputError
from analog_card.figures import card_figures
from analog_card.settings import boundary_layer_at

_SHORTEST = 1e-6
"""Settling time of a sliding surface times its damping, at the least [s]."""


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


def state_weights(settling_time: float, damping: float) -> tuple[float, float]:
    """Return the state weights c1 [1/s2] and c2 [1/s] of a sliding surface with c3 = 1.

    Parameters
    ----------
    settling_time : float
        Settling time of the sliding motion, 4/(damping wn) [s].
    damping : float
        Its damping ratio.

    Raises
    ------
    InputError
        When the surface would be faster than any servo.

    Notes
    -----
    Thesis (7.3), (7.4): c1 = wn^2, c2 = 2 zeta wn.

    Examples
    --------
    >>> [round(weight, 1) for weight in state_weights(0.07, 1.0)]
    [3265.3, 114.3]
    """
    if damping * settling_time < _SHORTEST:
        raise InputError(
            f"settling time {settling_time:g} s with damping {damping:g}: no surface is so fast; "
            f"their product has to be {_SHORTEST:g} s or more"
        )
    frequency = 4 / (damping * settling_time)
    return frequency**2, 2 * damping * frequency


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
    >>> from analog_card.design_file import load_design
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
