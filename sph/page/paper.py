"""What the page shows of the paper's study: its claims, and Figures 1 to 7 in the place of those of any study."""

from __future__ import annotations

from collections.abc import Mapping

from sph.experiments.paper import figures
from sph.experiments.paper.design import FIGURES as RESULTS
from sph.experiments.paper.design import PaperStudy
from sph.page.answer import CLAIMS, TRIGGER_CLAIM
from sph.page.sections import (
    DECIDING_TEXT,
    FIGURES,
    MAPS,
    OF_EVERY_STUDY,
    PREFLIGHT,
    SECTIONS,
    SPACING,
    TRIGGER,
    Section,
    drawings,
    numbered,
)
from sph.study.plan import Plan

PAPER_SECTIONS: tuple[Section, ...] = (
    FIGURES._replace(
        title="The paper's results",
        text="Figures 4 to 7 of the paper as this study gives them; the note in each says from which scene and resolution it comes. "
        "S_R, the strength ratio, is the paper's strength reduction factor, γ its coupling parameter (Eqs. 9, 14, 15). The paper shakes "
        "with 6.0 m/s² and shows S_R 0.10, 0.25 and 0.50 (0.35 in the caption of Fig. 7) with γ 100 and 1; other runs are not in it.",
        figures=drawings(figures.FIGURES, numbered(RESULTS)),
        leads=True,
    ),
    Section(
        "The paper's claims",
        "Each claim is turned into a test on numbers; a claim that fails is shown as such. Claim 11 needs a search: where one was made, "
        "it is decided under Trigger. Where sentences of the paper disagree, its figures count: Sec. 4 says that a larger γ makes the "
        "slope stable, and then that it collapses with γ 100 (claim 4); that A starts at the same moment in all cases, and earlier with "
        "S_R 0.10 (claims 5 and 6); that S_R 0.50 is both the slowest and the intermediate case, where 0.25 is meant (claims 7 and 8).",
        "snakemake --cores 2",
        tables={CLAIMS: "Claim, test, what was measured, verdict"},
        always=True,
        leads=True,
    ),
    FIGURES._replace(
        title="The paper's example",
        text="Figures 1 to 3 of the paper: slope, motion and particles of this study.",
        figures=drawings(figures.FIGURES, numbered(range(1, RESULTS.start))),
    ),
    PREFLIGHT,
    TRIGGER._replace(tables={TRIGGER_CLAIM: "What the search says of the paper's claim", **TRIGGER.tables}),
    MAPS,
    *OF_EVERY_STUDY,
)
"""The sections in their order on the page."""


def sections_of(plan: Plan) -> tuple[Section, ...]:
    """The sections of a study's page, the paper's or those of any, without figures that are left out."""
    study = plan.study
    second = (SPACING if plan.repeats_all else SPACING._replace(text=DECIDING_TEXT),) if plan.second else ()
    sections = PAPER_SECTIONS if isinstance(study, PaperStudy) else SECTIONS
    return tuple(_without(section, study.left_out) for section in sections) + second


def _without(section: Section, left_out: Mapping[str, str]) -> Section:
    """The section without these figures, which its text names with the reason."""
    missing = {f"{{fidelity}}/figures/{name}.png": reason for name, reason in left_out.items()}
    gone = [f"{section.figures[pattern].name} is left out ({missing[pattern]})." for pattern in section.figures if pattern in missing]
    shown = {pattern: drawing for pattern, drawing in section.figures.items() if pattern not in missing}
    return section._replace(text=" ".join([section.text, *gone]), figures=shown)
