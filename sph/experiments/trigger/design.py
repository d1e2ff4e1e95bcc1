"""The shaking that triggers failure (``config/trigger.yaml``, ``snakemake trigger`` and ``snakemake maps``): what is searched, and where.

A *case* lays scene keys over the study's scene; its runs share gravity stage and pre-failure runs with each other and, where the case
changes nothing, with the study.  A *lattice* is what one search refines: amplitudes at one S_R and gamma (``trigger``), or S_R,
gamma and amplitude together (``maps``).  All have their amplitudes on one dyadic lattice, so that they share pre-failure runs and runs.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Annotated, Any, Literal, get_args

import pandas as pd
from pydantic import BeforeValidator, model_validator

from sph.experiments.base import Label, Overrides, check_file_names, file_name
from sph.experiments.trigger.refinement import Place, Span
from sph.measures.metrics import CLASSES, GRID
from sph.scene.configuration import Section, found_file, key, read_yaml, validated
from sph.scene.names import check_known
from sph.scene.units import Acceleration, acceleration
from sph.study.dimensions import SHORT_NAMES, point_name
from sph.study.plan import Axis, Plan, Point
from sph.study.planned import Planned, planned

FOLDER = "trigger"
"""Folder of the results, in that of the study at the searching fidelity."""
MOST_RUNS = 10_000
"""Most points of an undivided lattice."""
MOST_LEVELS = 12
"""Most divisions of a cell."""
LEAST_STEP = 1e-5
"""Smallest step of a lattice over its largest value: labels have six digits."""
SEARCHED = {"points": "trigger", "maps": "maps"}
"""Table of all points of a search, and the search."""

DamageClass = Literal["minor", "damaged", "collapse"]
assert get_args(DamageClass) == CLASSES[1:]
Classes = tuple[DamageClass, ...]


def reached(collapse_class: str, wanted: str) -> bool | None:
    """Whether a run is of a class or a worse one; None for a diverged run, which is neither."""
    return CLASSES.index(collapse_class) >= CLASSES.index(wanted) if collapse_class in CLASSES else None


class Confirm(Section):
    """Brackets whose ends are run again at another fidelity."""

    fidelity: str = key("the fidelity, one of the study's", default="standard")
    cases: tuple[str, ...] | None = key("cases that are confirmed; null: all", default=None, min_length=1)
    S_R: Axis = key("their strength ratios, among those searched", default=("0.10", "0.25", "0.50"))
    gamma: Axis = key("their rates of the loss of strength, among those searched", "1/s", default=("100",))
    collapse_class: DamageClass = key("the class whose brackets are confirmed", default="collapse")


class Maps(Section):
    """The lattice of S_R, gamma and amplitude."""

    cases: tuple[str, ...] | None = key("cases that are mapped; null: all", default=None, min_length=1)
    S_R: Span = key("strength ratios")
    gamma: Span = key("rates of the loss of strength", "1/s")
    classes: Classes = key("cells whose corners differ in reaching one of these classes are divided", default=("collapse",), min_length=1)
    levels: int = key("how often a cell is divided", ge=0, le=4, default=2)


def _in_si(span: Any) -> Any:
    """A span of accelerations, which may be written with their units."""
    return {name: end if name == "scale" else acceleration(end) for name, end in span.items()} if isinstance(span, Mapping) else span


class Trigger(Section):
    """The configuration."""

    fidelity: str | None = key("the fidelity that searches, one of the study's; null: that of the study", default=None)
    cases: dict[Label, Overrides] = key("scene keys of each case, by label", min_length=1)
    amplitude: Annotated[Span, BeforeValidator(_in_si)] = key("amplitudes of the shaking, of all searches", "m/s2")
    tolerance: Acceleration = key("largest width of the bracket of a critical amplitude", "m/s2", gt=0, le=100)
    classes: Classes = key("classes whose critical amplitudes are searched", default=("collapse",), min_length=1)
    S_R: Axis = key("strength ratios at which they are searched")
    gamma: Axis = key("rates of the loss of strength at which they are searched", "1/s")
    confirm: Confirm | None = key("brackets whose ends are run again at another fidelity; null: none", default=None)
    maps: Maps | None = key("maps over S_R, gamma and amplitude; null: none", default=None)

    @model_validator(mode="after")
    def _known(self) -> Trigger:
        check_file_names("cases", self.cases)
        for case, overrides in self.cases.items():
            for name, dotted_key in SHORT_NAMES.items():
                section, last = dotted_key.split(".")
                if last in (overrides.get(section) or {}):
                    raise ValueError(f"cases.{case}: {dotted_key} is what is searched, see {name}")
        check_known("confirm.cases", self.confirm.cases if self.confirm else (), self.cases)
        check_known("maps.cases", self.maps.cases if self.maps else (), self.cases)
        for name in ("S_R", "gamma") if self.confirm else ():
            searched = {float(value) for value in getattr(self, name)}
            for value in getattr(self.confirm, name):
                if float(value) not in searched:
                    raise ValueError(f"confirm.{name}: {value} is not one of those searched, {', '.join(getattr(self, name))}")
        check_known("confirm.collapse_class", [self.confirm.collapse_class] if self.confirm else (), self.classes)
        if self.levels > MOST_LEVELS:
            raise ValueError(
                f"tolerance: {self.tolerance:g} m/s2 must be at least {self.amplitude.widest(MOST_LEVELS):.2g} m/s2 with this lattice"
            )
        self._check_extent()
        return self

    def _check_extent(self) -> None:
        spans = [("amplitude", self.amplitude, self.levels)]
        points = {"S_R, gamma, amplitude": len(self.cases) * len(self.S_R) * len(self.gamma) * (self.amplitude.cells + 1)}
        if self.maps:
            own = (self.maps.S_R, self.maps.gamma, self.amplitude)
            spans += [(f"maps.{name}", span, self.maps.levels) for name, span in zip(GRID, own, strict=True)]
            points["maps"] = len(self.maps.cases or self.cases) * math.prod(span.cells + 1 for span in own)
        for where, span, levels in spans:
            if span.widest(levels) <= LEAST_STEP * span.highest:
                raise ValueError(f"{where}: steps of {span.widest(levels):.2g} at {span.highest:g} are too small for labels of six digits")
        for where, count in points.items():
            if count > MOST_RUNS:
                raise ValueError(f"{where}: the undivided lattice has {count:,} points, at most {MOST_RUNS:,}")

    @property
    def levels(self) -> int:
        """How often a cell of amplitudes is divided until the widest is within the tolerance; ``MOST_LEVELS`` + 1 if that is not enough."""
        narrow = (level for level in range(MOST_LEVELS + 1) if self.amplitude.widest(level) <= self.tolerance * (1.0 + 1e-9))
        return next(narrow, MOST_LEVELS + 1)


class Lattice(Section):
    """What one search refines: some of the study's dimensions fixed, the others spanned."""

    case: str
    fixed: dict[str, str]
    spans: dict[str, Span]
    written: dict[str, tuple[str, ...]]
    """labels that the study has for numbers, by dimension; other numbers are written in six digits"""

    def labels(self, place: Place) -> tuple[str, ...]:
        """S_R, gamma and amplitude at a place, as written."""
        at = dict(zip(self.spans, place, strict=True))
        return tuple(self.fixed[name] if name in self.fixed else self.label(name, self.spans[name].value(at[name])) for name in GRID)

    def label(self, name: str, value: float) -> str:
        """The label of a number."""
        plain = f"{value:.6g}"
        return next((label for label in self.written[name] if float(label) == float(plain)), plain)


