"""Metrics and fields of a trajectory.

* ``metrics``: the numbers of one run; every definition is written there, once, in ``METRICS``
* ``fields``: quantities of one frame or one probe that metrics and figures share
"""
