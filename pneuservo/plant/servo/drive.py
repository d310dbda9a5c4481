"""What drives the chain between two samples, and what it was some time ago."""

from pneuservo.plant.servo.compilation import compiled
from pneuservo.plant.servo.layout import COMMANDED, NEWEST, PAST_ROWS, WHEN


@compiled
def given(drive, column, elapsed):
    """Return an input at a moment between two samples.

    Parameters
    ----------
    drive : (2, 5) array
        The inputs at the last sample and their rates.
    column : int
        Which input, from `layout`.
    elapsed : float
        Time since the last sample [s].
    """
    return drive[0, column] + drive[1, column] * elapsed


@compiled
def past(rows, memory, column, moment, now, present):
    """Return what a quantity was some time ago, straight between the steps.

    Parameters
    ----------
    rows : (1024, 4) array
        The past of the run, a ring.
    memory : array
        Of the chain; names the newest row.
    column : int
        Which quantity, from `layout`.
    moment, now : float
        The moment asked for and the present one [s].
    present : float
        The value now.
    """
    newest = int(memory[NEWEST])
    if moment >= rows[newest, WHEN]:
        if now <= rows[newest, WHEN]:
            return rows[newest, column]
        share = (moment - rows[newest, WHEN]) / (now - rows[newest, WHEN])
        return rows[newest, column] + share * (present - rows[newest, column])
    later = newest
    for back in range(1, PAST_ROWS):
        earlier = (newest - back) % PAST_ROWS
        if rows[earlier, WHEN] <= moment:
            width = rows[later, WHEN] - rows[earlier, WHEN]
            share = (moment - rows[earlier, WHEN]) / width
            return rows[earlier, column] + share * (rows[later, column] - rows[earlier, column])
        later = earlier
    return rows[later, column]


@compiled
def delayed_command(command, memory, rows, now, servo):
    """Return the command that the spool's motor hears [V].

    Parameters
    ----------
    command : float
        Into the valve driver now [V].
    memory, rows, servo
        As in `pneuservo.plant.servo.chain.derivative`.
    now : float
        Time since the start of the run [s].
    """
    delay = servo.effects.spool.delay
    if delay > 0.0:
        return past(rows, memory, COMMANDED, now - delay, now, command)
    return command
