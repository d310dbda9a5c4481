"""The command's hysteresis, the amplifier and the spool."""

import math

from pneuservo.challenge.truth import layout as at
from pneuservo.challenge.truth.compilation import truth_kernel

# A bristle of the spool's dry friction yields after a thousandth of full opening.
SPOOL_SLIP = 1e-3
SILTING_TRAVEL = 0.01
AMPLIFIER_LAG = 1e-4


@truth_kernel
def hysteresis(share, spool, kept, relays, centres, spreads):
    """Return the command after hysteresis [share of full opening].

    Relays in parallel (Preisach 1935), their centres densest at null, or parallel slack elements
    of several widths (Prandtl and Ishlinskii).
    """
    if spool.hysteresis > 0.0:
        excess = 0.0
        for j in range(len(relays)):
            offset = share - spool.hysteresis_spread * centres[j]
            if offset > spool.hysteresis * spreads[j]:
                relays[j] = 1.0
            elif offset < -spool.hysteresis * spreads[j]:
                relays[j] = -1.0
            excess += relays[j] - (1.0 if offset > 0.0 else -1.0)
        # So that the loop's half width at null is the one asked for.
        height = 0.5 * spool.hysteresis_spread * math.sqrt(2.0 * math.pi)
        share += height * excess / len(relays)
    if spool.slack > 0.0:
        mean = 0.0
        for j in range(at.SLACK_COUNT):
            width = spool.slack * (2.0 * j + 1.0) / at.SLACK_COUNT
            held = kept[at.SLACKS + j]
            kept[at.SLACKS + j] = min(max(held, share - width), share + width)
            mean += kept[at.SLACKS + j] / at.SLACK_COUNT
        share = mean
    return share


@truth_kernel
def spool_rates(share, time, spool, y, rates):
    """Set the rates of amplifier and spool."""
    opening, speed = y[at.SPOOL], y[at.SPOOL_SPEED]
    target = share + spool.bias + spool.bias_drift * time
    if spool.amplifier_slew < math.inf:
        wanted = (target - y[at.AMPLIFIER]) / AMPLIFIER_LAG
        rates[at.AMPLIFIER] = min(max(wanted, -spool.amplifier_slew), spool.amplifier_slew)
        target = y[at.AMPLIFIER]
    lag = target - opening
    stiffness = spool.frequency**2
    force = stiffness * lag / math.sqrt(1.0 + spool.softening * lag * lag)
    drag = 2.0 * spool.damping * spool.frequency * speed
    acceleration = force - drag * (1.0 + abs(speed) / spool.speed_scale)
    if spool.friction > 0.0:
        bristle = min(max(y[at.SPOOL_BRISTLE], -1.0), 1.0)
        grown = 1.0 + spool.silting * math.log1p(max(y[at.SPOOL_AGE], 0.0))
        acceleration -= stiffness * spool.friction * grown * bristle
        yields = abs(y[at.SPOOL_BRISTLE]) < 1.0 or bristle * speed < 0.0
        rates[at.SPOOL_BRISTLE] = speed / SPOOL_SLIP if yields else 0.0
        rates[at.SPOOL_AGE] = 1.0 - abs(speed) * y[at.SPOOL_AGE] / SILTING_TRAVEL
    limit = spool.acceleration_limit
    acceleration = min(max(acceleration, -limit), limit)
    if opening >= spool.travel_open and speed >= 0.0:
        speed, acceleration = 0.0, min(acceleration, 0.0)
    elif opening <= -spool.travel_close and speed <= 0.0:
        speed, acceleration = 0.0, max(acceleration, 0.0)
    rates[at.SPOOL] = speed
    rates[at.SPOOL_SPEED] = acceleration


@truth_kernel
def hold_spool_in_travel(spool, y):
    """Put a spool that went beyond its travel back on its stop."""
    if y[at.SPOOL] > spool.travel_open:
        y[at.SPOOL], y[at.SPOOL_SPEED] = spool.travel_open, min(y[at.SPOOL_SPEED], 0.0)
    elif y[at.SPOOL] < -spool.travel_close:
        y[at.SPOOL], y[at.SPOOL_SPEED] = -spool.travel_close, max(y[at.SPOOL_SPEED], 0.0)
    y[at.SPOOL_BRISTLE] = min(max(y[at.SPOOL_BRISTLE], -1.0), 1.0)
