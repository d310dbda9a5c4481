"""A closed chamber that loses air, made for tests.

Shares no code with the package: the states are the mass and the internal energy of the gas, the
solver is scipy's implicit Radau method, and the laws of the leaks are written out here.
"""

import numpy as np
from scipy.integrate import solve_ivp

from pneuservo.recordings import Recording
from pneuservo.rigs import load_rig, load_valve_tables

RATE = 10.0
AMBIENT, WALL, SUPPLY = 1.013e5, 293.0, 6.5e5
VOLUME = 50e-6
# The package's values for dry air, so that what differs is the method alone.
R, GAMMA = 287.0, 1.4
CV = R / (GAMMA - 1.0)
CP = GAMMA * CV
NOISE = 250.0
# So much heat from the wall that the gas stays within 0.1 K of it [W/K].
GOOD_CONDUCTOR = 50.0


def nozzle(area, upstream, downstream, temperature):
    """Isentropic flow through a hole (Saint-Venant and Wantzel 1839) [kg/s]."""
    critical = (2.0 / (GAMMA + 1.0)) ** (GAMMA / (GAMMA - 1.0))
    ratio = np.clip(downstream / upstream, critical, 1.0)
    speed = np.sqrt(2.0 * CP * temperature * (1.0 - ratio ** ((GAMMA - 1.0) / GAMMA)))
    return area * upstream / (R * temperature) * ratio ** (1.0 / GAMMA) * speed


def hole(area):
    """A leak as through a hole [kg/s]."""
    return lambda pressure, temperature: nozzle(area, pressure, AMBIENT, temperature)


def gap(conductance):
    """A laminar leak: volume flow times density, at the mean of both pressures [kg/s]."""

    def flow(pressure, temperature):
        mean = 0.5 * (pressure + AMBIENT)
        return conductance * 2.0 * mean * (pressure - AMBIENT) * 293.0 / temperature

    return flow


def hole_and_gap(area, conductance):
    """Both side by side [kg/s]."""
    one, other = hole(area), gap(conductance)
    return lambda pressure, temperature: one(pressure, temperature) + other(pressure, temperature)


def pores(at_one_bar, exponent):
    """Pores that open under pressure [kg/s]."""
    return lambda pressure, temperature: (
        at_one_bar * (max(pressure - AMBIENT, 0.0) / 1e5) ** exponent
    )


def pressure_history(
    leak=None, duration=60.0, gauge=7e5, released=0.0, excess=0.0, wall_conductance=GOOD_CONDUCTOR
):
    """Absolute pressure of a chamber left alone, at every sample [Pa].

    `leak` is a function of pressure and temperature [kg/s], `released` when the fill line is shut
    [s], `excess` the gas temperature above the wall's at that moment [K], `wall_conductance` the
    heat flow per temperature difference [W/K].
    """
    time = np.arange(round(duration * RATE) + 1) / RATE
    start = AMBIENT + gauge
    mass = start * VOLUME / (R * (WALL + excess))

    def balance(_, state):
        mass, energy = state
        temperature = energy / (mass * CV)
        out = leak(mass * R * temperature / VOLUME, temperature) if leak else 0.0
        return [-out, wall_conductance * (WALL - temperature) - out * CP * temperature]

    alone = time[time > released]
    solution = solve_ivp(
        balance,
        (released, time[-1]),
        [mass, mass * CV * (WALL + excess)],
        method="Radau",
        t_eval=alone,
        rtol=1e-8,
        atol=1e-14,
    )
    held = np.full(len(time) - len(alone), start)
    return np.concatenate([held, (GAMMA - 1.0) * solution.y[1] / VOLUME])


def recording(pressure, seed, noise=None):
    """A recording of a chamber that is isothermal as far as the rig file knows."""
    time = np.arange(len(pressure)) / RATE
    if noise is None:
        noise = NOISE * np.random.default_rng(seed).standard_normal(len(pressure))
    # A slow process is isothermal: stated, because leak, volume and index come as one product.
    conditions = {
        "ambient_pressure": AMBIENT,
        "temperature": WALL,
        "dead_volume_polytropic_index": 1.0,
    }
    channels = {"dead_volume_pressure": pressure + noise}
    return Recording(f"volume-{seed}", time, channels, "dead-volume", conditions=conditions)


def filled_and_shut(seed, leak=None, volume=VOLUME, supply=SUPPLY, noise=500.0):
    """A chamber filled through the valve at 0.5 V for 1.5 s, then shut off; 200 Hz."""
    time = np.arange(900) / 200.0
    voltage = np.where(time < 1.5, 0.5, 0.0)
    table = load_valve_tables("ddv-27a1")["s_a"]
    coefficients = [
        np.interp(0.5, table.command, column) for column in table.discharge_coefficient.T
    ]
    ratios = [np.interp(0.5, table.command, column) for column in table.pressure_ratio.T]
    area = load_rig("dead-volume")["valve.flow.area_s_a"] * 0.1

    def rate(moment, state, opened):
        pressure = state[0]
        into = 0.0
        if opened:
            coefficient = np.interp(pressure / supply, ratios, coefficients)
            into = coefficient * nozzle(area, supply, pressure, WALL)
        out = leak(pressure, WALL) if leak else 0.0
        return [1.4 * R * WALL / volume * (into - out)]

    pressure = [AMBIENT]
    for opened in (True, False):
        part = time[(time <= 1.5) if opened else (time >= 1.5)]
        span, start = (part[0], part[-1]), [pressure[-1]]
        solution = solve_ivp(
            rate, span, start, "RK45", part[1:], args=(opened,), rtol=1e-8, atol=1e-3
        )
        pressure.extend(solution.y[0])
    channels = {
        "dead_volume_pressure": pressure
        + noise * np.random.default_rng(seed).standard_normal(len(time)),
        "valve_voltage": voltage,
    }
    return Recording(f"filled-{seed}", time, channels, "dead-volume")
