"""Compiled physics of the rigs: every equation once."""
