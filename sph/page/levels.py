"""Tables of the first screen: the results by the amplitude of shaking, and widths that most runs do not pass."""

from __future__ import annotations

from collections.abc import Sequence

import pandas as pd

from sph.checks.after_run import at_least, in_motion, is_bounded
from sph.experiments.trigger.exceedance import SHARES, width_within
from sph.figures.style import AT_LEAST, NOTHING, metres
from sph.measures.metrics import CLASSES
from sph.measures.places import places_in
from sph.page.tables import MAX_VALUES, Table
from sph.scene.units import beside_g
from sph.study.dimensions import ALTERNATIVE, AMPLITUDE, Dimension

FEWEST = 4
"""Fewest runs an amplitude whose widths are worth a row."""


def widths(table: pd.DataFrame) -> list[Table]:
    """Widths that most of the runs do not pass, a row per amplitude; none for a study without places, and for too few runs an amplitude."""
    if not places_in(table.columns) or max(len(runs) for _, runs in _groups(table)) < FEWEST:
        return []
    rows = []
    for value, runs in _groups(table):
        runouts = runs["runout"].to_numpy(float)
        bounded = bool(at_least(runs).any())
        rows.append((beside_g(value), str(len(runs)), *(metres(width_within(runouts, share), bounded) for share in SHARES)))
    head = ("shaking (m/s²)", "runs", *(f"{share:.0%} (m)" for share in SHARES))
    errors = table["expected_runout_error"].dropna()
    error = f"the spacing adds an error of up to {errors.max():.0%}" if len(errors) else "the error due to the spacing is unknown"
    note = f"All runs of the study count equally, with the soils, motions and levels chosen; {error}."
    return [Table("Run-out from the toe not exceeded by this share of the runs", head, rows, note)]


def _groups(table: pd.DataFrame) -> list[tuple[str, pd.DataFrame]]:
    """The runs of a study by the amplitude of shaking, if it has one and not too many."""
    written = list(dict.fromkeys(table[AMPLITUDE])) if AMPLITUDE in table else []
    groups = [(str(value), table[table[AMPLITUDE] == value]) for value in sorted(written, key=float)]
    return groups if 0 < len(groups) <= MAX_VALUES else [("all" if groups else "of the scene", table)]


def levels(table: pd.DataFrame, dimensions: Sequence[Dimension], probe: str, why: str = "") -> Table:
    """Class, displacement, run-out and the slip of the sliding block, least to most over the other dimensions: a row per amplitude."""
    groups = _groups(table)
    rows = []
    for value, runs in groups:
        reached = [name for name in CLASSES if (runs["collapse_class"] == name).any()] or [NOTHING]
        met = at_least(runs)
        columns = (("displacement_magnitude", met), ("runout", met), ("newmark_displacement", met & False))
        spans = [_lengths(runs[name], bounds) for name, bounds in columns]
        rows.append((beside_g(value), " to ".join(dict.fromkeys((reached[0], reached[-1]))), *spans))
    head = ("shaking (m/s²)", "class", f"displacement of {probe} (m)", "run-out (m)", "Newmark block (m)")
    of = " for the scene as it is" * (ALTERNATIVE in table)
    notes = [f"Smallest to largest value over the other dimensions of the study{of}."] if len(table) > len(groups) else []
    if table["reached_side"].map(is_bounded).any():
        notes.append(f"{AT_LEAST.strip()}: in at least one run debris reached an end of the box and would have gone further.")
    if any(map(in_motion, table.to_dict("records"))):
        notes.append(f"{AT_LEAST.strip()}: in at least one run soil still moved at the end.")
    if why:
        notes.append(f"{AT_LEAST.strip()}: debris is braked, so the value is too small: {why}.")
    if table["newmark_displacement"].notna().any():
        soft = table["findings"].str.contains("block-not-rigid").any()
        rigid = "; where the slope is not rigid, the slip of the block is not an upper bound" if soft else ""
        notes.append(f"The Newmark block is rigid and uses the yield acceleration by SPH{rigid}.")
    return Table("By the amplitude of shaking", head, rows, " ".join(notes))


def _lengths(values: pd.Series, bounds: pd.Series) -> str:
    """The smallest to the largest of some lengths in m, some of which are lower bounds."""
    values = values.dropna()
    if values.empty:
        return NOTHING
    low, high = values.min(), values.max()
    ends = ((low, bounds[values.index][values == low].all()), (high, bounds.any()))
    return " to ".join(dict.fromkeys(metres(end, bool(bound)) for end, bound in ends))
