"""Flow through the valve's edges and through leaks."""

import math

from pneuservo.challenge.truth.compilation import truth_kernel

# A leak's size is stated as the orifice that passes the same at these pressures.
REFERENCE_HIGH, REFERENCE_LOW = 6e5, 1e5
CHOKED = 0.0404  # flow of a perfect orifice, m sqrt(T)/(A p) [K^0.5 s/m]
LINEARISER_AT = 0.2  # opening at which the lineariser is worst
RATED_RATIO = 0.528


@truth_kernel
def clear_opening(opening, valve):
    """Return how far an edge is open, from the spool's displacement [share of full opening].

    Overlap with rounded corners: a hyperbola whose asymptotes are closed and |opening| - overlap.
    """
    size = abs(opening)
    if valve.overlap == 0.0:
        return size
    beyond = size - valve.overlap
    corner = valve.overlap_rounding * valve.overlap
    return 0.5 * (beyond + math.sqrt(beyond * beyond + corner * corner))


@truth_kernel
def coefficient_at(valve, path, volts, ratio):
    """Return discharge coefficient times expansion factor from the map."""
    rows = valve.rows
    last = len(rows) - 1
    row, part = 0, 0.0
    if volts >= rows[last]:
        row, part = last - 1, 1.0
    elif volts > rows[0]:
        while volts > rows[row + 1]:
            row += 1
        part = (volts - rows[row]) / (rows[row + 1] - rows[row])
    place = ratio * (valve.coefficient.shape[2] - 1)
    column = min(int(place), valve.coefficient.shape[2] - 2)
    rest = place - column
    lower = valve.coefficient[path, row]
    upper = valve.coefficient[path, row + 1]
    low = lower[column] + rest * (lower[column + 1] - lower[column])
    high = upper[column] + rest * (upper[column + 1] - upper[column])
    return low + part * (high - low)


@truth_kernel
def subsonic_change(ratio, critical, index):
    """Return the flow of ISO 6358 with this critical ratio over that with the rated one."""
    lost = max((ratio - critical) / (1.0 - critical), 0.0)
    rated = max((ratio - RATED_RATIO) / (1.0 - RATED_RATIO), 0.0)
    return (1.0 - min(lost * lost, 1.0) + 1e-9) ** index / math.sqrt(
        1.0 - min(rated * rated, 1.0) + 1e-9
    )


@truth_kernel
def edge_flow(valve, path, area, volts, upstream, downstream, temperature, gas_constant):
    """Return the flow through an edge, positive from `upstream` to `downstream` [kg/s].

    m = Cd Y A sqrt(2 rho dp); laminar below a pressure drop where that is asked for: Cd by the
    flow number (McCloy and Martin 1980), or losses in series (Forchheimer 1901).
    """
    sign = 1.0
    if downstream > upstream:
        upstream, downstream, sign = downstream, upstream, -1.0
    ratio = downstream / upstream
    if not 0.0 <= ratio <= 1.0:
        # A step that overshot; it is taken again, shorter.
        return math.nan
    drop = 1.0 - ratio
    # Linear below a millionth of the pressure: the root has no slope at zero.
    root = drop / math.sqrt(drop + 1e-6)
    if valve.laminar_pressure > 0.0:
        fall = upstream - downstream
        if valve.laminar_series > 0.0:
            viscous = 0.5 * math.sqrt(valve.laminar_pressure / max(fall, 1e-9))
            root /= viscous + math.sqrt(1.0 + viscous * viscous)
        else:
            root *= math.tanh(math.sqrt(fall / valve.laminar_pressure))
    if valve.critical_ratio != RATED_RATIO or valve.subsonic_index != 0.5:
        root *= subsonic_change(ratio, valve.critical_ratio, valve.subsonic_index)
    coefficient = coefficient_at(valve, path, volts, ratio)
    return (
        sign * coefficient * area * upstream * root * math.sqrt(2.0 / (gas_constant * temperature))
    )


@truth_kernel
def leak_flow(area, laminar, high, low, temperature):
    """Return the flow through a leak, positive from `high` to `low` [kg/s].

    Viscous and kinetic losses in series, a m + b m^2 = p1^2 - p2^2 (Forchheimer 1901); `laminar`
    is the viscous share at the reference pressures, where the flow is that of an orifice `area`.
    """
    if area == 0.0:
        return 0.0
    reference = CHOKED * area * REFERENCE_HIGH / math.sqrt(temperature)
    span = REFERENCE_HIGH**2 - REFERENCE_LOW**2
    drive = abs(high * high - low * low)
    viscous = laminar * span / reference
    kinetic = max(1.0 - laminar, 1e-6) * span / reference**2
    # The stable form of the positive root; a small offset keeps its slope finite.
    root = math.sqrt(viscous * viscous + 4.0 * kinetic * (drive + 1e-9 * span))
    return math.copysign(2.0 * drive / (viscous + root), high - low)


@truth_kernel
def pore_flow(area, power, pressure, ambient, temperature):
    """Return the leak through pores that open with pressure [kg/s]."""
    reference = CHOKED * area * REFERENCE_HIGH / math.sqrt(temperature)
    gauge = max(pressure - ambient, 0.0) / (REFERENCE_HIGH - REFERENCE_LOW)
    return reference * gauge**power
