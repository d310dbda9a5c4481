"""The models the diagnosis compares with recordings, one per kind of rig."""

from pneuservo.diagnosis.models.analogue_card import AnalogueCardModel
from pneuservo.diagnosis.models.circuit import CircuitModel
from pneuservo.diagnosis.models.dead_volume import DeadVolumeModel
from pneuservo.diagnosis.models.model import Case, Model, Unknown
from pneuservo.diagnosis.models.seal_tester import SealTesterModel
from pneuservo.diagnosis.models.servo.servo import ServoModel
from pneuservo.errors import InputError

_MODELS: dict[str, type[Model]] = {
    model.kind: model
    for model in (DeadVolumeModel, SealTesterModel, CircuitModel, ServoModel, AnalogueCardModel)
}


def model_of(kind: str, without: frozenset[str] = frozenset()) -> Model:
    """Return the model for a kind of rig.

    Parameters
    ----------
    kind : str
        Kind of rig, such as ``"dead-volume"``.
    without : frozenset of str, optional
        Parts of the diagnosis that are left out, of `pneuservo.diagnosis.PARTS`.

    Returns
    -------
    Model
        The model.

    Raises
    ------
    InputError
        When the diagnosis does not cover this kind of rig.
    """
    if kind not in _MODELS:
        raise InputError(
            f"the diagnosis does not cover rig {kind!r} yet; it covers: {', '.join(_MODELS)}"
        )
    return _MODELS[kind](without)


def required_channels(kind: str) -> tuple[str, ...] | None:
    """Return the channels that a diagnosis of a kind of rig cannot do without.

    Parameters
    ----------
    kind : str
        Kind of rig.

    Returns
    -------
    tuple of str or None
        None when the diagnosis does not cover it.

    Examples
    --------
    >>> required_channels("dead-volume"), required_channels("figure-arm")
    (('dead_volume_pressure',), None)
    """
    return _MODELS[kind].required if kind in _MODELS else None


__all__ = ["AnalogueCardModel", "Case", "Model", "Unknown", "model_of", "required_channels"]
