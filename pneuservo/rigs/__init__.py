"""Rigs as data: one TOML per rig, every value with unit and source."""

from pneuservo.plant.flow_paths import FLOW_PATHS, FlowPathTable
from pneuservo.rigs.rig import BUILT_IN_RIGS, VARIANTS, Parameter, Rig, built_in_text, load_rig
from pneuservo.rigs.session import Session
from pneuservo.rigs.transducers import Transducer
from pneuservo.rigs.valve_tables import load_valve_tables

__all__ = [
    "BUILT_IN_RIGS",
    "FLOW_PATHS",
    "VARIANTS",
    "FlowPathTable",
    "Parameter",
    "Rig",
    "Session",
    "Transducer",
    "built_in_text",
    "load_rig",
    "load_valve_tables",
]
