"""SPICE netlists of the analogue card, as plain files that any ngspice user can open."""
