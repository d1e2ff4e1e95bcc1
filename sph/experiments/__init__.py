"""Experiments: sets of runs designed to answer one question, and what they answer.

* ``cost_accuracy``: what each saving of computing time costs in accuracy (``snakemake trade``)
* ``trigger``: the shaking at which a slope fails, and maps around it (``snakemake trigger``, ``maps``, ``confirm``)
* ``sensitivity``: which parameters decide the results (``snakemake sensitivity``)
* ``assumptions``: what the choices behind a scene do (``snakemake limits``)
* ``robustness``: how far the solver can be pushed (``snakemake extremes``)
* ``base``: what they share: what one is, keys, names of files, the check of every scene before any work
* ``registry``: those whose runs stand alone, which the workflow makes by one file of rules
* ``study_row``: the row of a study's table, with the error to expect
* ``measured``: what they gave for the release
"""
