"""Findings: what may spoil the results of a scene or a run, as a code, keys and numbers.

* ``finding``: what a finding is; ``messages``: all codes with severity and words, which nothing else makes
* ``scene``: all that need no run; ``soil``, ``layers``, ``cover_rows``, ``motion``, ``liquefaction``, ``loss``: those of one topic;
  ``step_limits``: limits of the time step, kept for scenes that share them
* ``stability``, ``equilibrium``: those of static tests and of limit equilibrium; ``after_run``: those of a run by its metrics
"""
