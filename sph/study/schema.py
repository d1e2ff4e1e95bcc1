"""The keys of a study: one scene with some of its keys varied, at a fidelity (``config/config.yaml``).

The runs are a grid of values, a list of cases or a sample (``sph.study.sampling``); a dimension is any key of the scene, three of
which have short names.  Values stay the strings they were written as (``sph.study.dimensions``).
"""

from __future__ import annotations

import functools
import itertools
import math
from collections.abc import Mapping, Sequence
from typing import Annotated, Any, Literal

import numpy as np
import pandas as pd
from pydantic import AfterValidator, BeforeValidator, Field, model_validator

from sph.measures.fields import FIELDS, check_field
from sph.measures.metrics import MetricSettings
from sph.scene.configuration import Section, key, validated
from sph.scene.names import check_known
from sph.scene.scheme import has_key
from sph.scene.units import Acceleration, in_both
from sph.study.dimensions import (
    ALTERNATIVE,
    AMPLITUDE,
    BASE,
    CASE,
    SAME_LEVEL,
    SPACING,
    Value,
    Values,
    as_written,
    check_names,
    in_order,
    in_si,
    is_number,
    point_name,
    scene_key,
    value_of,
)
from sph.study.sampling import KINDS, MAX_RUNS, Sample

NAME = r"^[A-Za-z0-9][A-Za-z0-9_.-]{0,63}$"
MAX_NAME = 120
"""Longest file name of a run that is made of its dimensions, without suffix; where one is longer, runs are numbered."""
OWN = "own"
"""The fidelity of a study that names none: the scene as it is."""
INPUT_FIGURES = ("section", "motion", "particles")
"""Figures of the input, which need one run."""
MOBILISED = "mobilised"
"""The figure of one run at the end of its gravity stage."""
PROFILES = "profiles"
"""The figure of some runs at their end."""
OF_ALL_RUNS = {"study": 1, "map": 2}
"""The figures of all runs, with the fewest dimensions in which runs must differ for it to show anything."""
FEW_PROFILES, CANDIDATES = 4, 12
"""Runs that it shows where the study does not choose them, and most of the strongest shaking among which it chooses."""
MAX_SHOWN = 200
"""Most runs that the page shows, evenly through the study."""
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


def _known_field(name: str) -> str:
    check_field(name)
    return name


def _evenly(names: Sequence[str], most: int) -> list[str]:
    """At most so many of some names, evenly spread."""
    at = np.unique(np.linspace(0, len(names) - 1, min(max(most, 0), len(names))).round().astype(int))
    return [names[number] for number in at]


class FigureCases(Section):
    """Which runs figures show."""

    runs: tuple[str, ...] = key(
        "runs whose profiles are drawn, by the names of their files without suffix; none: four of the strongest shaking, of "
        "each alternative the one whose probe moves farthest before a second one, and others where there are fewer",
        default=(),
        max_length=12,
    )
    field: Annotated[str, AfterValidator(_known_field)] = key(
        f"quantity that colours these profiles: {', '.join(FIELDS)}", default="displacement"
    )


