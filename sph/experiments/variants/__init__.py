"""A scene in variants: keys changed one at a time or in a list, each measured in some cases and, where there is one, against a reference.

* ``design``: the configurations and their runs
* ``cost_accuracy``: what each saving of computing time costs in accuracy; ``convergence`` with the spacing, and what
  follows for a scene that is like the measured one: ``advice``, ``likeness``
* ``assumptions``: what the choices behind a scene do
* ``robustness``: how runs behave at the ends of the keys' ranges
* ``second_spacing``: what other particles change in the runs of a study
"""
