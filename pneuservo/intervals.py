"""How wide intervals are, wherever one is given."""

CONFIDENCE = 0.95
"""Share of intervals that hold the true value."""
INTERVAL = 1.96
"""Half width of one, in standard deviations."""
