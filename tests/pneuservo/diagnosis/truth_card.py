"""Recordings of the card's taps, made for tests: ngspice on the card's netlists.

One channel on its supply. The transducer moves by three sines, from their tops so that nothing
jumps; they keep every op-amp of a healthy card within its swing. The demand is switched, which
drives the output to both levels.
"""

import tempfile
from functools import cache
from pathlib import Path

import numpy as np

import netlists
from analog_card.behaviour_elements import PLACES
from analog_card.ngspice import Session, Transient
from pneuservo.recordings import Recording

RATE, LEAD_IN, DURATION = 10e3, 0.01, 0.12
NOISE = 2e-3
NODES = ("transducer", "demand", "velocity", "acceleration", "surface", "control")
CHANNELS = (
    "card_sensor",
    "demand",
    "card_velocity",
    "card_acceleration",
    "card_surface",
    "card_output",
)
METRES_PER_VOLT = 3e-3
CIRCUIT = """one channel that a moving transducer and a switched demand drive
.include {root}/opamp/ca3140.lib
.include {root}/values.lib
.include {root}/stages/channel.lib
Xsupply vcc vee supply
Vrest resting 0 5
Vslow slow resting sin(0 2 3 0 0 90)
Vmiddle middle slow sin(0 1 17 0 0 90)
Vfast transducer middle sin(0 0.35 60 0 0 90)
Vdemand demand 0 pulse(4 6 20m 50u 50u 60m 120m)
Xone transducer demand velocity acceleration surface control vcc vee channel
+ p1={{displacement_weight}} p2={{velocity_weight}}
+ p3={{boundary_layer_setting}} p4={{level_setting}}
Rleak xone.displacement xone.xtaps.xvelocity.series 1t
.options method=gear reltol=1e-4
.tran 40u 300m 0 40u
.end
"""
_SLOWER = 180.0
"""CA3140 at 9 V/us; a hundred and eighty times slower it makes 0.05 V/us. Its gain-bandwidth goes
with the compensation capacitor as well unless the drive grows along."""
FAULTS = {
    "healthy": {},
    "first capacitor 12 % low": {"xone.xtaps.xvelocity.cinput": 88e-9},
    "second capacitor 15 % high": {"xone.xtaps.xacceleration.cinput": 115e-9},
    "first capacitor leaks": {"rleak": 1e6},
    "offset of the surface amplifier": {"xone.xsurface.xamplifier.xcore.voffset": 0.06},
    "offset of the first differentiator": {"xone.xtaps.xvelocity.xamplifier.xcore.voffset": 0.05},
    "wiper of P1": {"xone.xsurface.xdisplacement.xpotentiometer.rwiper": 20e3},
    "asymmetric clamp": {"xone.xlimiter.dlower[bv]": 5.0},
    "supplies of 10 V": {"xsupply.vpositive": 10.0, "xsupply.vnegative": 10.0},
    "slow op-amps": {
        f"xone.{place}.xamplifier.xcore.{element}": value
        for place in PLACES.values()
        for element, value in (("cgain", 30e-12 * _SLOWER), ("rdrive", _SLOWER))
    },
}


@cache
def voltages(fault):
    """Voltages of the nodes at the recorder's samples, after the transient of the start [V]."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "taps.cir"
        path.write_text(CIRCUIT.format(root=netlists.ROOT))
        with Session(path, save=NODES) as session:
            session.change(FAULTS[fault])
            found = session.run(Transient(stop=LEAD_IN + DURATION, longest_step=40e-6))
    time = LEAD_IN + np.arange(round(DURATION * RATE)) / RATE
    return np.array([found.at(time, node) for node in NODES])


def recording(fault, seed, noise=NOISE, stated=True, card=None):
    """What a recorder with white noise stores of a card."""
    samples = voltages(fault)
    samples = samples + noise * np.random.default_rng(seed).standard_normal(samples.shape)
    channels = dict(zip(CHANNELS, samples, strict=True))
    channels["demand"] = METRES_PER_VOLT * channels["demand"]
    known = {channel: noise for channel in CHANNELS if channel != "demand"} if stated else {}
    time = np.arange(samples.shape[1]) / RATE
    return Recording(
        f"card-{seed}", time, channels, "analogue-card", noise_rms=known, card=card or {}
    )
