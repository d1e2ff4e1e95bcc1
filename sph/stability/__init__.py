"""Companions of a run: what the simple methods of practice say about the same slope and the same shaking.

``newmark``  permanent displacement of a rigid sliding block

They are references to compare with, not parts of the model: the solver does not import them.
"""
