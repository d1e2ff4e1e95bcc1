"""Critical amplitudes of this release with strength that is lost by slip: against the spacing, and with choices that should not matter.

``python -m tools.levels`` writes ``slip_levels.csv`` of the package from the searches that lie in ``results``.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import pandas as pd

from sph.storage.trajectory import Variable
from sph.study.tables import number_column, read_csv, text_column, write_csv
from tools.shipped import MEASURED, SHIPPED, note, solver_of

STUDIES = ("slope_on_rock", "stiff_clay", "stiff_clay_choices")
"""Studies whose searches are kept."""
SLIP = "coupling.softening.slip_at_residual"
LEVELS: tuple[Variable, ...] = (
    text_column("study", "name of the study"),
    text_column("case", "case of its search"),
    number_column("S_R", "1", "strength ratio; NaN where the search does not vary it"),
    number_column("slip_at_residual", "m", "slip at the residual strength; NaN where the search does not vary it"),
    number_column("lower", "m s-2", "largest amplitude without collapse"),
    number_column("upper", "m s-2", "smallest amplitude with collapse"),
)
"""Columns of the table."""


def levels(results: Path) -> pd.DataFrame:
    """Brackets of the critical amplitude from a folder of results, columns ``LEVELS``; ValueError names a search that is missing."""
    tables = []
    for study in STUDIES:
        searches: Sequence[Path] = sorted((results / study).glob("*/trigger/trigger.csv"))
        if len(searches) != 1:
            raise ValueError(f"{results / study}: {len(searches)} searches, one is needed; run '{SHIPPED['slip_levels'].renewal}'")
        table = pd.read_csv(searches[0])
        tables.append(table.assign(study=study, slip_at_residual=table.get(SLIP, float("nan")), S_R=table.get("S_R", float("nan"))))
    return pd.concat(tables, ignore_index=True)[[row.name for row in LEVELS]]


def read_levels(path: Path = MEASURED / "slip_levels.csv") -> pd.DataFrame:
    """The table of this release; ValueError where the file is none."""
    return read_csv(path, LEVELS, "the critical amplitudes of a release")


if __name__ == "__main__":
    write_csv(levels(Path("results")), SHIPPED["slip_levels"].path)
    note("slip_levels", solver_of(SHIPPED["slip_levels"].runs))
    print(SHIPPED["slip_levels"].path)
