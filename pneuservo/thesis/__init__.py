"""The reproduction: every table and stated result of the thesis, recomputed."""
