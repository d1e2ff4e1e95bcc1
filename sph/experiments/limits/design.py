"""Assumptions behind the results, changed one at a time, and the effect of each (``config/limits.yaml``, ``snakemake limits``).

The first change is the reference, the scene as it is.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from pydantic import model_validator

from sph.experiments.base import Cases, Experiment, Label, Overrides, check_file_names, checked, file_name
from sph.measures.metrics import PROBE
from sph.scene.configuration import found_file, key, merge, read_scene, read_yaml, validated
from sph.study.plan import Plan
from sph.study.runs import BaseScene, Run


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
                self.runs[run_name(change, case)] = Run(BaseScene(scene))
                self.rows.append((change, case))

    @property
    def parameters(self) -> list[tuple[str, str]]:
        """Change and case of every row."""
        return self.rows


def run_name(change: str, case: str) -> str:
    """File name of a run, without suffix."""
    return f"{file_name(change)}/{file_name(case)}"


def load_limits(path: str, study: Plan, folders: Sequence[Path] = (Path(),), check: bool = True) -> LimitRuns:
    """Validate the configuration and every scene; ValueError names file, key and value."""
    limits = validated(Limits, read_yaml(found_file(folders, path, "limits")), path)
    scene = read_scene(found_file(folders, limits.scene, f"{path}: scene"))
    return LimitRuns(limits, scene, path, study.study.metrics.probe)


EXPERIMENT = Experiment("limits", "Limits", load_limits, Limits)
