"""The command ``sph`` and what only its users need: scene summary, status, schemas.

* ``cli``: the commands and their exit codes
* ``info``: what a scene amounts to before it is run
* ``repeat``: a trajectory in place of a scene file
* ``status``: progress of a running study, for a second terminal
* ``motion``: measures of a ground motion
* ``newmark``: a sliding block on a ground motion
* ``pack``: a study with all its files in one archive; ``named_files``: where a configuration or a scene names files
* ``schema``: JSON Schema of the files that a user writes
"""
