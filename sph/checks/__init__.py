"""Findings: what may spoil the results of a scene or a run.

* ``finding``: what a finding is, and the codes of all
* ``scene``: all that need no run; ``soil``, ``layers``, ``motion``, ``loss``: those of one topic
* ``equilibrium``: those of limit equilibrium; ``after_run``: those of a run by its metrics
"""
