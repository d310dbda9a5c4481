"""Where each state stands in the state vector of the truth."""

POSITION, SPEED = 0, 1
SPOOL, SPOOL_SPEED, AMPLIFIER, SPOOL_BRISTLE, SPOOL_AGE = 2, 3, 4, 5, 6
PRESSURE_A, PRESSURE_B, GAS_A, GAS_B, WALL_A, WALL_B = 7, 8, 9, 10, 11, 12
SUPPLY, EXHAUST, EXHAUSTED = 13, 14, 15
LOAD_POSITION, LOAD_SPEED, MODE, MODE_SPEED, FRAME, FRAME_SPEED = 16, 17, 18, 19, 20, 21
LAG_1, LAG_2, LAG_A, LAG_B = 22, 23, 24, 25
FILM, AGE = 26, 27
BRISTLES, BRISTLE_COUNT = 28, 4
HOSES = BRISTLES + BRISTLE_COUNT
CELLS = 10
"""Cells of one hose; each holds a pressure and the flow to the next."""
STATES = HOSES + 4 * CELLS

# What is kept from one control tick to the next.
COMMAND, ACCELERATION, NEXT_SWITCH, SWITCHES, ATTACHED_A, ATTACHED_B, WIPER = range(7)
SLACKS, SLACK_COUNT = 7, 4
KEPT = SLACKS + SLACK_COUNT
RELAYS = 3000
"""Relays of the hysteresis of the command."""
