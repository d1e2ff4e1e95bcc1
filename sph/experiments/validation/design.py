"""The suite of reference cases: which runs it needs and what is asked of them (``config/validation.yaml``).

A *case* is a problem with a known answer, a *run* one of its variants, a *level* one of its resolutions, from coarse to fine.
Every run is made at every level.  ``load_suite`` builds and checks the scene of each, so that a typo is refused before any work.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, Literal, NamedTuple

from pydantic import model_validator

from sph.experiments.base import Experiment, Label, Name, Overrides, check_file_names, checked, file_name
from sph.experiments.validation.cases import CASES, PROBES
from sph.experiments.validation.level import Kind
from sph.scene.configuration import Section, found_file, key, merge, read_scene, read_yaml, validated
from sph.scene.names import check_known
from sph.study.plan import Plan
from sph.study.planned import planned
from sph.study.runs import Run


class Quantity(Section):
    """One number that is compared with its reference."""

    kind: Kind = key("what it is a number of")
    tolerance: float = key("largest error on the finest level, relative to the reference, absolute where that is 0", ge=0)
    coarse: float = key("largest error on the coarsest level, which the tests run", ge=0)
    reason: str = key("why these tolerances", min_length=1)


class Case(Section):
    """A problem with a known answer."""

    title: str = key("what is tested", min_length=1)
    scene: str = key("scene file, relative to the working folder or the workflow's folder")
    by: Literal["simulation", "factor_of_safety", "critical_strength_ratio", "yield_acceleration", "computation"] = key(
        "how its result is found: runs of the scene, a search for the strength or load at which the slope just stands, or functions alone",
        default="simulation",
    )
    source: str = key("where the reference comes from", min_length=1)
    reference: Literal["published", "formula", "own"] = key(
        "what the source gives: published values, a published formula or method with our numbers in it, or a closed form of our own",
        default="own",
    )
    ours: str = key("which numbers of the problem are not from the source", min_length=1, default="all")
    size: Literal["numerics.spacing", "numerics.time_step"] = key("key in which the levels differ", default="numerics.spacing")
    compared: Literal["finest", "extrapolated"] = key(
        "value that is compared: that of the finest level, or that of the two finest extrapolated to spacing 0, as by sph fos",
        default="finest",
    )
    runs: dict[Name, Overrides] = key("scene keys of each variant, by name", min_length=1, default={"run": {}})
    levels: dict[Label, Overrides] = key("scene keys of each resolution, by label, from coarse to fine", min_length=1, default={"only": {}})
    quantities: dict[Name, Quantity] = key("what is compared, by name", min_length=1)

    @model_validator(mode="after")
    def _apart(self) -> Case:
        check_file_names("levels", self.levels)
        if self.compared == "extrapolated" and len(self.levels) < 2:
            raise ValueError("compared: extrapolated needs two levels, to extrapolate from")
        return self


class Validation(Section):
    """The configuration of the suite."""

    cases: dict[Name, Case] = key("the cases, by name", min_length=1)

    @model_validator(mode="after")
    def _known(self) -> Validation:
        check_known("cases", self.cases, CASES)
        return self


class Planned(NamedTuple):
    """One run of a case."""

    run: str
    level: str
    scene: dict[str, Any]
    """the scene as a mapping"""


class Suite:
    """A suite with its scene files read: every run, by file name without suffix."""

    def __init__(self, validation: Validation, scenes: Mapping[str, Mapping[str, Any]], origin: str) -> None:
        self.cases = validation.cases
        self.runs: dict[str, Run] = {}
        self._of: dict[str, dict[str, Planned]] = {name: {} for name in self.cases}
        self._sizes: dict[tuple[str, str], float] = {}
        for name, case in self.cases.items():
            for level, finer in case.levels.items():
                for run, variant in case.runs.items():
                    scene = merge(merge(scenes[name], variant), finer)
                    where = f"{origin}: case {name}, run {run!r}, level {level!r}"
                    built = checked(scene, where)
                    if len(built.probes) < PROBES.get(name, 0):
                        raise ValueError(f"{where}: probes: {len(built.probes)}, this case measures at the first {PROBES[name]}")
                    path = f"{name}/{run}/{file_name(level)}"
                    if case.by != "computation":
                        self.runs[path] = Run(scene, by=case.by, group=name)
                    self._of[name][path] = Planned(run, level, scene)
                section, field = case.size.split(".")
                self._sizes[name, level] = float(getattr(getattr(built, section), field))

    def of(self, case: str) -> dict[str, Planned]:
        """The runs of a case, by file name."""
        return self._of[case]

    def files(self, case: str) -> list[Run]:
        """The case's runs that leave files; a case of functions alone leaves none."""
        return [self.runs[run] for run in self.of(case) if run in self.runs]

    def sizes(self, case: str) -> list[float]:
        """Spacing (m) or time step (s) of the case's levels, in their order."""
        return [self._sizes[case, level] for level in self.cases[case].levels]

    def plan(self, case: str) -> dict[str, Any]:
        """What measuring a case needs: its configuration, sizes, and (level, run, planned scene) of every run in order."""
        return {
            "name": case,
            "case": self.cases[case].model_dump(),
            "sizes": self.sizes(case),
            "runs": [(each.level, each.run, planned(each.scene)) for each in self.of(case).values()],
        }


def load_suite(path: str, study: Plan, folders: Sequence[Path] = (Path(),), check: bool = True) -> Suite:
    """Validate a suite and every scene in it; ValueError names file, key and value.  It takes nothing from the study."""
    validation = validated(Validation, read_yaml(found_file(folders, path, "validation")), path)
    scenes = {name: read_scene(found_file(folders, case.scene, f"{path}: cases.{name}.scene")) for name, case in validation.cases.items()}
    return Suite(validation, scenes, path)


EXPERIMENT = Experiment(
    "validation",
    "Validation",
    load_suite,
    Validation,
    {"validation": lambda suite: ["validation.csv", "book.md", "book.pdf", *(f"figures/{case}" for case in suite.cases)]},
    wildcards={"case": "V[0-9]+"},
)
