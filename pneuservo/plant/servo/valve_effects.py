"""What the valve's edges do beyond tabulated orifices."""

import math
from typing import NamedTuple

from pneuservo.plant.asymptotes import lesser
from pneuservo.plant.gas import gas_mass_flow, mass_flow_coefficient
from pneuservo.plant.servo.compilation import compiled

# Openings at which the lineariser's error is given; linear between, held outside.
LINEARISER_KNOTS = (0.05, 0.3, 1.0)
_PER_LOWER_SPAN = 1.0 / (LINEARISER_KNOTS[1] - LINEARISER_KNOTS[0])
_PER_UPPER_SPAN = 1.0 / (LINEARISER_KNOTS[2] - LINEARISER_KNOTS[1])


class ValveEffects(NamedTuple):
    """Parameters of the effects on the flow through the valve."""

    overlap: float = 0.0
    """Opening at which a path begins to open [-]."""
    null_leakage: float = 0.0
    """Effective leak area of each path at null, as a share of its full area [-]."""
    null_leakage_width: float = 0.02
    """Opening over which the leak fades to 1/e [-]."""
    null_leakage_laminar: float = 0.0
    """Share of the leak that flows as through a narrow gap, not as through an orifice [-]."""
    critical_ratio: float = 0.0
    """Pressure ratio b of the ellipse of ISO 6358 [-]; 0 for the isentropic nozzle."""
    laminar_width: float = 0.0
    """Pressure drop, as a share, below which the flow is laminar [-]."""
    laminar_sharpness: float = 2.0
    """How sharply it becomes so, see `pneuservo.plant.asymptotes.lesser` [-]."""
    exhaust_excess: float = 0.0
    """Exhaust paths wider than the rig has them, relative [-]."""
    side_excess: float = 0.0
    """Paths of port b wider than the rig has them, relative [-]."""
    charge_low: float = 0.0
    charge_middle: float = 0.0
    charge_high: float = 0.0
    """Relative error of the charging paths' area at `LINEARISER_KNOTS` [-]."""
    exhaust_low: float = 0.0
    exhaust_middle: float = 0.0
    exhaust_high: float = 0.0
    """Relative error of the exhaust paths' area at `LINEARISER_KNOTS` [-]."""
    supply_warmth: float = 0.0
    """Supply air above the rig's temperature [K]."""
    exhaust_area: float = 0.0
    """Effective area of a silencer behind both exhaust paths [m^2]; 0 for none."""
    exhaust_volume: float = 2e-5
    """Volume between them and the silencer [m^3]."""
    attached_loss: float = 0.0
    """Discharge coefficient lost while the jet is attached to the wall, relative [-]."""
    attached_at_supply: float = 1.0
    """Share of that loss at the edges of the supply [-]."""
    attach_ratio: float = 0.4
    """Pressure ratio below which the jet attaches [-]."""
    detach_ratio: float = 0.6
    """Pressure ratio above which it comes free [-]."""


@compiled
def effective_opening(opening, effects):
    """Return the opening that is left once the overlap is passed [-].

    Parameters
    ----------
    opening : float
        Spool position as a fraction of full opening [-].
    effects : ValveEffects
        The effects.

    Examples
    --------
    >>> round(effective_opening(-0.05, ValveEffects(overlap=0.02)), 3)
    -0.03
    """
    if effects.overlap > 0.0:
        return math.copysign(max(abs(opening) - effects.overlap, 0.0), opening)
    return opening


@compiled
def area_factor(opening, exhausts, port_b, effects):
    """Return the area of a path over that of the rig [-].

    Parameters
    ----------
    opening : float
        Magnitude of the opening [-].
    exhausts, port_b : bool
        Whether the path exhausts, and whether it belongs to port b.
    effects : ValveEffects
        The effects.
    """
    low, middle, high = effects.charge_low, effects.charge_middle, effects.charge_high
    factor = 1.0
    if exhausts:
        low, middle, high = effects.exhaust_low, effects.exhaust_middle, effects.exhaust_high
        factor += effects.exhaust_excess
    if port_b:
        factor *= 1.0 + effects.side_excess
    first, second, third = LINEARISER_KNOTS
    if opening < second:
        share = (max(opening, first) - first) * _PER_LOWER_SPAN
        return factor * (1.0 + low + (middle - low) * share)
    share = (min(opening, third) - second) * _PER_UPPER_SPAN
    return factor * (1.0 + middle + (high - middle) * share)


@compiled
def flow_factor(pressure_ratio, gas, effects):
    """Return the mass flow over that of an isentropic nozzle [-].

    Parameters
    ----------
    pressure_ratio : float
        Lower over higher pressure [-].
    gas : Gas
        The gas.
    effects : ValveEffects
        The effects.

    Notes
    -----
    ISO 6358: sqrt(1 - ((Pr - b)/(1 - b))^2) in place of (4.17), 1 below b. In the laminar tail
    the discharge coefficient falls with the root of the pressure drop, so that the flow is linear
    in it; how soon depends on the edge (Merritt 1967: with the root of the Reynolds number).

    Examples
    --------
    >>> from pneuservo.plant.gas import ideal_gas
    >>> air = ideal_gas(293.0, 287.0, 1.4)
    >>> round(flow_factor(0.5283, air, ValveEffects(critical_ratio=0.3)), 3)
    0.945
    """
    if effects.critical_ratio == 0.0 and effects.laminar_width == 0.0:
        return 1.0
    nozzle = mass_flow_coefficient(pressure_ratio, gas)
    if nozzle == 0.0:
        return 1.0
    factor = 1.0
    if effects.critical_ratio > 0.0:
        along = max(pressure_ratio - effects.critical_ratio, 0.0) / (1.0 - effects.critical_ratio)
        factor = gas.choked_coefficient * math.sqrt(1.0 - along * along) / nozzle
    if effects.laminar_width > 0.0:
        limit = math.sqrt((1.0 - pressure_ratio) / effects.laminar_width)
        factor *= lesser(1.0, limit, effects.laminar_sharpness)
    return factor


