"""What experiments share: what one is, the keys of a configuration, names of files, and the check of every scene before any work."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path
from typing import Annotated, Any, NamedTuple, Protocol

import pandas as pd
import xarray as xr
from pydantic import Field, model_validator

from sph.measures.fields import check_probe
from sph.measures.metrics import MetricSettings
from sph.scene.configuration import Section, key
from sph.scene.schema import Scene, make_scene
from sph.solver.initial_stress import check_at_rest
from sph.solver.particles import locate_probes, place_particles
from sph.solver.time_step import check_time_step
from sph.storage.trajectory import Variable
from sph.study.plan import Plan
from sph.study.runs import Run
from sph.study.schema import NAME

Overrides = dict[str, Any]
Label = Annotated[str, Field(pattern=r"^[^\s\x00-\x1f$]([^\x00-\x1f$]{0,58}[^\s\x00-\x1f$])?$")]
"""One line without '$', which begins a formula in figures."""
Name = Annotated[str, Field(pattern=NAME)]


class Cases(Section):
    """A scene in some cases: what an experiment runs everything in."""

    scene: str = key("scene file, relative to the working folder or the workflow's")
    overrides: Overrides = key("scene keys of every run", default={})
    cases: dict[Label, Overrides] = key("scene keys of each case, by label", min_length=1)

    @model_validator(mode="after")
    def _cases_apart(self) -> Cases:
        check_file_names("cases", self.cases)
        return self


class Design(Protocol):
    """An experiment with its configuration read and its scenes checked."""

    @property
    def runs(self) -> Mapping[str, Run]:
        """By name, each whole, from the start to the end, on one core."""

    @property
    def parameters(self) -> Any:
        """What measuring needs beside the runs.  The job gets it pickled, and runs again when its ``repr`` changes."""


class Table(NamedTuple):
    """A table that an experiment writes."""

    columns: Sequence[Variable]
    shows: str = ""
    """what it is called in Snakemake's report; empty: it is not in there"""


class Trace(NamedTuple):
    """How the rows of the table <name>.csv are traced to their runs (``sph explain``)."""

    named: Sequence[str]
    """columns that tell rows apart"""
    runs: Callable[[Any], Mapping[tuple[str, ...], Sequence[str]]]
    """names of a row's runs by the values of these columns, from the design"""
    measure: Callable[[xr.Dataset, MetricSettings], Mapping[str, Any]]
    """columns that the first of these runs gives again"""


class Experiment(NamedTuple):
    """An experiment whose runs stand alone; ``sph.experiments.registry`` lists them, and the workflow makes what is listed there."""

    name: str
    """the target, the folder below ``results`` and the file in ``config``"""
    title: str
    """its section in Snakemake's report"""
    about: str
    """what its results show: their caption in the report, but for those that have one of their own in ``workflow/report``"""
    keys: type[Section]
    """of its configuration"""
    load: Callable[[str, Plan, Sequence[Path]], Design]
    """from the file of its configuration, the study and the folders that are searched in order; ValueError names file, key and value"""
    measure: Callable[[Any, Callable[[str], xr.Dataset], MetricSettings], Mapping[str, pd.DataFrame | xr.Dataset]]
    """the tables by file name, from the design's parameters, what reads a run by its name, and the study's thresholds"""
    tables: Mapping[str, Table]
    """by file name, .csv or .nc, one of them <name>.csv; figures are drawn from all that are .csv (``sph.figures.experiment_figures``)"""
    trace: Trace | None = None
    """None where a row is no single run"""

    @property
    def folder(self) -> str:
        """Where the results go, relative to the working folder."""
        return f"results/{self.name}"

    def rows(self, design: Design) -> dict[str, Run]:
        """The runs of its design, in its folder, by name."""
        return {name: run._replace(id=name, folder=self.folder, target=self.name, group=self.name) for name, run in design.runs.items()}


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
