"""The numbers of the truth, one group per block; the defaults are the rig without any effect."""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


class Spool(NamedTuple):
    """Command, amplifier and spool."""

    frequency: float = 2.0 * math.pi * 200.0  # [rad/s]
    damping: float = 0.7
    full_voltage: float = 5.0  # [V]
    bias: float = 0.0  # null shift, share of full opening
    bias_drift: float = 0.0  # its growth [1/s]
    hysteresis: float = 0.0  # half width of the loop at null, share of full opening
    hysteresis_spread: float = (
        0.3  # how far from null the relays' centres lie, share of full opening
    )
    slack: float = 0.0  # the same as parallel slack elements, half width, share of full opening
    delay: float = 0.0  # [s]
    amplifier_slew: float = math.inf  # share of full opening per second
    speed_scale: float = math.inf  # spool speed at which the drag has doubled [1/s]
    acceleration_limit: float = math.inf  # [1/s^2]
    softening: float = 0.0  # loss of stiffness per unit of lag squared
    friction: float = 0.0  # dry friction, share of full opening
    silting: float = 0.0  # its growth after rest, as a factor
    travel_open: float = 1.0
    travel_close: float = 1.0


class Valve(NamedTuple):
    """Flow through the four edges."""

    coefficient: Array  # discharge coefficient times expansion factor: path, row, pressure ratio
    rows: Array  # commands of the rows [V]
    area_s_a: float = 0.870e-6  # [m^2]
    area_s_b: float = 0.870e-6
    area_b_e: float = 0.810e-6
    area_a_e: float = 0.795e-6
    gain_charge: float = 0.0  # relative area error at a fifth of full opening, supply edges
    gain_exhaust: float = 0.0  # the same, exhaust edges
    overlap: float = 0.0  # share of full opening
    overlap_rounding: float = 0.25  # corner radius over overlap
    clearance: float = 0.0  # null leakage of each edge, share of full opening
    clearance_reach: float = 0.03  # opening at which it has halved
    clearance_laminar: float = 0.0  # share of it that is laminar, 0 to 1
    critical_ratio: float = 0.528
    subsonic_index: float = 0.5
    laminar_pressure: float = 0.0  # pressure drop below which flow turns laminar [Pa]
    laminar_series: float = 0.0  # 1 where viscous and kinetic losses add up at every drop
    attached_gain: float = 0.0  # relative rise of the coefficient of an attached jet
    attach_ratio: float = 0.45
    detach_ratio: float = 0.65
    icing: float = 0.0  # relative loss of exhaust area per kilogram exhausted [1/kg]
    warm_supply: float = 0.0  # supply gas above room temperature [K]


class Network(NamedTuple):
    """Supply, exhaust and hoses."""

    supply_pressure: float = 6.5e5  # [Pa]
    ambient_pressure: float = 1.013e5  # [Pa]
    temperature: float = 293.0  # [K]
    gas_constant: float = 287.0  # [J/(kg K)]
    reservoir: float = 0.0  # volume at the valve's supply port [m^3]; 0: none
    feed: float = 0.0  # conductance from the main [kg/(s Pa^0.5)]
    check_leak: float = 0.0  # leak back through the check valve [kg/(s Pa)]
    drift: float = 0.0  # of the main [Pa/s]
    wander: float = 0.0  # slow swing of the main [Pa]
    ripple: float = 0.0  # [Pa]
    ripple_frequency: float = 1.0  # [Hz]
    silencer: float = 0.0  # conductance of the silencer [kg/(s Pa^0.5)]; 0: none
    silencer_volume: float = 3e-5  # [m^3]
    hose_length: float = 0.0  # [m]; 0: no hoses
    hose_bore: float = 2e-3  # [m]
    hose_drag: float = 1.0  # factor on the friction of a smooth hose
    hose_stretch: float = 0.0  # relative growth of hose volume per pressure [1/Pa]
    hose_volume: float = 1.2e-6  # volume that stretches [m^3]


class Chambers(NamedTuple):
    """Gas in the two chambers, and where it escapes."""

    polytropic: float = 1.4  # index of the gas
    dead_volume_a: float = 1.7e-6  # [m^3]
    dead_volume_b: float = 1.7e-6
    area_a: float = 490.87e-6  # [m^2]
    area_b: float = 412.33e-6
    stroke: float = 0.030  # [m]
    energy_balance: float = 0.0  # 1: mass and energy with a wall; 0: the rig's index
    wall_transfer: float = 50.0  # [W/(m^2 K)]
    wall_exponent: float = 0.0  # growth of the transfer with density
    wall_capacity: float = math.inf  # [J/K]
    wall_cooling: float = 0.1  # wall to room [W/K]
    bore: float = 0.025  # [m]
    port_length: float = 0.0  # covered port: distance from the end [m]
    port_rest: float = 0.3  # share of area left at the very end
    leak_a: float = 0.0  # conductance as an orifice's area [m^2]
    leak_b: float = 0.0
    leak_cross: float = 0.0
    leak_laminar: float = 0.5  # share of the pressure loss that is laminar at the reference flow
    leak_return: float = 1.0  # cross leak the other way over this one
    leak_power: float = 0.0  # exponent over gauge pressure; 0: mixed law
    leak_place: float = 0.0  # worn zone: relative rise at its middle
    leak_place_at: float = 0.012  # [m]
    leak_place_width: float = 0.003  # [m]
    leak_speed: float = 0.0  # relative rise per speed [s/m]


