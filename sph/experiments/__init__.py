"""Experiments: sets of runs designed to answer one question, and what they answer.

* ``variants``: a scene with keys changed, for ``snakemake cost-accuracy``, ``resolution``, ``assumptions``, ``robustness`` and ``spacing``
* ``trigger``: the shaking at which a slope fails, and maps around it (``snakemake trigger``, ``fragility``, ``maps``, ``confirm``)
* ``sensitivity``: which parameters decide the results (``snakemake sensitivity``, ``back_analysis``)
* ``paper``: the source paper's study, its claims and figures
* ``registry``: lists them, and reads the configuration of a study
* ``base``: what one is, keys, names of files, the check of every scene before any work
* ``study_row``: the row of a study's table, with the error to expect
* ``measured``: what they gave for the release
"""
