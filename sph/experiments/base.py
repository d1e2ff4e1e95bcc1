"""What experiments share: what one is, the keys of a configuration, names of files, and the check of every scene before any work."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import nullcontext
from pathlib import Path
from typing import Annotated, Any, NamedTuple

from pydantic import Field, model_validator

from sph.measures.fields import check_probe
from sph.measures.metrics import METRIC_BY_NAME
from sph.scene.configuration import Section, key
from sph.scene.schema import Scene, make_scene
from sph.solver.compiled.jit import compile_lock
from sph.solver.initial_stress import check_at_rest
from sph.solver.particles import locate_probes, place_particles
from sph.solver.time_step import check_time_step
from sph.study.dimensions import shown_unit
from sph.study.plan import Plan
from sph.study.schema import NAME, Study

METRIC_WORDS = {
    "displacement_magnitude": "displacement of A",
    "runout": "run-out",
    "area_moved_50cm": "area moved by 0.5 m",
    "failed_fraction": "failed fraction of the soil",
}
"""Metrics that are not read as they are written."""
Overrides = dict[str, Any]
Label = Annotated[str, Field(pattern=r"^[^\s\x00-\x1f$]([^\x00-\x1f$]{0,58}[^\s\x00-\x1f$])?$")]
"""One line without '$', which begins a formula in figures."""
Name = Annotated[str, Field(pattern=NAME)]


class Cases(Section):
    """A scene in some cases: what an experiment runs everything in."""

    scene: str = key("scene file, relative to the working folder or the workflow's folder")
    overrides: Overrides = key("scene keys of every run", default={})
    cases: dict[Label, Overrides] = key("scene keys of each case, by label", min_length=1)

    @model_validator(mode="after")
    def _cases_apart(self) -> Cases:
        check_file_names("cases", self.cases)
        return self


class Experiment(NamedTuple):
    """An experiment: ``EXPERIMENT`` of the module ``design`` in the folder of its name, which ``sph.experiments.registry`` lists.

    Its rules, in a file of ``workflow/rules``, make its tables and figures by functions of its modules.
    """

    name: str
    """of the folder below ``results`` and the file in ``config``"""
    load: Callable[[str, Plan, Sequence[Path], bool], Any]
    """its design, with runs by name or rows of its own, from the file of its configuration, the study, the folders that are searched in
    order and whether every scene is checked; ValueError names file, key and value"""
    keys: type[Section] | None = None
    """of its configuration; None where it has no file of its own"""
    alone: bool = True
    """whether its results belong to no study; those of others are below the study's"""
    study: type[Study] | None = None
    """a study with the keys that it adds to those of any"""

    @property
    def folder(self) -> str:
        """Where the results of one that stands alone go, relative to the working folder."""
        return f"results/{self.name}"

    def plan(self, file: str, study: Plan, folders: Sequence[Path] = (Path(),), check: bool = True) -> Any:
        """Its design; where it stands alone, the runs of it in its folder."""
        # Taken anew for each of some thousand scenes, the lock would be two thirds of their checks.
        with compile_lock(required=False) if check else nullcontext():
            design = self.load(file, study, folders, check)
        for name, run in design.runs.items() if self.alone else ():
            design.runs[name] = run._replace(id=name, folder=self.folder, target=self.name, group=run.group or self.name)
        return design


def checked(scene: Mapping[str, Any], where: str, probe: str | None = None) -> Scene:
    """The scene, built as a run would build it, with the ``probe`` that is measured; ValueError says where it is refused."""
    built = make_scene(scene, where)
    if probe is not None:
        check_probe(probe, built, where)
    try:
        check_time_step(built)
        particles = place_particles(built)
        locate_probes(built, particles)
        check_at_rest(built, particles)
    except ValueError as error:
        raise ValueError(f"{where}: {error}") from error
    return built


def metric_words(metric: str) -> str:
    """A metric as it is read."""
    return METRIC_WORDS.get(metric, metric.replace("_", " "))


def metric_label(metric: str) -> str:
    """A metric with its unit, as an axis names it."""
    unit = shown_unit(METRIC_BY_NAME[metric].units)
    return metric_words(metric) + (f" ({unit})" if unit else "")


def file_name(label: str) -> str:
    """A label as part of a path: it cannot lead out of its folder, nor hide the file."""
    return re.sub(r"^\.+|[^A-Za-z0-9_.-]+", "-", label)


def check_file_names(where: str, labels: Iterable[str]) -> None:
    """Refuse two labels with one file name, whose runs would overwrite each other; ValueError begins with ``where``."""
    first: dict[str, str] = {}
    for label in labels:
        other = first.setdefault(file_name(label), label)
        if other != label:
            raise ValueError(f"{where}: {other!r} and {label!r} give the same file name {file_name(label)!r}")
