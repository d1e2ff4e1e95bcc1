"""Which factors decide the answer: designs of runs around the study's scene (``config/sensitivity.yaml``, ``snakemake sensitivity``).

Three designs.  *Morris* trajectories screen all factors (``elementary_effects``); *tornado* moves one factor at a time to
both ends of its range; *Sobol'* fills the space of the factors that matter, others at the scene's own values, for a surrogate and its
indices (``surrogate``).  Enlarging a design keeps its first runs: every trajectory has a seed of its own, and a longer
scrambled Sobol' sequence begins as a shorter one.  Some points of the last design can be confirmed at another fidelity.  The points at
which a back-analysis is confirmed by runs follow from its result (``back_analysis``).
"""

from __future__ import annotations

import functools
import itertools
import math
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Annotated, Any, Literal, NamedTuple

import numpy as np
import pandas as pd
import scipy  # type: ignore[import-untyped]
from pydantic import BeforeValidator, Field, model_validator

from sph.experiments.base import Experiment, Label, Overrides, checked
from sph.measures.fields import check_probe
from sph.measures.metrics import METRIC_BY_NAME
from sph.scene.configuration import Section, found_file, key, merge, read_yaml, validated
from sph.scene.extras import of_extra
from sph.scene.names import check_known
from sph.scene.schema import Scene
from sph.scene.strict_json import parse_json
from sph.scene.units import Acceleration
from sph.storage.trajectory import Variable
from sph.study.dimensions import (
    Values,
    as_written,
    check_names,
    in_si,
    is_number,
    number_at,
    readable,
    scene_key,
    scene_keys,
    shown_unit,
    value_at,
    value_of,
)
from sph.study.plan import Plan
from sph.study.runs import BaseScene, PlannedRun
from sph.study.tables import text_column

FOLDER = "sensitivity"
"""Folder of the results, in that of the study."""
BASE = "base"
"""Name of the run of the scene as it is."""
ENDS = ("low", "high")
"""Ends of a factor's range, in the order of its bounds."""
CONFIRM = "confirm"
"""Design of the runs that repeat others at another fidelity."""
BACK = "back"
"""Design of the runs that confirm a back-analysis."""
FACTORS_FILE, BACK_FILE = "factors.json", "back_points.csv"
"""Files that say what a design runs: the factors that matter, and the points of ``BACK``."""

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


class Axis(NamedTuple):
    """A factor, ready for use."""

    name: str
    label: str
    unit: str
    low: float
    high: float
    log: bool
    base: float  # value in the scene as it is
    levels: tuple[str, ...] = ()
    """names of the levels; a value is the number of one then, from 1"""

    @property
    def moved(self) -> dict[str, float]:
        """The values that the tornado moves it to, by name: the ends of the range, or all levels but the scene's own."""
        if self.levels:
            return {str(number): float(number) for number in range(1, len(self.levels) + 1) if number != self.base}
        return dict(zip(ENDS, (self.low, self.high), strict=True))

    @property
    def meaning(self) -> str:
        """Its values in tables."""
        numbered = "; ".join(f"{number}: {level}" for number, level in enumerate(self.levels, 1))
        return f"factor: {self.label}" + (f", the number of its level: {numbered}" if self.levels else "")

    def value(self, share: float) -> float:
        """Value at a share, 0 to 1, of the range; levels have equal parts of it."""
        if self.levels:
            return float(min(int(share * len(self.levels) + 1e-9), len(self.levels) - 1) + 1)
        if self.log:
            return float(self.low * (self.high / self.low) ** share)
        return self.low + share * (self.high - self.low)

    def share(self, value: np.ndarray) -> np.ndarray:
        """Share of the range below values (n,); of a level the middle of its part."""
        if self.levels:
            return (value - 0.5) / len(self.levels)
        if self.log:
            return np.log(value / self.low) / math.log(self.high / self.low)
        return (value - self.low) / (self.high - self.low)

    def span(self, low: float, high: float) -> str:
        """Two of its values with their unit."""
        return f"{short(low)} to {with_unit(high, self.unit)}"

    def snapped(self, shares: np.ndarray) -> np.ndarray:
        """Shares (n,) of the range, those of levels in the middle of their parts."""
        return self.share(np.array([self.value(share) for share in shares])) if self.levels else shares


