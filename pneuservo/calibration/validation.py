"""A model of the valve against charging and discharging curves (thesis, section 4.3.1.1)."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from pneuservo.arrays import Array
from pneuservo.calibration.experiment import CONDITIONS, simulate_transient
from pneuservo.calibration.transient import Transient, transient_of
from pneuservo.plant.flow_paths import FLOW_PATHS
from pneuservo.rigs import Rig, load_rig
from pneuservo.simulation import simulate_dead_volume

UNCALIBRATED_VALVE = "ddv-27a1-uncalibrated"
# Openings of 100, 20 and 4 %.
_COMMANDS = (5.0, 1.0, 0.2)
# The maker's area was found up to 8 % off (section 4.3.1).
_OTHER_AREA = 1.08
# Ten kelvin and the pressure of a good day: what two days of one month may differ by.
_OTHER_TEMPERATURE, _OTHER_AMBIENT = 10.0, 2.0e3
_STEPS_PER_SAMPLE = 4


@dataclass(frozen=True)
class Comparison:
    """A measured transient beside its simulation.

    Parameters
    ----------
    path : str
        Flow path.
    command : float
        Magnitude [V].
    time : (n,) array
        [s].
    measured, simulated : (n,) array
        Absolute pressure [Pa].
    """

    path: str
    command: float
    time: Array
    measured: Array
    simulated: Array

    @property
    def largest(self) -> float:
        """Return the largest difference [Pa]."""
        return float(np.max(np.abs(self.measured - self.simulated)))


def experiment_rig() -> Rig:
    """Return the dead-volume rig in the conditions of the experiment."""
    return load_rig("dead-volume").with_conditions(dict(CONDITIONS))


def compare(transient: Transient, rig: Rig) -> Comparison:
    """Simulate a transient with another rig, from its first pressure.

    Parameters
    ----------
    transient : Transient
        What was measured.
    rig : Rig
        The model, of kind ``dead-volume``.
    """
    time = transient.time
    run = simulate_dead_volume(
        rig,
        time=time,
        command=transient.opening * rig["valve.full_voltage"],
        port="a" if transient.path in ("s_a", "a_e") else "b",
        initial_pressure=float(transient.pressure[0]),
        largest_step=float(time[1] - time[0]) / _STEPS_PER_SAMPLE,
    )
    return Comparison(
        transient.path,
        transient.command,
        time,
        transient.pressure,
        run["dead_volume_pressure"],
    )


def comparisons(
    measured_rig: Rig,
    model: Rig,
    paths: Sequence[str] = FLOW_PATHS,
    commands: Sequence[float] = _COMMANDS,
    noise_rms: float = 0.0,
) -> list[Comparison]:
    """Simulate an experiment with one rig and compare it with a model.

    Parameters
    ----------
    measured_rig : Rig
        What stands in for the measurement.
    model : Rig
        What it is compared with.
    paths : sequence of str, optional
        Flow paths.
    commands : sequence of float, optional
        Magnitudes [V].
    noise_rms : float, optional
        Of the pressure transducer [Pa].

    Returns
    -------
    list of Comparison
        By path and then command.

    Examples
    --------
    >>> rig = experiment_rig()
    >>> same = comparisons(rig, rig, ["s_a"], [5.0])
    >>> round(same[0].largest * 1e-5, 3)
    0.0
    """
    return [
        compare(
            transient_of(
                simulate_transient(path, command, rig=measured_rig, noise_rms=noise_rms),
                measured_rig,
            ),
            model,
        )
        for path in paths
        for command in commands
    ]


def uncalibrated(rig: Rig) -> Rig:
    """Return a rig with the nominal coefficient of 0.8, as figure 4.10 simulates it.

    Parameters
    ----------
    rig : Rig
        With the calibrated valve.
    """
    return replace(rig, valve=UNCALIBRATED_VALVE)


def other_valve(rig: Rig) -> Rig:
    """Return a rig with another valve of the same make: areas 8 % larger, as figure 4.12.

    Parameters
    ----------
    rig : Rig
        With the valve that was calibrated.
    """
    areas = {
        name: _OTHER_AREA * rig[name] for name in rig.parameters if name.startswith("valve.flow.")
    }
    return rig.with_values(areas)


def other_day(rig: Rig) -> Rig:
    """Return a rig on a warmer day of higher air pressure, as figure 4.13.

    Parameters
    ----------
    rig : Rig
        On the day of the calibration.
    """
    return rig.with_values(
        {
            "temperature": rig["temperature"] + _OTHER_TEMPERATURE,
            "ambient.pressure": rig["ambient.pressure"] + _OTHER_AMBIENT,
        }
    )
