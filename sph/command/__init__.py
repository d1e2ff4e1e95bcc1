"""The command ``sph`` and what only a person at it needs: scene summary, status, table of keys.

* ``cli``: the commands and their exit codes
* ``info``: what a scene amounts to before it is run
* ``repeat``: a trajectory in place of a scene file
* ``status``: how far a study is, for a second terminal
* ``motion``: measures of a ground motion
* ``newmark``: a sliding block on a ground motion
* ``reference``: the tables of keys, variables, commands and measured results in README.md and docs
"""
