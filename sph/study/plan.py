"""A study: one scene with some of its keys varied, at a fidelity (``config/config.yaml``).

The runs are a grid of values, a list of cases or a sample (``sph.study.sampling``); a dimension is any key of the scene, three of
which have short names.  Values stay the strings they were written as (``sph.study.dimensions``).  ``load_study`` builds and validates
the scene of every run, so that a typo is refused before any work.  What runs share is simulated once (``sph.study.stages``).
"""

from __future__ import annotations

import functools
import itertools
import math
import warnings
from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path
from typing import Annotated, Any, NamedTuple, TypeVar

import numpy as np
import pandas as pd
from pydantic import BeforeValidator, Field, model_validator

from sph.measures.fields import check_probe
from sph.measures.metrics import MetricSettings
from sph.scene.configuration import Section, dotted, found_file, key, merge, one_line, read_scene, read_yaml, scene_files, validated
from sph.scene.names import check_known
from sph.scene.schema import Scene, make_scene
from sph.study.dimensions import (
    CASE,
    Dimension,
    Value,
    Values,
    as_written,
    check_names,
    dimension,
    in_order,
    in_si,
    is_number,
    named_point,
    point_name,
    scene_key,
    title_of,
    value_of,
)
from sph.study.planned import Planned, planned
from sph.study.sampling import KINDS, MOST_RUNS, Sample, read_cases
from sph.study.stages import SharedStages, Stages, search_name, searched_gravity, stage_point
from sph.study.tables import Layout

NAME = r"^[A-Za-z0-9][A-Za-z0-9_.-]{0,63}$"
LONGEST_NAME = 120
"""Longest file name of a run that is made of its dimensions, without suffix; where one is longer, runs are numbered."""
PART = 500
"""Runs that are measured by one job."""
OWN = "own"
"""The fidelity of a study that names none: the scene as it is."""
Number = Annotated[str, Field(max_length=24, pattern=r"^[0-9]+(\.[0-9]+)?([eE][+-]?[0-9]+)?$")]
Axis = Annotated[tuple[Number, ...], BeforeValidator(as_written), Field(min_length=1)]
Case = Annotated[dict[str, Value], BeforeValidator(in_si), Field(min_length=1)]
# ``load_study`` puts the cases in the place of the name of a file.
Cases = Annotated[
    tuple[Case, ...], Field(min_length=1), BeforeValidator(lambda cases: cases, json_schema_input_type=tuple[Case, ...] | str)
]
Point = dict[str, str]
"""Value of every dimension of a run, as written."""


def _dimensions_kept(grid: Any) -> Any:
    """A dimension set to null is none: so a configuration laid over another takes it out."""
    return in_si({name: values for name, values in grid.items() if values is not None}) if isinstance(grid, Mapping) else grid


class FigureCases(Section):
    """Which runs figures show."""

    runs: tuple[str, ...] = key(
        "runs, by the names of their files without suffix, whose profiles are drawn; none: four, evenly through the study",
        default=(),
        max_length=12,
    )


