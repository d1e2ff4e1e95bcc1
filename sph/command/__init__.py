"""The command ``sph`` and what only its users need: scene summary, status, schemas.

* ``cli``: the commands and their exit codes; ``options``: arguments and options that they share; ``terminal``: what they print;
  ``outputs``: the files that they are told to write
* ``given``, ``study``: the scene or the study that a command is given
* a module for each command; ``results`` for those that show a trajectory
* ``compatible``: the scene made of the column of ``site``
"""
