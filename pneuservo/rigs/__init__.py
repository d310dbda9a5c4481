"""Rigs as data: one TOML per rig, every value with unit and source."""
