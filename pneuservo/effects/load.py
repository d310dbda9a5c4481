"""What else pulls on the rod."""

from dataclasses import replace

from pneuservo.effects.effect import Effect, EffectParameter

_STIFFNESS = EffectParameter(
    "stiffness", "N/m", 0.0, -5000.0, 5000.0, (20.0,), "spring stiffness", "load.spring"
)
SPRING_OF_TESTER = Effect(
    id="load.spring",
    block="load",
    rigs=("seal-tester",),
    statement="Something pulls on the rod like a spring; the model has no spring.",
    equation="F = stiffness (x - x_mid)",
    parameters=(_STIFFNESS,),
    source="hose drag and cable chains; physics of a linear spring",
    experiment="drive slowly both ways over the full stroke: a spring does not change sign with v",
)
SPRING = replace(
    SPRING_OF_TESTER,
    rigs=("single-axis",),
    equation="F = stiffness (x - x_mid - origin)",
    parameters=(
        _STIFFNESS,
        EffectParameter(
            "origin", "m", 0.0, -0.06, 0.06, (0.0,), "beyond mid-stroke, where it is free",
            "load.spring_origin",
        ),
    ),
)  # fmt: skip
_RIGS = ("single-axis",)
_MODE_STARTS = (8.0, 11.0, 15.0, 21.0, 29.0, 40.0, 56.0)
"""Of a lightly damped mode nothing shows from a start far beside it [Hz]."""


def _mode(share: str, frequency: str) -> tuple[EffectParameter, ...]:
    """Return the parameters of a swing: that of the load and that of the frame obey one law."""
    return (
        EffectParameter("share", "", 0.0, 0.0, 0.4, (0.06,), share, "load.mode_share"),
        EffectParameter(
            "frequency", "Hz", 20.0, 3.0, 150.0, _MODE_STARTS, frequency, "load.mode_frequency"
        ),
        EffectParameter(
            "damping", "", 0.02, 1e-3, 0.3, (0.1,), "damping ratio", "load.mode_damping"
        ),
    )


_SWING = "swing of the structure"
_JOINT = "joint of the load"
TRANSVERSE_MODE = Effect(
    id="load.transverse-mode",
    block="load",
    rigs=_RIGS,
    statement="Part of the load swings by itself; the model's load is rigid.",
    equation="q'' + 2 damping w q' + w^2 q = -x'', F = -share m (x'' + q''), w = 2 pi frequency",
    parameters=_mode("of the mass that swings", "of the swing"),
    source="thesis section 4.3.3",
    experiment="tap it with an accelerometer on its side; change the mass",
    group=_SWING,
)
BASE_MOTION = Effect(
    id="load.base-motion",
    block="load",
    rigs=_RIGS,
    statement="The frame gives way under the piston's reaction; the model's stands still.",
    equation="y = share q, q'' + 2 damping w q' + w^2 q = -x'', F = -m y'', w = 2 pi frequency",
    parameters=_mode(
        "moved mass over that of frame and load together", "of frame and load on its feet"
    ),
    source="two masses on a spring, seen by a transducer on the frame; the law of the other mode",
    experiment="put an accelerometer on the frame",
    group=_SWING,
)
COMPLIANCE = Effect(
    id="load.compliance",
    block="load",
    rigs=_RIGS,
    statement="The load hangs on an elastic joint; the model's load is rigid.",
    equation="share m (x'' + q'') = share m g - F, F = stiffness q + damping q'",
    parameters=(
        EffectParameter(
            "share", "", 0.0, 0.0, 0.9, (0.5,), "of the mass behind the joint", "load.joint_share"
        ),
        EffectParameter(
            "stiffness",
            "N/m",
            0.0,
            1e4,
            1e7,
            (1e5, 3e5, 1e6, 3e6),
            "of the joint",
            "load.joint_stiffness",
        ),
        EffectParameter(
            "damping", "N*s/m", 0.0, 0.1, 1e3, (30.0,), "of the joint", "load.joint_damping"
        ),
    ),
    source="two masses; textbook dynamics",
    experiment="tap the load and compare accelerometers on load and rod",
    group=_JOINT,
)
BACKLASH = Effect(
    id="load.backlash",
    block="load",
    rigs=_RIGS,
    statement="The joint to the load has free travel; the model's load is rigid.",
    equation="F = 0 while |q| < play/2, of a joint with share of the mass behind it",
    parameters=(
        EffectParameter(
            "play", "m", 0.0, 0.0, 2e-3, (1e-4, 2e-5), "free travel", "load.joint_play"
        ),
        EffectParameter(
            "share", "", 0.0, 0.05, 0.9, (0.5,), "of the mass behind the joint", "load.joint_share"
        ),
    ),
    source="textbook dynamics; flanks taken as 1 N/um",
    experiment="repeat with gravity holding the joint to one side",
    group=_JOINT,
)
GRAVITY_ANGLE = Effect(
    id="load.gravity-angle",
    block="load",
    rigs=_RIGS,
    statement=(
        "The axis leans, or the rod points the other way; the model has gravity as the rig says."
    ),
    equation="F = m g cos(angle_rig + angle), g cos(angle_rig) = load.gravity",
    parameters=(
        EffectParameter(
            "angle",
            "rad",
            0.0,
            -3.2,
            3.2,
            (0.3, 3.1),
            "by which the rod is turned upwards from where the rig has it",
            "load.tilt",
        ),
    ),
    source="thesis equation (4.23)",
    experiment="put a level on the rig",
)
EFFECTS = (
    SPRING,
    SPRING_OF_TESTER,
    TRANSVERSE_MODE,
    BASE_MOTION,
    COMPLIANCE,
    BACKLASH,
    GRAVITY_ANGLE,
)
