"""Assumptions behind the results, changed one at a time, and the effect of each (``config/limits.yaml``, ``snakemake limits``).

The first change is the reference, the scene as it is.  The table measured for this release is part of the package (``SHIPPED``).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

import pandas as pd
import xarray as xr
from pydantic import model_validator

from sph.experiments.base import Cases, Experiment, Label, Overrides, Table, Trace, check_file_names, checked, file_name
from sph.measures.metrics import METRIC_BY_NAME, PROBE, MetricSettings, measure
from sph.scene.configuration import found_file, key, merge, read_scene, read_yaml, validated
from sph.storage.trajectory import Variable
from sph.study.plan import Plan
from sph.study.runs import Run
from sph.study.tables import ROW, read_csv

SHIPPED = Path(__file__).with_name("measured") / "limits.csv"
"""Table measured for this release."""
QUANTITIES = ("displacement_magnitude", "runout")

LIMITS: tuple[Variable, ...] = (
    Variable("change", ROW, "str", "1", "what differs from the scene as it is"),
    Variable("case", ROW, "str", "1", "point of the study"),
    *(METRIC_BY_NAME[name] for name in ("collapse_class", *QUANTITIES)),
    *(
        Variable(f"{name}_change", ROW, "f8", "1", f"{name} over that of the scene as it is, minus 1; NaN where that is 0")
        for name in QUANTITIES
    ),
)
"""The columns."""


class Limits(Cases):
    """The configuration."""

    changes: dict[Label, Overrides] = key("scene keys of each change, by label; the first is the reference", min_length=2)

    @model_validator(mode="after")
    def _apart(self) -> Limits:
        check_file_names("changes", self.changes)
        return self


class LimitRuns:
    """Every run by file name without suffix, and the change and case it belongs to."""

    def __init__(self, limits: Limits, base: Mapping[str, Any], origin: str, probe: str = PROBE) -> None:
        self.runs: dict[str, Run] = {}
        self.rows: list[tuple[str, str]] = []
        for change, settings in limits.changes.items():
            for case, point in limits.cases.items():
                scene = merge(merge(merge(base, limits.overrides), point), settings)
                checked(scene, f"{origin}: change {change!r}, case {case!r}", probe)
                self.runs[run_name(change, case)] = Run(scene)
                self.rows.append((change, case))

    @property
    def parameters(self) -> list[tuple[str, str]]:
        """Change and case of every row."""
        return self.rows


def run_name(change: str, case: str) -> str:
    """File name of a run, without suffix."""
    return f"{file_name(change)}/{file_name(case)}"


def load_limits(path: str, study: Plan, folders: Sequence[Path] = (Path(),)) -> LimitRuns:
    """Validate the configuration and every scene; ValueError names file, key and value."""
    limits = validated(Limits, read_yaml(found_file(folders, path, "limits")), path)
    scene = read_scene(found_file(folders, limits.scene, f"{path}: scene"))
    return LimitRuns(limits, scene, path, study.study.metrics.probe)


def limits_table(rows: Sequence[tuple[str, str]], runs: Sequence[xr.Dataset], settings: MetricSettings) -> pd.DataFrame:
    """One row a change and case, from the runs in the rows' order; the first change is the reference."""
    frame = pd.DataFrame(
        [{"change": change, "case": case, **measure(run, settings)} for (change, case), run in zip(rows, runs, strict=True)]
    )
    reference = frame[frame["change"] == rows[0][0]].set_index("case")
    for name in QUANTITIES:
        as_it_is = frame["case"].map(reference[name])
        frame[f"{name}_change"] = (frame[name] / as_it_is.where(as_it_is != 0)) - 1.0
    return frame[[row.name for row in LIMITS]]


def read_limits(path: Path | str = SHIPPED) -> pd.DataFrame:
    """Table from its CSV; ValueError names a file that is none."""
    return read_csv(path, LIMITS, "the limits")


def _measure(rows: Sequence[tuple[str, str]], read: Callable[[str], xr.Dataset], settings: MetricSettings) -> dict[str, pd.DataFrame]:
    return {"limits.csv": limits_table(rows, [read(run_name(change, case)) for change, case in rows], settings)}


EXPERIMENT = Experiment(
    "limits",
    "Limits",
    "What the answers rest on: A's displacement and the run-out with one choice changed at a time, over those of the scene as it is.",
    Limits,
    load_limits,
    _measure,
    {"limits.csv": Table(LIMITS, "every change")},
    Trace(("change", "case"), lambda design: {row: [run_name(*row)] for row in design.rows}, measure),
)
