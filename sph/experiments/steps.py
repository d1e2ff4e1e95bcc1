"""A step of an experiment: a function that makes tables and figures of tables and runs, which are read and written here.

The module ``measure`` of an experiment lists its ``STEPS``; ``workflow/rules/experiments.smk`` makes a rule of each, and the first
paragraph of its function's docstring is the caption in Snakemake's report.
"""

from __future__ import annotations

import functools
import inspect
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import pandas as pd
import xarray as xr
from matplotlib.figure import Figure

from sph.experiments.base import Experiment
from sph.experiments.registry import EXPERIMENTS
from sph.figures import RUN_FIGURES, caption, save
from sph.measures.metrics import MetricSettings
from sph.output.run import Run
from sph.scene.strict_json import to_json
from sph.storage import trajectory
from sph.storage.files import whole
from sph.study.planned import Planned
from sph.study.runs import Run as PlannedRun
from sph.study.tables import write_csv

Given = Mapping[str, Any]
Files = Mapping[str, str | Sequence[str]]
Made = pd.DataFrame | xr.Dataset | Figure | list[str] | Callable[..., None]


class Runs(Sequence[Run]):
    """The runs of a step, by their files and planned scenes, each read when it is asked for."""

    def __init__(self, paths: Sequence[str], scenes: Sequence[Planned]) -> None:
        self.paths, self.scenes = paths, scenes

    def __len__(self) -> int:
        return len(self.paths)

    def __getitem__(self, number: Any) -> Any:
        return self.scenes[number].read(self.paths[number])


def nothing(design: Any, **at: str) -> Mapping[str, Any]:
    """What a step needs that needs nothing."""
    return {}


class Step(NamedTuple):
    """A job that makes tables and figures.  Names of files may hold wildcards, whose values functions of the design are given by name."""

    name: str
    """of its rule and its log"""
    make: Callable[..., Any]
    """what it writes, in that order, from what it reads and is given, by name; if it takes ``settings`` and is given none, the study's
    thresholds of the metrics"""
    reads: Mapping[str, str] = {}
    """files in the folder of the experiment, by the names of ``READERS``"""
    writes: Mapping[str, str] = {}
    """what each file in that folder is called in Snakemake's report; a file without suffix is a figure, an empty name keeps it out"""
    given: Callable[..., Given] = nothing
    """what it is given beside these, from the design of the experiment"""
    needs: Callable[..., Files] = nothing
    """files from elsewhere, by the names of ``READERS`` or, where they are not read here, by others"""
    runs: Callable[..., Iterable[PlannedRun]] | None = None
    """those that it is given as ``runs``"""
    after: Callable[..., str | None] = lambda design, **at: None
    """the step that decides which runs these are, once it is done"""
    decides: bool = False
    """whether runs follow from what it writes"""
    searches: bool = False
    """whether it depends on the sources of the searches for the limits of slopes"""

    @property
    def about(self) -> str:
        """Its caption in the report."""
        return caption(self.make.func if isinstance(self.make, functools.partial) else self.make)

    @property
    def draws(self) -> bool:
        """Whether it depends on the sources of the drawing."""
        return any(not Path(file).suffix for file in self.writes)

    @property
    def log(self) -> str:
        """Its log in the folder of the experiment, which tells apart what its wildcards do."""
        first = next(iter(self.writes))
        return f"logs/{Path(first).stem if '{' in first else self.name}.log"

    @property
    def measures(self) -> bool:
        """Whether it takes thresholds of the metrics."""
        return "settings" in inspect.signature(self.make).parameters


def run_figures() -> dict[str, Callable[..., Figure]]:
    """Figures of one run of a study or of some, by the names of their files: those of any study, and ``FIGURES`` of experiments."""
    return RUN_FIGURES | {name: draw for each in EXPERIMENTS.values() for name, draw in getattr(each.measuring, "FIGURES", {}).items()}


def steps(experiment: Experiment) -> dict[str, Step]:
    """The steps of an experiment by name."""
    return {step.name: step for step in experiment.measuring.STEPS}


def table_step(experiment: str, measure: Callable[..., Any], writes: Mapping[str, str]) -> Step:
    """The step that makes the tables of a stand-alone experiment of all its runs.

    ``measure`` is given the ``parameters`` of the design, what reads a run by its name, and the thresholds of the metrics.
    """

    def make(parameters: Any, names: Sequence[str], runs: Runs, settings: Mapping[str, Any]) -> Any:
        return measure(parameters, lambda name: runs[names.index(name)], MetricSettings(**settings))

    make.__doc__ = measure.__doc__
    return Step(
        f"{experiment}_table",
        make,
        writes=writes,
        given=lambda design: {"parameters": design.parameters, "names": list(design.runs)},
        runs=lambda design: design.runs.values(),
    )


def make(experiment: Experiment, step: Step, inputs: Files, given: Given, scenes: Sequence[Planned], outputs: Sequence[str]) -> None:
    """Read what a step is given, make and write its tables and figures; ``scenes`` are those of ``inputs["runs"]``."""
    readers = experiment.measuring.READERS
    read = {name: readers[name](path, given) for name, path in inputs.items() if name in readers and path}
    if step.runs is not None:
        read["runs"] = Runs(inputs.get("runs", ()), scenes)
    made = step.make(**read, **given)
    paths: Iterator[str] = iter(outputs)
    for each in made if isinstance(made, tuple) else (made,):
        write(each, paths)


def write(made: Made, paths: Iterator[str]) -> None:
    """Write a table to the next of some paths, a figure to the next two; a function writes to all that are left."""
    if callable(made):
        made(*paths)
        return
    path = next(paths)
    if isinstance(made, Figure):
        save(made, path, next(paths))
    elif isinstance(made, pd.DataFrame):
        write_csv(made, path)
    elif isinstance(made, xr.Dataset):
        trajectory.write(path, made)
    else:
        with whole(path) as temporary:
            temporary.write_text(to_json(made) + "\n", encoding="utf-8")
