"""A study: one scene with some of its keys varied.

* ``plan``: the study and its runs; ``dimensions``, ``sampling``: what is varied; ``stages``: what runs share
* ``tables``: the table and the dataset of a study, and their files; ``baseline``: the sliding block beside every run
* ``planned``: scenes as jobs are given them, and what a file is held against
* ``cost``: what a scene asks of a machine; ``machine``: the machine that a cost was measured on
"""
