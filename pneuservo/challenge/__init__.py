"""The blind trial of the diagnosis: cases with a concealed effect, sealed keys, and their score.

Nothing here shares code, an integrator or, where an effect is concealed, the form of its law with
the diagnosis, but for forms that are marked as shared: what judges it must not be made of it. The
law of the baseline, the rig's numbers, the valve's tables and the form of a recording are the only
things in common.
"""
