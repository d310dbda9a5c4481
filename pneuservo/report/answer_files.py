"""The files of a diagnosis that programs read."""

import json
from typing import Any

import tomli_w

from pneuservo.diagnosis import Diagnosis, repaired_model


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
        ``diagnosis.json``, and ``model.toml``, the repaired rig.
    """
    return {
        "diagnosis.json": json.dumps(answer, indent=2) + "\n",
        "model.toml": tomli_w.dumps(repaired_model(found)),
    }
