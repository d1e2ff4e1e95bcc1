"""A study with its scene file read: its runs, the stages that they share and the files of both.

``load_study`` builds and validates the scene of every run, so that a typo is refused before any work.  What runs share is simulated
once (``sph.study.runs``).
"""

from __future__ import annotations

import functools
import itertools
import os
import re
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

from sph.measures.fields import check_probe
from sph.measures.places import check_places, check_same_places, place_columns
from sph.scene.configuration import found_file, merge, read_scene, read_yaml, scene_files
from sph.scene.schema import Scene, check_unit, written_amplitude
from sph.stability.record import YIELD
from sph.storage.files import whole
from sph.study.dimensions import (
    ALTERNATIVE,
    AMPLITUDE,
    BASE,
    RECORD,
    SYMBOLS,
    Dimension,
    dimension,
    scene_key,
    short_names,
    title_of,
    value_of,
)
from sph.study.runs import BaseScene, Kind, PlannedRun, SharedRuns
from sph.study.sampling import read_cases
from sph.study.schema import MAX_SHOWN, PROFILES, Point, Study
from sph.study.tables import MAX_SLOPES, Layout

PART = 500
"""Runs that are measured by one job."""
TOLD = 3
"""Most values of a dimension that a title names."""


class Plan:
    """A study with its scene file read: the scene of every stage and run, as mappings."""

    def __init__(
        self, study: Study, base: Mapping[str, Any], origin: str, overrides: Mapping[str, Any] | None = None, subfolder: str = ""
    ) -> None:
        self.study, self.origin, self._subfolder = study, origin, subfolder
        self._scene_file = base
        self._base = BaseScene(merge(merge(base, study.fidelities[study.fidelity]), overrides or {}), study.alternatives)
        self._standing: dict[tuple[tuple[str, str], ...], bool] = {}

    @property
    def folder(self) -> str:
        """Where the results go, relative to the working folder."""
        return "/".join(part for part in ("results", self.study.study, self.study.fidelity, self._subfolder) if part)

    def at(self, fidelity: str, overrides: Mapping[str, Any] | None = None, subfolder: str = "", origin: str = "") -> Plan:
        """The same study at one of its fidelities, with scene keys laid over it, its results in a folder below."""
        study = self.study.model_copy(update={"fidelity": fidelity})
        return Plan(study, self._scene_file, origin or self.origin, overrides, subfolder)

    def scene(self, **point: str) -> dict[str, Any]:
        """Scene with some of the dimensions set, as a mapping."""
        return self._base.at(point)

    def over(self, grid: Mapping[str, Sequence[str]]) -> Plan:
        """The same scenes as a grid over other dimensions; ValueError where its runs would have no names by their values."""
        kept = self.study.model_dump(
            include={"study", "scene", "fidelity", "fidelities", "metrics", "experiments", "searches", "yield_acceleration", "alternatives"}
        )
        if ALTERNATIVE not in grid:
            kept.pop("alternatives")
        study = Study(**kept, grid={name: tuple(values) for name, values in grid.items()})
        if study.numbered:
            raise ValueError(
                f"{self.origin}: {', '.join(grid)}: with these dimensions the names of runs become too long or contain a folder"
            )
        return Plan(study, self._scene_file, self.origin)

    def experiment_file(self, name: str) -> str:
        """File that configures an experiment on the study's own scene.

        ValueError for the user's own scene whose study names none: what ``config`` has is for the paper's.
        """
        if name not in self.study.experiments and self._base.keys.get("scheme") != "paper":
            raise ValueError(
                f"experiments.{name}: study {self.study.study!r} has a scene of its own and must name the file that configures {name}; "
                f"{self.study.file_of(name)} is for the paper's scene, and an example"
            )
        return self.study.file_of(name)

    @functools.cached_property
    def shared(self) -> SharedRuns:
        """The runs of the study, with their stages and the searches of their slopes."""
        return self.runs_at(self.study.runs)

    def runs_at(self, points: Mapping[str, Point]) -> SharedRuns:
        """The same of other runs, by name."""
        each = self.study.yield_acceleration == "each"
        return SharedRuns(points, PlannedRun(self._base, folder=self.folder), self.study.numbered, self._stands, each)

    def _stands(self, point: Mapping[str, str]) -> bool:
        at = tuple(point.items())
        if at not in self._standing:
            try:
                self.built(**point)
                self._standing[at] = True
            except ValueError:
                self._standing[at] = False
        return self._standing[at]

    @property
    def jobs(self) -> list[PlannedRun]:
        """Everything that is run for the study: stages, runs, and the searches for its yield accelerations."""
        searched = {search.file for search in self.searches.values()}
        own = [run for run in self.shared if run.kind != Kind.SEARCH or run.file in searched]
        return own + (self.second_runs if self.repeats_all else [])

    @functools.cached_property
    def second(self) -> Plan | None:
        """The study at another spacing: at its second fidelity, or, where it runs at that one, at the fidelity with the next finer spacing;
        None where there is none, and for what lies in a folder below that of the study."""
        if not self.study.second_fidelity or self._subfolder:
            return None
        if self.repeats_all:
            return self.at(self.study.second_fidelity)
        plans = [self.at(name) for name in self.study.fidelities if AMPLITUDE in self.study.names]
        finer = [plan for plan in plans if plan.spacing < self.spacing]
        return max(finer, key=lambda plan: plan.spacing, default=None)

    @property
    def repeats_all(self) -> bool:
        """Whether every run is repeated at the second spacing, and not just those that decide in what shaking the slope fails."""
        return self.study.second_fidelity != self.study.fidelity

    @property
    def spacing(self) -> float:
        """Spacing of the first run, m."""
        return self.built(**next(iter(self.study.runs.values()))).numerics.spacing

    @property
    def draft(self) -> Plan | None:
        """The study at its second fidelity where that is the coarser one, and so the sooner done."""
        return self.second if self.second and self.second.spacing > self.spacing else None

    @property
    def second_runs(self) -> list[PlannedRun]:
        """Stages and runs at the second spacing, of which only some are made unless all are repeated."""
        return self._repeated(self.second.shared) if self.second else []

    def repeated(self, names: Iterable[str]) -> list[PlannedRun]:
        """Those of some runs."""
        return self._repeated(self.second.runs_at({name: self.study.runs[name] for name in names})) if self.second else []

    def _repeated(self, shared: SharedRuns) -> list[PlannedRun]:
        at = f"fidelity {self.second.study.fidelity}" if self.second else ""
        return [run._replace(group=f"{run.group} at {at}", target=at) for run in shared if run.kind != Kind.SEARCH]

    @property
    def slope(self) -> PlannedRun:
        """The first gravity stage."""
        return self.shared.gravities[0]

    @functools.cached_property
    def searches(self) -> dict[str, PlannedRun]:
        """The search for the yield acceleration of the slope of every run, by run."""
        return self.searches_of(self.shared)

    def searches_of(self, shared: SharedRuns) -> dict[str, PlannedRun]:
        """The same of other runs; none where the study's ``searches`` are not ``full``, nor of runs of more than ``MAX_SLOPES`` slopes, of
        which all draws of uncertain soil are one unless each is searched."""
        few = self.study.searches == "full" and len(shared.searches(YIELD)) <= MAX_SLOPES
        return {run: shared.search_of(run) for run in shared.runs} if few else {}

    @property
    def page_runs(self) -> list[PlannedRun]:
        """The runs that the page shows."""
        return [self.shared.runs[name] for name in self.study.page_runs]

    @property
    def page_stages(self) -> list[PlannedRun]:
        """The stages whose cost the page counts: all, where it shows all runs."""
        return self.shared.gravities + self.shared.pre_failures if len(self.study.runs) <= MAX_SHOWN else []

    def figure_runs(self, figure: str) -> list[PlannedRun]:
        """The runs from which a figure is drawn, by the name of its file; ValueError for one that the study does not have."""
        shown = self.study.figure_files
        if figure not in shown:
            raise ValueError(f"{figure}: {self.study.why_without(figure)}")
        names = self.study.profile_runs if figure == PROFILES else shown[figure]
        return [self.shared.runs[name] for name in names]

    @functools.cached_property
    def dimensions(self) -> list[Dimension]:
        """The dimensions with units and meanings."""
        scene = self.built(**next(iter(self.study.runs.values())))
        dimensions = [dimension(name, values, scene) for name, values in self.study.values.items()]
        dimensions = [each._replace(names=self._records()) if each.name == RECORD else each for each in dimensions]
        return [each._replace(plainly=True) for each in dimensions] if self.study.page == "client" else dimensions

    @functools.cached_property
    def drawn_dimensions(self) -> list[Dimension]:
        """The dimensions as figures call them: in words where none has a symbol, so that a page for a client has the same figures."""
        plain = [each._replace(plainly=True) for each in self.dimensions]
        return self.dimensions if any(symbol in each.phrase for symbol in SYMBOLS for each in self.dimensions) else plain

    def _records(self) -> tuple[tuple[str, str], ...]:
        """The records of the study, as written, with what they are called: by their names where each has one of its own, else by their
        files."""
        first = {point[RECORD]: point for point in reversed(self.study.runs.values())}
        motions = {written: self.built(**point).motion for written, point in first.items()}
        names = {written: name for written, motion in motions.items() if (name := getattr(motion, "name", None))}
        own = len(set(names.values())) == len(motions)  # one that the scene gives is not that of all
        return tuple((names if own else short_names(list(motions))).items())

    def figure_titles(self, figure: str) -> list[list[str]]:
        """Titles of the runs of a figure: of profiles the dimensions in which runs of the study differ; none where it shows one run."""
        if figure != PROFILES:
            return self.study.figure_titles(figure)
        points, told = self.study.runs.values(), AMPLITUDE if self._all_strongest else ""
        differ = [each for each in self.drawn_dimensions if each.name != told and len({point[each.name] for point in points}) > 1]
        return [[title_of(differ or self.drawn_dimensions, self.study.runs[name])] for name in self.study.profile_runs]

    @property
    def other_shakings(self) -> str:
        """How the shaking of other runs of the study differs from that of its first, in words; nothing where all are shaken alike."""
        said, first = list[str](), next(iter(self.study.runs.values()))
        for each in self.drawn_dimensions:
            others = [value for value in dict.fromkeys(self.study.values[each.name]) if value != first[each.name]]
            if not others or not scene_key(each.name).startswith("motion."):
                continue
            if each.name == AMPLITUDE and float(first[AMPLITUDE]):
                scales = [f"× {float(value) / float(first[AMPLITUDE]):.3g}" for value in others]
            else:
                scales = [each.said(value) for value in others]
            said.append(
                " and ".join(scales) if len(scales) <= TOLD else f"{scales[0]} to {scales[-1]}" if "×" in scales[0] else each.symbol
            )
        return ", also ".join(said)

    @property
    def profile_choice(self) -> dict[str, Any]:
        """Among which files the figure of profiles chooses, by groups, and of how many runs, by what rule; no groups where none is left."""
        groups, size = self.study.profile_groups, len(self.study.runs)
        words, rule = f"{size:,} runs", ""
        if self._all_strongest:
            point = next(iter(self.study.strongest_runs.values()))
            at = next((each.said(point[AMPLITUDE]) for each in self.drawn_dimensions if each.name == AMPLITUDE), "")
            words, size = f"the {len(self.study.strongest_runs):,} runs with the strongest shaking, {at}", len(self.study.strongest_runs)
        if len(groups) > 1 and any(len(group) > 1 for group in groups):
            level = "" if self._all_strongest or AMPLITUDE not in self.study.names else " in the strongest shaking"
            each = "of each alternative " * (ALTERNATIVE in self.study.names)
            rule = f": {each}first the one in which {self.study.metrics.probe} moves farthest{level}"
        elif groups:
            rule = ": evenly through the study"
        files = [[self.shared.runs[name].file for name in group] for group in groups]
        return {"groups": files, "of": words, "size": size, "rule": rule, "probe": self.study.metrics.probe}

    @property
    def _all_strongest(self) -> bool:
        """Whether the study varies the shaking, and its profiles are all of the strongest."""
        names, strongest = [name for group in self.study.profile_groups for name in group], self.study.strongest_runs
        return len(strongest) < len(self.study.runs) and bool(names) and all(name in strongest for name in names)

    @property
    def note(self) -> str:
        """The line on a figure of all runs."""
        scene, runs = self._base.keys.get("name"), len(self.study.runs)
        return f"fidelity {self.study.fidelity} · scene {scene} · {runs:,} runs of study {self.study.study}"

    @property
    def layout(self) -> Layout:
        """How the study's tables are laid out."""
        listed = self.study.grid is None
        labels = () if listed else tuple(self.study.values.values())
        axes, places = tuple(dimension.variable(listed) for dimension in self.dimensions), place_columns(self.study.metrics.places)
        return Layout(axes, labels, self.study.numbered, places)

    @property
    def parts(self) -> list[str]:
        """Names of the parts in which the runs are measured."""
        return [f"{number + 1:04d}" for number in range(-(-len(self.study.runs) // PART))]

    def part(self, name: str) -> list[PlannedRun]:
        """The runs of a part."""
        first = (int(name) - 1) * PART
        return list(itertools.islice(self.shared.runs.values(), first, first + PART))

    def validate(self) -> None:
        """Build every scene; ValueError with file and key for the first that is refused."""
        plans = {plan.study.fidelity: plan for plan in (self, self.second) if plan}
        for name in self.study.fidelities:
            plans.get(name, self.at(name))._base.built({}, f"{self.origin} at fidelity {name}")
        seen: dict[tuple[float | str | None, ...], str] = {}
        for name, point in self.study.runs.items():
            self.built(**point)
            if self.second:
                self.second.built(**point)
            first = seen.setdefault(tuple(map(value_of, point.values())), name)
            if first != name and self.study.cases is not None:
                at = ", ".join(f"{key} = {value}" for key, value in point.items())
                raise ValueError(f"cases: {first} and {name} are the same run, {at}")
        self.study.figure_files  # noqa: B018  refuses what a figure lacks

    def built(self, **point: str) -> Scene:
        """The validated scene of a point; ValueError for one that cannot share its gravity stage or lacks the probe that is measured."""
        at = ", ".join(f"{name} = {value}" for name, value in point.items())
        origin = f"{self.origin} at {at}" if at else self.origin
        scene = self._base.built(point, origin)
        check_probe(self.study.metrics.probe, scene, origin)
        check_places(self.study.metrics.places, scene, origin)
        if point.get(ALTERNATIVE, BASE) != BASE:
            check_same_places(self.study.metrics.places, scene, self._base.built({**point, ALTERNATIVE: BASE}, origin), origin)
        if scene.coupling.initial_state == "fluid":
            raise ValueError(
                f"{self.origin}: coupling.initial_state: 'fluid' feels S_R from the start, but the runs share the gravity stage; "
                "allowed in a study: 'solid' (a fluid scene runs by 'sph run')"
            )
        return scene


def load_study(
    config: Mapping[str, Any] | Path | str,
    folders: Sequence[Path] = (Path(),),
    check: bool = True,
    kind: type[Study] = Study,
) -> Plan:
    """Validate a configuration and, with ``check``, every scene in it; ValueError names file, key and value.

    ``folders`` are searched in order for the scene file and a file of cases; ``kind`` says which keys a study may have.
    """
    origin = "config" if isinstance(config, Mapping) else str(config)
    data = config if isinstance(config, Mapping) else read_yaml(config)
    cases = data["cases"] if isinstance(data.get("cases"), str) else None
    if cases is not None:
        data = {**data, "cases": read_cases(folders, cases)}
    study = kind.read(data, origin)
    scene = found_file(folders, study.scene, f"{origin}: scene")
    plan = Plan(study, read_scene(scene), str(scene))
    if check:
        plan.validate()
        _check_units(plan, data, str(scene), origin)
        sources: list[Path | str] = [scene, *scene_files(plan.scene()), *([] if cases is None else [found_file(folders, cases, "cases")])]
        results = Path(folders[0], "results", study.study)
        _check_apart(sources, results, origin)
        _check_owner(results, study, origin)
    return plan


def _check_units(plan: Plan, data: Mapping[str, Any], scene: str, origin: str) -> None:
    """Refuse amplitudes without a unit that may be meant in g: that of the scene, where no dimension is, and a grid of such alone."""
    first, grid = plan.built(**next(iter(plan.study.runs.values()))), data.get("grid")
    if "amplitude" not in plan.study.names:
        check_unit(written_amplitude(read_yaml(scene)), first, f"{scene}: motion.amplitude")
    elif isinstance(grid, Mapping) and grid.get("amplitude"):
        with_units = [text for text in grid["amplitude"] if isinstance(text, str) and not re.fullmatch(r"[\d.\s]+", text)]
        largest = with_units[0] if with_units else max(grid["amplitude"], key=float)
        check_unit(largest, first, f"{origin}: grid.amplitude")


OWNER = "scene_file.txt"
"""In the folder of a study's results: the scene file that they are of, as the study names it."""


def owner_of(study: Study) -> str:
    """Scene file of a study, as it is written into the folder of its results."""
    return os.path.normpath(study.scene)


def claim_results(plan: Plan, folder: Path | str = ".") -> None:
    """Write into the folder of a study's results, below the working ``folder``, which scene file they are of; an earlier file stays."""
    path = Path(folder, "results", plan.study.study, OWNER)
    if not path.exists():
        path.parent.mkdir(parents=True, exist_ok=True)
        with whole(path) as temporary:
            temporary.write_text(owner_of(plan.study) + "\n", encoding="utf-8")


def _check_owner(results: Path, study: Study, origin: str) -> None:
    """Refuse a study whose results would take the place of those of another scene file; one without a note of it is taken as its own."""
    path = results / OWNER
    try:
        owner = path.read_text(encoding="utf-8").strip()
    except FileNotFoundError:
        return
    except (OSError, ValueError) as error:
        raise ValueError(f"{path}: cannot be read: {error}; delete it if the results beside it may be replaced") from error
    if owner != owner_of(study):
        raise ValueError(
            f"{origin}: study: {study.study!r}: {results} holds results of the scene {owner}, and this study has {owner_of(study)}; "
            f"give it another name (study: NAME), or, if the scene file was only moved or its results may be replaced, delete {path}"
        )


def _check_apart(sources: Iterable[Path | str], results: Path, origin: str) -> None:
    """Refuse a study whose files lie among its results, which are overwritten."""
    for file in map(Path, sources):
        if results.resolve() in file.resolve().parents:
            raise ValueError(f"{origin}: {file} lies in {results}, where results are overwritten; move it elsewhere")
