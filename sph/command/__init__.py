"""The command ``sph`` and what only its user needs: progress, scene summary, table of keys.

* ``cli``: the commands and their exit codes
* ``progress``: a bar on a terminal, lines in a log file
* ``info``: summary of a scene before it is run
* ``repeat``: a trajectory in place of a scene file
* ``status``: how far a study is, for a second terminal
* ``job``: the log of a workflow's job
* ``motion``: measures of a ground motion
* ``newmark``: a sliding block on a ground motion
* ``reference``: the tables of keys, variables, commands and measured results in README.md and docs
"""
