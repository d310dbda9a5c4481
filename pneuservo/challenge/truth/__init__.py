"""The truth simulator: the servo on equations and an integrator of its own."""
