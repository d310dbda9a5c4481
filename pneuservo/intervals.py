"""How wide intervals are, wherever one is given."""

INTERVAL = 1.96
"""Half width of a 95 % interval, in standard deviations."""
