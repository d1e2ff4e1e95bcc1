"""Reference cases: problems with a known answer, run by the solver that runs the studies (``snakemake --cores 2 validation``).

* ``suite``: which runs the cases need and what is asked of them (config/validation.yaml)
* ``level``: what a case measures on
* ``columns``: V1 gravity column, V2 waves, V3 shear column
* ``solids``: V4 plate, V5 rings, V12 block on an incline
* ``flows``: V6 Bingham channel, V7 Bingham slump, V8 granular column
* ``slopes``: V9 factor of safety, V10 critical strength ratio of the paper's slope, V16 drawdown and a chart, V17 and V18 both
  against limit analysis, V19 infinite slopes, V21 with water, V22 critical seismic coefficients
* ``wet_column``: V20 columns with water
* ``elements``: V11 Newmark block, V13 simple shear, V14 Mohr-Coulomb return
* ``conservation``: V15 momentum and energy
* ``table``: errors, orders of convergence, verdicts

A case's measure takes the results of one level and gives numbers beside their references; its picture shows all levels.
"""

from __future__ import annotations

from sph.validation.columns import (
    draw_gravity_column,
    draw_shear_column,
    draw_waves,
    measure_gravity_column,
    measure_shear_column,
    measure_waves,
)
from sph.validation.conservation import draw_conservation, measure_conservation
from sph.validation.elements import (
    draw_newmark,
    draw_return,
    draw_simple_shear,
    measure_newmark,
    measure_return,
    measure_simple_shear,
)
from sph.validation.flows import (
    draw_granular_column,
    draw_poiseuille,
    draw_slump,
    measure_granular_column,
    measure_poiseuille,
    measure_slump,
)
from sph.validation.level import Draw, Measure
from sph.validation.slopes import (
    draw_drawdown,
    draw_limits,
    draw_search,
    draw_seismic,
    measure_drawdown,
    measure_limits,
    measure_search,
    measure_seismic,
)
from sph.validation.solids import draw_incline, draw_plate, draw_rings, measure_incline, measure_plate, measure_rings
from sph.validation.wet_column import draw_wet_columns, measure_wet_columns

CASES: dict[str, tuple[Measure, Draw]] = {
    "V1": (measure_gravity_column, draw_gravity_column),
    "V2": (measure_waves, draw_waves),
    "V3": (measure_shear_column, draw_shear_column),
    "V4": (measure_plate, draw_plate),
    "V5": (measure_rings, draw_rings),
    "V6": (measure_poiseuille, draw_poiseuille),
    "V7": (measure_slump, draw_slump),
    "V8": (measure_granular_column, draw_granular_column),
    "V9": (measure_search, draw_search),
    "V10": (measure_limits, draw_limits),
    "V11": (measure_newmark, draw_newmark),
    "V12": (measure_incline, draw_incline),
    "V13": (measure_simple_shear, draw_simple_shear),
    "V14": (measure_return, draw_return),
    "V15": (measure_conservation, draw_conservation),
    "V16": (measure_drawdown, draw_drawdown),
    "V17": (measure_limits, draw_limits),
    "V18": (measure_limits, draw_limits),
    "V19": (measure_limits, draw_limits),
    "V20": (measure_wet_columns, draw_wet_columns),
    "V21": (measure_limits, draw_limits),
    "V22": (measure_seismic, draw_seismic),
}
"""What is measured and drawn for every case."""
PROBES = {"V2": 2, "V3": 1, "V4": 1}
"""Probes that a case measures at: the first of its scenes."""
