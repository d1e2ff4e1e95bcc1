"""What every run has, started by hand or by the workflow: progress messages, logs and exit codes.

No result depends on it: editing it runs nothing again.

* ``ahead``: how short runs share a job
* ``simulation``: what the jobs that simulate do
* ``log``: what a job is given, and its log
* ``progress``: a bar on a terminal, lines in a log file
* ``exit_codes``: of jobs and of the command
"""
