"""Robustness of the solver: one key at a time to the ends of its range (``config/extremes.yaml``, ``snakemake extremes``).

Scenes that the schema refuses have no run.  ``time_steps`` runs fixed steps below and above the limit that theory gives.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Annotated, Any, Literal, NamedTuple

from pydantic import Field, model_validator

from sph.experiments.base import Cases, Experiment, Label, Overrides, check_file_names, file_name
from sph.scene.configuration import Section, dotted, found_file, key, merge, read_scene, read_yaml, validated
from sph.scene.motion import NoMotion
from sph.scene.names import check_known
from sph.scene.schema import make_scene
from sph.solver.time_step import check_time_step, limits
from sph.study.plan import Plan
from sph.study.runs import BaseScene, Run

TIME_STEP = "time step over limit"
"""Name of the sweep over fixed time steps."""
REFUSED = "refused"
FRAME = 0.5
"""Interval of the frames of a run with a fixed step, about, s."""


class Sweep(Section):
    """One key and its values."""

    scene_key: str = key("scene key, dotted", pattern=r"^[A-Za-z_][A-Za-z0-9_.]*$")
    values: Annotated[tuple[Any, ...] | dict[Label, Any], Field(min_length=1)] = key("its values; with labels if they are sections")
    cases: tuple[str, ...] | None = key("cases to run; null: all", default=None)
    repeats: int | None = key("number of runs of every value; null: as for all sweeps", ge=1, le=10, default=None)
    scene: str | None = key("another scene file; null: that of all sweeps, with its overrides", default=None)
    symmetry: Literal["none", "mirror"] = key("mirror: the scene is symmetric about the middle of its box", default="none")


class TimeSteps(Section):
    """Fixed time steps around the limit."""

    factors: tuple[Annotated[float, Field(gt=0, le=10)], ...] = key("time steps divided by the theoretical limit", min_length=1)
    schemes: dict[Label, Overrides] = key("scene keys of each scheme, by label", min_length=1)


class Extremes(Cases):
    """The configuration."""

    repeats: int = key("number of runs of every value, which are compared bit for bit", ge=1, le=10, default=2)
    sweeps: dict[Label, Sweep] = key("the sweeps, by label", min_length=1)
    time_steps: TimeSteps = key("sweep over fixed time steps, in the first case")

    @model_validator(mode="after")
    def _apart(self) -> Extremes:
        check_file_names("sweeps", (*self.sweeps, TIME_STEP))
        check_file_names("time_steps.schemes", self.time_steps.schemes)
        for label, sweep in self.sweeps.items():
            check_file_names(f"sweeps.{label}.values", labelled(sweep.values))
        return self


class Row(NamedTuple):
    """One row of the table before it is measured."""

    sweep: str
    value: str
    case: str
    symmetric: bool
    refused: str
    """why the scene is refused; empty for one that runs"""
    runs: tuple[str, ...]
    """file names of its repeats, without suffix"""


def labelled(values: tuple[Any, ...] | Mapping[str, Any]) -> dict[str, Any]:
    """Values of a sweep by their labels."""
    return dict(values) if isinstance(values, Mapping) else {"null" if value is None else str(value): value for value in values}


class ExtremeRuns:
    """Every row of the table, and every run by file name without suffix."""

    def __init__(self, extremes: Extremes, scenes: Mapping[str, Mapping[str, Any]], origin: str) -> None:
        self.rows: list[Row] = []
        self.runs: dict[str, Run] = {}
        for label, sweep in extremes.sweeps.items():
            base = scenes[sweep.scene] if sweep.scene else merge(scenes[extremes.scene], extremes.overrides)
            check_known(f"{origin}: sweeps.{label}.cases", sweep.cases, extremes.cases)
            for case in sweep.cases or extremes.cases:
                start = merge(base, extremes.cases[case])
                make_scene(start, f"{origin}: sweeps.{label}, case {case!r}")
                repeats = sweep.repeats or extremes.repeats
                for text, value in labelled(sweep.values).items():
                    self._add(label, text, case, merge(start, dotted({sweep.scene_key: value})), repeats, sweep.symmetry == "mirror")
        start = merge(merge(scenes[extremes.scene], extremes.overrides), next(iter(extremes.cases.values())))
        for scheme, overrides in extremes.time_steps.schemes.items():
            for factor in extremes.time_steps.factors:
                self._add(TIME_STEP, f"{factor:g}", scheme, fixed_step(merge(start, overrides), factor), 1, symmetric=False)

    def _add(self, sweep: str, value: str, case: str, scene: dict[str, Any], repeats: int, symmetric: bool) -> None:
        stem = "/".join(file_name(part) for part in (sweep, case, value))
        refused = ""
        try:
            built = make_scene(scene, "scene")
            if sweep != TIME_STEP:
                check_time_step(built)
        except ValueError as error:
            refused = str(error)
        runs = () if refused else tuple(f"{stem}_{number}" for number in range(1, repeats + 1))
        self.runs |= dict.fromkeys(runs, Run(BaseScene(scene), enforce_limit=sweep != TIME_STEP))
        self.rows.append(Row(sweep, value, case, symmetric, refused, runs))

    @property
    def parameters(self) -> list[Row]:
        """The rows."""
        return self.rows


def fixed_step(scene: Mapping[str, Any], factor: float) -> dict[str, Any]:
    """A scene with a fixed time step, a factor times the smallest limit from theory; its intervals become multiples of the step."""
    step = factor * min(limit.seconds for limit in limits(make_scene(merge(scene, {"numerics": {"adaptive_step": None}}))))
    built = make_scene(scene)
    sample = max(1, round(built.outputs.series_interval / step)) * step

    def samples(time: float) -> float:
        return max(1, round(time / sample)) * sample

    stage = samples(built.gravity.duration)
    return merge(
        scene,
        {
            "duration": samples(built.duration),
            "gravity": {"duration": stage},
            "motion": {} if isinstance(built.motion, NoMotion) else {"start": max(stage, built.motion.start)},
            "numerics": {"time_step": step, "adaptive_step": None},
            "outputs": {"series_interval": sample, "frame_interval": samples(FRAME)},
        },
    )


def load_extremes(path: str, study: Plan, folders: Sequence[Path] = (Path(),), check: bool = True) -> ExtremeRuns:
    """Validate the configuration; ValueError names file, key and value.  Values that the schema refuses are rows, not errors.

    It takes nothing from the study.
    """
    extremes = validated(Extremes, read_yaml(found_file(folders, path, "extremes")), path)
    names = {extremes.scene, *(sweep.scene for sweep in extremes.sweeps.values() if sweep.scene)}
    scenes = {name: read_scene(found_file(folders, name, f"{path}: scene")) for name in names}
    return ExtremeRuns(extremes, scenes, path)


EXPERIMENT = Experiment("extremes", "Extremes", load_extremes, Extremes)
