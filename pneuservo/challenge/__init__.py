"""The blind trial of the diagnosis: cases with a concealed effect, sealed keys, and their score.

Nothing here shares an equation, an integrator or a submodel form with the diagnosis: what judges
it must not be made of it. The rig's numbers, the valve's tables and the form of a recording are
the only things in common.
"""
