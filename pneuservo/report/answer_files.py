"""The files of a diagnosis that programs read."""

import json
from typing import Any

import tomli_w

from pneuservo.diagnosis import Diagnosis, repaired_model
from pneuservo.rigs.rig_file import files_beside

NAMES = ("diagnosis.json", "model.toml")
"""The files of a diagnosis that programs read."""


def answer_files(found: Diagnosis, answer: dict[str, Any]) -> dict[str, str]:
    """Return the files of a diagnosis that programs read, by name.

    Parameters
    ----------
    found : Diagnosis
        What was found.
    answer : dict
        Its document, from `pneuservo.diagnosis.document`.

    Returns
    -------
    dict of str to str
        ``diagnosis.json``, and ``model.toml``, the repaired rig, with its valve file if it has one.
    """
    texts = (json.dumps(answer, indent=2) + "\n", tomli_w.dumps(repaired_model(found)))
    return {**dict(zip(NAMES, texts, strict=True)), **files_beside(found.rig)}
