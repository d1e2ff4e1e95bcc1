"""A study: one scene over a grid of S_R, gamma and shaking amplitude at a fidelity (``config/config.yaml``).

Grid values stay the strings they were written as, so that file names and labels are what the user
wrote; they become numbers in the scene and in the study's tables.  ``load_study`` builds and validates the
scene of every run, so that a typo is refused before any work.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Annotated, Any

import pandas as pd
from pydantic import BeforeValidator, Field, model_validator

from sph.analysis.claims import ClaimSettings
from sph.analysis.metrics import GRID, MetricSettings
from sph.configuration import Section, dotted, found_file, key, merge, read_scene, read_yaml, validated
from sph.scene import Scene, make_scene

NAME = r"^[A-Za-z0-9][A-Za-z0-9_.-]{0,63}$"
GRID_KEYS = {"S_R": "coupling.S_R", "gamma": "coupling.gamma", "amplitude": "motion.amplitude"}
"""The scene key that each dimension of the grid sets."""


def _as_written(values: Any) -> Any:
    """A number that YAML has read becomes its shortest text; quoted numbers keep theirs."""
    return [repr(v) if isinstance(v, (int, float)) else v for v in values] if isinstance(values, list) else values


MOST_RUNS = 10_000
"""Most points of a grid."""

Number = Annotated[str, Field(max_length=24, pattern=r"^[0-9]+(\.[0-9]+)?([eE][+-]?[0-9]+)?$")]
Axis = Annotated[tuple[Number, ...], BeforeValidator(_as_written), Field(min_length=1)]


class Grid(Section):
    """Values of the three dimensions, as written; every combination is run."""

    S_R: Axis = key("strength ratios; quote them to keep trailing zeros", source="Fig. 4")
    gamma: Axis = key("rates of the loss of strength", "1/s", "Fig. 5")
    amplitude: Axis = key("amplitudes of the shaking", "m/s2", "Sec. 3.2")

    @model_validator(mode="after")
    def _unique(self) -> Grid:
        for name in GRID:
            values = getattr(self, name)
            if len({float(value) for value in values}) < len(values):
                raise ValueError(f"{name}: {list(values)} holds one number twice")
        runs = math.prod(len(getattr(self, name)) for name in GRID)
        if runs > MOST_RUNS:
            raise ValueError(f"{', '.join(GRID)}: the grid has {runs:,} points, at most {MOST_RUNS:,}")
        return self


class FigureCases(Section):
    """Which runs Figs. 4-7 show, at the amplitude of the claims; values as in the grid."""

    strengths: Axis = key("S_R of Figs. 4 and 6", source="Figs. 4, 6", default=("0.10", "0.25", "0.50"))
    gamma: Number = key("gamma of Figs. 4 and 6", "1/s", "Figs. 4, 6", default="100")
    compared_gammas: Axis = key("gammas of Figs. 5 and 7", "1/s", "Figs. 5, 7", default=("100", "1"))
    compared_strengths: Axis = key(
        "S_R of the panels of Fig. 7, the first also of Fig. 5",
        source="Fig. 7: 0.25 in the text, 0.35 in the caption",
        default=("0.25", "0.35"),
    )


class Study(Section):
    """The configuration of the workflow."""

    study: str = key("name; results go to results/<study>/<fidelity>", pattern=NAME)
    scene: str = key("scene file, relative to the working folder or the workflow's")
    fidelity: str = key("which of the fidelities to run at")
    grid: Grid = key("the runs")
    fidelities: dict[Annotated[str, Field(pattern=NAME)], dict[str, Any]] = key("scene keys that each fidelity sets, by name")
    figures: FigureCases = key("runs shown in Figs. 4-7", default=FigureCases())
    metrics: MetricSettings = key("thresholds of the metrics", default=MetricSettings())
    claims: ClaimSettings = key("numbers that turn the paper's words into tests", default=ClaimSettings())
    trade: str = key("file of the ladder that 'snakemake trade' runs, searched for as the scene", default="config/trade.yaml")
    validation: str = key("file of the reference cases that 'snakemake validation' runs, likewise", default="config/validation.yaml")
    limits: str = key("file of the changes that 'snakemake limits' runs, likewise", default="config/limits.yaml")
    extremes: str = key("file of the sweeps that 'snakemake extremes' runs, likewise", default="config/extremes.yaml")
    sensitivity: str = key("file of the factors that 'snakemake sensitivity' varies, likewise", default="config/sensitivity.yaml")
    trigger: str = key("file of the searches that 'snakemake trigger' and 'snakemake maps' run, likewise", default="config/trigger.yaml")

    @model_validator(mode="after")
    def _known(self) -> Study:
        if self.fidelity not in self.fidelities:
            raise ValueError(f"fidelity: {self.fidelity!r} is not one of {', '.join(self.fidelities)}")
        return self

    @property
    def points(self) -> pd.DataFrame:
        """Table of all grid points, labels as written."""
        return pd.DataFrame(list(itertools.product(*(getattr(self.grid, name) for name in GRID))), columns=list(GRID))

    @staticmethod
    def point_name(point: Mapping[str, str]) -> str:
        """Name of a grid point in file names, as the Snakefile's ``Paramspace`` writes it."""
        return "_".join(f"{name}-{point[name]}" for name in GRID)

    @property
    def reference_amplitude(self) -> str:
        """Label of the amplitude at which claims are tested and figures drawn; ValueError if the grid lacks it."""
        return self.label("amplitude", str(self.claims.amplitude))

    def label(self, name: str, value: str) -> str:
        """The grid's own writing of a number; ValueError if the grid lacks it."""
        for label in getattr(self.grid, name):
            if float(label) == float(value):
                return str(label)
        raise ValueError(f"grid.{name}: {value} is needed by the figures, the grid has {', '.join(getattr(self.grid, name))}")

    def figure_runs(self, figure: int) -> Iterator[tuple[tuple[str, ...], dict[str, str]]]:
        """Titles (panel, then curve) and grid point of every run that a figure shows.

        Figs. 1-3 show what goes in and need one run without a title.
        """
        cases = self.figures
        if figure <= 3:
            pairs = [(cases.strengths[0], cases.gamma)]
        elif figure in (4, 6):
            pairs = [(S_R, cases.gamma) for S_R in cases.strengths]
        else:
            strengths = cases.compared_strengths if figure == 7 else cases.compared_strengths[:1]
            pairs = [(S_R, gamma) for S_R in strengths for gamma in cases.compared_gammas]
        for wanted_S_R, wanted_gamma in pairs:
            S_R, gamma = self.label("S_R", wanted_S_R), self.label("gamma", wanted_gamma)
            first, second = f"$S_R$ = {S_R}", f"γ = {gamma} s⁻¹"
            titles = () if figure <= 3 else (first, second) if figure == 7 else (f"{first}, {second}",)
            yield titles, {"S_R": S_R, "gamma": gamma, "amplitude": self.reference_amplitude}


