"""Reference cases: problems with a known answer, run by the solver that runs the studies (``snakemake --cores 2 validation``).

A case (``case``) is an object with its set-up, its exact solution, its tolerances and its source.  pytest runs it on its coarsest level
(``tests/validation``), the workflow on all of them, for the table and the verification book (``suite``, ``book``).

* ``columns``: V1 gravity column, V2 waves, V3 shear column; ``wet_column``: V20 columns with water
* ``solids``: V4 plate, V5 rings, V12 block on an incline; ``conservation``: V15 momentum and energy
* ``flows``: V6 Bingham channel, V7 Bingham slump, V8 granular column, V25 Bingham layer on an incline; ``rods``: V23 rods point by point
* ``elements``: V11 Newmark block, V13 simple shear, V14 Mohr-Coulomb return
* ``slopes``: V9 factor of safety, V10 critical strength ratio of the paper's slope, V16 drawdown and a chart, V17 and V18 both
  against limit analysis (``limit_analysis``), V19 infinite slopes, V21 with water, V22 critical seismic coefficients
* ``slow_sine``: V24 the dynamic counterpart of V22

Tolerances are on the finest level and were written, with their reasons, before any of these runs was looked at, but for the tighter ones
that V7 got with its no-slip wall and V9 and V10 with the extrapolation, and V19; those of the coarsest level are what the tests ask.  They
follow from what the reference is worth: per cent for a closed form, the few per cent between published solutions for a computed reference,
tens of per cent for the scaling of an experiment.  What was added after a result had been seen says so.
"""

from cases import columns, conservation, elements, flows, rods, slopes, slow_sine, solids, wet_column
from cases.case import Case

MODULES = (columns, conservation, elements, flows, rods, slopes, slow_sine, solids, wet_column)
CASES: dict[str, Case] = {
    name: case
    for name, case in sorted(
        ((name, case) for module in MODULES for name, case in vars(module).items() if isinstance(case, Case)),
        key=lambda found: int(found[0].removeprefix("V")),
    )
}
"""By name, in order."""
