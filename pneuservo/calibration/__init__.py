"""Calibration of a valve from charging and discharging a dead volume (thesis, section 4.3.1)."""

from pneuservo.calibration.experiment import simulate_transient
from pneuservo.calibration.flow_curve import FlowCurve, flow_curve
from pneuservo.calibration.table import RATED_COEFFICIENT, Calibration, FlowArea, calibrate
from pneuservo.calibration.table_row import TableRow, fit_row
from pneuservo.calibration.transient import LEAK, Transient, transient_of

__all__ = [
    "LEAK",
    "RATED_COEFFICIENT",
    "Calibration",
    "FlowArea",
    "FlowCurve",
    "TableRow",
    "Transient",
    "calibrate",
    "fit_row",
    "flow_curve",
    "simulate_transient",
    "transient_of",
]
