"""What the spool does beyond a linear second-order reply to its command."""

import math
from typing import NamedTuple

from pneuservo.plant.control_law import limited
from pneuservo.plant.servo.compilation import compiled
from pneuservo.plant.valve import spool_acceleration


class SpoolEffects(NamedTuple):
    """Parameters of the effects on the spool; shares are of full opening."""

    null_bias: float = 0.0
    """Opening at zero command [-]."""
    hysteresis: float = 0.0
    """Half width of the play between command and spool [-]."""
    delay: float = 0.0
    """Time from command to motor [s]."""
    acceleration_limit: float = 0.0
    """What the motor's largest force gives [1/s^2]; 0 for no limit."""
    rate_limit: float = 0.0
    """Fastest change of what drives the motor [1/s]; 0 for no limit."""
    stiction: float = 0.0
    """Command error that a spool does not follow after a long rest [-]."""
    stiction_time: float = 0.0
    """Rest over which the second half of the stiction builds up [s]; 0 for at once."""
    flow_force: float = 0.0
    """Closing shift at full opening with the whole supply pressure across both edges [-]."""
    extending_stop_loss: float = 0.0
    """Travel missing at the end that extends [-]."""
    retracting_stop_loss: float = 0.0
    """Travel missing at the end that retracts [-]."""


@compiled
def slewed(command, before, passed, full_voltage, effects):
    """Return the command that the driver's output has come to [V].

    Parameters
    ----------
    command : float
        Into the valve driver, delayed [V].
    before : float
        What its output was some time ago [V].
    passed : float
        That time [s].
    full_voltage : float
        Command at full opening [V].
    effects : SpoolEffects
        The effects.

    Examples
    --------
    >>> slewed(5.0, 0.0, 1e-3, 5.0, SpoolEffects(rate_limit=100.0))
    0.5
    """
    if effects.rate_limit > 0.0:
        return before + limited(command - before, effects.rate_limit * full_voltage * passed)
    return command


@compiled
def biased_with_play(command, play_position, full_voltage, effects):
    """Return the command that reaches the motor, after null bias and play [V].

    Parameters
    ----------
    command : float
        From `slewed` [V].
    play_position : float
        Where the play was left [V].
    full_voltage : float
        Command at full opening [V].
    effects : SpoolEffects
        The effects.

    Notes
    -----
    Play operator, Visintin 1994: the output stays until the input pushes it, exact for an input
    that does not turn between two updates of the play.

    Examples
    --------
    >>> biased_with_play(1.0, 0.0, 5.0, SpoolEffects(null_bias=0.01, hysteresis=0.1))
    0.55
    """
    biased = command + effects.null_bias * full_voltage
    half_width = effects.hysteresis * full_voltage
    if half_width > 0.0:
        return min(max(play_position, biased - half_width), biased + half_width)
    return biased


@compiled
def breakaway_of_spool(rest, effects):
    """Return the command error at which a spool at rest moves [-].

    Parameters
    ----------
    rest : float
        How long it has stood [s].
    effects : SpoolEffects
        The effects.

    Notes
    -----
    Dry friction holds at once, and as much again as the spool silts up (Merritt 1967):
    stiction (1 - exp(-rest/time)/2); without a time all at once.
    """
    if effects.stiction_time > 0.0:
        return effects.stiction * (1.0 - 0.5 * math.exp(-rest / effects.stiction_time))
    return effects.stiction


@compiled
def spool_rates(command, opening, opening_rate, pressure_share, stuck, valve, effects):
    """Return the rate of the spool [1/s] and its second derivative [1/s^2].

    Parameters
    ----------
    command : float
        From `biased_with_play`, limited to the full voltage [V].
    opening, opening_rate : float
        Spool position as a fraction of full opening [-] and its rate [1/s].
    pressure_share : float
        Mean pressure drop over the two open edges as a share of the supply pressure [-].
    stuck : float
        1 while stiction holds the spool, otherwise 0.
    valve : Valve
        The numbers of the valve.
    effects : SpoolEffects
        The effects.

    Notes
    -----
    The flow force closes in proportion to opening and pressure drop (Blackburn, Reethof, Shearer
    1960). Dry friction brakes a spool that moves as much as it holds one that has just come to
    rest. The limit of acceleration is that of the motor, and cuts off sharply.
    """
    if stuck != 0.0:
        return 0.0, 0.0
    if effects.flow_force > 0.0:
        command -= effects.flow_force * opening * pressure_share * valve.full_voltage
    if effects.stiction > 0.0 and opening_rate != 0.0:
        braked = breakaway_of_spool(0.0, effects) * valve.full_voltage
        command -= math.copysign(braked, opening_rate)
    acceleration = spool_acceleration(command, opening, opening_rate, valve)
    if effects.acceleration_limit > 0.0:
        acceleration = limited(acceleration, effects.acceleration_limit)
    return opening_rate, acceleration


@compiled
def travel_end(side, effects):
    """Return how far the spool can open to one side [-].

    Parameters
    ----------
    side : float
        Positive for the side that extends.
    effects : SpoolEffects
        The effects.
    """
    if side > 0.0:
        return 1.0 - effects.extending_stop_loss
    return 1.0 - effects.retracting_stop_loss
