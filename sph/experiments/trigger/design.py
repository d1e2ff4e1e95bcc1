"""The shaking that triggers failure (``config/trigger.yaml``, ``snakemake trigger`` and ``snakemake maps``): what is searched, and where.

A *case* lays scene keys over the study's scene; its runs share gravity stage and pre-failure runs with each other and, where the case
changes nothing and the study has the same dimensions, with the study.  A *lattice* is what one search refines: intensities of the
shaking at one value of every other dimension (``trigger``), or the others together with the intensity (``maps``).  All have their
intensities on one dyadic lattice, so that they share pre-failure runs and runs.
"""

from __future__ import annotations

import functools
import itertools
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import pandas as pd

from sph.experiments.base import Experiment, file_name
from sph.experiments.trigger.boundaries import place_of
from sph.experiments.trigger.hazard import Hazard, read_hazard
from sph.experiments.trigger.refinement import Place, Span
from sph.experiments.trigger.schema import Maps, Trigger
from sph.scene.configuration import Section, found_file, read_yaml, validated
from sph.scene.ground_motion.record import Record
from sph.scene.names import check_known
from sph.study.dimensions import Dimension, dimension, point_name, value_of
from sph.study.plan import Plan
from sph.study.planned import Planned, planned
from sph.study.runs import Kind, PlannedRun
from sph.study.schema import Point

FOLDER = "trigger"
"""Folder of the results, in that of the study at the searching fidelity."""
SEARCHED = {"points": "trigger", "maps": "maps"}
"""Table of all points of a search, and the search."""


class Searched(NamedTuple):
    """The dimensions of the searches."""

    all: tuple[Dimension, ...]  # in the order of file names and tables
    intensity_name: str

    @property
    def intensity(self) -> Dimension:
        """That whose critical values are searched."""
        return next(each for each in self.all if each.name == self.intensity_name)

    @property
    def others(self) -> tuple[Dimension, ...]:
        """Those at whose values it is searched."""
        return tuple(each for each in self.all if each.name != self.intensity_name)


class Lattice(Section):
    """What one search refines: some of its dimensions fixed, the others spanned."""

    case: str
    names: tuple[str, ...]
    """all dimensions, in the order of file names"""
    fixed: dict[str, str]
    spans: dict[str, Span]
    written: dict[str, tuple[str, ...]]
    """labels that the study has for numbers, by dimension; other numbers are written in six digits"""

    @property
    def goes_lower(self) -> bool:
        """Whether the search goes on below the smallest intensity where that already reaches what it looks for."""
        return len(self.spans) == 1 and all(span.lowest > 0.0 for span in self.spans.values())

    def labels(self, place: Place) -> tuple[str, ...]:
        """Values of the dimensions at a place, as written."""
        at = dict(zip(self.spans, place, strict=True))
        return tuple(self.fixed[name] if name in self.fixed else self.label(name, self.spans[name].value(at[name])) for name in self.names)

    def label(self, name: str, value: float) -> str:
        """The label of a number."""
        return label_among(self.written[name], f"{value:.6g}")


def label_among(written: Iterable[str], value: str) -> str:
    """The first of some labels that stands for the same value as another, or that one."""
    return next((label for label in written if value_of(label) == value_of(value)), value)