class Quantity(NamedTuple):
    """A metric as it is analysed."""

    metric: str
    log_offset: float | None

    @property
    def metric_unit(self) -> str:
        """Unit of the metric."""
        return METRIC_BY_NAME[self.metric].units

    @property
    def text(self) -> str:
        """What is analysed, in words."""
        return self.metric if self.log_offset is None else f"log10({self.metric} + {self.log_offset:g} {self.metric_unit})"

    @property
    def unit(self) -> str:
        """Unit of what is analysed: a decade of the sum on the logarithmic scale."""
        return self.metric_unit if self.log_offset is None else "decade"

    def of(self, values: np.ndarray) -> np.ndarray:
        """What is analysed, from metrics (n,); NaN stays NaN."""
        return values if self.log_offset is None else np.log10(values + self.log_offset)

    def metric_of(self, analysed: np.ndarray) -> np.ndarray:
        """Metrics (n,) from what is analysed."""
        return analysed if self.log_offset is None else 10.0**analysed - self.log_offset


class Observation(NamedTuple):
    """An observed metric."""

    quantity: Quantity
    value: float
    error: float
    """its standard deviation"""

    @property
    def analysed(self) -> tuple[float, float]:
        """Value and standard deviation of what is analysed; of a logarithm the latter to first order."""
        offset = self.quantity.log_offset
        error = self.error if offset is None else self.error / ((self.value + offset) * math.log(10.0))
        return float(self.quantity.of(np.array(self.value))), error


WORDS = {"displacement_magnitude": "displacement of A", "runout": "run-out", "area_moved_50cm": "area moved by 0.5 m"}
"""Metrics that are not read as they are written."""


def metric_words(metric: str) -> str:
    """A metric as it is read."""
    return WORDS.get(metric, metric.replace("_", " "))


def short(value: float) -> str:
    """A value in three digits."""
    return f"{value:.3g}".replace("e+0", "e").replace("e-0", "e-")


def with_unit(value: float, unit: str) -> str:
    """A value in three digits with its unit."""
    return f"{short(value)} {shown_unit(unit)}".rstrip()


Point = tuple[float, ...]
Chosen = Sequence[str] | Mapping[str, Point]
"""What a design varies beside those that vary all: the names of the factors, or of ``BACK`` the points themselves."""


