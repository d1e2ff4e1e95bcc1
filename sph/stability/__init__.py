"""Companions of a run: results of the simple methods of practice for the same slope and the same shaking.

* ``standing``: the static test of a scene, and the rule by which it stands or has failed
* ``search``: bracket and bisection between what stands and what fails
* ``safety``: factor of safety, critical strength ratio and yield acceleration
* ``record``: a search as a file
* ``limit_equilibrium``: Bishop's and Spencer's methods for slices; ``slip_surface`` cuts those of a scene, ``slip_search`` finds the worst
* ``newmark``: permanent displacement of a rigid sliding block

They are references to compare with, not parts of the model: the solver does not import them.
"""
