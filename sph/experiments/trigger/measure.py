"""The searches for critical intensities: rounds, brackets and their confirmation, fragility and maps."""

from __future__ import annotations

import functools
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import pandas as pd
import xarray as xr
from matplotlib.figure import Figure

from sph.experiments.steps import Runs, Step
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
from sph.experiments.trigger.design import Lattice, Searched, TriggerPlan
from sph.experiments.trigger.efficiency import measures_table, motion_measures
from sph.experiments.trigger.exceedance import exceedance, widths
from sph.experiments.trigger.figures import MAPS, figure_critical
from sph.experiments.trigger.figures_fragility import figure_fragility
from sph.experiments.trigger.figures_reach import figure_reach
from sph.experiments.trigger.fragility import fragility
from sph.experiments.trigger.hazard import Hazard, read_hazard
from sph.experiments.trigger.maps import class_shares, map_cells, read_shares
from sph.experiments.trigger.points import Key, measured_points, no_points, read_points, read_wanted, wanted_points
from sph.measures.metrics import MetricSettings, measure
from sph.scene.schema import Scene
from sph.study.planned import Planned
from sph.study.searches import SlopeSearch, slope_searches, yield_accelerations
from sph.study.tables import flat_dataset

Settings = Mapping[str, Any]


def want_points(lattices: Sequence[Settings], classes: Sequence[str], number: int, points: pd.DataFrame | None = None) -> pd.DataFrame:
    """Corners of the cells divided ``number`` times that are not among the points of earlier rounds."""
    return wanted_points([Lattice(**data) for data in lattices], no_points() if points is None else points, classes, number)


def measure_points(wanted: pd.DataFrame, settings: Settings, runs: Runs, points: pd.DataFrame | None = None) -> pd.DataFrame:
    """The points of a round with the metrics of its runs, in their order, after those of the rounds before it."""
    chosen = MetricSettings(**settings)
    return measured_points(no_points() if points is None else points, wanted, [measure(run, chosen) for run in runs], chosen.places)


def searched_points(points: pd.DataFrame) -> pd.DataFrame:
    """All points of a search: those of its last round."""
    return points


def trigger_table(
    points: pd.DataFrame,
    searches: Mapping[Key, SlopeSearch],
    scenes: Mapping[Key, Planned],
    classes: Sequence[str],
    settings: Settings,
    searched: Searched,
    highest: float,
    facts: Mapping[str, str],
) -> tuple[xr.Dataset, pd.DataFrame]:
    """Critical intensity of every case, value of the other dimensions and class: the bracket that the search left, with the pseudo-static
    estimate and that of a sliding block. Every column is defined in docs/reference/files.md.

    By case and these values: the ``scenes``, shaken at the ``highest`` intensity, and the ``searches`` for their yield accelerations.
    """
    built = {at: scene.build() for at, scene in scenes.items()}
    estimates = block_estimates(built, yield_accelerations(searches), classes, MetricSettings(**settings), searched, highest)
    first = {at[0]: scene for at, scene in reversed(built.items())}
    table = critical_table(points, classes, estimates, searched, coarser_cases(first))
    return flat_dataset(table, critical_columns(searched), facts), table


def fragility_table(critical: pd.DataFrame, searched: Searched, note: str) -> tuple[pd.DataFrame, pd.DataFrame, Figure]:
    """Probability that the slope reaches a class at an intensity, over the motions of the search: lognormal fits to the brackets, with
    intervals, and the number of motions that never reach the class, diverged or are not monotone. Every column is defined in
    docs/reference/files.md.
    """
    fits, curves = fragility(critical, searched.intensity.shown_unit)
    return fits, curves, figure_fragility(critical, fits, curves, searched, note)


def fragility_measures(
    critical: pd.DataFrame, scenes: Mapping[Key, Planned], periods: Sequence[float], highest: float, searched: Searched
) -> pd.DataFrame:
    """Fragility in other measures of the shaking than the intensity that is searched, the most efficient first. Every column is defined in
    docs/reference/files.md.

    From the scenes shaken at the ``highest`` intensity.
    """
    motions = {at: motion_measures(scene.build(), periods) for at, scene in scenes.items()}
    return measures_table(critical, motions, highest, searched)


def fragility_annual(critical: pd.DataFrame, hazard: Hazard, span: tuple[float, float], searched: Searched) -> pd.DataFrame:
    """How often a year each class is reached, from the fragility and the hazard of the site, of a search between the ends of a span of
    intensities. Every column is defined in docs/reference/files.md.
    """
    return annual_table(critical, hazard, *span, searched.intensity.shown_unit)


