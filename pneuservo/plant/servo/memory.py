"""What the chain remembers from step to step: play, stiction, rest, bristles, jets, the past."""

from pneuservo.plant.control_law import limited
from pneuservo.plant.piston import is_moving
from pneuservo.plant.presliding import presliding_step
from pneuservo.plant.servo.chain import commanded_voltage, driving
from pneuservo.plant.servo.compilation import compiled, compiled_apart
from pneuservo.plant.servo.drive import delayed_command, given
from pneuservo.plant.servo.layout import (
    BRISTLE,
    BRISTLE_PLACE,
    COMMANDED,
    EXHAUST,
    FIRST_JET,
    FLOWED_A,
    FLOWED_B,
    LAST_SPOOL_RATE,
    NEWEST,
    PAST_COLUMNS,
    PAST_ROWS,
    PISTON_REST,
    PLAY,
    SLEWED,
    SLEWED_WHEN,
    SPOOL_REST,
    SPOOL_STUCK,
    TIME,
    WHEN,
)
from pneuservo.plant.servo.spool_effects import breakaway_of_spool, slewed
from pneuservo.plant.servo.valve_effects import jet_is_attached, silenced
from pneuservo.plant.servo.valve_side import supply_at_valve, valve_flows
from pneuservo.plant.single_axis import (
    DISPLACEMENT,
    MOTION,
    PRESSURE_A,
    PRESSURE_B,
    SPOOL,
    SPOOL_RATE,
)
from pneuservo.plant.valve import A_TO_EXHAUST, B_TO_EXHAUST, SUPPLY_TO_A, SUPPLY_TO_B


@compiled
def remember(state, modes, memory, rows, drive, elapsed, passed, servo, grid):
    """Update what is remembered once a step is done.

    Parameters
    ----------
    state, modes, memory, rows, drive, elapsed, servo, grid
        As in `pneuservo.plant.servo.chain.derivative`; memory and rows are changed.
    passed : float
        Length of the step [s].

    Notes
    -----
    Play, stiction of the spool, jets and rest change only here, so that their timing is known to
    a step; friction that builds up over a distance is exact for a step without a reversal.
    """
    effects = servo.effects.spool
    if remembers(effects):
        now = given(drive, TIME, elapsed)
        command = _driver_command(state, modes, memory, drive, elapsed, servo)
        late = delayed_command(command, memory, rows, now, servo)
        remember_spool(late, now, state, memory, passed, servo)
    remember_beside_spool(state, modes, memory, rows, drive, elapsed, passed, servo, grid)


@compiled
def remember_beside_spool(state, modes, memory, rows, drive, elapsed, passed, servo, grid):
    """Update what is remembered once a step is done, but for what the spool remembers.

    Parameters
    ----------
    state, modes, memory, rows, drive, elapsed, passed, servo, grid
        As in `remember`.
    """
    effects = servo.effects
    memory[PISTON_REST] = 0.0 if is_moving(modes[MOTION]) else memory[PISTON_REST] + passed
    memory[BRISTLE] = presliding_step(
        memory[BRISTLE],
        state[DISPLACEMENT] - memory[BRISTLE_PLACE],
        effects.friction.presliding_travel,
        effects.friction.presliding_exponent,
    )
    memory[BRISTLE_PLACE] = state[DISPLACEMENT]
    if effects.valve.attached_loss != 0.0:
        _remember_jets(state, memory, drive, elapsed, servo)
    if effects.valve.exhaust_area > 0.0:
        _remember_exhaust(state, memory, drive, elapsed, passed, servo, grid)
    if effects.spool.delay > 0.0 or effects.line.delay > 0.0:
        record(state, modes, memory, rows, drive, elapsed, servo, grid)


@compiled
def _driver_command(state, modes, memory, drive, elapsed, servo):
    command = commanded_voltage(state, modes, memory, drive, elapsed, servo)
    return limited(command, servo.law.level)


@compiled
def remembers(effects):
    """Return whether a spool needs to be told when a step is done.

    Parameters
    ----------
    effects : SpoolEffects
        The effects.
    """
    return effects.hysteresis > 0.0 or effects.stiction > 0.0 or effects.rate_limit > 0.0


