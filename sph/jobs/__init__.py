"""What every run has, started by hand or by the workflow: what is said while it runs, how it ends.

No result depends on it: editing it runs nothing again.

* ``log``: what a job is given, and its log
* ``progress``: a bar on a terminal, lines in a log file
* ``exit_codes``: of jobs and of the command
"""
