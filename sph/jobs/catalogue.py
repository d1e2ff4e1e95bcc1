"""Every run that is planned below a working folder: of a study, of the experiments on its scene, and of those that stand alone.

The rows of a study and of a stand-alone experiment follow from its configuration, those of the searches for critical intensities and of
the sensitivity analysis also from the tables that they have written so far.  The workflow makes what stands here and keeps it, as
``plan.json``, with the results; ``sph status``, ``sph cost`` and ``sph explain`` ask here what there is to be done or what a file holds.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path, PurePath
from typing import Any

from sph.experiments.registry import CONFIGURED, EXPERIMENTS
from sph.experiments.sensitivity.design import BACK_FILE, FACTORS_FILE, SensitivityPlan
from sph.experiments.sensitivity.design import FOLDER as SENSITIVITY
from sph.experiments.trigger.design import FOLDER as TRIGGER
from sph.experiments.trigger.design import TriggerPlan
from sph.experiments.variants.design import EARLIER
from sph.experiments.variants.second_spacing import DECIDING, read_deciding
from sph.scene.names import check_known
from sph.scene.strict_json import to_json
from sph.storage.files import whole
from sph.study.plan import Plan
from sph.study.runs import PlannedRun

FILE = "plan.json"
"""In the folder of results: the runs that are planned there."""
ALONE = {each.folder: name for name, each in EXPERIMENTS.items() if each.alone}
"""Experiments whose results belong to no study, by the folder of these."""


class Catalogue:
    """The runs of a study's configuration and of those that it names, each read when it is asked for."""

    def __init__(self, plan: Plan, folders: Sequence[Path], base: Path = Path(), check: bool = True) -> None:
        for name in EARLIER.keys() & plan.study.experiments.keys():
            raise ValueError(
                f"config: experiments.{name}: is called {EARLIER[name]} now, and its file has the keys of config/{EARLIER[name]}.yaml"
            )
        check_known("config: experiments", plan.study.experiments, CONFIGURED)
        self.plan, self.base, self._folders, self._check = plan, base, folders, check
        self._known: dict[str, tuple[tuple[tuple[Path, int], ...], dict[str, PlannedRun]]] = {}
        self._designs: dict[str, Any] = {}

    def design(self, name: str) -> Any:
        """An experiment with its configuration read; ValueError names file, key and value."""
        if name not in self._designs:
            experiment = EXPERIMENTS[name]
            file = self.plan.study.file_of(name) if experiment.alone or not experiment.keys else self.plan.experiment_file(name)
            self._designs[name] = experiment.plan(file, self.plan, self._folders, self._check or experiment.alone)
        return self._designs[name]

    def refuses(self, file: str) -> bool:
        """Whether a file below the study's results is one of an experiment whose configuration is refused, so that no rule can make it."""
        name = PurePath(file).relative_to(PurePath(self.plan.folder).parent).parts[1]
        if name in EXPERIMENTS:
            try:
                self.design(name)
            except ValueError:
                return True
        return False

    @property
    def trigger(self) -> TriggerPlan:
        """The searches for critical intensities."""
        plan: TriggerPlan = self.design("trigger")
        return plan

    @property
    def sensitivity(self) -> SensitivityPlan:
        """The designs of the sensitivity analysis."""
        plan: SensitivityPlan = self.design("sensitivity")
        return plan

    def row(self, file: str) -> PlannedRun:
        """The row of a file, relative to the working folder; ValueError where none is."""
        folder = next((folder for folder in ALONE if file.startswith(f"{folder}/runs/")), None)
        if folder is not None:
            return _among(self._rows(folder, (), lambda: self.design(ALONE[folder]).runs.values()), file)
        if file.startswith(f"{self.plan.folder}/{SENSITIVITY}/runs/"):
            return _among(self.sampled, file)
        return self.own[file] if file in self.own else _among(self.searched, file)

    @property
    def own(self) -> dict[str, PlannedRun]:
        """The runs, stages and searches of the study, by file."""
        return self._rows(self.plan.folder, (), lambda: (*self.plan.shared, *self.plan.second_runs))

    @property
    def searched(self) -> dict[str, PlannedRun]:
        """What the searches for critical intensities need and have asked for so far, by file."""
        return self._rows(TRIGGER, [path for _, path in self.trigger.tables(self.base)], lambda: self.trigger.so_far(self.base))

    @property
    def sampled(self) -> dict[str, PlannedRun]:
        """The runs of the sensitivity analysis that are known so far, by file."""
        place = self.base / self.plan.folder / SENSITIVITY
        tables = [place / name for name in (FACTORS_FILE, BACK_FILE) if (place / name).is_file()]
        return self._rows(SENSITIVITY, tables, lambda: self.sensitivity.so_far(self.base))

    @property
    def repeated(self) -> list[PlannedRun]:
        """The runs that are repeated at a second spacing where not all are, once these are known, with their stages."""
        path = self.base / self.plan.folder / DECIDING
        return self.plan.repeated(read_deciding(path)) if not self.plan.repeats_all and path.is_file() else []

    @property
    def started(self) -> list[PlannedRun]:
        """Runs of the searches and of the analysis that have been started, without those that are the study's own, and those that are
        repeated."""
        place = self.base / self.plan.folder
        searched = self.searched.values() if (place / TRIGGER).is_dir() else ()
        sampled = self.sampled.values() if (place / SENSITIVITY).is_dir() else ()
        return [run for run in (*searched, *sampled) if run.target and run.file not in self.own] + self.repeated

    def _rows(self, name: str, tables: Sequence[Path], made: Callable[[], Iterable[PlannedRun]]) -> dict[str, PlannedRun]:
        """Rows by file, made anew when a table from which they follow has changed."""
        now = tuple((table, table.stat().st_mtime_ns) for table in tables)
        if name not in self._known or self._known[name][0] != now:
            rows: dict[str, PlannedRun] = {}
            for run in made():
                rows.setdefault(run.file, run)
            self._known[name] = now, rows
        return self._known[name][1]

    def write(self) -> None:
        """Write what is planned, of what has been asked for here, into the folders of its results."""
        asked = {**self.searched} if TRIGGER in self._known else {}
        asked |= self.sampled if SENSITIVITY in self._known else {}
        for folder in self._known.keys() & {self.plan.folder, *ALONE}:
            rows = list(self._known[folder][1].values())
            if folder == self.plan.folder:
                rows = self.plan.jobs + self.repeated + [run for run in asked.values() if run.file not in self.own]
            path = self.base / folder / FILE
            path.parent.mkdir(parents=True, exist_ok=True)
            with whole(path) as temporary:
                temporary.write_text(to_json(_record(rows)) + "\n", encoding="utf-8")


def _among(rows: Mapping[str, PlannedRun], file: str) -> PlannedRun:
    if file not in rows:
        raise ValueError(f"{file}: the present configuration has no such run")
    return rows[file]


def _record(rows: Iterable[PlannedRun]) -> dict[str, Any]:
    """The rows for machines: scenes as they are read, and what every row lays over the one that it names by its number."""
    rows = list(rows)
    scenes = {id(run.base): run.base.keys for run in rows}
    numbers = {scene: number for number, scene in enumerate(scenes)}
    names = ("id", "file", "point", "parent", "until", "by", "group", "target")
    told = [{name: getattr(run, name) for name in names} | {"scene": numbers[id(run.base)]} for run in rows]
    return {"scenes": [*scenes.values()], "runs": told}
