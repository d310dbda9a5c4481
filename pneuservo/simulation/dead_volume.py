"""Running the closed test volume behind one port of the valve."""

import math

import numpy as np
from numpy.typing import ArrayLike

from pneuservo.errors import InputError
from pneuservo.plant import dead_volume as kernels
from pneuservo.plant.control_law import OPEN_LOOP
from pneuservo.rigs import Rig, plant_numbers
from pneuservo.simulation.inputs import (
    LARGEST_STEP,
    require_kind,
    require_samples,
    require_times,
)
from pneuservo.simulation.readings import EXACT, Seed, draw_noise, within_range
from pneuservo.simulation.result import Simulation
from pneuservo.simulation.run import integration_step
from pneuservo.simulation.soundness import require_finite


def simulate_dead_volume(
    rig: Rig | str = "dead-volume",
    *,
    time: ArrayLike,
    command: ArrayLike,
    port: str = "a",
    initial_pressure: float | None = None,
    largest_step: float = LARGEST_STEP,
    seed: Seed = 0,
) -> Simulation:
    """Simulate a closed test volume behind one port of the valve.

    Parameters
    ----------
    rig : Rig or str, optional
        A rig of kind ``dead-volume``, or its name.
    time : (n,) array
        Times of the result, strictly increasing [s].
    command : (n,) array or float
        Voltage into the valve driver, held until the next time; the spool follows at once [V].
    port : str, optional
        ``"a"`` is charged by a positive command, ``"b"`` by a negative one.
    initial_pressure : float, optional
        Absolute pressure at the first time; the ambient pressure by default [Pa].
    largest_step : float, optional
        The integration never takes a longer step [s].
    seed : int or sequence of int, optional
        Of the pressure transducer's noise, where the rig has any.

    Returns
    -------
    Simulation
        The run: ``dead_volume_pressure``, ``valve_voltage`` and ``spool`` at every time, in SI.

    Raises
    ------
    InputError
        When the rig is not one this can simulate, or an argument cannot be used.

    Examples
    --------
    >>> run = simulate_dead_volume(time=[0.0, 1.0], command=5.0)
    >>> round(run["dead_volume_pressure"][1])
    650000
    """
    rig = require_kind(rig, "dead-volume")
    times = require_times(time)
    voltage = require_samples("command", command, times)
    ports = {"a": kernels.PORT_A, "b": kernels.PORT_B}
    if port not in ports:
        raise InputError(f"port is {port!r}; the valve has the ports 'a' and 'b'")
    plant = plant_numbers.dead_volume(rig)
    start = plant.ambient_pressure if initial_pressure is None else float(initial_pressure)
    if not 0.0 < start < math.inf:
        raise InputError(f"initial pressure is {start:g} Pa; it has to be greater than 0")
    pressure = kernels.run_dead_volume(
        times,
        voltage,
        start,
        ports[port],
        plant,
        plant_numbers.valve_grid(rig.valve),
        integration_step(largest_step, 0.0, OPEN_LOOP),
    )
    require_finite(times, np.isfinite(pressure[:, np.newaxis]).all(axis=1))
    noise = draw_noise(rig, len(times), seed).pressure_a
    pressure = within_range(pressure + noise, rig.transducers.get("pressure", EXACT))
    full = plant.valve.full_voltage
    channels = {
        "valve_voltage": voltage,
        "spool": np.clip(voltage / full, -1.0, 1.0),
        "dead_volume_pressure": pressure,
    }
    return Simulation(rig, times, channels)
