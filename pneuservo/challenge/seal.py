"""Keys that are promised before and opened after: salted hash commitments."""

import hashlib
import json
import secrets
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from analog_card.files import write_whole
from pneuservo.errors import InputError


def commitment(salt: str, text: str) -> str:
    """Return what is published of a key: the SHA-256 of its salt and its text.

    Examples
    --------
    >>> commitment("salt", "key")[:8]
    '4196e2e8'
    """
    return hashlib.sha256(f"{salt}\n{text}".encode()).hexdigest()


def seal(key: Mapping[str, Any], path: Path) -> str:
    """Write a key with a salt of its own and return its commitment.

    Parameters
    ----------
    key : mapping
        What the case conceals, as JSON takes it.
    path : Path
        Where to, outside every folder that a diagnosis is given.

    Returns
    -------
    str
        To be published beside the cases.
    """
    salt = secrets.token_hex(16)
    text = _text(key)
    write_whole(path, json.dumps({"salt": salt, "key": json.loads(text)}, indent=2) + "\n")
    return commitment(salt, text)


def sealed_commitment(path: Path) -> str:
    """Return the commitment of a key that was sealed earlier."""
    sealed = _read(path)
    return commitment(sealed["salt"], _text(sealed["key"]))


def unseal(path: Path, published: str) -> dict[str, Any]:
    """Return a key, checked against what was published of it.

    Parameters
    ----------
    path : Path
        From `seal`.
    published : str
        Its commitment.

    Returns
    -------
    dict
        What the case conceals.

    Raises
    ------
    InputError
        When the key is not the one that was promised.
    """
    sealed = _read(path)
    if commitment(sealed["salt"], _text(sealed["key"])) != published:
        raise InputError(
            f"{path}: this key is not the one whose hash was published before the diagnosis; "
            "make the case again in a new folder"
        )
    key: dict[str, Any] = sealed["key"]
    return key


def _text(key: Mapping[str, Any]) -> str:
    return json.dumps(key, sort_keys=True)


def _read(path: Path) -> dict[str, Any]:
    try:
        sealed = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError) as problem:
        raise InputError(f"{path}: the sealed key cannot be read: {problem}") from problem
    if not isinstance(sealed, dict) or not {"salt", "key"} <= set(sealed):
        raise InputError(f"{path}: is not a sealed key; it has to hold salt and key")
    return sealed
