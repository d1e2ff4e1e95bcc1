"""The solver: a scene in, its trajectory out.

* ``run``: stages, recording and restart; ``checkpoint``: a run that may be killed; ``guard``, ``early_stop``: how it ends
* ``particles``, ``state``, ``initial_stress``: what it starts from
* ``integration``, ``neighbours``, ``time_step``: how it advances
* ``physics``: a term a file; ``boundaries``: a kind of wall a file; ``compiled``: how numba compiles, and threads
"""