def reach(points: pd.DataFrame, scenes: Mapping[Key, Planned], searched: Searched, note: str) -> tuple[pd.DataFrame, pd.DataFrame, Figure]:
    """Share of the motions whose run-out or displacement exceeds a length, at every intensity at which all motions were run; a diverged run
    counts in the upper share only. Every column is defined in docs/reference/files.md.

    The figure has the section of the cases whose scenes, by case and other values, have one ground.
    """
    table = exceedance(points, searched)
    by_case: dict[str, list[Scene]] = {}
    for (case, *_), scene in scenes.items():
        by_case.setdefault(case, []).append(scene.build())
    of_one_ground = {case: built[0] for case, built in by_case.items() if all(each.geometry == built[0].geometry for each in built)}
    return table, widths(points, searched), figure_reach(table, searched, of_one_ground, note)


def want_confirmation(critical: pd.DataFrame, points: pd.DataFrame, confirm: Settings, searched: Searched) -> pd.DataFrame:
    """The ends that exist of the brackets of a class, for chosen cases and values."""
    return bracket_ends(critical, points, confirm["collapse_class"], confirm["cases"], confirm["at"], searched)


def confirm_ends(ends: pd.DataFrame, points: pd.DataFrame, settings: Settings, searched: Searched, runs: Runs) -> pd.DataFrame:
    """The ends of brackets run again at another fidelity: class, displacement of A and run-out at both, and their differences."""
    return confirm_table(ends, points, [measure(run, MetricSettings(**settings)) for run in runs], searched)


def map_tables(
    points: pd.DataFrame, lattices: Sequence[Settings], classes: Sequence[str], levels: int, searched: Searched
) -> tuple[pd.DataFrame, pd.DataFrame]:
    """Share of the values searched, on their scales, with which a class or a worse one is reached: its lower and its upper bound over
    intervals of the intensity. It is not a probability, neither of soils nor of ground motions.
    """
    cells = map_cells([Lattice(**data) for data in lattices], points, classes, levels, searched)
    return cells, class_shares(cells, searched)


def draw_trigger(critical: pd.DataFrame, searched: Searched, note: str) -> Figure:
    """Critical intensity of the shaking. A point is the middle of a bracket, a bar the bracket. Hollow arrows: the class is reached at the
    lowest intensity (down), or not reached at the highest (up), and there is no bracket. A ring marks a bracket with a diverged run inside
    or with a second change of class above. Lines: the yield acceleration of a pseudo-static search, and the intensity at which a rigid
    block with that yield acceleration slips by the displacement at which the class begins.
    """
    return figure_critical(critical, searched, note)


def draw_map(name: str, searched: Searched, note: str, **tables: pd.DataFrame) -> Figure:
    """Map over a dimension of the search and the intensity, linear between the runs (dots); for the class, between its ranks. Crosses are
    runs that diverged and have no value.
    """
    (table,) = tables.values()
    return MAPS[name][1](table, searched, note)


def draw_shares(shares: pd.DataFrame, searched: Searched, note: str) -> Figure:
    """Share of the values searched, on their scales, with which a class or a worse one is reached, against the intensity. The band lies
    between the lower and the upper bound that the runs leave. It is a share of parameter values, not a probability of a ground motion.
    """
    return MAPS["shares"][1](shares, searched, note)


def _brackets(design: TriggerPlan) -> dict[str, Any]:
    return {"searched": design.dimensions, "note": f"{design.note()} · brackets to {design.tolerance}"}


def _all_points(search: str, table: str) -> Step:
    return Step(f"{search}_points", searched_points, writes={table: ""}, needs=lambda design: {"points": design.points(search)})


def _earlier(design: TriggerPlan, search: str, round: str) -> dict[str, str | list[str]]:
    """The points of the round before one, if there is one."""
    return {"points": design.points(search, int(round) - 1) if int(round) else []}