class Study(Section):
    """The configuration of the workflow."""

    study: str = key("name; results go to results/<study>/<fidelity>", pattern=NAME)
    scene: str = key("scene file, relative to the working folder or the workflow's")
    fidelity: str = key("which of the fidelities to run at", default=OWN)
    grid: Annotated[dict[str, Values], BeforeValidator(_dimensions_kept), Field(min_length=1)] | None = key(
        "values of each dimension, every combination is run; quote them to keep trailing zeros; dimensions: S_R, gamma, amplitude "
        "or any dotted key of the scene that takes a number or a word",
        source="Figs. 4-5, Sec. 3.2",
        default=None,
    )
    cases: Cases | None = key(
        "instead of a grid: the runs one by one, a value of each dimension; or the name of a CSV file with a column a dimension",
        default=None,
    )
    sample: Sample | None = key("instead of a grid: runs that fill ranges of the dimensions", default=None)
    fidelities: dict[Annotated[str, Field(pattern=NAME)], dict[str, Any]] = key(
        "scene keys that each fidelity sets, by name", default={OWN: {}}, min_length=1
    )
    figures: FigureCases = key("runs shown in figures", default=FigureCases())
    metrics: MetricSettings = key("thresholds of the metrics", default=MetricSettings())
    experiments: dict[str, str] = key(
        "file of an experiment, by the name of its target, searched for like the scene; of others config/<name>.yaml", default={}
    )

    @model_validator(mode="after")
    def _known(self) -> Study:
        check_known("fidelity", [self.fidelity], self.fidelities)
        return self

    @model_validator(mode="after")
    def _runs_known(self) -> Study:
        chosen = [kind for kind in KINDS if getattr(self, kind) is not None]
        if len(chosen) != 1:
            raise ValueError(f"one of {', '.join(KINDS)} says which runs there are (found {' and '.join(chosen) or 'none'})")
        if self.sample is not None:
            check_names("sample.ranges", self.sample.ranges)
        elif self.grid is not None:
            check_names("grid", self.grid)
            for name, values in self.grid.items():
                if len({value_of(value) for value in values}) < len(values):
                    raise ValueError(f"grid.{name}: {list(values)} holds one value twice")
            runs = math.prod(len(values) for values in self.grid.values())
            if runs > MOST_RUNS:
                raise ValueError(f"grid: {', '.join(self.grid)}: the grid has {runs:,} points, at most {MOST_RUNS:,}")
        else:
            assert self.cases is not None
            check_names("cases", self.cases[0])
            if len(self.cases) > MOST_RUNS:
                raise ValueError(f"cases: {len(self.cases):,} runs, at most {MOST_RUNS:,}")
            for number, case in enumerate(self.cases, 1):
                if set(case) != set(self.cases[0]):
                    raise ValueError(f"cases: number {number} sets {', '.join(case)}, the first {', '.join(self.cases[0])}")
        return self

    @functools.cached_property
    def names(self) -> list[str]:
        """The dimensions, in the order of file names and tables."""
        return in_order(self.grid or (self.sample.ranges if self.sample else self.cases[0] if self.cases else ()))

    def is_grid_over(self, names: Sequence[str]) -> bool:
        """Whether the study is a grid over exactly these dimensions."""
        return self.grid is not None and self.names == in_order(names)

    def needs_grid_over(self, names: Sequence[str], what: str) -> None:
        """ValueError, which says ``what`` needs it, where the study is not a grid over exactly these dimensions."""
        if not self.is_grid_over(names):
            raise ValueError(f"{what} need a grid over exactly {', '.join(names)}; study {self.study!r} varies {', '.join(self.names)}")

    def file_of(self, experiment: str) -> str:
        """File that configures an experiment, as written."""
        return self.experiments.get(experiment, f"config/{experiment}.yaml")

    @functools.cached_property
    def values(self) -> dict[str, tuple[str, ...]]:
        """Values of each dimension of a grid, numbers increasing and words as written; of a list, those of all runs in their order."""
        if self.grid is None:
            points = self.sample.points() if self.sample else self.cases or ()
            return {name: tuple(point[name] for point in points) for name in self.names}
        return {
            name: tuple(sorted(self.grid[name], key=float) if all(map(is_number, self.grid[name])) else self.grid[name])
            for name in self.names
        }

    @functools.cached_property
    def numbered(self) -> bool:
        """Whether the names of runs are numbers: in a list, and in a grid whose dimensions make too long a name."""
        longest = point_name({name: max(values, key=len) for name, values in self.values.items()})
        return self.grid is None or len(longest) > LONGEST_NAME

    @functools.cached_property
    def runs(self) -> dict[str, Point]:
        """Every run by the name of its file, in the order of the tables."""
        combined = zip(*self.values.values(), strict=True) if self.grid is None else itertools.product(*self.values.values())
        points = [dict(zip(self.names, values, strict=True)) for values in combined]
        if self.numbered:
            return {f"{CASE}-{number:06d}": point for number, point in enumerate(points, 1)}
        return {point_name(point): point for point in points}

    @property
    def points(self) -> pd.DataFrame:
        """Table of all runs, values as written."""
        return pd.DataFrame(list(self.runs.values()), columns=self.names)

    def name_of(self, point: Mapping[str, str]) -> str:
        """Name of the file of a run of the study."""
        return next(name for name, own in self.runs.items() if own == point) if self.numbered else point_name(point)

    def shown_runs(self, most: int, chosen: Sequence[str] = ()) -> list[str]:
        """Names of at most ``most`` runs, evenly through the study, with the ``chosen`` ones, in the order of the tables."""
        names = list(self.runs)
        for name in chosen:
            if name not in self.runs:
                raise ValueError(f"figures.runs: there is no run {name!r}; the first are {', '.join(names[:3])}")
        even = np.unique(np.linspace(0, len(names) - 1, min(max(most - len(chosen), 0), len(names))).round().astype(int))
        wanted = {names[number] for number in even} | set(chosen)
        return [name for name in names if name in wanted]

    @property
    def page_runs(self) -> list[str]:
        """Names of the runs that the page shows."""
        few = len(self.runs) <= MOST_SHOWN
        return list(self.runs) if few else self.shown_runs(MOST_SHOWN, self.figure_files.get(PROFILES, []))

    @property
    def figure_files(self) -> dict[str, list[str]]:
        """Names of the runs from which a figure is drawn, by the name of its file; ValueError where the study lacks what one needs.

        The figures of all runs (``sph.figures.STUDY_FIGURES``) are not among them.
        """
        return dict.fromkeys(INPUT_FIGURES, list(self.runs)[:1]) | {PROFILES: self.profile_runs}

    @property
    def profile_runs(self) -> list[str]:
        """Names of the runs whose profiles are drawn."""
        return self.shown_runs(FEW_PROFILES if not self.figures.runs else 0, self.figures.runs)


