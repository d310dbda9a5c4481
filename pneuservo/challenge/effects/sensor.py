"""Concealed errors of transducers."""

from pneuservo.challenge.effects.concealed import SENSOR, ConcealedEffect, Form
from pneuservo.challenge.truth.rig import changed

_POSITION = ("sensor.displacement",)
_PRESSURE = ("sensor.pressure",)
_FAST = ("sliding-mode", "multilevel", "relay")

EFFECTS = (
    ConcealedEffect(
        "sensor.position-lag", SENSOR, _POSITION, 1e-4, 5e-3, "s",
        (
            Form("one lag", lambda t, s: changed(t, "sensors", position_lag=s), shared=True),
            Form(
                "two lags",
                lambda t, s: changed(t, "sensors", position_lag=s, position_lag_order=2.0),
            ),
        ),
        _FAST,
    ),
    ConcealedEffect(
        "sensor.position-gain", SENSOR, _POSITION, 2e-3, 0.04, "",
        (
            Form("reads too far", lambda t, s: changed(t, "sensors", position_gain=1.0 + s), True),
            Form(
                "reads too short", lambda t, s: changed(t, "sensors", position_gain=1.0 - s), True
            ),
        ),
        ("sliding-mode", "multilevel", "proportional"),
    ),
    ConcealedEffect(
        "sensor.position-offset", SENSOR, _POSITION, 1e-4, 2e-3, "m",
        (
            Form("zero shifted", lambda t, s: changed(t, "sensors", position_offset=s), True),
            Form("zero shifted back", lambda t, s: changed(t, "sensors", position_offset=-s), True),
        ),
        ("sliding-mode", "multilevel", "stop-test"),
    ),
    ConcealedEffect(
        "sensor.position-nonlinearity", SENSOR, _POSITION, 3e-5, 1e-3, "m",
        (
            Form("bowed curve", lambda t, s: changed(t, "sensors", position_bow=s)),
            Form("loaded potentiometer", lambda t, s: changed(t, "sensors", position_load=s)),
        ),
        ("sliding-mode", "triangle", "multilevel"),
    ),
    ConcealedEffect(
        "sensor.position-wiper", SENSOR, _POSITION, 5e-6, 1.5e-4, "m",
        (Form("wiper with slack", lambda t, s: changed(t, "sensors", position_slack=s)),),
        ("triangle", "multilevel", "proportional"),
    ),
    ConcealedEffect(
        "sensor.pressure-offset-a", SENSOR, _PRESSURE, 300.0, 1.5e4, "Pa",
        (
            Form("reads high", lambda t, s: changed(t, "sensors", pressure_offset_a=s), True),
            Form("reads low", lambda t, s: changed(t, "sensors", pressure_offset_a=-s), True),
        ),
    ),
    ConcealedEffect(
        "sensor.pressure-offset-b", SENSOR, _PRESSURE, 300.0, 1.5e4, "Pa",
        (
            Form("reads high", lambda t, s: changed(t, "sensors", pressure_offset_b=s), True),
            Form("reads low", lambda t, s: changed(t, "sensors", pressure_offset_b=-s), True),
        ),
    ),
    ConcealedEffect(
        "sensor.pressure-gain-a", SENSOR, _PRESSURE, 2e-3, 0.05, "",
        (
            Form("reads high", lambda t, s: changed(t, "sensors", pressure_gain_a=1.0 + s), True),
            Form("reads low", lambda t, s: changed(t, "sensors", pressure_gain_a=1.0 - s), True),
        ),
        ("stop-test", "multilevel", "sliding-mode"),
    ),
    ConcealedEffect(
        "sensor.pressure-gain-b", SENSOR, _PRESSURE, 2e-3, 0.05, "",
        (
            Form("reads high", lambda t, s: changed(t, "sensors", pressure_gain_b=1.0 + s), True),
            Form("reads low", lambda t, s: changed(t, "sensors", pressure_gain_b=1.0 - s), True),
        ),
        ("stop-test", "multilevel", "sliding-mode"),
    ),
    ConcealedEffect(
        "sensor.pressure-static", SENSOR, _PRESSURE, 0.1, 2.0, "",
        (
            Form(
                "tap in the pipe misses the dynamic pressure",
                lambda t, s: changed(t, "sensors", dynamic_pressure=s),
                shared=True,
            ),
        ),
        _FAST,
    ),
    ConcealedEffect(
        "sensor.pressure-lag", SENSOR, _PRESSURE, 1e-4, 8e-3, "s",
        (
            Form("tap tube", lambda t, s: changed(t, "sensors", pressure_lag=s), shared=True),
        ),
        _FAST,
    ),
    ConcealedEffect(
        "sensor.ground-shift", SENSOR, _PRESSURE, 30.0, 3e3, "Pa/V",
        (
            Form(
                "amplifier shares a lead with one transducer",
                lambda t, s: changed(t, "sensors", shift_by_command=s),
                shared=True,
            ),
            Form(
                "coil shares a lead with both",
                lambda t, s: changed(t, "sensors", shift_by_coil=t.spool.full_voltage * s),
            ),
        ),
        _FAST,
    ),
)  # fmt: skip