WANTED, MEASURED, ENDS = "rounds/{search}-{round}-wanted.csv", "rounds/{search}-{round}-points.csv", "rounds/confirm-wanted.csv"
READERS: dict[str, Callable[[str, Mapping[str, Any]], Any]] = {
    "points": lambda path, given: read_points(path),
    "wanted": lambda path, given: read_wanted(path),
    "critical": lambda path, given: read_critical(path),
    "ends": lambda path, given: read_ends(path),
    "shares": lambda path, given: read_shares(path),
    "hazard": lambda path, given: read_hazard(path, given["searched"].intensity_name),
}
STEPS = (
    Step(
        "want_points",
        want_points,
        writes={WANTED: ""},
        given=lambda design, search, round: {
            "lattices": [lattice.model_dump() for lattice in design.lattices(search)],
            "classes": design.classes(search),
            "number": int(round),
        },
        needs=_earlier,
        decides=True,
    ),
    Step(
        "measure_points",
        measure_points,
        {"wanted": WANTED},
        {MEASURED: ""},
        needs=_earlier,
        runs=lambda design, search, round: design.wanted(design.file(WANTED, search=search, round=round)),
        after=lambda design, **at: "want_points",
    ),
    _all_points("trigger", "points.csv"),
    _all_points("maps", "maps.csv"),
    Step(
        "trigger_table",
        trigger_table,
        {"points": "points.csv"},
        {"trigger.nc": "", "trigger.csv": "critical intensities"},
        lambda design: {
            "searches": slope_searches(design.searches),
            "scenes": design.shaken,
            "classes": design.classes("trigger"),
            "searched": design.dimensions,
            "highest": design.trigger.intensity.highest,
            "facts": design.facts,
        },
        lambda design: {"yields": sorted({search.file for search in design.searches.values()})},
        searches=True,
    ),
    Step("trigger_figure", draw_trigger, {"critical": "trigger.csv"}, {"figures/trigger": "figure"}, _brackets),
    Step(
        "fragility_table",
        fragility_table,
        {"critical": "trigger.csv"},
        {"fragility_fit.csv": "fits", "fragility_curves.csv": "", "figures/fragility": "figure of the fragility"},
        _brackets,
    ),
    Step(
        "fragility_measures",
        fragility_measures,
        {"critical": "trigger.csv"},
        {"fragility_measures.csv": "measures of the shaking"},
        lambda design: {
            "scenes": design.shaken,
            "periods": design.trigger.periods,
            "highest": design.trigger.intensity.highest,
            "searched": design.dimensions,
        },
    ),
    Step(
        "fragility_annual",
        fragility_annual,
        {"critical": "trigger.csv"},
        {"fragility_annual.csv": "annual frequencies"},
        lambda design: {"span": (design.trigger.intensity.lowest, design.trigger.intensity.highest), "searched": design.dimensions},
        lambda design: {"hazard": design.hazard_file},
    ),
    Step(
        "exceedance",
        reach,
        {"points": "points.csv"},
        {
            "exceedance.csv": "exceedance of run-out and displacement",
            "widths.csv": "widths that debris does not pass",
            "figures/exceedance": "figure of the exceedance",
        },
        lambda design: {"scenes": design.shaken, "searched": design.dimensions, "note": design.note()},
    ),
    Step(
        "want_confirmation",
        want_confirmation,
        {"critical": "trigger.csv", "points": "points.csv"},
        {ENDS: ""},
        lambda design: {"confirm": design.confirm, "searched": design.dimensions},
        decides=True,
    ),
    Step(
        "confirm_table",
        confirm_ends,
        {"points": "points.csv", "ends": ENDS},
        {"confirm.csv": "confirmed brackets"},
        lambda design: {"searched": design.dimensions},
        runs=lambda design: design.wanted(design.file(ENDS), design.confirm["fidelity"]),
        after=lambda design: "want_confirmation",
    ),
    Step(
        "map_tables",
        map_tables,
        {"points": "maps.csv"},
        {"cells.csv": "", "shares.csv": "shares of each class"},
        lambda design: {
            "lattices": [lattice.model_dump() for lattice in design.lattices("maps")],
            "classes": design.classes("maps"),
            "levels": design.levels("maps"),
            "searched": design.dimensions,
        },
    ),
    Step(
        "map_figure_shares",
        draw_shares,
        {"shares": "shares.csv"},
        {"figures/shares": "figure of the shares"},
        lambda design: {"searched": design.dimensions, "note": design.note("maps")},
    ),
    *(
        Step(
            f"map_figure_{name.replace('-', '_')}",
            functools.partial(draw_map, name),
            {"points": "maps.csv"},
            {f"figures/{name}": f"figure {name}"},
            lambda design: {"searched": design.dimensions, "note": design.note("maps")},
        )
        for name in MAPS
        if name != "shares"
    ),
)
"""The jobs of the searches."""
