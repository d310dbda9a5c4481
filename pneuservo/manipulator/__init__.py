"""A two-link manipulator with ideal actuators, and the open linkage it is a case of."""
