"""A scene in variants: which runs there are.

Every variant is run in every case, as a whole and without shared stages.  In a cost-accuracy study the timed case is run several times,
and a variant with a list for ``numerics.lattice_shift`` is a *mean*: one run per shift, whose results are averaged and whose times add up.
``load_variants`` builds and checks the scene of every run, so that a typo or a time step above its limit is refused before any work; in a
study of robustness, which goes to the ends of the keys' ranges, a variant that is refused is a row of the table.  Equal scenes are run
once, whichever variants they belong to.
"""

from __future__ import annotations

import functools
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

from sph.experiments.base import Experiment, Overrides, checked, file_name
from sph.experiments.variants.schema import FIDELITY, TIME_STEP, Assumptions, CostAccuracy, Parameter, Robustness, Variants
from sph.measures.metrics import PROBE
from sph.scene.configuration import found_file, merge, read_scene, read_yaml, validated
from sph.scene.motion import NoMotion
from sph.scene.names import check_known
from sph.scene.schema import Scene, make_scene
from sph.scene.strict_json import to_json
from sph.solver.time_step import limits
from sph.study.plan import Plan
from sph.study.runs import BaseScene, PlannedRun

NOT_SCHEME = ("name", "title", "scheme", "duration", "geometry", "soil", "layers", "water", "uncertain", "motion", "probes", "outputs")
"""Sections and keys of a scene that say what is simulated, not how."""
CASE_KEYS = ("S_R", "gamma", "solid_after_failure")
"""Keys of ``coupling`` that say what is simulated."""
FRAME = 0.5
"""Interval of the frames of a run with a fixed step, about, s."""


class Row(NamedTuple):
    """One variant in one case: a row of the table."""

    parameter: str
    variant: str
    case: str
    changes: str
    """accuracy or model"""
    settings: Overrides
    """scene keys of the variant over the scene file"""
    scheme: Overrides
    """see the function"""
    timed: bool
    reference: bool
    symmetric: bool
    refused: str
    """why the scene is refused; empty for one that runs"""
    repeats: int
    """how many runs were asked for; of a scene that other variants share there may be more"""
    lattices: tuple[tuple[str, ...], ...]
    """keys of ``VariantRuns.runs``, one a repeat; one such tuple a lattice shift"""

    @property
    def runs(self) -> tuple[str, ...]:
        """All runs."""
        return tuple(run for repeats in self.lattices for run in repeats)


class Measured(NamedTuple):
    """What the tables are made by, beside the runs."""

    rows: tuple[Row, ...]
    baseline: str = ""
    """fidelity"""
    convergence: str = ""
    """parameter whose variants differ in spacing"""


class VariantRuns:
    """A configuration with its scene files read: every row of its table, and every run by file name without suffix."""

    def __init__(
        self,
        variants: Variants,
        scenes: Mapping[str, Mapping[str, Any]],
        fidelities: Mapping[str, Overrides],
        origin: str,
        probe: str = PROBE,
    ) -> None:
        self.variants, self._origin, self._probe = variants, origin, probe
        self.runs: dict[str, PlannedRun] = {}
        self._stems: dict[str, str] = {}
        self._repeats: dict[str, int] = {}
        self._rows: list[Row] = []
        own = merge(scenes[variants.scene], variants.overrides)
        parameters = variants.parameters
        if isinstance(variants, CostAccuracy):
            fidelities = fidelities if variants.fidelities is None else variants.fidelities
            check_known(f"{origin}: baseline", [variants.baseline], fidelities)
            parameters = {FIDELITY: Parameter(variants=dict(fidelities)), **parameters}
        for name, parameter in parameters.items():
            base = scenes[parameter.scene] if parameter.scene else own
            for label, settings in parameter.settings.items():
                for case in variants.extent(name, label).cases or ():
                    self._add(name, label, case, parameter, merge(base, variants.cases[case]), settings)
        if isinstance(variants, Robustness):
            start = merge(own, next(iter(variants.cases.values())))
            for scheme, overrides in variants.time_steps.schemes.items():
                for factor in variants.time_steps.factors:
                    self._add_time_step(f"{factor:g}", scheme, fixed_step(merge(start, overrides), factor))
        self.rows = [
            row._replace(lattices=tuple(tuple(f"{stem}_{number + 1}" for number in range(self._repeats[stem])) for (stem,) in row.lattices))
            for row in self._rows
        ]
        reference = getattr(variants, "reference", None)
        missing = set(variants.cases) - {row.case for row in self.rows if row.reference}
        if reference and missing:
            raise ValueError(
                f"{origin}: reference: parameter {reference.parameter!r}, variant {reference.variant!r} does not run in every case "
                f"(missing: {', '.join(sorted(missing))})"
            )

    def _add(self, name: str, label: str, case: str, parameter: Parameter, point: dict[str, Any], settings: Overrides) -> None:
        """Add a variant in a case, whose scene is ``point`` without its ``settings``."""
        variants = self.variants
        where = f"{self._origin}: parameter {name!r}, variant {label!r}, case {case!r}"
        own, how, refused = [], {}, ""
        # In a study of robustness the case alone has to be right: what the schema says of a variant is its result.
        robust = isinstance(variants, Robustness)
        if robust:
            make_scene(point, where)
        shifts = lattices(settings) if isinstance(variants, CostAccuracy) else [("", settings)]
        if not shifts:
            raise ValueError(f"{where}: numerics.lattice_shift: [] must name a lattice")
        repeats = variants.extent(name, label).repeats or 1
        timed = case == getattr(variants, "timed_case", case)
        for shift, shifted in shifts:
            scene = merge(point, shifted)
            try:
                built = checked(scene, "scene" if robust else where, None if robust else self._probe)
            except ValueError as error:
                if not robust:
                    raise
                refused = str(error)
                break
            how = scheme(built)
            stem = "/".join(file_name(part) for part in (name, f"{label} {shift}".strip(), case))
            own.append((self._run(stem, built, PlannedRun(BaseScene(scene)), repeats if timed else 1),))
        if is_mean(settings):
            how = merge(how, {"numerics": {"lattice_shift": settings["numerics"]["lattice_shift"]}})
        reference = getattr(variants, "reference", None)
        self._rows.append(
            Row(
                name,
                label,
                case,
                parameter.changes,
                merge({} if parameter.scene else variants.overrides, settings),
                how,
                timed,
                reference is not None and (reference.parameter, reference.variant) == (name, label),
                parameter.symmetry == "mirror",
                refused,
                repeats,
                tuple(own),
            )
        )

    def _add_time_step(self, factor: str, case: str, scene: dict[str, Any]) -> None:
        built = make_scene(scene, f"{self._origin}: time_steps.schemes, {case!r}")
        stem = "/".join(file_name(part) for part in (TIME_STEP, factor, case))
        own = self._run(stem, built, PlannedRun(BaseScene(scene), enforce_limit=False), 1)
        self._rows.append(Row(TIME_STEP, factor, case, "accuracy", {}, {}, True, False, False, "", 1, ((own,),)))

    def _run(self, stem: str, built: Scene, run: PlannedRun, repeats: int) -> str:
        """Plan the repeats of a run, unless its scene is run already; its name without their number."""
        stem = self._stems.setdefault(f"{run.enforce_limit} {built.model_dump_json(exclude={'name', 'title'})}", stem)
        self._repeats[stem] = max(self._repeats.get(stem, 1), repeats)
        for number in range(self._repeats[stem]):
            self.runs.setdefault(f"{stem}_{number + 1}", run)
        return stem

    @property
    def parameters(self) -> Measured:
        """What its tables are made by."""
        of_cost = [getattr(self.variants, name, "") for name in ("baseline", "convergence")]
        return Measured(tuple(self.rows), *of_cost)


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


