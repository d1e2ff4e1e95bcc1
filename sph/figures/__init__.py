"""Figures of studies and the plot of one trajectory; a function draws, it does not derive quantities.

Those of an experiment are in its folder.

* ``arrangement``: the input: geometry, motion, initial particles
* ``mobilised``: how near to its strength soil is before the shaking
* ``profile``: particles of a frame, drawn to size
* ``history``: motion of a probe against time
* ``overview``: one trajectory at a chosen time (``sph plot``)
* ``film``: one trajectory through time (``sph animate``)
* ``scene``: a scene before it is run (``sph check``)
* ``study``: a study of any dimensions: curves and a map
* ``labels``: names at places of a section, kept apart
* ``style``: sizes, fonts, colours, the note on every figure, saving
"""

from __future__ import annotations

import inspect
from collections.abc import Callable
from typing import Any

from matplotlib.figure import Figure

from sph.figures.arrangement import figure_arrangement, figure_geometry, figure_motion
from sph.figures.mobilised import figure_mobilised
from sph.figures.overview import plot_trajectory
from sph.figures.profile import figure_displaced, figure_profiles
from sph.figures.study import figure_map, figure_study
from sph.figures.style import save
from sph.study.schema import INPUT_FIGURES, MOBILISED, PROFILES

__all__ = [
    "MARKED",
    "RUN_FIGURES",
    "STUDY_FIGURES",
    "caption",
    "figure_displaced",
    "figure_arrangement",
    "figure_geometry",
    "figure_map",
    "figure_mobilised",
    "figure_motion",
    "figure_profiles",
    "figure_study",
    "plot_trajectory",
    "save",
]

RUN_FIGURES: dict[str, Callable[..., Figure]] = {
    **dict(zip(INPUT_FIGURES, (figure_geometry, figure_motion, figure_arrangement), strict=True)),
    MOBILISED: figure_mobilised,
    PROFILES: figure_displaced,
}
"""Figures of one run or of some, by the names of their files: functions of the run, or of runs by title, and the fidelity."""
STUDY_FIGURES: dict[str, Callable[..., Figure]] = {"study": figure_study, "map": figure_map}
"""Figures of all runs of a study, by the names of their files: functions of its table, its dimensions, the probe and the note."""
MARKED = {INPUT_FIGURES[0]: ("places",), INPUT_FIGURES[1]: ("others",), PROFILES: ("places", "field", "choice")}
"""What figures of runs take from their study beside these, by name: places to mark, how other runs are shaken, the quantity to
show, which runs these are."""


def caption(figure: Callable[..., Any]) -> str:
    """Caption of a figure for a report: the first paragraph of its function's docstring, on one line."""
    return " ".join((inspect.getdoc(figure) or "").split("\n\n")[0].split())
