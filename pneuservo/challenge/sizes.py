"""How many cases a trial holds."""

QUICK = 32
FULL = 200
FEWEST_CONTROLS = 47
"""Without any effect, in a full trial: at most one false alarm in so many bounds its rate below a
tenth with 95 % confidence."""
