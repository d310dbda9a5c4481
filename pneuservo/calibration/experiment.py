"""The dead-volume experiment, simulated: one path, one held command, a noisy transducer."""

from collections.abc import Mapping, Sequence

import numpy as np

from pneuservo.errors import InputError
from pneuservo.plant.flow_paths import FLOW_PATHS
from pneuservo.recordings import Recording
from pneuservo.rigs import Rig, load_rig
from pneuservo.simulation import simulate_dead_volume

# At 7.7 bar, the top of the supply range of section 3.1, the first break points of the tables,
# 0.13 and above, are within reach of a discharge to atmosphere. A volume of 120 cm^3 gives the
# charging times that section 4.3.1 states: below 1 s at full and about 3 min at 2 % opening.
CONDITIONS: Mapping[str, float] = {"supply_pressure": 7.7e5, "dead_volume_volume": 120e-6}
COMMANDS: tuple[float, ...] = (0.1, 0.2, 0.4, 0.6, 0.8, 1.0, 2.0, 3.0, 4.0, 5.0)
_BUILT_IN = "dead-volume"
_SAMPLES = 3000
_STEPS_PER_SAMPLE = 16
_SETTLED = 5e-3
_LONGEST = 400.0


def simulate_transient(
    path: str,
    command: float,
    *,
    rig: Rig | str = _BUILT_IN,
    noise_rms: float = 300.0,
    seed: int | Sequence[int] = 0,
    samples: int = _SAMPLES,
) -> Recording:
    """Simulate one charge or discharge of a dead volume at a held command.

    Parameters
    ----------
    path : str
        Flow path: ``s_a``, ``b_e``, ``s_b`` or ``a_e``.
    command : float
        Magnitude of the command [V].
    rig : Rig or str, optional
        Of kind ``dead-volume``, or its name or file; the built-in one by its name is given the
        conditions of the experiment, `CONDITIONS`.
    noise_rms : float, optional
        Of the pressure transducer [Pa].
    seed : int or sequence of int, optional
        Of the noise.
    samples : int, optional
        Over the whole transient, which lasts until the pressure hardly moves any more.

    Returns
    -------
    Recording
        ``valve_voltage`` and ``dead_volume_pressure``.

    Raises
    ------
    InputError
        When there is no such path.

    Notes
    -----
    Section 4.3.1 of the thesis. Charging starts at ambient, discharging at supply pressure.

    Examples
    --------
    >>> recording = simulate_transient("s_a", 5.0, noise_rms=0.0)
    >>> bool(recording.time[-1] < 2.0), round(float(recording["dead_volume_pressure"][-1]), -3)
    (True, 770000.0)
    """
    if path not in FLOW_PATHS:
        raise InputError(f"flow path {path!r} is not known; there are: {', '.join(FLOW_PATHS)}")
    conditions: dict[str, float] = {}
    if not isinstance(rig, Rig):
        # A rig of one's own has its own supply and volume.
        conditions = dict(CONDITIONS) if rig == _BUILT_IN else {}
        rig = load_rig(rig).with_conditions(conditions)
    voltage = command if path in ("s_a", "b_e") else -command
    port = "a" if path in ("s_a", "a_e") else "b"
    start = rig["ambient.pressure"] if path.startswith("s_") else rig["supply.pressure"]
    # A first guess, doubled until the pressure has settled.
    duration = 0.5 * rig["valve.full_voltage"] / command
    while True:
        time = np.linspace(0.0, duration, samples)
        run = simulate_dead_volume(
            rig,
            time=time,
            command=voltage,
            port=port,
            initial_pressure=start,
            largest_step=duration / samples / _STEPS_PER_SAMPLE,
        )
        pressure = run["dead_volume_pressure"]
        end = abs(pressure[-1] - pressure[-samples // 4])
        if end < _SETTLED * abs(pressure[-1] - start) or duration >= _LONGEST:
            break
        duration *= 1.5
    noise = noise_rms * np.random.default_rng(seed).standard_normal(samples)
    return Recording(
        name=f"{path}-{command:g}V",
        time=time,
        channels={
            "valve_voltage": np.full(samples, voltage),
            "dead_volume_pressure": pressure + noise,
        },
        rig=rig.name,
        conditions=conditions,
        noise_rms={"dead_volume_pressure": noise_rms} if noise_rms else {},
        title=f"dead volume, path {path}, {command:g} V, simulated",
    )
