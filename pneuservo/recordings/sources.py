"""Which column is what, and what its numbers are in SI: the tables [time] and [channels]."""

from collections.abc import Mapping

import numpy as np

from pneuservo.arrays import Array
from pneuservo.errors import InputError
from pneuservo.recordings.channels import CHANNELS, Channel
from pneuservo.recordings.conditions import ambient_pressure
from pneuservo.recordings.sidecar import ChannelSource, Sidecar, TimeSource
from pneuservo.recordings.table import Table
from pneuservo.recordings.units import conversion, difference
from pneuservo.rigs import Rig

TIME = "time"


def channel_sources(
    table: Table, sidecar: Sidecar
) -> tuple[Mapping[str, ChannelSource], list[str]]:
    """Return which column each channel comes from.

    Parameters
    ----------
    table : Table
        The raw table.
    sidecar : Sidecar
        Its table ``[channels]``; without one, the columns with canonical names are taken, in SI.

    Returns
    -------
    sources : mapping of str to ChannelSource
        By canonical name.
    warnings : list of str
        Columns that were left out because their names are not canonical.

    Raises
    ------
    InputError
        When there is neither a table ``[channels]`` nor a column with a canonical name.
    """
    if sidecar.channels is not None:
        return sidecar.channels, []
    sources = {
        name: ChannelSource(name, channel.unit)
        for name, channel in CHANNELS.items()
        if name in table
    }
    if not sources:
        listed = ", ".join(repr(name) for name in table.names) or "none"
        missing = "has no [channels]" if sidecar.present else "does not exist"
        raise InputError(
            f"{table.path}: no column has the name of a channel, and the sidecar {sidecar.path} "
            f"{missing}; write one that says which column is what. The columns are: {listed}; "
            f"the channels are: {', '.join(CHANNELS)}"
        )
    read = {table.find(name, str(sidecar.path)) for name in sources}
    if TIME in table:
        read.add(table.find(TIME, str(sidecar.path)))
    other = ", ".join(repr(name) for name in table.names if name not in read)
    return sources, [f"columns that are no channels were left out: {other}"] if other else []


def time_source(table: Table, sidecar: Sidecar) -> TimeSource:
    """Return where the time comes from.

    Parameters
    ----------
    table : Table
        The raw table.
    sidecar : Sidecar
        Its table ``[time]`` comes first, then a column ``time`` in s, then the file's own rate.

    Returns
    -------
    TimeSource
        A column with its unit, or a rate; neither when the file's own rate is to be used.

    Raises
    ------
    InputError
        When nothing says what the time is, or a column has no unit.
    """
    if sidecar.time is not None:
        source = sidecar.time
        if source.column is None:
            return source
        column = table.find(source.column, f"{sidecar.path}: [time]")
        if source.unit != "s" and table.holds_time_stamps(column):
            if source.unit is not None:
                raise InputError(
                    f"{sidecar.path}: [time] column {source.column!r} holds dates and times, "
                    f"and its unit is {source.unit!r}; leave the unit out"
                )
            return TimeSource(source.column, "s")
        if source.unit is None:
            if source.column != TIME:
                raise InputError(
                    f"{sidecar.path}: [time] column {source.column!r} has no unit; "
                    'add for example unit = "ms"'
                )
            return TimeSource(TIME, "s")
        return source
    if TIME in table:
        return TimeSource(TIME, "s")
    if table.rates:
        return TimeSource()
    listed = ", ".join(repr(name) for name in table.names)
    raise InputError(
        f"{table.path}: there is no column 'time'; say in {sidecar.path} which one it is, "
        'with [time] column = "..." and unit = "ms", or give rate = "1 kHz". '
        f"The columns are: {listed}"
    )


