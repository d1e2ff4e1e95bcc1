"""Analysis of trajectories: from runs to numbers, tables, verdicts and figures.

* ``fields``: quantities of one frame or one probe that metrics and figures share
* ``metrics``: the numbers of one run; every definition is written there, once, in ``METRICS``
* ``tables``: the table and the dataset of a study, and their files
* ``trade``, ``trade_table``, ``advice``, ``convergence``, ``machine``: the ladder: its runs, its table, what that answers,
  the order of convergence, and where it was timed
* ``claims``: the paper's twelve claims, decided by numbers
* ``figures``: Figs. 1-7 and the plot of one trajectory

Nothing here runs or changes a simulation, and the solver does not import it.
"""
