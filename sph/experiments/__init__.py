"""Experiments: sets of runs designed to answer one question, and what they answer.

* ``cost_accuracy``: what each saving of computing time costs in accuracy (``snakemake trade``)
* ``trigger``: the shaking at which a slope fails, and maps around it (``snakemake trigger``, ``maps``, ``confirm``)
* ``sensitivity``: which parameters decide the results (``snakemake sensitivity``)
* ``assumptions``: what the choices behind a scene do (``snakemake limits``)
* ``robustness``: robustness of the solver (``snakemake extremes``)
* ``study_row``: the row of a study's table, with the error to expect
* ``measured``: what they gave for the release
"""
