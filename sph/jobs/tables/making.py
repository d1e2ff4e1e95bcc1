"""A step of an experiment: a function that makes tables and figures of tables and runs, which are read and written here.

A module of this folder lists the ``STEPS`` of an experiment; ``workflow/rules/tables.smk`` makes a rule of each that has files of its own,
and the first paragraph of its function's docstring is the caption in Snakemake's report.
"""

from __future__ import annotations

import functools
from collections.abc import Callable, Iterator, Mapping, Sequence
from importlib import import_module
from pathlib import Path
from typing import Any, NamedTuple

import pandas as pd
import xarray as xr
from matplotlib.figure import Figure

from sph.experiments.sensitivity.back_analysis import BACK_ANALYSIS, point_columns
from sph.experiments.sensitivity.design import chosen_factors
from sph.experiments.sensitivity.elementary_effects import MORRIS
from sph.experiments.sensitivity.surrogate import CROSS_VALIDATION, SOBOL
from sph.experiments.sensitivity.tables import TORNADO, read_sample
from sph.experiments.trigger.critical import read_critical, read_ends
from sph.experiments.trigger.hazard import read_hazard
from sph.experiments.trigger.maps import read_shares
from sph.experiments.trigger.points import read_points, read_wanted
from sph.figures import caption, save
from sph.scene.strict_json import to_json
from sph.storage import trajectory
from sph.storage.files import whole
from sph.study.planned import Planned
from sph.study.tables import read_csv, read_study, write_csv

Given = Mapping[str, Any]
Files = Mapping[str, str | Sequence[str]]
Made = pd.DataFrame | xr.Dataset | Figure | list[str]


class Step(NamedTuple):
    """A job that makes tables and figures."""

    name: str
    """of its rule and its log"""
    make: Callable[..., Made | tuple[Made, ...]]
    """what it writes, in that order, from what it reads and is given, by name"""
    reads: Mapping[str, str] = {}
    """files in the folder of the experiment, by the names of ``READERS``"""
    writes: Mapping[str, str] = {}
    """what each file in that folder is called in Snakemake's report; a file without suffix is a figure, an empty name keeps it out"""
    given: Callable[[Any], Given] = lambda design: {}
    """what it is given beside these, from the design of the experiment"""
    needs: Callable[[Any], Files] = lambda design: {}
    """files from elsewhere, by the names of ``READERS`` or, where they are not read here, by others"""
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


def steps(experiment: str) -> dict[str, Step]:
    """The steps of an experiment by name: ``STEPS`` of its module."""
    return {step.name: step for step in import_module(f"sph.jobs.tables.{experiment}").STEPS}


def _samples(paths: Sequence[str], given: Given) -> pd.DataFrame:
    return pd.concat([read_sample(path, given["axes"], given["quantities"]) for path in paths], ignore_index=True)


def _sample(path: str, given: Given) -> pd.DataFrame:
    return read_sample(path, given["axes"], given["quantities"])


def _posterior(path: str, given: Given) -> pd.DataFrame:
    with xr.open_dataset(path) as found:
        return found.to_dataframe()


READERS: dict[str, Callable[[Any, Given], Any]] = {
    "study": lambda path, given: read_study(path),
    "points": lambda path, given: read_points(path),
    "wanted": lambda path, given: read_wanted(path),
    "critical": lambda path, given: read_critical(path),
    "ends": lambda path, given: read_ends(path),
    "shares": lambda path, given: read_shares(path),
    "hazard": lambda path, given: read_hazard(path, given["searched"].intensity.unit),
    "factors": lambda path, given: chosen_factors(path),
    "sample": _sample,
    "confirming": _sample,
    "samples": _samples,
    "screening": lambda path, given: read_csv(path, MORRIS, "a screening"),
    "tornado": lambda path, given: read_csv(path, TORNADO, "a tornado"),
    "indices": lambda path, given: read_csv(path, SOBOL, "Sobol' indices"),
    "validation": lambda path, given: read_csv(path, CROSS_VALIDATION, "a cross-validation"),
    "result": lambda path, given: read_csv(path, BACK_ANALYSIS, "a back-analysis"),
    "confirmable": lambda path, given: read_csv(path, point_columns(given["axes"]), "the points of a back-analysis"),
    "posterior": _posterior,
}
"""What reads a file, by the name under which a step is given it: functions of path and of what the step is given else."""


def make(step: Step, inputs: Files, given: Given, scenes: Sequence[Planned], outputs: Sequence[str]) -> None:
    """Read what a step is given, make and write its tables and figures; ``scenes`` are those of ``inputs["runs"]``, read one by one."""
    read = {name: READERS[name](path, given) for name, path in inputs.items() if name in READERS and path}
    if "runs" in inputs:
        read["runs"] = (scene.read(path) for scene, path in zip(scenes, inputs["runs"], strict=True))
    made = step.make(**read, **given)
    paths: Iterator[str] = iter(outputs)
    for each in made if isinstance(made, tuple) else (made,):
        write(each, paths)


def write(made: Made, paths: Iterator[str]) -> None:
    """Write a table to the next of some paths, a figure to the next two."""
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
