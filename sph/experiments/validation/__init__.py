"""Reference cases: problems with a known answer, run by the solver that runs the studies (``snakemake --cores 2 validation``).

* ``design``: which runs the cases need and what is asked of them (config/validation.yaml)
* ``level``: what a case measures on
* ``columns``: V1 gravity column, V2 waves, V3 shear column
* ``solids``: V4 plate, V5 rings, V12 block on an incline
* ``flows``: V6 Bingham channel, V7 Bingham slump, V8 granular column, V25 Bingham layer on an incline
* ``rods``: V23 a column of rods, point by point
* ``slopes``: V9 factor of safety, V10 critical strength ratio of the paper's slope, V16 drawdown and a chart, V17 and V18 both
  against limit analysis, V19 infinite slopes, V21 with water, V22 critical seismic coefficients
* ``slow_sine``: V24 the dynamic counterpart of V22
* ``wet_column``: V20 columns with water
* ``elements``: V11 Newmark block, V13 simple shear, V14 Mohr-Coulomb return
* ``conservation``: V15 momentum and energy
* ``cases``: what is measured and drawn for every case
* ``measure``: errors, orders of convergence, verdicts; ``book``: a page per case

A case's measure takes the results of one level and gives numbers beside their references; its picture shows all levels.
"""
