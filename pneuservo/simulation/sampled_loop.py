"""A plant with the converters and the controller that samples it, from instant to instant."""

import math

import numpy as np

from pneuservo.arrays import Array
from pneuservo.controllers import AnalogueCard, Reading, SampledController
from pneuservo.errors import InputError
from pneuservo.plant.control_law import OPEN_LOOP
from pneuservo.plant.integrator import initial_modes
from pneuservo.plant.outputs import OUTPUTS
from pneuservo.plant.sampled_hold import TAPS, hold_voltage
from pneuservo.plant.single_axis import COMMAND, DISPLACEMENT, EXTERNAL_FORCE
from pneuservo.rigs import Rig, plant_numbers
from pneuservo.simulation.initial_state import InitialState
from pneuservo.simulation.inputs import Driven
from pneuservo.simulation.readings import EXACT, Seed, within_range
from pneuservo.simulation.soundness import require_sound

# Of the accelerometer [m/s^2], equation (9.2) of the thesis, and of the pressure transducers
# above the ambient pressure [Pa], its table 3.8.
ACCELERATION_RANGE = 322.57
PRESSURE_RANGE = 20.7e5
# Up to which the noise of a transducer before differentiators is stated [Hz]: that of a value held
# for the plant's usual step, 20 us.
NOISE_BANDWIDTH = 25e3
# Steps of the plant to the shortest time constant of the differentiators.
_STEPS_PER_LAG = 2.0
# Streams of the seed, apart from those of the noise that is recorded.
_TRANSDUCERS, _CONVERTERS = 101, 102


class SampledLoop:
    """Plant, differentiators, converters and controller of one run.

    Parameters
    ----------
    controller : SampledController
        What closes the loop.
    rig : Rig
        What is controlled.
    initial : InitialState
        By default at rest at the first demand; the differentiators have settled there.
    driven : Driven
        Its first demand and force.
    step : float
        The plant never takes a longer step [s].
    seed : int or sequence of int
        Of the noise.

    Raises
    ------
    InputError
        When the controller reads what cannot be read.
    """

    def __init__(
        self,
        controller: SampledController,
        rig: Rig,
        initial: InitialState,
        driven: Driven,
        step: float,
        seed: Seed,
    ) -> None:
        """Start at rest, the output of the board at zero."""
        self._controller, self._rig = controller, rig
        self._plant = plant_numbers.single_axis(rig)
        self._grid = plant_numbers.valve_grid(rig.valve)
        demand, force = float(driven.held[0]), float(driven.force[0])
        self._state = initial.state(self._plant, demand, force)
        self._held = np.array([0.0, force])
        self._modes = initial_modes(self._state, self._held, self._plant)
        self._card = OPEN_LOOP
        self._step = step
        if controller.differentiators is not None:
            self._card = AnalogueCard(controller.differentiators).law(rig)
            lags = [self._card.velocity_lag_1, self._card.velocity_lag_2]
            lags += [self._card.acceleration_lag_1, self._card.acceleration_lag_2]
            self._step = min(step, min(lags) / _STEPS_PER_LAG)
        self._taps = np.zeros(TAPS)
        self._taps[0] = self._card.sensitivity * self._state[DISPLACEMENT]
        parts = [seed] if isinstance(seed, int) else list(seed)
        self._transducer_noise = np.random.default_rng([*parts, _TRANSDUCERS])
        self._converter_noise = np.random.default_rng([*parts, _CONVERTERS])
        self._ranges = _ranges(controller, rig)
        self._voltage = controller.start(rig)
        self.demand = demand
        """[m]."""

    def hold(self, voltage: float | None = None, force: float | None = None) -> None:
        """Change the voltage into the valve driver [V] or the external force [N]."""
        if voltage is not None:
            self._held[COMMAND] = voltage
        if force is not None:
            self._held[EXTERNAL_FORCE] = force

    def advance(self, duration: float) -> Array:
        """Return the outputs after a duration, in the order of `OUTPUTS`, the surface unknown.

        Parameters
        ----------
        duration : float
            0 for the outputs now [s].
        """
        steps = max(math.ceil(duration / self._step - 1e-9), 1)
        noise = np.zeros(0)
        if self._controller.differentiators is not None and duration > 0.0:
            noise = self._transducer_noise.standard_normal(steps)
            # Even up to its bandwidth, however short the steps that draw it are.
            held = NOISE_BANDWIDTH * 2.0 * duration / steps
            noise *= self._controller.transducer_noise / math.sqrt(held)
        found = hold_voltage(
            self._state,
            self._modes,
            self._taps,
            noise,
            self._held,
            duration,
            steps,
            self._card,
            OPEN_LOOP,
            self._plant,
            self._grid,
        )
        outputs = np.array(found)
        if self._controller.differentiators is not None:
            outputs[OUTPUTS.index("card_velocity")] = (
                -self._card.velocity_time_constant * self._taps[1]
            )
            outputs[OUTPUTS.index("card_acceleration")] = (
                -self._card.acceleration_time_constant * self._taps[3]
            )
        return outputs

    def decide(self, time: float) -> float:
        """Return the voltage that the board puts out for what the controller reads now [V].

        Parameters
        ----------
        time : float
            [s].

        Raises
        ------
        BrokenRunError
            When the plant's state is not finite, or a pressure not positive.
        InputError
            When the controller gives no finite voltage.
        """
        board = self._controller.board
        outputs = self.advance(0.0)
        # A controller would answer a broken state with a voltage that is not finite either.
        require_sound(np.array([time]), outputs[np.newaxis])
        values = dict(zip(OUTPUTS, outputs, strict=True))
        readings = {}
        for name, (low, high) in self._ranges.items():
            reading = self._transducer(name, float(values[name]))
            if board is not None:
                reading = board.read(reading, low, high, self._converter_noise.standard_normal())
            readings[name] = reading
        voltage = float(self._voltage(Reading(time, self.demand, **readings)))
        if not math.isfinite(voltage):
            raise InputError(
                f"controller {self._controller.kind} gives {voltage:g} V at {time:g} s; it has to "
                "give a finite voltage for every reading"
            )
        return voltage if board is None else board.write(voltage)

    def _transducer(self, name: str, value: float) -> float:
        """Return what the rig's transducer makes of a value."""
        transducer = self._rig.transducers.get(name.partition("_")[0], EXACT)
        if transducer == EXACT:
            return value
        noisy = value + transducer.noise * self._transducer_noise.standard_normal()
        return float(within_range(np.asarray(noisy), transducer))


def _ranges(controller: SampledController, rig: Rig) -> dict[str, tuple[float, float]]:
    """Return lowest and highest value of what a controller reads."""
    taps = 0.5 * rig["sensor.displacement.range"]
    ambient = rig["ambient.pressure"]
    known = {
        "displacement": (0.0, rig["piston.stroke"]),
        "acceleration": (-0.5 * ACCELERATION_RANGE, 0.5 * ACCELERATION_RANGE),
        "pressure_a": (ambient, ambient + PRESSURE_RANGE),
        "pressure_b": (ambient, ambient + PRESSURE_RANGE),
        "card_velocity": (-taps, taps),
        "card_acceleration": (-taps, taps),
    }
    for name in controller.inputs:
        if name not in known:
            raise InputError(
                f"controller {controller.kind} reads {name!r}; it can read: {', '.join(known)}"
            )
        if name.startswith("card_") and controller.differentiators is None:
            raise InputError(
                f"controller {controller.kind} reads {name} but has no differentiators; give it "
                "the figures of a card"
            )
    return {name: known[name] for name in controller.inputs}