def is_mean(settings: Mapping[str, Any]) -> bool:
    """Whether scene keys name several lattices, over which results are averaged."""
    numerics = settings.get("numerics")
    return isinstance(numerics, Mapping) and isinstance(numerics.get("lattice_shift"), list)


def lattices(settings: Overrides) -> list[tuple[str, Overrides]]:
    """The lattices of a variant: the shift as text, empty where there is one alone, and the scene keys."""
    if not is_mean(settings):
        return [("", settings)]
    return [(str(shift), merge(settings, {"numerics": {"lattice_shift": shift}})) for shift in settings["numerics"]["lattice_shift"]]


def scheme(scene: Scene) -> Overrides:
    """How a scene is simulated, as the keys that differ from their defaults: everything but ``NOT_SCHEME`` and ``CASE_KEYS``.

    Two scenes of one scheme differ in what is simulated only.
    """
    kept = scene.model_dump(mode="json", exclude_defaults=True, exclude={*NOT_SCHEME})
    coupling = {name: value for name, value in kept.pop("coupling", {}).items() if name not in CASE_KEYS}
    return kept | ({"coupling": coupling} if coupling else {})


def settings_text(settings: Mapping[str, Any]) -> str:
    """Scene keys as one line of JSON, for a table."""
    return to_json(settings, sort_keys=True, separators=(", ", ": "))


def load_variants(
    name: str, keys: type[Variants], path: str, study: Plan, folders: Sequence[Path] = (Path(),), check: bool = True
) -> VariantRuns:
    """Validate the configuration of an experiment and every scene in it; ValueError names file, key and value."""
    variants = validated(keys, read_yaml(found_file(folders, path, name)), path)
    names = {variants.scene, *(parameter.scene for parameter in variants.parameters.values() if parameter.scene)}
    scenes = {scene: read_scene(found_file(folders, scene, f"{path}: scene")) for scene in names}
    return VariantRuns(variants, scenes, study.study.fidelities, path, study.study.metrics.probe)


class Spacing(NamedTuple):
    """A study at its fidelity and at another spacing."""

    own: Plan
    second: Plan

    @property
    def spacings(self) -> tuple[float, float]:
        """Spacing of the first run at both, m."""
        return self.own.spacing, self.second.spacing


def load_spacing(file: str, study: Plan, folders: Sequence[Path] = (Path(),), check: bool = True) -> Spacing:
    """The runs of a study at a second spacing, which its key ``second_fidelity`` asks for.

    ValueError for a study without a second spacing, and for two fidelities with one spacing.
    """
    if study.second is None:
        raise ValueError(
            f"second_fidelity: study {study.study.study!r} names none besides fidelity {study.study.fidelity!r}, so there is nothing to "
            f"compare; it has {', '.join(study.study.fidelities)}"
        )
    spacing = Spacing(study, study.second)
    if spacing.spacings[0] == spacing.spacings[1]:
        raise ValueError(
            f"second_fidelity: {study.study.second_fidelity!r} has the spacing of {study.study.fidelity!r}, {spacing.spacings[0]:g} m; "
            "name one with another numerics.spacing"
        )
    return spacing


def _experiment(name: str, keys: type[Variants]) -> Experiment:
    return Experiment(name, functools.partial(load_variants, name, keys), keys)


EXPERIMENTS = (
    _experiment("cost-accuracy", CostAccuracy),
    _experiment("resolution", CostAccuracy),
    _experiment("assumptions", Assumptions),
    _experiment("robustness", Robustness),
    Experiment("spacing", load_spacing, alone=False),
)
EARLIER = {"trade": "cost-accuracy", "limits": "assumptions", "extremes": "robustness"}
"""What they are called now, by the names that targets and configurations had until version 0.3."""