def sample_rate(
    table: Table, sidecar: Sidecar, source: TimeSource, columns: list[str]
) -> tuple[float, list[str]]:
    """Return the sample rate of a recording without a time column.

    Parameters
    ----------
    table : Table
        The raw table, which may know the rate of a column.
    sidecar : Sidecar
        The sidecar, for messages.
    source : TimeSource
        Its rate comes first.
    columns : list of str
        The columns that are read.

    Returns
    -------
    rate : float
        The sample rate [Hz].
    warnings : list of str
        Whether the file says otherwise.

    Raises
    ------
    InputError
        When neither says a rate, or the columns have different ones.
    """
    known = {name: table.rates[name] for name in columns if name in table.rates}
    if source.rate is not None:
        # One part in a million is the accuracy of a good clock.
        other = [rate for rate in known.values() if abs(rate - source.rate) > 1e-6 * source.rate]
        warning = "the file itself says {:.9g} Hz; the sidecar's rate of {:.9g} Hz is used"
        return source.rate, [warning.format(rate, source.rate) for rate in other[:1]]
    if not known:
        raise InputError(
            f"{table.path}: the channels' columns have no sample rate; "
            f'say in {sidecar.path} [time] rate = "1 kHz"'
        )
    rates = set(known.values())
    if len(rates) > 1:
        listed = ", ".join(f"{name!r} {rate:.9g} Hz" for name, rate in known.items())
        raise InputError(
            f"{table.path}: the columns have different sample rates: {listed}; "
            "take channels of one rate"
        )
    return rates.pop(), []


def _unit(source: ChannelSource, channel: Channel, where: str) -> str:
    if source.unit is not None:
        return source.unit
    # A column under its canonical name is in SI by definition.
    if source.column == channel.name or not channel.unit:
        return channel.unit
    raise InputError(f'{where} has no unit; add for example unit = "{channel.unit}"')


def samples_in_si(
    source: ChannelSource,
    name: str,
    raw: Array,
    sidecar: Sidecar,
    rig: Rig,
) -> Array:
    """Return the samples of a channel in SI, pressures absolute.

    Parameters
    ----------
    source : ChannelSource
        Scale, offset, unit, and whether it is a gauge pressure.
    name : str
        Canonical name of the channel.
    raw : (n,) array
        The numbers in the file.
    sidecar, rig : Sidecar, Rig
        Either may state the ambient pressure.

    Returns
    -------
    (n,) array
        (raw * scale + offset) in SI, plus the ambient pressure where it is a gauge pressure.

    Raises
    ------
    InputError
        When the unit is missing, unknown or of the wrong dimension, or there is no ambient
        pressure to add.
    """
    channel = CHANNELS[name]
    where = f"{sidecar.path}: [channels] {name}"
    how = conversion(_unit(source, channel, where), channel.unit, f"{where} unit")
    if None not in (source.gauge, how.gauge) and source.gauge != how.gauge:
        said = "gauge" if how.gauge else "absolute"
        raise InputError(
            f"{where}: the unit says {said}, and gauge = {str(source.gauge).lower()}; "
            "keep one of them"
        )
    with np.errstate(over="ignore"):
        values = (raw * source.scale + source.offset) * how.scale + how.offset
    if np.isinf(values).any():
        raise InputError(f"{where}: scale and offset make values that are not finite; check them")
    if not (source.gauge or how.gauge):
        return values
    ambient = ambient_pressure(sidecar, rig)
    if ambient is None:
        raise InputError(
            f"{where} is a gauge pressure, and the rig {rig.name} has no ambient pressure; "
            'add [conditions] ambient_pressure = "1.013 bar"'
        )
    return values + ambient


def noise_in_si(sources: Mapping[str, ChannelSource], sidecar: Sidecar) -> dict[str, float]:
    """Return the noise of the channels for which the sidecar states it.

    Parameters
    ----------
    sources : mapping of str to ChannelSource
        By canonical name.
    sidecar : Sidecar
        The sidecar, for messages.

    Returns
    -------
    dict of str to float
        Root mean square of the noise, in the channel's SI unit.

    Raises
    ------
    InputError
        When it is not a quantity of the channel's dimension, or negative.
    """
    noise: dict[str, float] = {}
    for name, source in sources.items():
        if source.noise_rms is None:
            continue
        where = f"{sidecar.path}: [channels] {name} noise_rms"
        noise[name] = difference(source.noise_rms, CHANNELS[name].unit, where)
        if noise[name] < 0.0:
            raise InputError(f"{where} is {source.noise_rms!r}; it cannot be negative")
    return noise
