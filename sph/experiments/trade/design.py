"""The cost-accuracy study: which runs measure what each saving of computing time costs in accuracy (``config/trade.yaml``).

A *parameter* is one thing that is varied, a *variant* one of its values, a *case* a point of the study.  Every variant is run
in every case, as a whole and without shared stages; the timed case is run several times.
A variant with a list for ``numerics.lattice_shift`` is a *mean*: one run per shift, whose results are averaged and whose times add up.
``load_trade`` builds and checks the scene of every run, so that a typo or a time step above its limit is refused before any work.  Equal
scenes are run once, whichever variants they belong to.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, Literal, NamedTuple

from pydantic import model_validator

from sph.experiments.base import Cases, Experiment, Label, Name, Overrides, check_file_names, checked, file_name
from sph.measures.metrics import PROBE
from sph.scene.configuration import Section, found_file, key, merge, read_scene, read_yaml, validated
from sph.scene.names import check_known
from sph.scene.schema import Scene
from sph.scene.strict_json import to_json
from sph.study.plan import Plan
from sph.study.runs import BaseScene, Run

FIDELITY = "fidelity"
"""Parameter whose variants are the study's fidelities."""
NOT_SCHEME = ("name", "title", "scheme", "duration", "geometry", "soil", "layers", "water", "uncertain", "motion", "probes", "outputs")
"""Sections and keys of a scene that say what is simulated, not how."""
CASE_KEYS = ("S_R", "gamma", "solid_after_failure")
"""Keys of ``coupling`` that say what is simulated."""


class Extent(Section):
    """How much of the variants is run."""

    repeats: int | None = key("number of runs of the timed case; null: as one level up", ge=1, le=100, default=None)
    cases: tuple[str, ...] | None = key("cases to run, including the timed one; null: as one level up", min_length=1, default=None)


class Parameter(Extent):
    """A parameter and its variants."""

    about: str = key("what the parameter does, in one sentence", min_length=1)
    changes: Literal["accuracy", "model"] = key(
        "accuracy: how well the scene is computed; model: what is computed, which 'sph advise' leaves alone", default="accuracy"
    )
    base: Overrides = key("scene keys of all its variants", default={})
    variants: dict[Label, Overrides] = key("scene keys of each variant, by label", min_length=1)
    exceptions: dict[Label, Extent] = key("variants that are run fewer times or in fewer cases than the others, by label", default={})

    @model_validator(mode="after")
    def _known(self) -> Parameter:
        check_known("exceptions", self.exceptions, self.variants)
        check_file_names("variants", self.variants)
        return self


class Reference(Section):
    """The variant from which deviations are measured."""

    parameter: str = key("its parameter")
    variant: str = key("its label")


class Trade(Cases):
    """The configuration of the cost-accuracy study."""

    timed_case: str = key("case whose runs are repeated and whose computing time is a variant's cost")
    repeats: int = key("number of runs of the timed case", ge=1, le=100, default=3)
    reference: Reference = key("the variant from which deviations are measured, the finest that runs in every case")
    baseline: str = key("fidelity from which deviations are also given", default="paper")
    convergence: str = key("parameter whose variants differ in spacing: the order of convergence is measured on it", default="spacing")
    fidelities: dict[Name, Overrides] | None = key(
        f"scene keys of the fidelities that are variants of {FIDELITY!r}, by name; null: those of the study", min_length=1, default=None
    )
    parameters: dict[Name, Parameter] = key(f"the parameters, by name; the study's fidelities are added as '{FIDELITY}'", min_length=1)

    @model_validator(mode="after")
    def _known(self) -> Trade:
        if FIDELITY in self.parameters:
            raise ValueError(f"parameters: {FIDELITY!r} is the parameter of the study's fidelities, choose another name")
        check_known("convergence", [self.convergence], self.parameters)
        check_known("timed_case", [self.timed_case], self.cases)
        for name, parameter in self.parameters.items():
            for label in parameter.variants:
                cases = self.extent(name, label).cases or ()
                check_known(f"parameters.{name}, variant {label!r}: cases", cases, self.cases)
                if self.timed_case not in cases:
                    raise ValueError(f"parameters.{name}, variant {label!r}: cases: the timed case {self.timed_case!r} must be among them")
        return self

    def extent(self, parameter: str, variant: str) -> Extent:
        """Cases and repeats of a variant: its own, else its parameter's, else those of all."""
        asked: list[Extent] = []
        if parameter in self.parameters:
            asked = [self.parameters[parameter].exceptions.get(variant, Extent()), self.parameters[parameter]]
        asked.append(Extent(repeats=self.repeats, cases=tuple(self.cases)))
        return Extent(
            repeats=next(extent.repeats for extent in asked if extent.repeats),
            cases=next(extent.cases for extent in asked if extent.cases),
        )