@compiled_apart
def remember_spool(command, now, state, memory, passed, servo):
    """Update the driver's output, where the play was left and whether stiction holds the spool.

    Parameters
    ----------
    command : float
        Into the valve driver, delayed [V].
    now : float
        Time since the start of the run [s].
    state, memory, servo
        As in `pneuservo.plant.servo.chain.derivative`; the first two are changed.
    passed : float
        Length of the step [s].
    """
    effects, full = servo.effects.spool, servo.plant.valve.full_voltage
    memory[PLAY] = driving(command, memory, passed, servo)
    memory[SLEWED] = slewed(command, memory[SLEWED], passed, full, effects)
    memory[SLEWED_WHEN] = now
    if effects.stiction == 0.0:
        return
    error = abs(limited(memory[PLAY], full) / full - state[SPOOL])
    turned = state[SPOOL_RATE] * memory[LAST_SPOOL_RATE] <= 0.0
    if memory[SPOOL_STUCK] != 0.0:
        memory[SPOOL_REST] += passed
        if error > breakaway_of_spool(memory[SPOOL_REST], effects):
            memory[SPOOL_STUCK] = 0.0
    elif turned and error < breakaway_of_spool(0.0, effects):
        memory[SPOOL_STUCK] = 1.0
        memory[SPOOL_REST] = 0.0
        state[SPOOL_RATE] = 0.0
    memory[LAST_SPOOL_RATE] = state[SPOOL_RATE]


@compiled_apart
def _remember_jets(state, memory, drive, elapsed, servo):
    supply, ambient = supply_at_valve(state, drive, elapsed, servo), servo.plant.ambient_pressure
    pa, pb = state[PRESSURE_A], state[PRESSURE_B]
    effects = servo.effects.valve
    for path, one, other in (
        (SUPPLY_TO_A, supply, pa),
        (B_TO_EXHAUST, pb, ambient),
        (SUPPLY_TO_B, supply, pb),
        (A_TO_EXHAUST, pa, ambient),
    ):
        place = FIRST_JET + path
        memory[place] = jet_is_attached(memory[place], min(one, other) / max(one, other), effects)


@compiled_apart
def _remember_exhaust(state, memory, drive, elapsed, passed, servo, grid):
    supply = supply_at_valve(state, drive, elapsed, servo)
    flow_a, flow_b, drawn = valve_flows(state[SPOOL], state, memory, supply, servo, grid)
    exhausted = drawn - flow_a - flow_b
    memory[EXHAUST] = silenced(memory[EXHAUST], exhausted, passed, servo.plant, servo.effects.valve)


@compiled_apart
def record(state, modes, memory, rows, drive, elapsed, servo, grid):
    """Add the present command and flows to the past.

    Parameters
    ----------
    state, modes, memory, rows, drive, elapsed, servo, grid
        As in `remember`.
    """
    place = (int(memory[NEWEST]) + 1) % PAST_ROWS
    supply = supply_at_valve(state, drive, elapsed, servo)
    flow_a, flow_b, _ = valve_flows(state[SPOOL], state, memory, supply, servo, grid)
    command = _driver_command(state, modes, memory, drive, elapsed, servo)
    rows[place, WHEN] = given(drive, TIME, elapsed)
    rows[place, COMMANDED] = command
    rows[place, FLOWED_A] = flow_a
    rows[place, FLOWED_B] = flow_b
    memory[NEWEST] = place


@compiled_apart
def begin(state, modes, memory, rows, drive, servo, grid):
    """Fill memory and past as if the run had stood like its start for ever.

    Parameters
    ----------
    state, modes, memory, rows, drive, servo, grid
        As in `remember`.
    """
    for i in range(memory.shape[0]):
        memory[i] = 0.0
    memory[BRISTLE_PLACE] = state[DISPLACEMENT]
    memory[EXHAUST] = servo.plant.ambient_pressure
    command = _driver_command(state, modes, memory, drive, 0.0, servo)
    begin_spool(memory, command, given(drive, TIME, 0.0), servo)
    if servo.effects.valve.attached_loss != 0.0:
        _remember_jets(state, memory, drive, 0.0, servo)
    record(state, modes, memory, rows, drive, 0.0, servo, grid)
    newest = int(memory[NEWEST])
    for row in range(PAST_ROWS):
        if row != newest:
            for column in range(PAST_COLUMNS):
                rows[row, column] = rows[newest, column]
            rows[row, WHEN] = -1e30


@compiled
def begin_spool(memory, command, now, servo):
    """Fill what the spool remembers as if its command had stood for ever.

    Parameters
    ----------
    memory, servo
        As in `remember`.
    command : float
        Into the valve driver [V].
    now : float
        Time since the start of the run [s].
    """
    memory[SLEWED], memory[SLEWED_WHEN] = command, now
    memory[PLAY] = command + servo.effects.spool.null_bias * servo.plant.valve.full_voltage
