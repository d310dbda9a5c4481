"""SPICE netlists of the analogue card, as plain files that any ngspice user can open."""

from pathlib import Path

ROOT = Path(__file__).resolve().parent

DOUBLE_DIFFERENTIATOR_AC = ROOT / "benches" / "double-differentiator-ac.cir"
DOUBLE_DIFFERENTIATOR_TRANSIENT = ROOT / "benches" / "double-differentiator-transient.cir"
RC_LOW_PASS = ROOT / "benches" / "rc-low-pass.cir"