class SensitivityPlan:
    """The factors, and the values and the scene of every run by design and name."""

    def __init__(self, settings: Sensitivity, plan: Plan, origin: str) -> None:
        self.settings, self.origin = settings, origin
        self.folder = f"{plan.folder}/{FOLDER}"
        """of the results, relative to the working folder"""
        confirm, own = settings.confirm, plan.study.fidelity
        self.fidelities = (own, confirm.fidelity if confirm else own)
        check_known(f"{origin}: confirm.fidelity", self.fidelities, plan.study.fidelities)
        self.quantities = [Quantity(name, analysed.log_offset) for name, analysed in settings.metrics.items()]
        self._bases = {name: BaseScene(merge(plan.at(name).scene(), settings.overrides)) for name in self.fidelities}
        self.axes = self._axes(plan.study.metrics.probe)

    @functools.cached_property
    def _designs(self) -> dict[str, dict[str, Point]]:
        """Those that vary all factors."""
        return {"morris": dict(self._morris()), "tornado": dict(self._tornado())}

    @property
    def confirmed(self) -> int:
        """Number of points that are repeated at another fidelity."""
        own, other = self.fidelities
        return self.settings.confirm.points if self.settings.confirm and other != own else 0

    @property
    def observations(self) -> list[Observation]:
        """What was observed; ValueError where nothing was."""
        if self.settings.back_analysis is None:
            example = "back_analysis: {observed: {runout: {value: 21.0, error: 1.0}}}"
            raise ValueError(f"{self.origin}: back_analysis: null: write what was observed, like {example}")
        quantities = {quantity.metric: quantity for quantity in self.quantities}
        return [Observation(quantities[name], seen.value, seen.error) for name, seen in self.settings.back_analysis.observed.items()]

    @property
    def sought(self) -> Sequence[str]:
        """Factors that are sought whichever others matter."""
        return (self.settings.back_analysis and self.settings.back_analysis.over) or ()

    def design(self, design: str, chosen: Chosen = ()) -> dict[str, Point]:
        """Values of the factors of every run of a design, by name; ``chosen`` factors are varied in 'sobol' and 'confirm'."""
        if design in self._designs:
            return self._designs[design]
        if isinstance(chosen, Mapping):
            return dict(chosen)
        return dict(itertools.islice(self._sobol(chosen), self.confirmed if design == CONFIRM else None))

    def rows(self, design: str, chosen: Chosen = ()) -> list[PlannedRun]:
        """The runs of a design, in their order; ``chosen`` as above."""
        pattern = PlannedRun(self._bases[self.fidelities[design == CONFIRM]], folder=self.folder, target=FOLDER, group=f"{FOLDER} {design}")
        points = self.design(design, chosen)
        return [pattern._replace(id=f"{design}/{run}", point=self._written(point)) for run, point in points.items()]

    def known_by(self, design: str) -> str:
        """The file that must be there before the runs of a design are known; empty for one that varies every factor."""
        return "" if design in self._designs else f"{self.folder}/{BACK_FILE if design == BACK else FACTORS_FILE}"

    def chosen(self, design: str) -> Chosen:
        """What a design varies beside those that vary all, by that file."""
        path = self.known_by(design)
        return () if not path else chosen_points(path, self.axes) if design == BACK else chosen_factors(path)

    def so_far(self, base: Path) -> list[PlannedRun]:
        """The runs that are known by what lies in the folder of results, below a working folder."""
        factors, points = (base / self.folder / name for name in (FACTORS_FILE, BACK_FILE))
        known: dict[str, Chosen] = dict.fromkeys(self._designs, ())
        if factors.is_file() and {axis.name for axis in self.axes} & {*chosen_factors(factors)}:
            known |= dict.fromkeys(("sobol", CONFIRM), chosen_factors(factors))
        if points.is_file() and self.settings.back_analysis:
            known[BACK] = chosen_points(points, self.axes)
        return [run for design, chosen in known.items() for run in self.rows(design, chosen)]

    def check(self) -> None:
        """Build the scene of every run, with its particles and probes, and of every corner of the ranges at every fidelity; ValueError
        names the point.

        Which factors the Sobol' sample varies is not known yet: that of all factors stands for it.
        """
        for design in (*self._designs, "sobol"):
            for run, point in self.design(design, [axis.name for axis in self.axes]).items():
                checked(self._scene(point, self.fidelities[0]), f"{self.origin}: at {design}/{run}")
        for corner in itertools.product(
            *((axis.base, *axis.moved.values()) if axis.levels else (axis.low, axis.high) for axis in self.axes)
        ):
            at = ", ".join(f"{axis.name} = {value:g}" for axis, value in zip(self.axes, corner, strict=True))
            for fidelity in self._bases:
                checked(self._scene(corner, fidelity), f"{self.origin}: at {at}, fidelity {fidelity}")

    def _scene(self, point: Point, fidelity: str) -> dict[str, Any]:
        return self._bases[fidelity].at(self._written(point))

    def _written(self, point: Point) -> dict[str, str]:
        """Keys of the scene that a point sets."""
        factors = list(zip(self.settings.factors.values(), point, strict=True))
        levels = {name: of[int(value) - 1] for factor, value in factors for name, of in (factor.levels or {}).items()}
        return {name: repr(ratio * value) for factor, value in factors for name, ratio in factor.keys.items()} | levels

    def _axes(self, probe: str) -> list[Axis]:
        scene = self._bases[self.fidelities[0]].built({}, self.origin)
        for fidelity, keys in self._bases.items():
            check_probe(probe, keys.built({}, self.origin), f"{self.origin}: at fidelity {fidelity}")
        axes = []
        for name, factor in self.settings.factors.items():
            where = f"{self.origin}: factors.{name}"
            if not isinstance(scene.probes[probe], str) and any(path.startswith("geometry.") for path in factor.sets):
                raise ValueError(
                    f"{where}: changes the geometry, which probes.{probe}: {scene.probes[probe]} does not follow; use crest_edge"
                )
            label = factor.label or readable(factor.sets[0])
            if factor.levels:
                axes.append(level_axis(name, label, scene, factor.levels, where))
                continue
            values, units = zip(*(number_at(scene, path, f"{where}: keys") for path in factor.keys), strict=True)
            bases = np.divide(values, list(factor.keys.values()))
            if not np.allclose(bases, bases[0]):
                raise ValueError(
                    f"{where}: keys: the scene's own values, {', '.join(f'{v:g}' for v in values)}, are not in this proportion"
                )
            unit, base, (low, high) = units[0], float(bases[0]), factor.bounds or (math.nan, math.nan)
            axis = Axis(name, label, unit, low, high, factor.scale == "log", base)
            if not axis.low <= axis.base <= axis.high:
                raise ValueError(f"{where}: bounds: [{axis.low:g}, {axis.high:g}] do not hold the scene's own value, {axis.base:g} {unit}")
            axes.append(axis)
        return axes

    def _values(self, shares: np.ndarray, axes: Sequence[Axis]) -> Point:
        """Values of all factors: ``axes`` at shares (k,) of their ranges, others at their base value."""
        moved = {axis.name: axis.value(float(share)) for axis, share in zip(axes, shares, strict=True)}
        return tuple(moved.get(axis.name, axis.base) for axis in self.axes)

    def _morris(self) -> Iterable[tuple[str, Point]]:
        morris = of_extra("SALib.sample.morris", "sensitivity")
        problem = {"num_vars": len(self.axes), "names": [axis.name for axis in self.axes], "bounds": [[0.0, 1.0]] * len(self.axes)}
        for number in range(self.settings.morris.trajectories):
            seed = int(np.random.SeedSequence([self.settings.seed, number]).generate_state(1)[0])
            steps = morris.sample(problem, 1, num_levels=self.settings.morris.levels, seed=seed)
            for step, shares in enumerate(steps):
                yield f"{number:04d}/{step:02d}", self._values(shares, self.axes)

    def _tornado(self) -> Iterable[tuple[str, Point]]:
        base = tuple(axis.base for axis in self.axes)
        yield BASE, base
        for place, axis in enumerate(self.axes):
            for end, value in axis.moved.items():
                yield f"{axis.name}/{end}", (*base[:place], value, *base[place + 1 :])

    def _sobol(self, chosen: Sequence[str]) -> Iterable[tuple[str, Point]]:
        axes = [axis for axis in self.axes if axis.name in chosen]
        count = self.settings.sobol.samples
        sequence = scipy.stats.qmc.Sobol(len(axes), scramble=True, rng=self.settings.seed).random_base2(math.ceil(math.log2(count)))
        for number, shares in enumerate(sequence[:count]):
            yield f"{number:04d}", self._values(shares, axes)


