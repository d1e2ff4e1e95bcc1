"""Configurations of a scene in variants (``config/cost-accuracy.yaml``, ``resolution.yaml``, ``assumptions.yaml``, ``robustness.yaml``).

A *parameter* is what is changed, a *variant* one of its values, a *case* a point of the study.
"""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import Field, model_validator

from sph.experiments.base import Cases, Label, Name, Overrides, check_file_names
from sph.scene.configuration import Section, dotted, key, merge
from sph.scene.names import check_known
from sph.study.dimensions import check_key

FIDELITY = "fidelity"
"""Parameter of a cost-accuracy study whose variants are the study's fidelities."""
TIME_STEP = "time step over limit"
"""Parameter of a study of robustness whose variants are fixed time steps."""


class Extent(Section):
    """How much of the variants is run."""

    repeats: int | None = key("number of runs of a variant; null: as one level up", ge=1, le=100, default=None)
    cases: tuple[str, ...] | None = key("cases to run, including the timed one; null: as one level up", min_length=1, default=None)


class Parameter(Extent):
    """What is changed, and its variants."""

    about: str = key("what the parameter does, in one sentence", default="")
    changes: Literal["accuracy", "model"] = key(
        "accuracy: how well the scene is computed; model: what is computed, which 'sph advise' leaves alone", default="accuracy"
    )
    scene: str | None = key("another scene file; null: that of all parameters, with its overrides", default=None)
    symmetry: Literal["none", "mirror"] = key(
        "mirror: the scene is symmetric about the middle of its box, which a study of robustness measures", default="none"
    )
    base: Overrides = key("scene keys of all its variants", default={})
    variants: dict[Label, Overrides] = key("scene keys of each variant, by label", default={})
    scene_key: str | None = key("instead of variants, a scene key, dotted", pattern=r"^[A-Za-z_][A-Za-z0-9_.]*$", default=None)
    values: tuple[Any, ...] = key("the values of that key, each a variant", default=())
    exceptions: dict[Label, Extent] = key("variants that are run fewer times or in fewer cases than the others, by label", default={})

    @model_validator(mode="after")
    def _known(self) -> Parameter:
        if bool(self.variants) == bool(self.values) or bool(self.values) == (self.scene_key is None):
            raise ValueError("variants: give variants with their scene keys, or a scene_key and its values")
        if self.scene_key is not None:
            check_key(f"scene_key: {self.scene_key}", self.scene_key)
        check_known("exceptions", self.exceptions, self.settings)
        check_file_names("variants" if self.variants else "values", self.settings)
        return self

    @property
    def settings(self) -> dict[str, Overrides]:
        """Scene keys of each variant, by label."""
        listed = {"null" if value is None else str(value): dotted({str(self.scene_key): value}) for value in self.values}
        return {label: merge(self.base, keys) for label, keys in (self.variants or listed).items()}


class Reference(Section):
    """The variant from which deviations are measured."""

    parameter: str = key("its parameter")
    variant: str = key("its label")


class Variants(Cases):
    """What every configuration has."""

    repeats: int = key(
        "number of runs of every variant, which are compared bit for bit; in a cost-accuracy study those of the timed case",
        ge=1,
        le=100,
        default=1,
    )
    parameters: dict[Label, Parameter] = key("the parameters, by name", min_length=1)

    @model_validator(mode="after")
    def _cases_known(self) -> Variants:
        check_file_names("parameters", self.parameters)
        for name, parameter in self.parameters.items():
            for label in parameter.settings:
                check_known(f"parameters.{name}, variant {label!r}: cases", self.extent(name, label).cases, self.cases)
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


class CostAccuracy(Variants):
    """A cost-accuracy study."""

    timed_case: str = key("case whose runs are repeated and whose computing time is a variant's cost")
    reference: Reference = key("the variant from which deviations are measured, the finest that runs in every case")
    baseline: str = key("fidelity from which deviations are also given", default="paper")
    convergence: str = key("parameter whose variants differ in spacing: the order of convergence is measured on it", default="spacing")
    fidelities: dict[Name, Overrides] | None = key(
        f"scene keys of the fidelities, which are variants of the parameter {FIDELITY!r}, by name; null: those of the study",
        min_length=1,
        default=None,
    )

    @model_validator(mode="after")
    def _known(self) -> CostAccuracy:
        if FIDELITY in self.parameters:
            raise ValueError(f"parameters: {FIDELITY!r} is the parameter of the study's fidelities, choose another name")
        check_known("convergence", [self.convergence], self.parameters)
        check_known("timed_case", [self.timed_case], self.cases)
        for name, parameter in self.parameters.items():
            for label in parameter.settings:
                if self.timed_case not in (self.extent(name, label).cases or ()):
                    raise ValueError(f"parameters.{name}, variant {label!r}: cases: the timed case {self.timed_case!r} must be among them")
        return self


class Assumptions(Variants):
    """Assumptions that are changed one at a time."""

    reference: Reference = key("the variant from which changes are measured, the scene as it is")

    @model_validator(mode="after")
    def _apart(self) -> Assumptions:
        labels = [label for parameter in self.parameters.values() for label in parameter.settings]
        if len(labels) > len({*labels}):
            raise ValueError("parameters: two variants have one label, by which the table names its rows")
        return self


class TimeSteps(Section):
    """Fixed time steps around the limit."""

    factors: tuple[Annotated[float, Field(gt=0, le=10)], ...] = key("time steps divided by the theoretical limit", min_length=1)
    schemes: dict[Label, Overrides] = key("scene keys of each scheme, by label", min_length=1)


class Robustness(Variants):
    """Keys at the ends of their ranges."""

    time_steps: TimeSteps = key("fixed time steps below and above their limit, in the first case")

    @model_validator(mode="after")
    def _apart(self) -> Robustness:
        check_file_names("parameters", (*self.parameters, TIME_STEP))
        check_file_names("time_steps.schemes", self.time_steps.schemes)
        return self