class TriggerPlan:
    """A configuration with the study it belongs to: folders, plans of every case and fidelity, lattices."""

    def __init__(self, trigger: Trigger, study: Plan, origin: str) -> None:
        self.trigger, self._study, self.origin = trigger, study, origin
        self.fidelity = trigger.fidelity or study.study.fidelity
        self.plans: dict[str, Plan] = {}
        self.folders: dict[tuple[str, str], str] = {}
        """folder of the stages and runs of a fidelity and case"""
        wanted = {"fidelity": self.fidelity} | ({"confirm.fidelity": trigger.confirm.fidelity} if trigger.confirm else {})
        for where, fidelity in wanted.items():
            check_known(f"{origin}: {where}", [fidelity], study.study.fidelities)
            for case, overrides in trigger.cases.items():
                plan = study.at(fidelity, overrides, f"{FOLDER}/{file_name(case)}" if overrides else "", f"{origin}: case {case!r}")
                self.plans[plan.folder] = plan
                self.folders[fidelity, case] = plan.folder
        self.folder = study.at(self.fidelity).folder
        values = {name: tuple(dict.fromkeys(study.study.values[name] + getattr(trigger, name))) for name in ("S_R", "gamma")}
        self._written = {**values, "amplitude": study.study.values["amplitude"]}
        self._validate()

    def _validate(self) -> None:
        """Build every scene at the ends of the lattices."""
        searches = [search for search in SEARCHED.values() if search != "maps" or self.trigger.maps]
        for plan in self.plans.values():
            for line in (line for search in searches for line in self.lattices(search)):
                for ends in itertools.product(*((0.0, float(span.cells)) for span in line.spans.values())):
                    plan.built(**dict(zip(GRID, line.labels(ends), strict=True)))

    @property
    def maps(self) -> Maps:
        """What is mapped; ValueError where nothing is."""
        if self.trigger.maps is None:
            raise ValueError(f"{self.origin}: maps: null, there is nothing to map")
        return self.trigger.maps

    @property
    def confirm(self) -> dict[str, Any]:
        """What is confirmed; ValueError where nothing is."""
        if self.trigger.confirm is None:
            raise ValueError(f"{self.origin}: confirm: null, there is nothing to confirm")
        return self.trigger.confirm.model_dump() | {"cases": self.trigger.confirm.cases or tuple(self.trigger.cases)}

    def lattices(self, search: str) -> list[Lattice]:
        """What a search refines."""
        chosen, spans = self.trigger, {"amplitude": self.trigger.amplitude}
        if search == "maps":
            spans = {"S_R": self.maps.S_R, "gamma": self.maps.gamma, **spans}
            return [Lattice(case=case, fixed={}, spans=spans, written=self._written) for case in self.maps.cases or chosen.cases]
        return [
            Lattice(
                case=case, fixed={"S_R": self._label("S_R", S_R), "gamma": self._label("gamma", gamma)}, spans=spans, written=self._written
            )
            for case, S_R, gamma in itertools.product(chosen.cases, chosen.S_R, chosen.gamma)
        ]

    def _label(self, name: str, value: str) -> str:
        return next(label for label in self._written[name] if float(label) == float(value))

    def classes(self, search: str) -> Classes:
        """The classes whose boundaries a search refines."""
        return self.maps.classes if search == "maps" else self.trigger.classes

    def levels(self, search: str) -> int:
        """The last round of a search."""
        return self.maps.levels if search == "maps" else self.trigger.levels

    def points(self, search: str, number: int | None = None) -> str:
        """File of the points up to a round of a search, or to its last."""
        return f"{self.folder}/{FOLDER}/rounds/{search}-{self.levels(search) if number is None else number}-points.csv"

    def runs(self, path_to_points: str, pattern: str, fidelity: str | None = None) -> list[str]:
        """Files of the runs of a table of points, in its order, at the searching fidelity or another; ``pattern`` as of the rule."""
        return [pattern.format(folder=folder, run=point_name(point)) for folder, point in self._points(path_to_points, fidelity)]

    def planned(self, path_to_points: str, fidelity: str | None = None) -> list[Planned]:
        """Scenes of the same runs."""
        return [planned(self.plans[folder].scene(**point)) for folder, point in self._points(path_to_points, fidelity)]

    def asked(self, base: Path) -> Iterator[tuple[str, str, str, Point]]:
        """Target, case, folder and point of every run that the searches have asked for so far, by the tables below a working folder."""
        tables = base / self.folder / FOLDER / "rounds"
        rounds = [(search, path) for search in SEARCHED.values() for path in sorted(tables.glob(f"{search}-*-wanted.csv"))]
        for target, path in [*rounds, ("confirm", tables / "confirm-wanted.csv")]:
            if path.is_file():
                fidelity = self.confirm["fidelity"] if target == "confirm" else self.fidelity
                yield from ((target, case, self.folders[fidelity, case], point) for case, point in _wanted(path))

    def _points(self, path_to_points: str, fidelity: str | None) -> Iterator[tuple[str, Point]]:
        """Folder and point of every run."""
        for case, point in _wanted(path_to_points):
            yield self.folders[fidelity or self.fidelity, case], point

    @property
    def searched(self) -> dict[str, str]:
        """Folder of the stages and runs of every case, at the searching fidelity."""
        return {case: self.folders[self.fidelity, case] for case in self.trigger.cases}

    @property
    def scenes(self) -> dict[str, dict[str, Any]]:
        """Scene of every case, shaken at the largest amplitude."""
        strongest = f"{self.trigger.amplitude.highest:.6g}"
        return {case: self.plans[folder].scene(amplitude=strongest) for case, folder in self.searched.items()}

    @property
    def facts(self) -> dict[str, str]:
        """Study and fidelity, for the table's attributes."""
        return {"title": f"{self._study.study.study}: critical amplitudes", "fidelity": self.fidelity}

    @property
    def note(self) -> str:
        """The line on every figure."""
        scene = next(iter(self.plans.values())).built()
        parts = (f"fidelity {self.fidelity}", f"scene {scene.name}", f"spacing {scene.numerics.spacing:.4g} m", f"{scene.duration:g} s")
        return " · ".join(parts)


def _wanted(path: Path | str) -> Iterator[tuple[str, Point]]:
    """Case and point of every row of a table of points."""
    for case, *point in pd.read_csv(path, dtype=str, keep_default_na=False)[["case", *GRID]].itertuples(index=False, name=None):
        yield case, dict(zip(GRID, point, strict=True))


def load_trigger(path: str, study: Plan, folders: Sequence[Path] = (Path(),)) -> TriggerPlan:
    """Validate the configuration, and scenes at the ends of its lattices; ValueError names file, key and value."""
    study.study.needs_grid_over(GRID, "trigger and maps")
    return TriggerPlan(validated(Trigger, read_yaml(found_file(folders, path, "trigger")), path), study, path)


def plan_of(study: Plan, trigger: Callable[[], TriggerPlan], folder: str) -> Plan:
    """The plan whose stages and runs lie in a folder: that of the study, else one of the trigger's."""
    if folder == study.folder:
        return study
    plans = trigger().plans
    if folder not in plans:
        raise ValueError(f"{folder}: nothing is configured to lie there; known are {', '.join(plans)}")
    return plans[folder]
