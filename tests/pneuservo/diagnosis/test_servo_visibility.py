"""What a recording of the servo could hide is said with the size from which it would show."""

import dataclasses
import re

from servo_recordings import recorded

from pneuservo.controllers import Proportional
from pneuservo.diagnosis import diagnose, document
from pneuservo.rigs import load_rig

LEAK = "leakage.rod-seal"


def leaking(area):
    """Return a recording of a servo whose rod seal leaks."""
    rig = load_rig("single-axis")
    effects = {LEAK: {"area": area, "laminar": 0.0}} if area else {}
    return recorded(dataclasses.replace(rig, effects=effects), Proportional(), 6, duration=2.0)


def test_the_size_below_which_a_leak_would_not_show_is_where_it_begins_to():
    sound = document(diagnose([leaking(0.0)]))
    assert sound["verdict"] == "consistent"
    (entry,) = (entry for entry in sound["not_visible"] if entry["effect"] == LEAK)
    limit = float(re.fullmatch(r"shows only from (\S+) m\^2 on \(area\)", entry["why"])[1])
    below = document(diagnose([leaking(0.4 * limit)]))
    assert below["verdict"] == "consistent"
    above = document(diagnose([leaking(2.5 * limit)]))
    assert above["verdict"] == "missing-physics"
    assert LEAK in above["missing"][0]["class"]