class VariantRow(NamedTuple):
    """One variant in one case: a row of the table."""

    parameter: str
    variant: str
    case: str
    changes: str  # accuracy or model
    settings: Overrides  # scene keys of the variant over the scene file
    scheme: Overrides  # see the function
    timed: bool
    reference: bool
    lattices: tuple[tuple[str, ...], ...]  # keys of ``TradeRuns.runs``, one a repeat; one such tuple a lattice shift

    @property
    def runs(self) -> tuple[str, ...]:
        """All runs."""
        return tuple(run for repeats in self.lattices for run in repeats)


class TradeParameters(NamedTuple):
    """What the tables are made by, beside the runs."""

    rows: tuple[VariantRow, ...]
    baseline: str
    """fidelity"""
    convergence: str
    """parameter whose variants differ in spacing"""


class TradeRuns:
    """A cost-accuracy study with its scene file read: every row of its table, and every run by file name without suffix."""

    def __init__(self, trade: Trade, base: Mapping[str, Any], fidelities: Mapping[str, Overrides], origin: str, probe: str = PROBE) -> None:
        fidelities = fidelities if trade.fidelities is None else trade.fidelities
        check_known(f"{origin}: baseline", [trade.baseline], fidelities)
        self.trade, self._fidelities = trade, fidelities
        self.runs: dict[str, Run] = {}
        stems: dict[str, str] = {}
        repeats: dict[str, int] = {}
        found = []
        for parameter, label, settings in self._variants():
            extent = trade.extent(parameter, label)
            if not lattices(settings):
                raise ValueError(f"{origin}: parameter {parameter!r}, variant {label!r}: numerics.lattice_shift: [] must name a lattice")
            for case in extent.cases or ():
                own, how = [], {}
                for shift, shifted in lattices(settings):
                    scene = merge(merge(base, shifted), trade.cases[case])
                    built = checked(scene, f"{origin}: parameter {parameter}, variant {label!r}, case {case!r}", probe)
                    content = built.model_dump_json(exclude={"name", "title"})
                    stem = stems.setdefault(content, f"{parameter}/{file_name(f'{label} {shift}'.strip())}/{file_name(case)}")
                    repeats[stem] = max(repeats.get(stem, 1), (extent.repeats or 1) if case == trade.timed_case else 1)
                    own.append(stem)
                    how = scheme(built)
                    run = Run(BaseScene(scene))
                    for number in range(1, repeats[stem] + 1):
                        self.runs.setdefault(f"{stem}_{number}", run)
                if is_mean(settings):
                    how = merge(how, {"numerics": {"lattice_shift": settings["numerics"]["lattice_shift"]}})
                changes = trade.parameters[parameter].changes if parameter in trade.parameters else "accuracy"
                found.append((parameter, label, case, changes, settings, how, own))
        reference = (trade.reference.parameter, trade.reference.variant)
        self.rows = [
            VariantRow(
                parameter,
                label,
                case,
                changes,
                settings,
                how,
                case == trade.timed_case,
                (parameter, label) == reference,
                tuple(tuple(f"{stem}_{number}" for number in range(1, repeats[stem] + 1)) for stem in own),
            )
            for parameter, label, case, changes, settings, how, own in found
        ]
        missing = set(trade.cases) - {row.case for row in self.rows if row.reference}
        if missing:
            raise ValueError(
                f"{origin}: reference: parameter {reference[0]!r}, variant {reference[1]!r} does not run in every case "
                f"(missing: {', '.join(sorted(missing))})"
            )

    @property
    def parameters(self) -> TradeParameters:
        """What its tables are made by."""
        return TradeParameters(tuple(self.rows), self.trade.baseline, self.trade.convergence)

    def _variants(self) -> Iterator[tuple[str, str, Overrides]]:
        for label, settings in self._fidelities.items():
            yield FIDELITY, label, merge(self.trade.overrides, settings)
        for name, parameter in self.trade.parameters.items():
            for label, settings in parameter.variants.items():
                yield name, label, merge(merge(self.trade.overrides, parameter.base), settings)


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


def load_trade(path: str, study: Plan, folders: Sequence[Path] = (Path(),), check: bool = True) -> TradeRuns:
    """Validate a cost-accuracy study and every scene in it; ValueError names file, key and value."""
    trade = validated(Trade, read_yaml(found_file(folders, path, "trade")), path)
    scene = read_scene(found_file(folders, trade.scene, f"{path}: scene"))
    return TradeRuns(trade, scene, study.study.fidelities, path, study.study.metrics.probe)


def settings_text(settings: Mapping[str, Any]) -> str:
    """Scene keys as one line of JSON, for a table."""
    return to_json(settings, sort_keys=True, separators=(", ", ": "))


def cost_accuracy(name: str, title: str) -> Experiment:
    """An experiment of this kind."""
    return Experiment(name, title, load_trade, Trade, uses=["trade"] * (name != "trade"))


EXPERIMENT = cost_accuracy("trade", "Cost and accuracy")
