"""The diagnosis: where a simulation and a recording differ, why, and how much better it gets."""