class Friction(NamedTuple):
    """Seals and drag of the piston."""

    viscous: float = 102.53  # [N s/m]
    coulomb: float = 1.013  # [N]
    slip_short: float = 1e-7  # deflection at which the first element slips [m]
    slip_long: float = 2e-7  # ... and the last
    asymmetry: float = 0.0  # Coulomb friction, half of extending less retracting [N]
    viscous_asymmetry: float = 0.0  # [N s/m]
    static_rise: float = 0.0  # at rest over sliding [N]
    static_speed: float = 0.01  # [m/s]
    static_shape: float = 2.0  # exponent of the fall
    dwell_rise: float = 0.0  # [N] per natural logarithm of contact age
    dwell_length: float = 2e-5  # [m]
    lag: float = 0.0  # film relaxation [s]
    film: float = 0.0  # drag that follows the film [N s/m]
    pressure_sum: float = 0.0  # [N/Pa^power]
    pressure_power: float = 1.0
    pressure_lips: float = 0.0  # each lip by its own gauge pressure [N/Pa]
    bump: float = 0.0  # rise of Coulomb friction at a place [N]
    bump_at: float = 0.012  # [m]
    bump_width: float = 0.004  # [m]
    waviness: float = 0.0  # evenly spaced tight spots, their height [N]
    wave_number: float = 2.0 * math.pi / 0.012  # [rad/m]
    drag: float = 0.0  # [N (s/m)^power]
    drag_power: float = 2.0
    wear: float = 0.0  # relative fall of friction and drag by running in
    wear_time: float = 4.0  # [s]
    side_load: float = 0.0  # friction per tilt of a lever [N/m]


class Load(NamedTuple):
    """What hangs on the rod, and the frame."""

    mass: float = 1.825  # [kg]
    gravity: float = 9.81  # [m/s^2]
    mass_rate: float = 0.0  # [kg/s]
    spring: float = 0.0  # [N/m]
    spring_at: float = 0.015  # [m]
    spring_cubic: float = 0.0  # relative hardening per squared deflection [1/m^2]
    mode_mass: float = 0.0  # [kg]
    mode_frequency: float = 2.0 * math.pi * 20.0  # [rad/s]
    mode_damping: float = 0.02
    joint_stiffness: float = 0.0  # [N/m]; 0: rigid
    joint_damping: float = 40.0  # [N s/m]
    joint_gap: float = 0.0  # [m]
    rod_mass: float = 0.35  # [kg]
    frame_mass: float = 0.0  # [kg]; 0: rigid frame
    frame_frequency: float = 2.0 * math.pi * 25.0  # [rad/s]
    frame_damping: float = 0.05
    frame_gap: float = 0.0  # loose mount [m]
    push: float = 0.0  # external force, size [N]
    stop_stiffness: float = 1e8  # [N/m]
    stop_damping: float = 2.5e4  # [N s/m]


class Sensors(NamedTuple):
    """Transducers before noise and conversion."""

    position_gain: float = 1.0
    position_offset: float = 0.0  # [m]
    position_bow: float = 0.0  # largest error of a bowed curve [m]
    position_load: float = 0.0  # largest error of a loaded potentiometer [m]
    position_lag: float = 0.0  # [s]
    position_lag_order: float = 1.0
    position_slack: float = 0.0  # half width of the wiper's slack [m]
    reference_drift: float = 0.0  # relative growth of the reading [1/s]
    pressure_offset_a: float = 0.0  # [Pa]
    pressure_offset_b: float = 0.0
    pressure_gain_a: float = 1.0
    pressure_gain_b: float = 1.0
    pressure_lag: float = 0.0  # [s]
    dynamic_pressure: float = 0.0  # share of it that is missed
    pipe_bore: float = 2e-3  # [m]
    folded: float = 0.0  # amplitude of a disturbance near the sampling rate, pressure a [Pa]
    folded_frequency: float = 1001.7  # [Hz]
    shift_by_command: float = 0.0  # of pressure b's ground, by the valve's amplifier [Pa/V]
    shift_by_coil: float = 0.0  # of both, by what holds the spool off its middle [Pa]


class Truth(NamedTuple):
    """The whole servo."""

    valve: Valve
    spool: Spool = Spool()
    network: Network = Network()
    chambers: Chambers = Chambers()
    friction: Friction = Friction()
    load: Load = Load()
    sensors: Sensors = Sensors()
