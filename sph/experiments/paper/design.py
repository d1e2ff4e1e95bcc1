"""The paper's study: a grid over its three dimensions, at one amplitude of which its claims are decided and Figs. 4-7 drawn."""

from __future__ import annotations

import functools
from collections.abc import Iterator, Mapping
from typing import Any

from sph.experiments.base import Experiment
from sph.experiments.paper.claims import ClaimSettings
from sph.scene.configuration import key, validated
from sph.study.dimensions import SHORT_NAMES, named, value_of
from sph.study.schema import Axis, FigureCases, Number, Point, Study

DIMENSIONS = tuple(SHORT_NAMES)
"""The paper varies what has a short name."""
FIGURES = range(4, 8)
"""Figures of results; those before them show what goes in."""


class PaperFigures(FigureCases):
    """Which runs figures show: Figs. 4-7 at the amplitude of the claims, values as in the grid."""

    strengths: Axis = key("S_R of Figs. 4 and 6", source="Figs. 4, 6", default=("0.10", "0.25", "0.50"))
    gamma: Number = key("gamma of Figs. 4 and 6", "1/s", "Figs. 4, 6", default="100")
    compared_gammas: Axis = key("gammas of Figs. 5 and 7", "1/s", "Figs. 5, 7", default=("100", "1"))
    compared_strengths: Axis = key(
        "S_R of the panels of Fig. 7, the first also of Fig. 5",
        source="Fig. 7: 0.25 in the text, 0.35 in the caption",
        default=("0.25", "0.35"),
    )


class AnyStudy(Study):
    """The configuration of the workflow: a study's, with the keys of the paper's.

    One over other dimensions has no use for these, but need not remove them from the configuration that it overrides.
    """

    figures: PaperFigures = key(
        "runs shown in Figs. 4-7, of a study over other dimensions than the paper's in profiles", default=PaperFigures()
    )
    claims: ClaimSettings | None = key(
        "numbers that turn the source paper's words into tests: with them a grid over exactly S_R, gamma and amplitude has its claims "
        "decided and its Figures 1 to 7 drawn; null: neither",
        default=None,
    )

    def why_without(self, figure: str) -> str:
        """Why this study has no figure of that name: those of the paper need its dimensions, and their runs."""
        try:
            paper_study(self, "the paper's figures")
        except ValueError as error:
            return str(error)
        return super().why_without(figure)

    @classmethod
    def read(cls, data: Mapping[str, Any], origin: str) -> Study:
        """Validate the keys of a study, the paper's where its dimensions are those; ValueError names ``origin``, key and value."""
        study = validated(AnyStudy, data, origin)
        return validated(PaperStudy, data, origin) if study.claims is not None and study.is_grid_over(DIMENSIONS) else study


class PaperStudy(AnyStudy):
    """A study over exactly the paper's dimensions, of which its claims are asked."""

    claims: ClaimSettings = key("numbers that turn the source paper's words into tests", default=ClaimSettings())

    @property
    def figure_files(self) -> dict[str, list[str]]:
        """Names of the runs from which Figs. 1-7 are drawn, without figures that are left out; ValueError where the grid lacks what
        the configuration asks for."""
        amplitudes = self.values["amplitude"]
        if float(self.claims.amplitude) not in map(value_of, amplitudes):
            raise ValueError(
                f"claims.amplitude: {self.claims.amplitude} is not in grid.amplitude, which has {', '.join(amplitudes)}; write one of "
                "these, or claims: null for a study of which no claims are asked"
            )
        drawn, left_out = self._drawn
        if left_out and self.figures.model_fields_set & {*PaperFigures.model_fields} - {*FigureCases.model_fields}:
            raise ValueError(next(iter(left_out.values())))
        first = next(iter(drawn.values()), list(self.runs))[:1]
        return {f"fig{number}": first for number in range(1, FIGURES.start)} | drawn

    @property
    def left_out(self) -> dict[str, str]:
        """Figs. 4-7 whose runs are not in the grid, with the value that is missing."""
        return self._drawn[1]

    @functools.cached_property
    def _drawn(self) -> tuple[dict[str, list[str]], dict[str, str]]:
        """Names of the runs of Figs. 4-7, and what is missing for the others."""
        drawn, left_out = {}, {}
        for number in FIGURES:
            try:
                drawn[f"fig{number}"] = [self.name_of(point) for _, point in self.figure_runs(number)]
            except ValueError as error:
                left_out[f"fig{number}"] = str(error)
        return drawn, left_out

    def figure_titles(self, figure: str) -> list[list[str]]:
        """Titles of the runs of Figs. 4-7: panel, where there are several, and curve."""
        of = {f"fig{number}": number for number in FIGURES}
        return [list(titles) for titles, _ in self.figure_runs(of[figure])] if figure in of else []

    def figure_runs(self, number: int) -> Iterator[tuple[tuple[str, ...], Point]]:
        """Titles (panel, then curve) and point of every run of one of ``FIGURES``; ValueError where the study lacks one."""
        cases = self.figures
        if number in (4, 6):
            pairs = [(S_R, cases.gamma) for S_R in cases.strengths]
        else:
            strengths = cases.compared_strengths if number == 7 else cases.compared_strengths[:1]
            pairs = [(S_R, gamma) for S_R in strengths for gamma in cases.compared_gammas]
        for wanted_S_R, wanted_gamma in pairs:
            S_R, gamma = self._label("S_R", wanted_S_R), self._label("gamma", wanted_gamma)
            amplitude = self._label("amplitude", str(self.claims.amplitude))
            first = named("S_R").equation(S_R)
            second, third = named("gamma").equation(gamma), f"amplitude {amplitude} m/s²"
            titles = {6: (f"{second}, {third}", first), 7: (f"{first}, {third}", second)}.get(number, (f"{first}, {second}, {third}",))
            yield titles, {"S_R": S_R, "gamma": gamma, "amplitude": amplitude}

    def _label(self, name: str, value: str) -> str:
        """The grid's own writing of a number; ValueError if the grid lacks it."""
        for label in self.values[name]:
            if value_of(label) == float(value):
                return label
        raise ValueError(f"grid.{name}: {value} is shown in this figure, the grid has {', '.join(self.values[name])}")


def paper_study(study: Study, what: str) -> PaperStudy:
    """The study, where it is the paper's; ValueError, which says ``what`` needs it, where not."""
    study.needs_grid_over(DIMENSIONS, what)
    if not isinstance(study, PaperStudy):
        raise ValueError(f"{what} need the key claims in study {study.study!r}, for the paper's is {{amplitude: 6.0}}")
    return study


EXPERIMENT = Experiment("paper", lambda file, plan, folders, check: plan.study, alone=False, study=AnyStudy)