class Study(Section):
    """The configuration of the workflow."""

    study: str = key("name; results go to results/<study>/<fidelity>", pattern=NAME)
    scene: str = key("scene file, relative to the working folder or the workflow's folder")
    fidelity: str = key("name of the fidelity to run at", default=OWN)
    grid: Annotated[dict[str, Values], BeforeValidator(_dimensions_kept), Field(min_length=1)] | None = key(
        "values of each dimension, every combination is run; quote them to keep trailing zeros; dimensions: S_R, gamma, amplitude "
        "or any dotted key of the scene that takes a number or a word",
        source="Figs. 4-5, Sec. 3.2",
        default=None,
    )
    cases: Cases | None = key(
        "instead of a grid: the runs one by one, with a value for each dimension; or the name of a CSV file with one column per dimension",
        default=None,
    )
    sample: Sample | None = key("instead of a grid: runs that fill ranges of the dimensions", default=None)
    alternatives: dict[Annotated[str, Field(pattern=r"^[A-Za-z][A-Za-z0-9_.-]{0,31}$")], dict[str, Any]] = key(
        f"scene keys of each alternative, by name: every run is made for the scene as it is ({BASE}) and for each of them, unless the grid "
        f"has a dimension {ALTERNATIVE} of its own; files as seen from the working folder",
        default={},
        max_length=20,
    )
    assumed: dict[str, str] = key(
        "what of the scene nobody has measured, in words by its key: the page names it", default={}, max_length=40
    )
    fidelities: dict[Annotated[str, Field(pattern=NAME)], dict[str, Any]] = key(
        "scene keys that each fidelity sets, by name", default={OWN: {}}, min_length=1
    )
    second_fidelity: str | None = key(
        "one of the fidelities, with another spacing, at which every run is repeated, so that the page shows what the spacing changes; at "
        "that fidelity itself only those runs are, with the next finer spacing of the fidelities, that decide in what shaking the slope "
        "fails; null: none",
        default=None,
    )
    design: Acceleration | None = key(
        "amplitude of the shaking that the page answers first, one of those of the runs; null: the largest",
        "m/s2",
        default=None,
        gt=0,
        le=100,
    )
    figures: FigureCases = key("runs shown in figures", default=FigureCases())
    searches: Literal["full", "quick", "none"] = key(
        "what is found of the unshaken slopes beside the runs; none: limit equilibrium alone; quick: also static tests and the factor of "
        "safety at coarse spacings; full: also the yield acceleration of every slope with particles, and by it the sliding block",
        default="full",
    )
    on_error: Literal["stop", "go_on"] = key(
        "what happens where an error is found of the unshaken slopes, as of one that fails or a layer that particles do not resolve; stop: "
        "no run is started, and none further where a test beside the runs finds it; go_on: all are",
        default="stop",
    )
    yield_acceleration: Literal["mean", "each"] = key(
        "for uncertain soil: mean, one search at the means of the distributions, shared by all draws; each, a search for each draw",
        default="mean",
    )
    backend: Literal["cpu", "cuda"] = key(
        "what advances the runs: cpu, or cuda, a graphics card of NVIDIA, on which runs advance together; searches stay on processors",
        default="cpu",
    )
    page: Literal["full", "client"] = key(
        "client: the page leaves out keys, paths, commands, costs and sections that have not been made yet, and has project, author and "
        "date",
        default="full",
    )
    project: str = key("project that the client's page is for", default="", max_length=200)
    author: str = key("who answers for the client's page", default="", max_length=200)
    metrics: MetricSettings = key("thresholds of the metrics", default=MetricSettings())
    experiments: dict[str, str] = key(
        "file of an experiment, by the name of its target, found like the scene; config/<name>.yaml for targets that are left out",
        default={},
    )

    @model_validator(mode="before")
    @classmethod
    def _title_of_scene(cls, data: Any) -> Any:
        if isinstance(data, Mapping) and "title" in data:
            raise ValueError("title: is a key of the scene, whose title heads the page; write it in the scene file, and leave it out here")
        return data

    @model_validator(mode="after")
    def _known(self) -> Study:
        check_known("fidelity", [self.fidelity], self.fidelities)
        check_known("second_fidelity", [self.second_fidelity] if self.second_fidelity else (), self.fidelities)
        return self

    @model_validator(mode="after")
    def _runs_known(self) -> Study:
        chosen = [kind for kind in KINDS if getattr(self, kind) is not None]
        if len(chosen) != 1:
            raise ValueError(f"give the runs by exactly one of {', '.join(KINDS)} (found {' and '.join(chosen) or 'none'})")
        if self.sample is not None:
            check_names("sample.ranges", self.sample.ranges)
        elif self.grid is not None:
            check_names("grid", self.grid)
            for name, values in self.grid.items():
                if len({value_of(value) for value in values}) < len(values):
                    raise ValueError(f"grid.{name}: {list(values)} contains the same value twice")
            runs = math.prod(len(values) for values in self.grid.values())
            if runs > MAX_RUNS:
                raise ValueError(f"grid: {', '.join(self.grid)}: the grid has {runs:,} points, at most {MAX_RUNS:,}")
        else:
            assert self.cases is not None
            check_names("cases", self.cases[0])
            if len(self.cases) > MAX_RUNS:
                raise ValueError(f"cases: {len(self.cases):,} runs, at most {MAX_RUNS:,}")
            for number, case in enumerate(self.cases, 1):
                if set(case) != set(self.cases[0]):
                    raise ValueError(
                        f"cases: case {number} sets {', '.join(case)}, the first {', '.join(self.cases[0])}; all must set the same keys"
                    )
        return self

    @model_validator(mode="after")
    def _design_run(self) -> Study:
        levels = [float(value) for value in self.values.get(AMPLITUDE, ()) if is_number(value)] if self.design is not None else []
        if self.design is not None and not any(math.isclose(level, self.design, rel_tol=SAME_LEVEL) for level in levels):
            those = ", ".join(map(in_both, sorted(set(levels)))) or "none"
            raise ValueError(f"design: {in_both(self.design)}: must be one of the amplitudes of the runs, which are {those}")
        return self

    @model_validator(mode="after")
    def _searched(self) -> Study:
        if self.yield_acceleration == "each" and self.searches != "full":
            raise ValueError(f"yield_acceleration: each asks for searches that searches: {self.searches} leaves out; write searches: full")
        return self

    @model_validator(mode="after")
    def _alternatives_apart(self) -> Study:
        taken = [name for name in self.alternatives if name in (BASE, "null")]
        if taken:
            raise ValueError(f"alternatives.{taken[0]}: is the name of the scene as it is, or of nothing; choose another")
        for name, keys in self.alternatives.items():
            both = [each for each in self.names if each != ALTERNATIVE and has_key(keys, scene_key(each))]
            if both:
                raise ValueError(
                    f"alternatives.{name}: {scene_key(both[0])}: is a dimension of the runs, which would replace it; leave out one"
                )
        return self

    @model_validator(mode="after")
    def _one_spacing_a_fidelity(self) -> Study:
        if self.second_fidelity not in (None, self.fidelity) and SPACING in self.names:
            raise ValueError(
                f"second_fidelity: {self.second_fidelity!r} has no spacing of its own, since {SPACING} is a dimension of the runs; "
                "leave out one of the two"
            )
        return self

    @functools.cached_property
    def names(self) -> list[str]:
        """The dimensions, in the order of file names and tables."""
        own = in_order(self.grid or (self.sample.ranges if self.sample else self.cases[0] if self.cases else ()))
        return own if ALTERNATIVE in own or not self.alternatives else [*own, ALTERNATIVE]

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
            if self.alternatives and points and ALTERNATIVE not in points[0]:
                points = [{**point, ALTERNATIVE: name} for point in points for name in self._alternatives]
            return {name: tuple(point[name] for point in points) for name in self.names}
        grid = {ALTERNATIVE: self._alternatives, **self.grid}
        return {name: tuple(sorted(grid[name], key=float) if all(map(is_number, grid[name])) else grid[name]) for name in self.names}

    @property
    def _alternatives(self) -> tuple[str, ...]:
        return (BASE, *self.alternatives)

    @functools.cached_property
    def numbered(self) -> bool:
        """Whether the names of runs are numbers: in a list, and in a grid whose dimensions make too long a name."""
        longest = point_name({name: max(values, key=len) for name, values in self.values.items()})
        return self.grid is None or len(longest) > MAX_NAME

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
        wanted = {*_evenly(names, most - len(chosen)), *chosen}
        return [name for name in names if name in wanted]

    @property
    def page_runs(self) -> list[str]:
        """Names of the runs that the page shows."""
        few = len(self.runs) <= MAX_SHOWN
        return list(self.runs) if few else self.shown_runs(MAX_SHOWN, self.figure_files.get(PROFILES, []))

    @property
    def figure_files(self) -> dict[str, list[str]]:
        """Names of the runs from which a figure is drawn, by the name of its file; ValueError where the study lacks what one needs.

        The figures of all runs (``OF_ALL_RUNS``) are not among them.
        """
        return dict.fromkeys((*INPUT_FIGURES, MOBILISED), list(self.runs)[:1]) | {PROFILES: self.profile_runs}

    @property
    def left_out(self) -> dict[str, str]:
        """Figures that cannot be drawn of this study, or would show nothing, with the reason."""
        varied = sum(len(set(values)) > 1 for values in self.values.values())
        differ = {0: "there is one run", 1: "the runs differ in one dimension"}
        return {name: differ[varied] for name, needed in OF_ALL_RUNS.items() if varied < needed}

    def why_without(self, figure: str) -> str:
        """Why this study has no figure of that name."""
        return self.left_out.get(figure) or f"study {self.study!r} has {', '.join(self.figure_files)}"

    def figure_titles(self, figure: str) -> list[list[str]]:
        """Titles of the runs of a figure: its panel, if it has several, and its curve or profile; none where it shows one run."""
        return []

    @property
    def profile_runs(self) -> list[str]:
        """Names of the runs among which are those whose profiles are drawn: those asked for, or else those of ``profile_groups``."""
        if self.figures.runs:
            return self.shown_runs(0, self.figures.runs)
        return [name for group in self.profile_groups for name in group]

    @property
    def profile_groups(self) -> list[list[str]]:
        """Names of the runs among which the figure of profiles chooses those that it shows: of each group one before a second.

        Those of the strongest shaking are a group for each alternative, of at most ``CANDIDATES`` runs in all, or without alternatives
        those that it shows, evenly; where they are fewer, runs of weaker shakings follow, each by itself.  None where the study asks for
        runs.
        """
        if self.figures.runs:
            return []
        strongest = dict[str, list[str]]()
        for name in self.strongest_runs:
            strongest.setdefault(self.runs[name].get(ALTERNATIVE, BASE), []).append(name)
        most = max(CANDIDATES // len(strongest), 1) if len(strongest) > 1 else FEW_PROFILES
        groups = [_evenly(names, most) for names in strongest.values()][:CANDIDATES]
        others = [name for name in self.runs if name not in self.strongest_runs]
        own = [name for name in others if self.runs[name].get(ALTERNATIVE, BASE) == BASE] or others
        return groups + [[name] for name in reversed(_evenly(own, FEW_PROFILES - sum(map(len, groups))))]

    @functools.cached_property
    def strongest_runs(self) -> dict[str, Point]:
        """The runs of the strongest shaking by name; all where the study does not vary it."""
        shaking = {name: float(point.get(AMPLITUDE, 0.0)) for name, point in self.runs.items()}
        strongest = max(shaking.values())
        return {name: self.runs[name] for name, amplitude in shaking.items() if amplitude == strongest}

    @classmethod
    def read(cls, data: Mapping[str, Any], origin: str) -> Study:
        """Validate the keys of a study; ValueError names ``origin``, key and value."""
        return validated(cls, data, origin)
