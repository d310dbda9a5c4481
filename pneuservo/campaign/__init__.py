"""Sweeps and campaigns: a closed loop run many times, over grids and distributions.

`plan` says which sample has which values, `run` runs them (`cluster` elsewhere), `summary` and
`picture` say what came out; `plan_file` reads campaigns from TOML.
"""
