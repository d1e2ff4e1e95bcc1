"""The configuration of the sensitivity analysis (``config/sensitivity.yaml``)."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Any, Literal

from pydantic import BeforeValidator, Field, model_validator

from sph.experiments.base import Label, Overrides
from sph.measures.metrics import METRIC_BY_NAME
from sph.scene.configuration import Section, key
from sph.scene.names import check_known
from sph.scene.units import Acceleration
from sph.storage.trajectory import Variable
from sph.study.dimensions import Values, check_names, in_si, is_number, scene_key, scene_keys
from sph.study.tables import text_column

SAMPLE: tuple[Variable, ...] = (
    text_column("run", "file of the run under runs/, without suffix"),
    text_column("reason", "why a run diverged"),
    *(METRIC_BY_NAME[name] for name in ("status", "collapse_class", "still_moving", "wall_time")),
)
"""The columns of a sample before those of its factors and metrics."""
Name = Annotated[str, Field(pattern=r"^[A-Za-z][A-Za-z0-9_]{0,31}$")]
SceneKey = Annotated[str, Field(pattern=r"^[A-Za-z_][A-Za-z0-9_]*(\.[A-Za-z_][A-Za-z0-9_]*)*$")]


class Factor(Section):
    """A number of the scene, or several in proportion, and its range; or values of keys, one a level."""

    keys: dict[SceneKey, Annotated[float, Field(gt=0)]] = key(
        "scene keys, dotted (layers.clay.soil.cohesion), each with the multiplier of the factor's value, in the proportion of the scene's "
        "own values; unit and base value are those of the first",
        default={},
    )
    bounds: tuple[Acceleration, Acceleration] | None = key(
        "smallest and largest value, in the unit of the first key, or accelerations with theirs (0.2g); the scene's own value lies between",
        default=None,
    )
    scale: Literal["linear", "log"] = key("scale on which the range is filled evenly", default="linear")
    levels: Annotated[dict[SceneKey, Annotated[Values, Field(min_length=2, max_length=20)]], BeforeValidator(in_si)] | None = key(
        "instead of keys and bounds: the values of scene keys, one a level, as motion.file: [a.csv, b.csv]; those of several keys go "
        "together; the scene's own values are among them",
        default=None,
        min_length=1,
    )
    label: Label | None = key("name in figures; null: that of the first key", default=None)

    @model_validator(mode="before")
    @classmethod
    def _units(cls, data: Any) -> Any:
        keys, bounds = (data.get("keys"), data.get("bounds")) if isinstance(data, Mapping) else (None, None)
        if isinstance(keys, Mapping) and keys and isinstance(bounds, (list, tuple)):
            first = next(iter(keys))
            for value in bounds:
                if isinstance(value, str) and not is_number(value) and scene_keys().get(scene_key(str(first))) != "m/s2":
                    raise ValueError(f"bounds: {value!r}: {first} is not an acceleration; write a number in the unit of that key")
        return data

    @model_validator(mode="after")
    def _range(self) -> Factor:
        if bool(self.levels) == bool(self.keys) or bool(self.keys) != bool(self.bounds):
            raise ValueError("keys, bounds, levels: give keys with their bounds, or levels alone")
        low, high = self.bounds or (1.0, 2.0)
        if not low < high or self.scale == "log" and low <= 0:
            raise ValueError(f"bounds: [{low}, {high}] must increase" + (" and be positive on a log scale" if self.scale == "log" else ""))
        if self.levels:
            check_names("levels", self.levels)
            if len({len(values) for values in self.levels.values()}) > 1:
                raise ValueError(f"levels: {', '.join(self.levels)} must have as many values each")
            if self.scale == "log":
                raise ValueError("scale: log is of a range, and levels have none; leave it out")
        return self

    @property
    def sets(self) -> tuple[str, ...]:
        """The scene keys that it sets."""
        return tuple(self.levels or self.keys)


class Analysed(Section):
    """How a metric is analysed."""

    log_offset: float | None = key(
        "null: the metric itself; a number: the decimal logarithm of metric + number, in the metric's unit", gt=0, default=None
    )


class MorrisSettings(Section):
    """The screening."""

    trajectories: int = key("number of trajectories, each with one run more than there are factors", ge=2, le=1000, default=10)
    levels: Literal[4, 6, 8, 10] = key("number of levels of every factor", default=4)
    resamples: int = key("number of bootstrap resamples for the intervals", ge=100, le=100_000, default=2000)


class SobolSettings(Section):
    """The indices and the surrogate they are computed with."""

    samples: int = key(
        "number of runs, the first points of a scrambled Sobol' sequence; powers of 2 fill the space most evenly",
        ge=8,
        le=8192,
        default=128,
    )
    factors: tuple[str, ...] | None = key("factors to vary; null: those that the screening finds", min_length=1, default=None)
    share: float = key(
        "the screening finds a factor whose mu* is at least this part of the largest mu* of some metric", gt=0, le=1, default=0.2
    )
    folds: int = key("number of parts (folds) of the cross-validation", ge=2, le=100, default=8)
    least_q2: float = key("the indices of a metric whose Q² lies below this are not to be trusted", ge=0, lt=1, default=0.8)
    draws: int = key("number of functions drawn from the surrogate's posterior for the intervals", ge=50, le=10_000, default=400)
    points: int = key("number of points of the estimator of the indices, a power of 2", ge=64, le=65_536, default=1024)

    @model_validator(mode="after")
    def _power(self) -> SobolSettings:
        if self.points.bit_count() != 1:
            raise ValueError(f"points: {self.points} is not a power of 2")
        return self


class Confirm(Section):
    """Points that are repeated at another fidelity."""

    fidelity: str = key("one of the study's fidelities; where it is the study's own, nothing is repeated")
    points: int = key("number of points, the first of the Sobol' sample", ge=1, le=1000)


class Observed(Section):
    """What was observed of a metric."""

    value: float = key("observed value, in the metric's unit")
    error: float = key("standard deviation of the observation, in the same unit", gt=0)


class BackAnalysis(Section):
    """Which values of the factors agree with what was observed."""

    observed: dict[Name, Observed] = key("what was observed, by the names of analysed metrics", min_length=1)
    over: tuple[str, ...] | None = key(
        "factors whose values are sought; all others keep the scene's own; null: those that the Sobol' sample varies",
        min_length=1,
        default=None,
    )


class Sensitivity(Section):
    """The configuration."""

    overrides: Overrides = key("scene keys of every run, over those of the fidelity", default={})
    seed: int = key("seed of trajectories, sequence, cross-validation and draws", ge=0, le=2**31, default=1)
    factors: dict[Name, Factor] = key("the factors, by name", min_length=1, max_length=12)
    metrics: dict[Name, Analysed] = key("the metrics that are analysed, by their names in study.csv", min_length=1, max_length=6)
    morris: MorrisSettings = key("screening of all factors by elementary effects", default=MorrisSettings())
    sobol: SobolSettings = key("indices of the factors that matter", default=SobolSettings())
    confirm: Confirm | None = key("points repeated at another fidelity", default=None)
    back_analysis: BackAnalysis | None = key("back-analysis: values of the factors that agree with an observation", default=None)

    @model_validator(mode="after")
    def _known(self) -> Sensitivity:
        check_known("metrics", self.metrics, [metric.name for metric in METRIC_BY_NAME.values() if metric.dtype == "f8"])
        check_known("sobol.factors", self.sobol.factors, self.factors)
        taken = {column.name for column in SAMPLE} | set(self.metrics)
        for name in self.factors:
            if name in taken:
                raise ValueError(f"factors: {name!r} is a column of the sample already, choose another name")
        paths = [path for factor in self.factors.values() for path in factor.sets]
        if len(set(paths)) < len(paths):
            raise ValueError(f"factors: two of them set the key {next(path for path in paths if paths.count(path) > 1)}")
        if self.confirm and self.confirm.points > self.sobol.samples:
            raise ValueError(f"confirm.points: {self.confirm.points} is more than sobol.samples: {self.sobol.samples}")
        if self.back_analysis:
            check_known("back_analysis.observed", self.back_analysis.observed, self.metrics)
            check_known("back_analysis.over", self.back_analysis.over, self.sobol.factors or self.factors)
            for name in self.back_analysis.over or self.sobol.factors or self.factors:
                if self.factors[name].levels:
                    raise ValueError(
                        f"back_analysis.over: {name!r} has levels, between which there are no values to find; name those of the others"
                    )
            for name, observed in self.back_analysis.observed.items():
                least = self.metrics[name].log_offset
                if least is not None and observed.value <= -least:
                    raise ValueError(f"back_analysis.observed.{name}.value: {observed.value:g} must be above -log_offset, {-least:g}")
        return self
