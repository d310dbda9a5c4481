"""The diagnosis: where a simulation and a recording differ, why, and how much better it gets."""

from pneuservo.diagnosis.diagnosis import PARTS, Diagnosis, diagnose
from pneuservo.diagnosis.document import document, repaired_model

__all__ = ["PARTS", "Diagnosis", "diagnose", "document", "repaired_model"]
