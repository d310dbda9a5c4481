"""Compiled physics of the rigs: every equation once, as a small function.

By phenomenon: `gas` (orifices), `valve` (discharge, paths, spool), `chamber`, `piston` (forces,
friction, stops), `control_law`, `analogue_card`. Put together: `single_axis` with `events` and
`integrator`, and `dead_volume`. `pneuservo.rigs.plant_numbers` turns a rig into the numbers they
take; `compilation` says how they are compiled.
"""
