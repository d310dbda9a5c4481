"""The identification experiment, simulated: proportional control following a sine sweep."""

from collections.abc import Sequence

import numpy as np

from pneuservo.arrays import Array
from pneuservo.controllers import Proportional
from pneuservo.recordings import Recording
from pneuservo.rigs import Rig, load_rig
from pneuservo.simulation import simulate

# Section 4.3.2.1 of the thesis.
SAMPLING_FREQUENCY = 500.0
SWEEP_FREQUENCIES = (0.5, 20.0)
SWEEP_DURATION = 60.0
CENTRES = (0.012, 0.015, 0.018)
# 0.3 % of the largest reading: 0.09 mm over the stroke of 30 mm.
NOISE_SHARE = 0.003
CHANNELS = ("displacement", "pressure_a", "pressure_b")


def sine_sweep(
    duration: float = SWEEP_DURATION,
    frequencies: tuple[float, float] = SWEEP_FREQUENCIES,
    centre: float = 0.015,
    amplitude: float = 0.003,
    rate: float = SAMPLING_FREQUENCY,
) -> tuple[Array, Array]:
    """Return a sine whose frequency rises evenly.

    Parameters
    ----------
    duration : float, optional
        [s].
    frequencies : (low, high), optional
        At the start and at the end [Hz].
    centre, amplitude : float, optional
        [m].
    rate : float, optional
        Samples per second [Hz].

    Returns
    -------
    time, demand : (n,) array
        [s], [m].

    Examples
    --------
    >>> time, demand = sine_sweep(duration=1.0)
    >>> len(time), round(float(demand.max()), 4)
    (500, 0.018)
    """
    from scipy.signal import chirp

    time = np.arange(round(duration * rate)) / rate
    phase = chirp(time, frequencies[0], duration, frequencies[1], phi=-90.0)
    return time, centre + amplitude * phase


def simulate_excitation(
    rig: Rig | str = "single-axis",
    *,
    duration: float = SWEEP_DURATION,
    frequencies: tuple[float, float] = SWEEP_FREQUENCIES,
    centre: float = 0.015,
    amplitude: float = 0.003,
    gain: float = 1.0,
    noise_share: float = NOISE_SHARE,
    seed: int | Sequence[int] = 0,
    rate: float = SAMPLING_FREQUENCY,
    held: bool = False,
) -> Recording:
    """Simulate the rig under proportional control following a sine sweep, with noise.

    Parameters
    ----------
    rig : Rig or str, optional
        Of kind ``single-axis``.
    duration, frequencies, centre, amplitude, rate
        As in `sine_sweep`.
    gain : float, optional
        Of the controller [V/V].
    noise_share : float, optional
        Noise of displacement and pressures as a share of the largest reading of each: three
        standard deviations [-].
    seed : int or sequence of int, optional
        Of the noise.
    held : bool, optional
        Whether each sample of the command is held, as by a converter, so that it replays exactly.
        The loop is open then, and the piston drifts over long runs.

    Returns
    -------
    Recording
        Demand, displacement, both pressures and the valve voltage.

    Notes
    -----
    Section 4.3.2.1 of the thesis: "maximum noise level of 0.3 % of the maximum measured signals",
    read as a bound that three standard deviations reach.

    Examples
    --------
    >>> recording = simulate_excitation(duration=1.0)
    >>> len(recording), round(recording.sampling_interval, 6)
    (500, 0.002)
    """
    if not isinstance(rig, Rig):
        rig = load_rig(rig)
    time, demand = sine_sweep(duration, frequencies, centre, amplitude, rate)
    run = simulate(rig, time=time, controller=Proportional(gain), demand=demand)
    if held:
        run = simulate(rig, time=time, command=run["valve_voltage"])
    random = np.random.default_rng(seed)
    channels = {"demand": demand, "valve_voltage": run["valve_voltage"]}
    noise = {}
    for name in CHANNELS:
        noise[name] = noise_share / 3.0 * float(np.max(np.abs(run[name])))
        channels[name] = run[name] + noise[name] * random.standard_normal(len(time))
    recording = run.to_recording(f"sweep-{1e3 * centre:g}-mm")
    return Recording(
        name=recording.name,
        time=time,
        channels=channels,
        rig=recording.rig,
        conditions=recording.conditions,
        noise_rms=noise if noise_share else {},
        title=f"sine sweep about {1e3 * centre:g} mm, simulated",
    )