def chosen_factors(path: Path | str | Sequence[str]) -> list[str]:
    """Names in the file of the factors that matter; none where there is no file."""
    return parse_json(Path(path).read_text(encoding="utf-8")) if isinstance(path, (str, Path)) else []


def chosen_points(path: Path | str | Sequence[str], axes: Sequence[Axis]) -> dict[str, Point]:
    """Points of ``BACK`` in their file, by name, a value per factor; none where there is no file."""
    if not isinstance(path, (str, Path)):
        return {}
    table = pd.read_csv(path).set_index("run")[[axis.name for axis in axes]]
    return {str(run): tuple(map(float, values)) for run, values in zip(table.index, table.to_numpy(), strict=True)}


def level_axis(name: str, label: str, scene: Scene, levels: Mapping[str, Sequence[str]], where: str) -> Axis:
    """A factor of levels; ValueError, which begins with ``where``, where no level has the scene's own values."""
    own = {path: value_at(scene, path, f"{where}: levels")[0] for path in levels}
    words = [", ".join(values) for values in zip(*levels.values(), strict=True)]
    rows = [tuple(map(value_of, values)) for values in zip(*levels.values(), strict=True)]
    if tuple(own.values()) not in rows:
        values = ", ".join(f"{path}: {as_written(value)}" for path, value in own.items())
        raise ValueError(f"{where}: levels: {', '.join(words)} do not hold the scene's own value, {values}; add it, or set it in overrides")
    return Axis(name, label, "-", 1.0, float(len(words)), False, rows.index(tuple(own.values())) + 1.0, tuple(words))


def load_sensitivity(path: str, study: Plan, folders: Sequence[Path] = (Path(),), check: bool = True) -> SensitivityPlan:
    """Validate the configuration and, with ``check``, the scenes of all runs; ValueError names file, key and value."""
    settings = validated(Sensitivity, read_yaml(found_file(folders, path, "experiments.sensitivity")), path)
    found = SensitivityPlan(settings, study, path)
    if check:
        found.check()
    return found


EXPERIMENT = Experiment("sensitivity", load_sensitivity, Sensitivity, alone=False)
