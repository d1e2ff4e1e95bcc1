"""The jobs of the searches for critical intensities: rounds, brackets and their confirmation, fragility and maps.

Tables are given as the paths of their files; the rules are in ``workflow/rules/trigger.smk``.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import pandas as pd
import xarray as xr
from matplotlib.figure import Figure

from sph.experiments.study_row import measured
from sph.experiments.trigger.annual import annual_table
from sph.experiments.trigger.critical import (
    block_estimates,
    bracket_ends,
    coarser_cases,
    confirm_table,
    critical_columns,
    critical_table,
    read_critical,
    read_ends,
)
from sph.experiments.trigger.design import Lattice, Searched
from sph.experiments.trigger.efficiency import measures_table, motion_measures
from sph.experiments.trigger.exceedance import exceedance, widths
from sph.experiments.trigger.figures import MAPPED, figure_class_map, figure_critical, figure_map, figure_shares
from sph.experiments.trigger.figures_fragility import figure_fragility
from sph.experiments.trigger.figures_reach import figure_reach
from sph.experiments.trigger.fragility import fragility
from sph.experiments.trigger.hazard import read_hazard
from sph.experiments.trigger.maps import class_shares, map_cells, read_shares
from sph.experiments.trigger.points import Key, measured_points, no_points, read_points, read_wanted, wanted_points
from sph.measures.metrics import MetricSettings
from sph.output.run import Run
from sph.scene.schema import Scene
from sph.study.planned import Planned
from sph.study.searches import SlopeSearch, yield_accelerations
from sph.study.tables import flat_dataset

Runs = Mapping[Any, Run]


def want_points(lattices: Sequence[Lattice], classes: Sequence[str], number: int, points: str = "") -> pd.DataFrame:
    """Corners of the cells divided ``number`` times that are not among the points of earlier rounds."""
    return wanted_points(lattices, read_points(points) if points else no_points(), classes, number)


def measure_points(wanted: str, settings: MetricSettings, runs: Runs, points: str = "") -> pd.DataFrame:
    """The points of a round with the metrics of its runs, in their order, after those of the rounds before it."""
    earlier, metrics = read_points(points) if points else no_points(), [measured(run, settings) for run in runs.values()]
    return measured_points(earlier, read_wanted(wanted), metrics, settings.places)


def searched_points(points: str) -> pd.DataFrame:
    """All points of a search: those of its last round."""
    return read_points(points)


def trigger_table(
    points: str,
    searches: Mapping[Key, SlopeSearch],
    scenes: Mapping[Key, Planned],
    classes: Sequence[str],
    settings: MetricSettings,
    searched: Searched,
    highest: float,
    facts: Mapping[str, str],
) -> tuple[xr.Dataset, pd.DataFrame]:
    """Critical intensity of every case, value of the other dimensions and class: the bracket that the search left, with the pseudo-static
    estimate and that of a sliding block. Every column is defined in docs/reference/files.md.

    By case and these values: the ``scenes``, shaken at the ``highest`` intensity, and the ``searches`` for their yield accelerations.
    """
    built = {at: scene.build() for at, scene in scenes.items()}
    estimates = block_estimates(built, yield_accelerations(searches), classes, settings, searched, highest)
    first = {at[0]: scene for at, scene in reversed(built.items())}
    table = critical_table(read_points(points), classes, estimates, searched, coarser_cases(first))
    return flat_dataset(table, critical_columns(searched), facts), table


def fragility_table(critical: str, searched: Searched, note: str) -> tuple[pd.DataFrame, pd.DataFrame, Figure]:
    """Probability that the slope reaches a class at an intensity, over the motions of the search: lognormal fits to the brackets, with
    intervals, and the number of motions that never reach the class, diverged, are braked or are not monotone. Every column is defined in
    docs/reference/files.md.
    """
    brackets = read_critical(critical)
    fits, curves = fragility(brackets, searched.intensity.shown_unit)
    return fits, curves, figure_fragility(brackets, fits, curves, searched, note)


def fragility_measures(
    critical: str, scenes: Mapping[Key, Planned], periods: Sequence[float], highest: float, searched: Searched
) -> pd.DataFrame:
    """Fragility in other measures of the shaking than the intensity that is searched, the most efficient first. Every column is defined in
    docs/reference/files.md.

    From the scenes shaken at the ``highest`` intensity.
    """
    motions = {at: motion_measures(scene.build(), periods) for at, scene in scenes.items()}
    return measures_table(read_critical(critical), motions, highest, searched)


def fragility_annual(critical: str, hazard: str, span: tuple[float, float], searched: Searched) -> pd.DataFrame:
    """How often a year each class is reached, from the fragility and the hazard of the site, of a search between the ends of a span of
    intensities. Every column is defined in docs/reference/files.md.
    """
    curve = read_hazard(hazard, searched.intensity_name)
    return annual_table(read_critical(critical), curve, *span, searched.intensity.shown_unit)


def reach(points: str, scenes: Mapping[Key, Planned], searched: Searched, note: str) -> tuple[pd.DataFrame, pd.DataFrame, Figure]:
    """Share of the motions whose run-out or displacement exceeds a length, at every intensity at which all motions were run; a diverged
    run, and one whose debris is braked before that length, count in the upper share only. Every column is defined in
    docs/reference/files.md.

    The figure has the section of the cases whose scenes, by case and other values, have one ground.
    """
    of_all = read_points(points)
    table = exceedance(of_all, searched)
    by_case: dict[str, list[Scene]] = {}
    for (case, *_), scene in scenes.items():
        by_case.setdefault(case, []).append(scene.build())
    of_one_ground = {case: built[0] for case, built in by_case.items() if all(each.geometry == built[0].geometry for each in built)}
    return table, widths(of_all, searched), figure_reach(table, searched, of_one_ground, note)


def want_confirmation(critical: str, points: str, confirm: Mapping[str, Any], searched: Searched) -> pd.DataFrame:
    """The ends that exist of the brackets of a class, for chosen cases and values."""
    chosen = confirm["collapse_class"], confirm["cases"], confirm["at"]
    return bracket_ends(read_critical(critical), read_points(points), *chosen, searched)


def confirm_ends(ends: str, points: str, settings: MetricSettings, searched: Searched, runs: Runs) -> pd.DataFrame:
    """The ends of brackets run again at another fidelity: class, displacement of A and run-out at both, and their differences."""
    return confirm_table(read_ends(ends), read_points(points), [measured(run, settings) for run in runs.values()], searched)


def map_tables(
    points: str, lattices: Sequence[Lattice], classes: Sequence[str], levels: int, searched: Searched
) -> tuple[pd.DataFrame, pd.DataFrame]:
    """Share of the values searched, on their scales, with which a class or a worse one is reached: its lower and its upper bound over
    intervals of the intensity. It is not a probability, neither of soils nor of ground motions.
    """
    cells = map_cells(lattices, read_points(points), classes, levels, searched)
    return cells, class_shares(cells, searched)


def draw_trigger(critical: str, searched: Searched, note: str) -> Figure:
    """Critical intensity of the shaking. A point is the middle of a bracket, a bar the bracket. Hollow arrows: the class is reached at the
    lowest intensity (down), or not reached at the highest (up), and there is no bracket. A ring marks a bracket with a diverged run inside
    or with a second change of class above. Lines: the yield acceleration of a pseudo-static search, and the intensity at which a rigid
    block with that yield acceleration slips by the displacement at which the class begins.
    """
    return figure_critical(read_critical(critical), searched, note)


def draw_map(points: str, name: str, searched: Searched, note: str) -> Figure:
    """Map over a dimension of the search and the intensity, linear between the runs (dots); for the class, between its ranks. Crosses are
    runs that diverged and have no value.
    """
    table = read_points(points)
    return figure_map(table, searched, MAPPED[name], note) if name in MAPPED else figure_class_map(table, searched, note)


def draw_shares(shares: str, searched: Searched, note: str) -> Figure:
    """Share of the values searched, on their scales, with which a class or a worse one is reached, against the intensity. The band lies
    between the lower and the upper bound that the runs leave. It is a share of parameter values, not a probability of a ground motion.
    """
    return figure_shares(read_shares(shares), searched, note)
