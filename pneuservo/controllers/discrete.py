"""Discrete sliding mode: the switching function is brought down sample by sample, by a model."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from analog_card.linear_servo import LinearServo
from pneuservo.controllers.digital import DifferencedStates, SampledSlidingMode
from pneuservo.controllers.requirements import require
from pneuservo.controllers.sampled import Reading, Voltage
from pneuservo.plant.control_law import limited
from pneuservo.rigs import Rig


@dataclass(frozen=True)
class DiscreteSlidingMode(SampledSlidingMode):
    """Sliding mode designed in discrete time on a linear model of the servo.

    Parameters
    ----------
    accelerometer : bool, optional
        Whether the acceleration is measured; by differences otherwise.
    reaching_share : float, optional
        Share of the switching function that is taken away in each sample, above 0 and below 2 [-].
    switching_share : float, optional
        What the switching adds, as a share of the level [-].
    servo : LinearServo or None, optional
        The model, without its valve; by default that of the rig at mid-stroke, extending.

    Notes
    -----
    Section 6.13.2 of the thesis, the law of Gao, Wang and Homaifa (1995): the voltage that takes
    the model from sigma(k) to (1 - share) sigma(k), which satisfies (6.59) and (6.60), and a
    switching part, whose sign goes over into a line within the boundary layer. The model has no
    valve, which is what limits the share in practice.
    """

    kind: ClassVar[str] = "discrete-sliding-mode"
    accelerometer: bool = True
    reaching_share: float = 0.2
    switching_share: float = 0.1
    servo: LinearServo | None = None

    def __post_init__(self) -> None:
        """Refuse values that make no controller."""
        super().__post_init__()
        require(self.kind, "reaching_share", self.reaching_share, above=0.0)
        require(self.kind, "2 less reaching_share", 2.0 - self.reaching_share, above=0.0)
        require(self.kind, "switching_share", self.switching_share, at_least=0.0)

    @property
    def inputs(self) -> tuple[str, ...]:  # type: ignore[override]
        """Return what is converted."""
        return ("displacement", "acceleration") if self.accelerometer else ("displacement",)

    def start(self, rig: Rig) -> Voltage:
        """Return what gives the voltage for each reading."""
        states = DifferencedStates(self.sampling_time)
        feedback, reaching = self._gains(self.servo or _at_mid_stroke(rig))

        def voltage(reading: Reading) -> float:
            state = states(reading)
            sigma = self.switching_function(state)
            kept = -sum(k * x for k, x in zip(feedback, state, strict=True))
            switching = self.switching_share * self.switched(sigma)
            return float(limited(kept + reaching * sigma + switching, self.level))

        return voltage

    def _gains(self, servo: LinearServo) -> tuple[tuple[float, ...], float]:
        """Return gains that keep sigma where it is, and the voltage for each unit of it."""
        # Imported when needed: it takes longer than a run.
        from scipy.signal import cont2discrete

        from pneuservo.linear.models import state_matrices, without_valve

        a, b = state_matrices(without_valve(servo))
        transition, effect, *_ = cont2discrete((a, b, np.eye(3), None), self.sampling_time)
        weights = np.array(self.weights)
        per_volt = float((weights @ effect)[0])
        keep = weights @ (transition - np.eye(3)) / per_volt
        return tuple(float(k) for k in keep), self.reaching_share / per_volt


def _at_mid_stroke(rig: Rig) -> LinearServo:
    from pneuservo.linear import advanced_servo, servo_data

    data = servo_data(rig)
    return advanced_servo(data, 0.5 * data.stroke, extending=True)
