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
from typing import Any

import numpy as np
import pandas as pd
import scipy  # type: ignore[import-untyped]

from sph.experiments.base import Experiment, checked
from sph.experiments.sensitivity.factors import Axis, Observation, Quantity, level_axis
from sph.experiments.sensitivity.schema import Sensitivity
from sph.measures.fields import check_probe
from sph.scene.configuration import found_file, merge, read_yaml, validated
from sph.scene.extras import of_extra
from sph.scene.names import check_known
from sph.scene.strict_json import parse_json
from sph.study.dimensions import number_at, readable
from sph.study.plan import Plan
from sph.study.runs import BaseScene, PlannedRun

FOLDER = "sensitivity"
"""Folder of the results, in that of the study."""
BASE = "base"
"""Name of the run of the scene as it is."""
CONFIRM = "confirm"
"""Design of the runs that repeat others at another fidelity."""
BACK = "back"
"""Design of the runs that confirm a back-analysis."""
FACTORS_FILE, BACK_FILE = "factors.json", "back_points.csv"
"""Files that say what a design runs: the factors that matter, and the points of ``BACK``."""

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


def chosen_factors(path: Path | str) -> list[str]:
    """Names in the file of the factors that matter."""
    return parse_json(Path(path).read_text(encoding="utf-8"))


def chosen_points(path: Path | str, axes: Sequence[Axis]) -> dict[str, Point]:
    """Points of ``BACK`` in their file, by name, a value per factor."""
    table = pd.read_csv(path).set_index("run")[[axis.name for axis in axes]]
    return {str(run): tuple(map(float, values)) for run, values in zip(table.index, table.to_numpy(), strict=True)}


def load_sensitivity(path: str, study: Plan, folders: Sequence[Path] = (Path(),), check: bool = True) -> SensitivityPlan:
    """Validate the configuration and, with ``check``, the scenes of all runs; ValueError names file, key and value."""
    settings = validated(Sensitivity, read_yaml(found_file(folders, path, "experiments.sensitivity")), path)
    design = SensitivityPlan(settings, study, path)
    if check:
        design.check()
    return design


EXPERIMENT = Experiment("sensitivity", load_sensitivity, Sensitivity, alone=False)
