"""A study with its scene file read: its runs, the stages that they share and the files of both.

``load_study`` builds and validates the scene of every run, so that a typo is refused before any work.  What runs share is simulated
once (``sph.study.stages``).
"""

from __future__ import annotations

import functools
import itertools
import os
from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

from sph.measures.fields import check_probe
from sph.scene.configuration import dotted, found_file, merge, read_scene, read_yaml, scene_files
from sph.scene.schema import Scene, make_scene
from sph.storage.files import whole
from sph.study.dimensions import Dimension, dimension, named_point, scene_key, title_of, value_of
from sph.study.planned import planned
from sph.study.sampling import read_cases
from sph.study.schema import MOST_SHOWN, Point, Study, read_study
from sph.study.searches import SLOPE_LIMITS, SlopeSearch, search_name, searched_limit
from sph.study.stages import GRAVITY, SharedStages, Stages, stage_point
from sph.study.tables import MOST_SLOPES, Layout

PART = 500
"""Runs that are measured by one job."""


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
        limit = searched_limit(name)
        stage = name if limit is None else GRAVITY + name.removeprefix(limit)
        if stage in self._shared.points:
            return self._shared.points[stage]
        found = stage_point(stage, self.study.names) if self._named else None
        if found is None:
            what, known = ("stage", list(self._shared.points)) if limit is None else ("search", self._search_names(limit))
            raise ValueError(f"study {self.study.study!r} has no {what} {name!r}; the first are {', '.join(known[:3])}")
        return found

    def _search_names(self, limit: str) -> list[str]:
        return [search_name(gravity, limit) for gravity in self.gravities]

    def search_files(self, limit: str) -> list[str]:
        """Files of the searches for a limit of the study's slopes."""
        return [f"{self.folder}/stages/{name}.nc" for name in self._search_names(limit)]

    def gravity_of(self, pre_failure: str) -> str:
        """Name of the gravity stage of a shared pre-failure run."""
        found = self._shared.gravity_of
        return found[pre_failure] if pre_failure in found else self._shared.of(pre_failure, self._stage_point(pre_failure)).gravity

    def files(self, others: Mapping[str, Point] | None = None) -> dict[str, Point]:
        """The dimensions that the scene of each stage, search and run sets, by file; ``others`` are runs, by name, that the study lacks."""
        runs = self.study.runs | dict(others or {})
        shared = SharedStages(runs, self.study.numbered, self._stands) if others else self._shared
        gravities = {stages.gravity: shared.points[stages.gravity] for stages in shared.of_runs.values()}
        searches = {search_name(gravity, limit): point for gravity, point in gravities.items() for limit in SLOPE_LIMITS}
        of = {"stages": shared.points | searches, "runs": runs}
        return {f"{self.folder}/{place}/{name}.nc": point for place, points in of.items() for name, point in points.items()}

    @property
    def gravities(self) -> list[str]:
        """Names of all gravity stages."""
        return list(dict.fromkeys(stages.gravity for stages in self._shared.of_runs.values()))

    @property
    def pre_failures(self) -> list[str]:
        """Names of all shared pre-failure runs."""
        return list(dict.fromkeys(stages.pre_failure for stages in self._shared.of_runs.values()))

    @property
    def page_stages(self) -> list[str]:
        """Names of the stages whose cost the page counts: all, where it shows all runs."""
        return self.gravities + self.pre_failures if len(self.study.runs) <= MOST_SHOWN else []

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
        slopes = {run: self.stages(run).gravity for run in runs}
        if len(set(slopes.values())) > MOST_SLOPES:
            return {}
        names = {gravity: search_name(gravity) for gravity in slopes.values()}
        found = {
            gravity: SlopeSearch(name, f"{self.folder}/stages/{name}.nc", planned(self.stage(gravity))) for gravity, name in names.items()
        }
        return {run: found[gravity] for run, gravity in slopes.items()}

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
    study = read(data, origin)
    scene = found_file(folders, study.scene, f"{origin}: scene")
    plan = Plan(study, read_scene(scene), str(scene))
    if check:
        plan.validate()
        sources: list[Path | str] = [scene, *scene_files(plan.scene()), *([] if cases is None else [found_file(folders, cases, "cases")])]
        results = Path(folders[0], "results", study.study)
        _check_apart(sources, results, origin)
        _check_owner(results, study, origin)
    return plan


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
            raise ValueError(f"{origin}: {file} lies in {results}, where results are written over; move it elsewhere")
