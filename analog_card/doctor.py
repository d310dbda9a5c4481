"""Finding out whether the simulator works on this computer."""

import math
import platform
from dataclasses import dataclass
from importlib.metadata import version

import netlists
from analog_card.library import ngspice_library
from analog_card.ngspice import FrequencySweep, ngspice_version, run


@dataclass(frozen=True)
class Examination:
    """What was found.

    Attributes
    ----------
    python, pyspice, ngspice, library : str
        Versions, and where the ngspice library loads from.
    gain : float
        Simulated gain of an RC low pass at its corner frequency [V/V].
    """

    python: str
    pyspice: str
    ngspice: str
    library: str
    gain: float

    @property
    def works(self) -> bool:
        """Whether the RC circuit gave 1/sqrt(2), to the six digits its parts are known to."""
        return math.isclose(self.gain, math.sqrt(0.5), rel_tol=1e-6)


def examine() -> Examination:
    """Look up the versions and run one RC circuit.

    Returns
    -------
    Examination
        What was found.

    Raises
    ------
    SimulationError
        When ngspice does not start or fails.

    Examples
    --------
    >>> examine().works
    True
    """
    sweep = run(netlists.RC_LOW_PASS, FrequencySweep(1e3, 1e4, 1))
    return Examination(
        python=platform.python_version(),
        pyspice=version("PySpice"),
        ngspice=str(ngspice_version()),
        library=ngspice_library(),
        gain=float(abs(sweep["out"][0])),
    )
