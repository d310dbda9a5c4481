"""The behavioural analogue card: two differentiators in series on the displacement transducer.

Each stage is V_out = -s RC / ((1 + s tau1)(1 + s tau2)) V_in: an op-amp with Rs and C at its input
and R and Cf in its feedback, equation (9.3) of the thesis. Surface and output stage are those of
`control_law`. Op-amp dynamics and offsets are left to the netlists.
"""

from pneuservo.plant.compilation import compiled


@compiled
def differentiator_rates(signal, lagged, derivative, lag_1, lag_2):
    """Return the rates of the two states of a differentiator stage.

    Parameters
    ----------
    signal : float
        Input of the stage [V].
    lagged : float
        First state, the input after one lag [V].
    derivative : float
        Second state, the derivative of the input after both lags [V/s].
    lag_1, lag_2 : float
        Time constants of the two breaks, C Rs and Cf R [s].

    Returns
    -------
    float, float
        Rates of the first state [V/s] and of the second [V/s^2].
    """
    lagged_rate = (signal - lagged) / lag_1
    return lagged_rate, (lagged_rate - derivative) / lag_2


@compiled
def differentiator_output(derivative, time_constant):
    """Return the output of a differentiator stage [V].

    Parameters
    ----------
    derivative : float
        Second state of the stage [V/s].
    time_constant : float
        RC [s].

    Examples
    --------
    >>> differentiator_output(100.0, 12e-3)
    -1.2
    """
    return -time_constant * derivative
