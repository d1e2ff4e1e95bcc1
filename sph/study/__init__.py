"""A study: one scene with some of its keys varied.

* ``schema``: its keys; ``plan``: its runs and their files; ``dimensions``, ``sampling``: what is varied; ``stages``: what runs share
* ``searches``: the limits of its slopes
* ``tables``: the table and the dataset of a study, and their files; ``baseline``: the sliding block beside every run
* ``planned``: scenes as jobs are given them, with which files are compared
* ``cost``: what a scene needs; ``machine``: the machine that a cost was measured on
"""
