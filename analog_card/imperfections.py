"""Which imperfections of the real card its behaviour has."""

from dataclasses import dataclass, fields, replace


@dataclass(frozen=True)
class Imperfections:
    """What of the real card its behaviour has; each can be left out alone.

    Attributes
    ----------
    gain_bandwidth : bool
        Finite gain-bandwidth product and open-loop gain of every op-amp; it is what delays the
        relay.
    slew_rate : bool
        Limited slew rate of the differentiators and of the boundary-layer amplifier.
    offset_voltage, bias_current : bool
        Of every op-amp.
    output_resistance : bool
        Of the op-amps of the differentiators.
    saturation : bool
        Asymmetric swing of differentiators, inverter, surface and boundary-layer amplifier, with
        the recovery from it. Without it the last two stop at the smaller swing, either sign.
    common_mode : bool
        Finite common-mode rejection of buffers and difference amplifier.
    potentiometer_contacts : bool
        End and wiper resistances. The load on the wipers is never left out.
    zener_knee : bool
        The knee and the differential resistance of the zeners; without them a hard limit.

    Examples
    --------
    >>> Imperfections.none().offset_voltage, Imperfections().without("slew_rate").slew_rate
    (False, False)
    """

    gain_bandwidth: bool = True
    slew_rate: bool = True
    offset_voltage: bool = True
    bias_current: bool = True
    output_resistance: bool = True
    saturation: bool = True
    common_mode: bool = True
    potentiometer_contacts: bool = True
    zener_knee: bool = True

    @classmethod
    def none(cls) -> "Imperfections":
        """Return the ideal card's."""
        return cls(**{item.name: False for item in fields(cls)})

    @classmethod
    def only(cls, *names: str) -> "Imperfections":
        """Return those named and no others."""
        return replace(cls.none(), **dict.fromkeys(names, True))

    def without(self, *names: str) -> "Imperfections":
        """Return these without those named."""
        return replace(self, **dict.fromkeys(names, False))

    @property
    def any(self) -> bool:
        """Whether there is any."""
        return any(vars(self).values())
