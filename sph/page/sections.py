"""What the page shows besides the runs: sections of tables and figures, found at paths below ``results/<study>``.

A section whose files do not exist names the command that makes them.  To add one, add a row to ``OF_EVERY_STUDY``.  What
only the paper's study shows is in ``sph.page.paper``.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from itertools import chain
from pathlib import Path, PurePath
from typing import Any, NamedTuple, TypeVar

from sph.experiments.trigger.figures import MAPPED
from sph.experiments.variants.second_spacing import spacing_columns
from sph.figures import RUN_FIGURES, STUDY_FIGURES
from sph.figures import caption as caption_of
from sph.page.answer import ANNUAL, CRITICAL, FINDINGS, SPACINGS
from sph.storage.trajectory import Variable
from sph.study.schema import INPUT_FIGURES, MOBILISED, PROFILES

Held = TypeVar("Held")


class Drawing(NamedTuple):
    """A figure: its name and what it shows."""

    name: str
    caption: str


class Section(NamedTuple):
    """A part of the page; patterns are those of ``Path.glob`` without ``**``, relative to ``results/<study>``, where ``{fidelity}`` is
    that of the page: a target that runs at a fidelity of its own is found by ``*``, and its path says at which."""

    title: str
    text: str
    command: str  # makes its files
    tables: Mapping[str, str] = {}  # caption by pattern of CSV files
    figures: Mapping[str, Drawing] = {}  # by pattern of PNG files
    variables: Sequence[Variable] = ()  # columns of its tables, whose units the headings show
    aside: Sequence[str] = ()  # columns of its tables that are for programs
    keys: Sequence[str] = ()  # others that name keys and codes, which a client does not need
    always: bool = False  # made with every study
    leads: bool = False  # stands before the run that the reader chooses


MAP = "Map over the first dimension of the search and the shaking."


def drawings(figures: Mapping[str, Callable[..., Any]], names: Mapping[str, str]) -> dict[str, Drawing]:
    """Figures of a study by their patterns; ``names`` by those of their files, and so the functions."""
    return {f"{{fidelity}}/figures/{file}.png": Drawing(name, caption_of(figures[file])) for file, name in names.items()}


def numbered(numbers: Iterable[int]) -> dict[str, str]:
    """Names of figures with numbers by those of their files."""
    return {f"fig{number}": f"Figure {number}" for number in numbers}


INPUTS = dict(zip(INPUT_FIGURES, ("Section", "Motion", "Initial particles"), strict=True))
"""Names of the figures of the input."""
PREFLIGHT = Section(
    "Before the runs",
    "Findings on the scenes and on the stability of the slope before any run: errors, warnings and notes.",
    "snakemake --cores 2",
    tables={"{fidelity}/preflight.csv": "Findings"},
    aside=("worst_run", "subject", "off_by", "numbers"),
    keys=("code", "key"),
    always=True,
)
FIGURES = Section(
    "Figures",
    "Results and inputs of this study. The note in each figure says from which scene and resolution it comes.",
    "snakemake --cores 2",
    figures=drawings(
        STUDY_FIGURES | RUN_FIGURES,
        {name: name.capitalize() for name in (*STUDY_FIGURES, PROFILES)} | {MOBILISED: "Mobilised strength before the shaking"} | INPUTS,
    ),
    always=True,
)
TRIGGER = Section(
    "Trigger",
    "The shaking at which the slope begins to fail, bracketed by a run that stands and one that fails.",
    "snakemake --cores 2 trigger",
    tables={
        "*/trigger/trigger.csv": "Critical intensities of the shaking",
        "*/trigger/confirm.csv": "Ends of the brackets, repeated at another fidelity",
    },
    figures={
        "*/trigger/figures/trigger.png": Drawing("Trigger", "Critical intensity of the shaking against the first dimension of the search.")
    },
)
MAPS = Section(
    "Maps",
    "Displacement and class over the dimensions of the search and the shaking.",
    "snakemake --cores 2 maps",
    tables={"*/trigger/shares.csv": "Shares of the values searched that reach each class"},
    figures={
        "*/trigger/figures/shares.png": Drawing("Shares", "Shares of the values searched that reach each class."),
        "*/trigger/figures/map-class.png": Drawing("Map of the class", MAP),
        **{f"*/trigger/figures/map-{name}.png": Drawing(f"Map of the {name}", MAP) for name in MAPPED},
    },
)
OF_EVERY_STUDY: tuple[Section, ...] = (
    Section(
        "Fragility",
        "The probability that the slope reaches a damage class at a given intensity, and how far it moves, over the motions of the search.",
        "snakemake --cores 2 fragility",
        tables={
            "*/trigger/fragility_fit.csv": "Lognormal fits, with the results in words",
            "*/trigger/fragility_annual.csv": "Annual frequencies, with the seismic hazard of the site",
            "*/trigger/fragility_measures.csv": "The fits in other intensity measures, the most efficient first",
            "*/trigger/widths.csv": "Run-out not exceeded by most of the motions",
            "*/trigger/exceedance.csv": "Share of the motions that exceed a run-out or a displacement",
        },
        figures={
            "*/trigger/figures/fragility.png": Drawing("Fragility", "Probability of each class against the intensity."),
            "*/trigger/figures/exceedance.png": Drawing("Exceedance", "Share of the motions that exceed a run-out or a displacement."),
        },
    ),
    Section(
        "Sensitivity",
        "The parameters that matter most for the results.",
        "snakemake --cores 2 sensitivity",
        tables={
            "*/sensitivity/morris.csv": "Screening (Morris)",
            "*/sensitivity/tornado.csv": "One parameter at a time",
            "*/sensitivity/sobol.csv": "Shares of the variance (Sobol)",
            "*/sensitivity/cross_validation.csv": "Cross-validation: predictions for runs left out of the fit",
            "*/sensitivity/confirm.csv": "Points repeated at another fidelity",
        },
        figures={
            "*/sensitivity/figures/morris.png": Drawing("Morris", "Screening (Morris)."),
            "*/sensitivity/figures/tornado.png": Drawing("Tornado", "One parameter at a time."),
            "*/sensitivity/figures/sobol.png": Drawing("Sobol", "Shares of the variance (Sobol)."),
            "*/sensitivity/figures/cross_validation.png": Drawing(
                "Cross-validation", "Predicted and computed results of runs left out of the fit."
            ),
        },
    ),
    Section(
        "Back-analysis",
        "The parameter values that reproduce the observation.",
        "snakemake --cores 2 back_analysis",
        tables={
            "*/sensitivity/back_analysis.csv": "Values and intervals, with the results in words",
            "*/sensitivity/back_confirmed.csv": "Runs at the best point and at the ends of the intervals",
        },
        figures={
            "*/sensitivity/figures/back_analysis.png": Drawing(
                "Back-analysis", "The observation, the surrogate and the runs, against the parameters sought."
            )
        },
    ),
)
DOCS = {
    "Speed and accuracy": "docs/evidence/cost-accuracy.md",
    "Validation": "docs/evidence/validation.md",
    "Robustness": "docs/evidence/robustness.md",
    "Limits of the model": "docs/model/limits.md",
}
"""Pages of the documentation on the accuracy and the limits of the program in general."""
SPACING = Section(
    "Spacing",
    "Every run at a second spacing: what finer or coarser particles change.",
    "snakemake --cores 2",
    tables={SPACINGS: "Both spacings, and the value extrapolated to spacing 0"},
    variables=spacing_columns(),
    always=True,
)
"""Of a study with a second fidelity."""
DECIDING_TEXT = "The runs that decide in what shaking the slope fails, at a second spacing."
"""What it says where no others are repeated."""
SECTIONS = (FIGURES, PREFLIGHT, TRIGGER, MAPS, *OF_EVERY_STUDY)
"""The sections of a study of any dimensions, in their order on the page."""
FIRST_SCREEN = (FINDINGS, CRITICAL, SPACINGS, ANNUAL)
"""Files from which the page begins, where they exist."""


def existing(folder: Path | str, sections: Iterable[Section]) -> list[str]:
    """Files of the first screen and of all sections that exist, for the page of a folder ``results/<study>/<fidelity>``; sorted within each
    pattern."""
    folder = Path(folder)
    return [
        str(path)
        for pattern in dict.fromkeys(chain(FIRST_SCREEN, *((*section.tables, *section.figures) for section in sections)))
        for path in sorted(folder.parent.glob(pattern.format(fidelity=folder.name)))
        if not path.name.startswith(".")
    ]


def certain(folder: Path | str, sections: Iterable[Section], kinds: Sequence[str] = (".png",)) -> list[str]:
    """Files that every study makes, of sections with ``always``; figures as files of all ``kinds``."""
    folder, found = Path(folder), list[str]()
    for section in (section for section in sections if section.always):
        figures = [str(Path(pattern).with_suffix(kind)) for pattern in section.figures for kind in kinds]
        found += [str(folder.parent / pattern.format(fidelity=folder.name)) for pattern in (*section.tables, *figures)]
    return found


def of(patterns: Mapping[str, Held], files: Iterable[str], folder: Path | str) -> Iterator[tuple[str, Held]]:
    """Those of ``files`` that patterns match for the page of a folder, with what is held for them, in the order of the patterns."""
    study, fidelity = Path(folder).parent, Path(folder).name
    paths = {file: PurePath(file).relative_to(study) for file in files}
    for pattern, held in patterns.items():
        wanted = PurePath(pattern.format(fidelity=fidelity))
        yield from ((file, held) for file, path in paths.items() if len(path.parts) == len(wanted.parts) and path.match(str(wanted)))
