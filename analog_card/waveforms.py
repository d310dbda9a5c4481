"""What a simulation gave: values by node, and noise integrated over a band."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from analog_card.errors import InputError
from analog_card.netlist_text import nearest


@dataclass(frozen=True)
class Waveforms:
    """What one analysis gave.

    Attributes
    ----------
    netlist : Path
        Where the circuit came from.
    vectors : dict of str to ndarray
        Node voltages by node name, branch currents as ``source#branch``, and the axis as
        ``time`` [s] or ``frequency`` [Hz]; complex for a frequency sweep. Names are lower case.
    warnings : tuple of str
        What ngspice remarked without failing.
    axis : str or None
        Name of what the values run over; None for an operating point.
    """

    netlist: Path
    vectors: dict[str, np.ndarray]
    warnings: tuple[str, ...] = ()
    axis: str | None = None

    def __getitem__(self, node: str) -> np.ndarray:
        """Return the values at a node."""
        try:
            return self.vectors[node.lower()]
        except KeyError:
            raise InputError(
                f"{self.netlist}: no node {node!r}{nearest(node.lower(), self.vectors)}"
            ) from None

    @property
    def time(self) -> np.ndarray:
        """The time points the solver chose [s]."""
        return self["time"]

    @property
    def frequency(self) -> np.ndarray:
        """The frequencies [Hz]."""
        return self["frequency"].real

    def at(self, times: np.ndarray, node: str) -> np.ndarray:
        """Return the values at a node at given times.

        The solver's own points differ from run to run; waveforms are only comparable on a
        common grid.

        Parameters
        ----------
        times : ndarray, shape (n,)
            Increasing times within the run [s].
        node : str
            Node name.

        Returns
        -------
        ndarray, shape (n,)
            Values interpolated between the solver's points.
        """
        return np.interp(times, self.time, self[node])

    @property
    def sweep(self) -> np.ndarray:
        """The values of the swept source [V] or [A]."""
        return self[self.axis if self.axis in ("v-sweep", "i-sweep") else "sweep"]

    @property
    def noise_density(self) -> np.ndarray:
        """Noise density at the node asked for [V/sqrt(Hz)]."""
        return self["onoise_spectrum"].real


def noise_voltage(
    frequency: np.ndarray,
    density: np.ndarray,
    start: float | None = None,
    stop: float | None = None,
) -> float:
    """Integrate a noise density over a band.

    Parameters
    ----------
    frequency : ndarray, shape (n,)
        Increasing frequencies [Hz].
    density : ndarray, shape (n,)
        Noise density, greater than 0 [V/sqrt(Hz)].
    start, stop : float, optional
        Ends of the band; without them the first and last frequency [Hz].

    Returns
    -------
    float
        Root-mean-square voltage [V].

    Raises
    ------
    InputError
        When the band is not within the frequencies.

    Notes
    -----
    Between the points the squared density is taken as a power of the frequency, which is exact
    for white and for flicker noise.

    Examples
    --------
    >>> frequency = np.geomspace(1.0, 1e4, 5)
    >>> round(noise_voltage(frequency, np.full(5, 1e-6), 1.0, 101.0), 9)  # 1 uV sqrt(100)
    1e-05
    """
    low, high = frequency[0] if start is None else start, frequency[-1] if stop is None else stop
    if not frequency[0] * (1 - 1e-9) <= low < high <= frequency[-1] * (1 + 1e-9):
        raise InputError(
            f"band from {low:g} to {high:g} Hz; within {frequency[0]:g} to {frequency[-1]:g} Hz "
            "is needed, the frequencies of the noise analysis"
        )
    inside = frequency[(frequency > low) & (frequency < high)]
    f = np.concatenate([[low], inside, [high]])
    power = np.exp(2 * np.interp(np.log(f), np.log(frequency), np.log(density)))
    steps = np.diff(np.log(f))
    exponent = np.diff(np.log(power * f))
    # The integral of p (f/f1)^(exponent/step - 1) over a step, in a form that holds at 0 too.
    level = np.abs(exponent) < 1e-9
    growth = np.where(level, 1.0, np.expm1(exponent) / np.where(level, 1.0, exponent))
    return float(np.sqrt(np.sum(power[:-1] * f[:-1] * steps * growth)))
