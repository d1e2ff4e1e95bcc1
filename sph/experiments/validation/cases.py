"""The cases: what is measured and drawn for each."""

from __future__ import annotations

from sph.experiments.validation import columns, conservation, elements, flows, rods, slopes, slow_sine, solids, wet_column
from sph.experiments.validation.level import Draw, Measure

CASES: dict[str, tuple[Measure, Draw]] = {
    "V1": (columns.measure_gravity_column, columns.draw_gravity_column),
    "V2": (columns.measure_waves, columns.draw_waves),
    "V3": (columns.measure_shear_column, columns.draw_shear_column),
    "V4": (solids.measure_plate, solids.draw_plate),
    "V5": (solids.measure_rings, solids.draw_rings),
    "V6": (flows.measure_poiseuille, flows.draw_poiseuille),
    "V7": (flows.measure_slump, flows.draw_slump),
    "V8": (flows.measure_granular_column, flows.draw_granular_column),
    "V9": (slopes.measure_search, slopes.draw_search),
    "V10": (slopes.measure_limits, slopes.draw_limits),
    "V11": (elements.measure_newmark, elements.draw_newmark),
    "V12": (solids.measure_incline, solids.draw_incline),
    "V13": (elements.measure_simple_shear, elements.draw_simple_shear),
    "V14": (elements.measure_return, elements.draw_return),
    "V15": (conservation.measure_conservation, conservation.draw_conservation),
    "V16": (slopes.measure_drawdown, slopes.draw_drawdown),
    "V17": (slopes.measure_limits, slopes.draw_limits),
    "V18": (slopes.measure_limits, slopes.draw_limits),
    "V19": (slopes.measure_limits, slopes.draw_limits),
    "V20": (wet_column.measure_wet_columns, wet_column.draw_wet_columns),
    "V21": (slopes.measure_limits, slopes.draw_limits),
    "V22": (slopes.measure_seismic, slopes.draw_seismic),
    "V23": (rods.measure_rods, rods.draw_rods),
    "V24": (slow_sine.measure_slow_sine, slow_sine.draw_slow_sine),
    "V25": (flows.measure_incline, flows.draw_incline),
}
PROBES = {"V2": 2, "V3": 1, "V4": 1}
"""Probes that a case measures at: the first of its scenes."""
