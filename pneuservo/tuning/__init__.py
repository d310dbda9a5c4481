"""Tuning under uncertainty: potentiometer settings that are best in the worst rig of a set.

`problem` says which rigs and which limits, `evaluation` what one setting is worth, `search` tries
settings, `front` says which of them nothing beats, `check` has the choice judged by other means;
`run` does all of it in turn, `summary` and `picture` say what came out.
"""
