"""What a case is to hold, and what it turned out to hold."""

from dataclasses import asdict, dataclass, field
from typing import Any


@dataclass(frozen=True)
class Wish:
    """What a case is to hold.

    Parameters
    ----------
    effects : tuple of str
        Ids of one effect or of two; ``("none",)`` for none.
    visibility : str
        ``visible``, ``faint`` or ``hidden``.
    form : int, optional
        Which of the truth's forms; counted modulo their number.
    retune : bool, optional
        Whether the baseline is re-tuned to swallow the effect.
    missing : tuple of str, optional
        Channels that are not recorded.
    louder : float, optional
        Factor on the noise, after the size has been chosen.
    stratum : str, optional
        Which part of the mix the case belongs to.
    """

    effects: tuple[str, ...]
    visibility: str = "visible"
    form: int = 0
    retune: bool = False
    missing: tuple[str, ...] = ()
    louder: float = 1.0
    stratum: str = "single"


@dataclass(frozen=True)
class Key:
    """What a case conceals; the diagnosis never sees it.

    Parameters
    ----------
    effects : tuple of str
        Ids; ``("none",)`` for none.
    kinds : tuple of str
        Physics, sensor, parameter, outside or none, effect by effect.
    blocks : tuple of tuple of str
        Blocks that are a right answer, effect by effect.
    forms, sizes, units
        Which of the truth's forms, and how large, effect by effect.
    shared : bool
        Whether a form may be a formula of the catalogue too.
    distances : tuple of float
        Visibility of each effect [-].
    visibility : str
        Class of the least visible one.
    follow_up : tuple of float
        Visibility of each in the experiments that follow a hidden effect; 0 without any [-].
    stratum, retuned, missing, experiments, noise
        How the case was made.
    parameters : dict
        True values of the rig's parameters, SI.
    """

    effects: tuple[str, ...]
    kinds: tuple[str, ...]
    blocks: tuple[tuple[str, ...], ...]
    forms: tuple[str, ...]
    sizes: tuple[float, ...]
    units: tuple[str, ...]
    shared: bool
    distances: tuple[float, ...]
    follow_up: tuple[float, ...]
    visibility: str
    stratum: str
    retuned: bool
    missing: tuple[str, ...]
    experiments: dict[str, str]
    noise: dict[str, float]
    parameters: dict[str, float] = field(default_factory=dict)

    def document(self) -> dict[str, Any]:
        """Return the key as JSON takes it."""
        return asdict(self)