class Plan:
    """A study with its scene file read: the scene of every stage and run, as mappings."""

    def __init__(
        self, study: Study, base: Mapping[str, Any], origin: str, overrides: Mapping[str, Any] | None = None, subfolder: str = ""
    ) -> None:
        self.study, self.origin, self._subfolder = study, origin, subfolder
        self._scene_file = base
        self._base = merge(merge(base, study.fidelities[study.fidelity]), overrides or {})

    @property
    def folder(self) -> str:
        """Where the results go, relative to the working folder."""
        return "/".join(part for part in ("results", self.study.study, self.study.fidelity, self._subfolder) if part)

    def at(self, fidelity: str, overrides: Mapping[str, Any] | None = None, subfolder: str = "", origin: str = "") -> Plan:
        """The same study at one of its fidelities, with scene keys laid over it, its results in a folder below."""
        return Plan(self.study.model_copy(update={"fidelity": fidelity}), self._scene_file, origin or self.origin, overrides, subfolder)

    def scene(self, **point: str) -> dict[str, Any]:
        """Scene with some of S_R, gamma and amplitude set, as a mapping."""
        return merge(self._base, dotted({GRID_KEYS[name]: float(value) for name, value in point.items()}))

    def validate(self) -> None:
        """Build every scene; ValueError with file and key for the first that is refused."""
        for name, overrides in self.study.fidelities.items():
            make_scene(merge(self._scene_file, overrides), f"{self.origin} at fidelity {name}")
        for point in self.study.points.to_dict("records"):
            self.built(**{str(name): str(value) for name, value in point.items()})
        for figure in range(1, 8):
            list(self.study.figure_runs(figure))

    def built(self, **point: str) -> Scene:
        """The validated scene of a point; ValueError for one that cannot share its gravity stage."""
        at = ", ".join(f"{name} = {value}" for name, value in point.items())
        scene = make_scene(self.scene(**point), f"{self.origin} at {at}")
        if scene.coupling.initial_state == "fluid":
            raise ValueError(
                f"{self.origin}: coupling.initial_state: 'fluid' feels S_R from the start, but the runs share the gravity stage; "
                "allowed in a study: 'solid' (a fluid scene runs by 'sph run')"
            )
        return scene


def load_study(config: Mapping[str, Any] | Path | str, folders: Sequence[Path] = (Path(),)) -> Plan:
    """Validate a configuration and every scene in it; ValueError names file, key and value.

    ``folders`` are searched in order for the scene file.
    """
    origin = "config" if isinstance(config, Mapping) else str(config)
    data = config if isinstance(config, Mapping) else read_yaml(config)
    study = validated(Study, data, origin)
    scene = found_file(folders, study.scene, f"{origin}: scene")
    plan = Plan(study, read_scene(scene), str(scene))
    plan.validate()
    return plan