class TriggerPlan:
    """A configuration with the study it belongs to: folders, plans of every case and fidelity, lattices."""

    def __init__(self, trigger: Trigger, study: Plan, origin: str, folders: Sequence[Path], check: bool = True) -> None:
        self.trigger, self._study, self.origin = trigger, study, origin
        self._hazard_file = found_file(folders, trigger.hazard, f"{origin}: hazard") if trigger.hazard else None
        self.fidelity = trigger.fidelity or study.study.fidelity
        self.plans: dict[str, Plan] = {}
        self.folders: dict[tuple[str, str], str] = {}
        """folder of the stages and runs of a fidelity and case"""
        self.names = trigger.dimensions
        own = study.study.is_grid_over(self.names)
        values = {name: study.study.values[name] if own else () for name in self.names}
        self._written = {
            name: (*known, *(label for label in trigger.at.get(name, ()) if label_among(known, label) == label))
            for name, known in values.items()
        }
        ends = tuple(f"{end:.6g}" for end in (trigger.intensity.lowest, trigger.intensity.highest))
        searching = study if own else study.over({**trigger.at, trigger.intensity.dimension: ends})
        check_known(f"{origin}: classes: runout", filter(None, map(place_of, trigger.classes)), study.study.metrics.places)
        wanted = {"fidelity": self.fidelity} | ({"confirm.fidelity": trigger.confirm.fidelity} if trigger.confirm else {})
        for where, fidelity in wanted.items():
            check_known(f"{origin}: {where}", [fidelity], study.study.fidelities)
            for case, overrides in trigger.cases.items():
                apart = f"{FOLDER}/{file_name(case)}" if overrides or not own else ""
                plan = searching.at(fidelity, overrides, apart, f"{origin}: case {case!r}")
                self.plans[plan.folder] = plan
                self.folders[fidelity, case] = plan.folder
        self.folder = study.at(self.fidelity).folder
        if check:
            self._validate()

    def _validate(self) -> None:
        """Build every scene at the ends of the lattices."""
        searches = [search for search in SEARCHED.values() if search != "maps" or self.trigger.maps]
        periods = set[float]()
        for plan in self.plans.values():
            for line in (line for search in searches for line in self.lattices(search)):
                for ends in itertools.product(*((0.0, float(span.cells)) for span in line.spans.values())):
                    motion = plan.built(**dict(zip(self.names, line.labels(ends), strict=True))).motion
                    if isinstance(motion, Record) and motion.spectral_acceleration is not None:
                        periods.add(motion.spectral_acceleration.period)
        if self._hazard_file:
            self._check_hazard(read_hazard(self.hazard_file, self.trigger.intensity.dimension), periods)

    def _check_hazard(self, hazard: Hazard, periods: set[float]) -> None:
        """ValueError for a curve of which no part was searched, or of another period than those (s) of the scenes."""
        others = [period for period in sorted(periods) if hazard.period is not None and abs(period / hazard.period - 1.0) > 1e-3]
        if others:
            raise ValueError(
                f"{self.origin}: hazard: {self.hazard_file}: is of the spectral acceleration at {hazard.period:g} s, the search of that at "
                f"{others[0]:g} s; give the curve of that period, or set motion.spectral_acceleration.period to {hazard.period:g}"
            )
        span, ends = self.trigger.intensity, (hazard.intensity[0], hazard.intensity[-1])
        if not (ends[0] < span.highest and ends[1] > span.lowest):
            unit = self.dimensions.intensity.shown_unit
            raise ValueError(
                f"{self.origin}: hazard: {self.hazard_file}: runs from {ends[0]:.3g} to {ends[1]:.3g} {unit} of {span.dimension}, the "
                f"search from {span.lowest:.3g} to {span.highest:.3g}: they do not overlap"
            )

    @property
    def maps(self) -> Maps:
        """What is mapped; ValueError where nothing is."""
        if self.trigger.maps is None:
            raise ValueError(f"{self.origin}: maps: null, so there is nothing to map")
        return self.trigger.maps

    @property
    def hazard_file(self) -> str:
        """The file of the hazard curve; ValueError where there is none."""
        if self._hazard_file is None:
            raise ValueError(
                f"{self.origin}: hazard: null, there are no annual frequencies; delete fragility_annual.csv of an earlier search"
            )
        return str(self._hazard_file)

    @property
    def confirm(self) -> dict[str, Any]:
        """What is confirmed; ValueError where nothing is."""
        if self.trigger.confirm is None:
            raise ValueError(f"{self.origin}: confirm: null, so there is nothing to confirm")
        chosen = self.trigger.confirm
        return {
            "fidelity": chosen.fidelity,
            "collapse_class": chosen.collapse_class,
            "cases": chosen.cases or tuple(self.trigger.cases),
            "at": {**self.trigger.at, **chosen.at},
        }

    def lattices(self, search: str) -> list[Lattice]:
        """What a search refines."""
        chosen, over = self.trigger, self.maps.over if search == "maps" else {}
        cases = (self.maps.cases if search == "maps" else None) or chosen.cases
        spans = {**over, chosen.intensity.dimension: Span(**chosen.intensity.model_dump(exclude={"dimension"}))}
        at = {name: [label_among(self._written[name], value) for value in chosen.at[name]] for name in chosen.at if name not in over}
        return [
            Lattice(case=case, names=self.names, fixed=dict(zip(at, values, strict=True)), spans=spans, written=self._written)
            for case, *values in itertools.product(cases, *at.values())
        ]

    @functools.cached_property
    def dimensions(self) -> Searched:
        """The dimensions of the searches with their units and meanings."""
        plan, labels = next(iter(self.plans.values())), self.lattices("trigger")[0].labels((0.0,))
        scene = plan.built(**dict(zip(self.names, labels, strict=True)))
        return Searched(tuple(dimension(name, self._written[name], scene) for name in self.names), self.trigger.intensity.dimension)

    def classes(self, search: str) -> Sequence[str]:
        """The classes whose boundaries a search refines."""
        return self.maps.classes if search == "maps" else self.trigger.classes

    def levels(self, search: str) -> int:
        """The last round of a search."""
        return self.maps.levels if search == "maps" else self.trigger.levels

    def file(self, name: str, **at: str) -> str:
        """A file of the searches, by its name in their folder, with values of wildcards in it."""
        return f"{self.folder}/{FOLDER}/{name}".format(**at)

    def points(self, search: str, number: int | None = None) -> str:
        """File of the points up to a round of a search, or to its last."""
        return self.file(f"rounds/{search}-{self.levels(search) if number is None else number}-points.csv")

    def wanted(self, path_to_points: Path | str, fidelity: str | None = None) -> list[PlannedRun]:
        """The runs of a table of points, in its order, at the searching fidelity or another."""
        return self.runs_at(list(_wanted(path_to_points)), fidelity)

    def runs_at(self, asked: Sequence[tuple[str, Point]], fidelity: str | None = None) -> list[PlannedRun]:
        """The runs of cases and points; KeyError for an unknown case."""
        folders = [self.folders[fidelity or self.fidelity, case] for case, _ in asked]
        names = [point_name(point) for _, point in asked]
        points: dict[str, dict[str, Point]] = {folder: {} for folder in folders}
        for folder, name, (_, point) in zip(folders, names, asked, strict=True):
            points[folder][name] = point
        shared = {folder: self.plans[folder].runs_at(at) for folder, at in points.items()}
        return [shared[folder].runs[name] for folder, name in zip(folders, names, strict=True)]

    def tables(self, base: Path) -> list[tuple[str, Path]]:
        """The tables of the points that the searches have asked for so far, below a working folder, each with the target that asks."""
        rounds = base / self.folder / FOLDER / "rounds"
        asked = [(search, path) for search in SEARCHED.values() for path in sorted(rounds.glob(f"{search}-*-wanted.csv"))]
        return asked + [("confirm", path) for path in rounds.glob("confirm-wanted.csv") if self.trigger.confirm]

    def so_far(self, base: Path) -> list[PlannedRun]:
        """What the searches have asked for so far, with stages and searches of slopes, and the searches that every one needs.

        Points of an earlier configuration are left out.
        """
        points: dict[str, dict[str, Point]] = {folder: {} for folder in self.plans}
        of: dict[tuple[str, str], tuple[str, str]] = {}
        for target, path in self.tables(base):
            fidelity = self.confirm["fidelity"] if target == "confirm" else self.fidelity
            for case, point in _wanted(path):
                if (fidelity, case) in self.folders and tuple(point) == self.names:
                    at = self.folders[fidelity, case], point_name(point)
                    points[at[0]][at[1]] = point
                    of.setdefault(at, (target, f"{target} {case} {point[self.trigger.intensity.dimension]}"))
        known = [*self.searches.values()]
        for folder, asked in points.items():
            for run in self.plans[folder].runs_at(asked):
                target, group = of[folder, run.id] if run.kind == Kind.RUN else ("", run.group)
                known.append(run._replace(target=target, group=group))
        return known

    @property
    def searched(self) -> dict[str, str]:
        """Folder of the stages and runs of every case, at the searching fidelity."""
        return {case: self.folders[self.fidelity, case] for case in self.trigger.cases}

    @property
    def shaken(self) -> dict[tuple[str, ...], Planned]:
        """Scenes shaken at the largest intensity, by case and the values of the other dimensions in their order."""
        plans = {case: self.plans[folder] for case, folder in self.searched.items()}
        return {(case, *others): planned(plans[case].scene(**point)) for (case, *others), point in self._strongest.items()}

    @functools.cached_property
    def _strongest(self) -> dict[tuple[str, ...], Point]:
        """Points at the largest intensity, by case and the values of the other dimensions in their order."""
        points = {}
        for lattice in self.lattices("trigger"):
            point = dict(zip(self.names, lattice.labels((float(self.trigger.intensity.cells),)), strict=True))
            others = (value for name, value in point.items() if name != self.trigger.intensity.dimension)
            points[lattice.case, *others] = point
        return points

    @functools.cached_property
    def searches(self) -> dict[tuple[str, ...], PlannedRun]:
        """The searches for the yield accelerations of the slopes, by case and the values of the other dimensions.

        A case of more than ``MAX_SLOPES`` slopes has none.  A slope that the study, or a case before, searches is not searched again.
        """
        all_searches: dict[tuple[str, ...], PlannedRun] = {}
        shares = self.fidelity == self._study.study.fidelity
        known = {search.slope: search for search in self._study.searches.values()} if shares else {}
        for case, folder in self.searched.items():
            points = {at: point for at, point in self._strongest.items() if at[0] == case}
            plan = self.plans[folder]
            searches = plan.searches_of(plan.runs_at({point_name(point): point for point in points.values()}))
            for at, point in points.items() if searches else ():
                own = searches[point_name(point)]
                all_searches[at] = known.setdefault(own.slope, own)
        return all_searches

    @property
    def tolerance(self) -> str:
        """The tolerance with its unit."""
        return f"{self.trigger.tolerance:g} {self.dimensions.intensity.shown_unit}".rstrip()

    @property
    def facts(self) -> dict[str, str]:
        """Study and fidelity, for the table's attributes."""
        return {"title": f"{self._study.study.study}: critical intensities", "fidelity": self.fidelity}

    def note(self, search: str = "trigger") -> str:
        """The line on every figure of a search."""
        cases = list(dict.fromkeys(lattice.case for lattice in self.lattices(search)))
        scenes = [self.plans[self.searched[case]].built() for case in cases]
        spacings = [f"{spacing:.4g}" for spacing in sorted({scene.numerics.spacing for scene in scenes}, reverse=True)]
        changed = f", case {cases[0]}" if len(cases) == 1 and self.trigger.cases[cases[0]] else ""
        parts = (
            f"fidelity {self.fidelity}{changed}",
            f"scene {scenes[0].name}",
            f"spacing {' to '.join(dict.fromkeys((spacings[0], spacings[-1])))} m",
            f"{scenes[0].duration:g} s",
        )
        return " · ".join(parts)


def _wanted(path: Path | str) -> Iterator[tuple[str, Point]]:
    """Case and point of every row of a table of points."""
    table = pd.read_csv(path, dtype=str, keep_default_na=False)
    names = names_in(table.columns)
    for case, *point in table[["case", *names]].itertuples(index=False, name=None):
        yield case, dict(zip(names, point, strict=True))


def names_in(columns: Iterable[str]) -> list[str]:
    """The dimensions among the columns of a table of a search: those after its case, before the first column that every such table has."""
    return [*itertools.takewhile(lambda name: name not in ("round", "collapse_class", "wanted_class"), columns)][1:]


def load_trigger(path: str, study: Plan, folders: Sequence[Path] = (Path(),), check: bool = True) -> TriggerPlan:
    """Validate the configuration and, with ``check``, scenes at the ends of its lattices; ValueError names file, key and value."""
    return TriggerPlan(validated(Trigger, read_yaml(found_file(folders, path, "experiments.trigger")), path), study, path, folders, check)


EXPERIMENT = Experiment("trigger", load_trigger, Trigger, alone=False)
