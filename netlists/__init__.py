"""SPICE netlists of the analogue card, as plain files that any ngspice user can open.

``card.cir`` is the whole card, ``stages`` its stages as subcircuits, ``opamp`` the op-amp,
``benches`` one circuit to try each on, ``values.lib`` every value. ``plant.cir`` is the pneumatic
servo that the card controls, ``plant`` its parts and values.
"""

from pathlib import Path

ROOT = Path(__file__).resolve().parent

CARD = ROOT / "card.cir"
PLANT = ROOT / "plant.cir"
BENCHES = ROOT / "benches"
CARD_AC = BENCHES / "card-ac.cir"
CARD_NOISE = BENCHES / "card-noise.cir"
DOUBLE_DIFFERENTIATOR_AC = BENCHES / "double-differentiator-ac.cir"
DOUBLE_DIFFERENTIATOR_TRANSIENT = BENCHES / "double-differentiator-transient.cir"
RC_LOW_PASS = BENCHES / "rc-low-pass.cir"


def shipped() -> dict[str, Path]:
    """Return the circuits that can be run as they are, by name.

    Examples
    --------
    >>> shipped()["rc-low-pass"].name
    'rc-low-pass.cir'
    """
    return {path.stem: path for path in sorted([CARD, PLANT, *BENCHES.glob("*.cir")])}