INPUT_FIGURES = ("fig1", "fig2", "fig3")
"""Figures of what goes in, which need one run: geometry, motion, initial particles."""
PROFILES = "profiles"
"""The figure of some runs at their end."""
FEW_PROFILES = 4
"""Runs that it shows where the study does not choose them."""
MOST_SHOWN = 200
"""Most runs that the page shows, evenly through the study."""
AnyKey = TypeVar("AnyKey")
MOST_SLOPES = 10
"""Most slopes of a study, or of a case of a search, whose yield accelerations are searched."""


class SlopeSearch(NamedTuple):
    """The search for the yield acceleration of a slope."""

    file: str
    scene: Planned


def yield_accelerations(searches: Mapping[AnyKey, SlopeSearch]) -> dict[AnyKey, float]:
    """What searches found, m/s2, by the keys that they are given with: 0 for a slope that does not stand, NaN where one found none.

    ValueError names a file of another slope.
    """
    values = {file: float(scene.read(file).attrs["value"]) for file, scene in {each.file: each.scene for each in searches.values()}.items()}
    return {at: values[search.file] for at, search in searches.items()}


class Plan:
    """A study with its scene file read: the scene of every stage and run, as mappings."""

    def __init__(
        self, study: Study, base: Mapping[str, Any], origin: str, overrides: Mapping[str, Any] | None = None, subfolder: str = ""
    ) -> None:
        self.study, self.origin, self._subfolder = study, origin, subfolder
        self._scene_file = base
        self._base = merge(merge(base, study.fidelities[study.fidelity]), overrides or {})

    @property
    def folder(self) -> str:
        """Where the results go, relative to the working folder."""
        return "/".join(part for part in ("results", self.study.study, self.study.fidelity, self._subfolder) if part)

    def at(self, fidelity: str, overrides: Mapping[str, Any] | None = None, subfolder: str = "", origin: str = "") -> Plan:
        """The same study at one of its fidelities, with scene keys laid over it, its results in a folder below."""
        return Plan(self.study.model_copy(update={"fidelity": fidelity}), self._scene_file, origin or self.origin, overrides, subfolder)

    def scene(self, **point: str) -> dict[str, Any]:
        """Scene with some of the dimensions set, as a mapping."""
        return merge(self._base, dotted({scene_key(name): value_of(value) for name, value in point.items()}))

    def run_scene(self, name: str) -> dict[str, Any]:
        """Scene of a run by the name of its file."""
        return self.scene(**self.point(name))

    def over(self, grid: Mapping[str, Sequence[str]]) -> Plan:
        """The same scenes as a grid over other dimensions; ValueError where its runs would have no names by their values."""
        kept = self.study.model_dump(include={"study", "scene", "fidelity", "fidelities", "metrics", "experiments"})
        study = Study(**kept, grid={name: tuple(values) for name, values in grid.items()})
        if study.numbered:
            raise ValueError(f"{self.origin}: {', '.join(grid)}: these dimensions make names of runs that are too long, or hold a folder")
        return Plan(study, self._scene_file, self.origin)

    def experiment_file(self, name: str) -> str:
        """File that configures an experiment on the study's own scene.

        ValueError for a scene of one's own whose study names none: what ``config`` has is for the paper's.
        """
        if name not in self.study.experiments and self._base.get("scheme") != "paper":
            raise ValueError(
                f"experiments.{name}: study {self.study.study!r} has a scene of its own and must name the file that configures {name}; "
                f"{self.study.file_of(name)} is for the paper's scene, and an example"
            )
        return self.study.file_of(name)

    def point(self, name: str) -> Point:
        """Point of a run by the name of its file; of a grid also of one between its values, which a search may ask for."""
        if name in self.study.runs:
            return self.study.runs[name]
        found = named_point(name, self.study.names) if self._named else None
        if found is None:
            raise ValueError(f"study {self.study.study!r} has no run {name!r}; the first is {next(iter(self.study.runs))}")
        return found

    @property
    def _named(self) -> bool:
        """Whether the name of a run says its values."""
        return self.study.grid is not None and not self.study.numbered

    @functools.cached_property
    def _shared(self) -> SharedStages:
        return SharedStages(self.study.runs, self.study.numbered, self._stands)

    def _stands(self, point: Mapping[str, str]) -> bool:
        try:
            self.built(**point)
        except ValueError:
            return False
        return True

    def stages(self, name: str) -> Stages:
        """The stages of a run by the name of its file."""
        return self._shared.of_runs.get(name) or self._shared.of(name, self.point(name))

    def stage(self, name: str) -> dict[str, Any]:
        """Scene of a gravity stage, shared pre-failure run or search by the name of its file; of a grid also of one between its values."""
        return self.scene(**self._stage_point(name))

    def _stage_point(self, name: str) -> Point:
        name = searched_gravity(name)
        if name in self._shared.points:
            return self._shared.points[name]
        found = stage_point(name, self.study.names) if self._named else None
        if found is None:
            raise ValueError(f"study {self.study.study!r} has no stage {name!r}; the first are {', '.join(list(self._shared.points)[:3])}")
        return found

    def gravity_of(self, trunk: str) -> str:
        """Name of the gravity stage of a shared pre-failure run."""
        found = self._shared.gravity_of
        return found[trunk] if trunk in found else self._shared.of(trunk, self._stage_point(trunk)).gravity

    def files(self, others: Mapping[str, Point] | None = None) -> dict[str, Point]:
        """The dimensions that the scene of each stage, search and run sets, by file; ``others`` are runs, by name, that the study lacks."""
        runs = self.study.runs | dict(others or {})
        shared = SharedStages(runs, self.study.numbered, self._stands) if others else self._shared
        searches = {search_name(stages.gravity): shared.points[stages.gravity] for stages in shared.of_runs.values()}
        of = {"stages": shared.points | searches, "runs": runs}
        return {f"{self.folder}/{place}/{name}.nc": point for place, points in of.items() for name, point in points.items()}

    @property
    def gravities(self) -> list[str]:
        """Names of all gravity stages."""
        return list(dict.fromkeys(stages.gravity for stages in self._shared.of_runs.values()))

    @property
    def trunks(self) -> list[str]:
        """Names of all shared pre-failure runs."""
        return list(dict.fromkeys(stages.trunk for stages in self._shared.of_runs.values()))

    @property
    def page_stages(self) -> list[str]:
        """Names of the stages whose cost the page counts: all, where it shows all runs."""
        return self.gravities + self.trunks if len(self.study.runs) <= MOST_SHOWN else []

    @property
    def slope(self) -> dict[str, Any]:
        """Scene of the first gravity stage, as a mapping."""
        return self.stage(self.gravities[0])

    @functools.cached_property
    def searches(self) -> dict[str, SlopeSearch]:
        """The search for the yield acceleration of the slope of every run, by run."""
        return self.searches_of(self.study.runs)

    def searches_of(self, runs: Iterable[str]) -> dict[str, SlopeSearch]:
        """The same of other runs, by the names of their files; none of runs of more than ``MOST_SLOPES`` slopes."""
        names = {run: search_name(self.stages(run).gravity) for run in runs}
        slopes = dict.fromkeys(names.values())
        if len(slopes) > MOST_SLOPES:
            return {}
        found = {name: SlopeSearch(f"{self.folder}/stages/{name}.nc", planned(self.stage(name))) for name in slopes}
        return {run: found[name] for run, name in names.items()}

    @functools.cached_property
    def dimensions(self) -> list[Dimension]:
        """The dimensions with units and meanings."""
        scene = self.built(**next(iter(self.study.runs.values())))
        return [dimension(name, values, scene) for name, values in self.study.values.items()]

    @property
    def profile_titles(self) -> list[str]:
        """Titles of the runs whose profiles are drawn: the dimensions in which runs of the study differ."""
        points = self.study.runs.values()
        differ = [dimension for dimension in self.dimensions if len({point[dimension.name] for point in points}) > 1]
        return [title_of(differ or self.dimensions, self.study.runs[name]) for name in self.study.profile_runs]

    @property
    def note(self) -> str:
        """The line on a figure of all runs."""
        return (
            f"fidelity {self.study.fidelity} · scene {self._base.get('name')} · {len(self.study.runs):,} runs of study {self.study.study}"
        )

    @property
    def layout(self) -> Layout:
        """How the study's tables are laid out."""
        listed = self.study.grid is None
        labels = () if listed else tuple(self.study.values.values())
        return Layout(tuple(found.variable(listed) for found in self.dimensions), labels, self.study.numbered)

    @property
    def parts(self) -> list[str]:
        """Names of the parts in which the runs are measured."""
        return [f"{number + 1:04d}" for number in range(-(-len(self.study.runs) // PART))]

    def part(self, name: str) -> dict[str, Point]:
        """The runs of a part, by name."""
        first = (int(name) - 1) * PART
        return dict(itertools.islice(self.study.runs.items(), first, first + PART))

    def part_searches(self, name: str) -> dict[str, SlopeSearch]:
        """The searches of the slopes of a part's runs, by run."""
        return {run: self.searches[run] for run in self.part(name) if run in self.searches}

    def validate(self) -> None:
        """Build every scene; ValueError with file and key for the first that is refused."""
        for name, overrides in self.study.fidelities.items():
            make_scene(merge(self._scene_file, overrides), f"{self.origin} at fidelity {name}")
        seen: dict[tuple[float | str | None, ...], str] = {}
        for name, point in self.study.runs.items():
            self.built(**point)
            first = seen.setdefault(tuple(map(value_of, point.values())), name)
            if first != name and self.study.cases is not None:
                at = ", ".join(f"{key} = {value}" for key, value in point.items())
                raise ValueError(f"cases: {first} and {name} are one run, {at}")
        self.study.figure_files  # noqa: B018  refuses what a figure lacks

    def built(self, **point: str) -> Scene:
        """The validated scene of a point; ValueError for one that cannot share its gravity stage or lacks the probe that is measured."""
        at = ", ".join(f"{name} = {value}" for name, value in point.items())
        scene = make_scene(self.scene(**point), f"{self.origin} at {at}" if at else self.origin)
        check_probe(self.study.metrics.probe, scene, f"{self.origin} at {at}" if at else self.origin)
        if scene.coupling.initial_state == "fluid":
            raise ValueError(
                f"{self.origin}: coupling.initial_state: 'fluid' feels S_R from the start, but the runs share the gravity stage; "
                "allowed in a study: 'solid' (a fluid scene runs by 'sph run')"
            )
        return scene


def read_study(data: Mapping[str, Any], origin: str) -> Study:
    """Validate the keys of a study; ValueError names ``origin``, key and value."""
    return validated(Study, data, origin)


def load_study(
    config: Mapping[str, Any] | Path | str,
    folders: Sequence[Path] = (Path(),),
    check: bool = True,
    read: Callable[[Mapping[str, Any], str], Study] = read_study,
) -> Plan:
    """Validate a configuration and, with ``check``, every scene in it; ValueError names file, key and value.

    ``folders`` are searched in order for the scene file and a file of cases; ``read`` makes the study of the keys, of any kind.
    """
    origin = "config" if isinstance(config, Mapping) else str(config)
    data = config if isinstance(config, Mapping) else read_yaml(config)
    cases = data["cases"] if isinstance(data.get("cases"), str) else None
    if cases is not None:
        data = {**data, "cases": read_cases(folders, cases)}
    study = read(_with_experiments(data, origin, check), origin)
    scene = found_file(folders, study.scene, f"{origin}: scene")
    plan = Plan(study, read_scene(scene), str(scene))
    if check:
        plan.validate()
        sources: list[Path | str] = [scene, *scene_files(plan.scene()), *([] if cases is None else [found_file(folders, cases, "cases")])]
        _check_apart(sources, Path(folders[0], "results", study.study), origin)
    return plan


FORMER_KEYS = ("trade", "validation", "limits", "extremes", "sensitivity", "trigger")
"""Experiments whose files the study named by keys of its own; taken until the next release."""


def _with_experiments(data: Mapping[str, Any], origin: str, warn: bool) -> Mapping[str, Any]:
    """A configuration with former keys put below ``experiments``, and a FutureWarning if so; ValueError where both name a file."""
    former = {name: data[name] for name in FORMER_KEYS if name in data}
    named = data.get("experiments", {})
    if not former or not isinstance(named, Mapping):
        return data
    for name in former:
        if name in named:
            raise ValueError(f"{origin}: {name}: is now experiments.{name}, which is there as well; leave one")
    if warn:
        wanted = one_line(", ".join(f"{name}: {file}" for name, file in former.items()))
        # Of this module: a warning of the frame above it, which may be the Snakefile, does not come through Snakemake.
        warnings.warn(f"{origin}: write experiments: {{{wanted}}}; as keys of the study they end with the next release", FutureWarning, 2)
    return {name: value for name, value in data.items() if name not in former} | {"experiments": {**former, **named}}


def _check_apart(sources: Iterable[Path | str], results: Path, origin: str) -> None:
    """Refuse a study whose files lie among its results, which are overwritten."""
    for file in map(Path, sources):
        if results.resolve() in file.resolve().parents:
            raise ValueError(f"{origin}: {file} lies in {results}, where results are written over; move it elsewhere")