@compiled
def in_series(coefficient, area, series_area):
    """Return the discharge coefficient of an orifice with another one ahead of it [-].

    Parameters
    ----------
    coefficient : float
        Its discharge coefficient alone [-].
    area : float
        Its geometric area [m^2].
    series_area : float
        Effective area of the one ahead [m^2]; 0 for none.

    Notes
    -----
    1/C^2 = 1/Cv^2 + 1/Cl^2 (Richer and Hurmuzlu 2000; Beater 2007).

    Examples
    --------
    >>> round(in_series(1.0, 1e-6, 1e-6), 4)
    0.7071
    """
    if series_area > 0.0:
        share = coefficient * area / series_area
        return coefficient / math.sqrt(1.0 + share * share)
    return coefficient


@compiled
def pressure_behind(upstream, downstream, share, gas):
    """Return the pressure between an edge of the valve and a hose behind it [Pa].

    Parameters
    ----------
    upstream, downstream : float
        Absolute pressures before the edge and behind the hose [Pa].
    share : float
        Effective area of the edge over that of the hose [-].
    gas : Gas
        The gas.

    Notes
    -----
    What passes the edge passes the hose: share^2 (P^2 - ((Pe - b P)/(1 - b))^2) = Pe^2 - Pd^2,
    the ellipse of ISO 6358 for the edge, and for the hose a turbulent pipe's difference of
    squares (Beater 2007). Where Pe stays below b P the edge is choked and does not notice.

    Examples
    --------
    >>> from pneuservo.plant.gas import ideal_gas
    >>> air = ideal_gas(293.0, 287.0, 1.4)
    >>> pressure_behind(6e5, 1e5, 0.01, air) < 1.003e5
    True
    >>> round(pressure_behind(6e5, 1e5, 1.0, air) / 6e5, 3)
    0.814
    """
    choked = math.sqrt(downstream * downstream + share * share * upstream * upstream)
    bend = gas.critical_pressure_ratio * upstream
    if choked <= bend:
        return choked
    slope = share / (1.0 - gas.critical_pressure_ratio)
    slope *= slope
    known = slope * bend * bend - share * share * upstream * upstream - downstream * downstream
    root = math.sqrt(slope * slope * bend * bend - (1.0 + slope) * known)
    return (slope * bend + root) / (1.0 + slope)


@compiled
def silenced(pressure, exhausted, passed, plant, effects):
    """Return the pressure before a silencer some time later [Pa].

    Parameters
    ----------
    pressure : float
        What it was [Pa].
    exhausted : float
        Mass flow out of the valve [kg/s].
    passed : float
        The time [s].
    plant : SingleAxis
        The numbers of the rig.
    effects : ValveEffects
        With a silencer.

    Notes
    -----
    V/(n R T) dPe/dt = m - area Cm(0) sqrt((Pe^2 - P_atm^2)/T), a turbulent pipe's difference of
    squares (Beater 2007), by one step of the implicit rule: however small the volume, it comes to
    rest where as much leaves as arrives.
    """
    gas, ambient = plant.gas, plant.ambient_pressure
    rise = plant.polytropic_index * gas.gas_constant * gas.temperature
    rise *= passed / effects.exhaust_volume
    passes = gas_mass_flow(ambient, 0.0, effects.exhaust_area, 1.0, gas) / ambient
    shut = max(pressure + rise * exhausted, ambient)
    share = (rise * passes) ** 2
    root = math.sqrt(share * (shut * shut + (share - 1.0) * ambient * ambient))
    return (shut * shut + share * ambient * ambient) / (shut + root)


@compiled
def null_leakage_share(opening, effects):
    """Return the leak area of each path as a share of its full area [-].

    Parameters
    ----------
    opening : float
        Spool position as a fraction of full opening [-].
    effects : ValveEffects
        The effects.

    Notes
    -----
    After Eryilmaz and Wilson 2000: the radial clearance leaks most at null.
    """
    return effects.null_leakage * math.exp(-abs(opening) / effects.null_leakage_width)


@compiled
def jet_is_attached(attached, pressure_ratio, effects):
    """Return 1 while a jet is attached to the wall, otherwise 0.

    Parameters
    ----------
    attached : float
        What it was before.
    pressure_ratio : float
        Lower over higher pressure across the path [-].
    effects : ValveEffects
        The effects.

    Notes
    -----
    Two flow patterns with a band of pressure ratios in which either lasts (Stenning 1955).
    """
    if pressure_ratio < effects.attach_ratio:
        return 1.0
    if pressure_ratio > effects.detach_ratio:
        return 0.0
    return attached
