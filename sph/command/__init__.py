"""The command ``sph`` and what only a person at it needs: progress, scene summary, table of keys.

``cli``        the commands and their exit codes
``progress``   a bar on a terminal, lines in a log file
``info``       what a scene amounts to before it is run
``newmark``    a sliding block on a ground motion
``reference``  the table of scene keys in config/README.md
"""
