"""What the page shows besides the runs: sections of tables and figures, found at paths below ``results/<study>``.

A section whose files do not exist names the command that makes them.  To add one, add a row to ``SECTIONS``.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path, PurePath
from typing import NamedTuple, TypeVar

from sph.figures import FIGURES, STUDY_FIGURES, figure_profiles
from sph.figures import caption as caption_of
from sph.figures.trigger import MAPPED
from sph.storage.trajectory import Variable

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
    measured: Mapping[str, str] = {}  # caption by name in sph.command.reference.TABLES: what the release holds
    always: bool = False  # made with every study
    of_the_paper: bool | None = None  # only for studies over the paper's dimensions, or only for others; None: for all


MAP = "Map over strength ratio and amplitude."


def numbered(number: int) -> Drawing:
    """One of the paper's figures."""
    return Drawing(f"Figure {number}", caption_of(FIGURES[number]))


SECTIONS: tuple[Section, ...] = (
    Section(
        "The paper's claims",
        "Each claim is turned into a test on numbers; a claim that fails is shown as such.",
        "snakemake --cores 2",
        tables={"{fidelity}/claims.csv": "Claim, test, what was measured, verdict"},
        always=True,
        of_the_paper=True,
    ),
    Section(
        "Figures",
        "Figures 1 to 7 of the paper as this study gives them. The note in each says from which scene and resolution it comes.",
        "snakemake --cores 2",
        figures={f"{{fidelity}}/figures/fig{number}.png": numbered(number) for number in FIGURES},
        always=True,
        of_the_paper=True,
    ),
    Section(
        "Figures",
        "What this study finds, and what went in. The note in each figure says from which scene and resolution it comes.",
        "snakemake --cores 2",
        figures={
            **{f"{{fidelity}}/figures/{name}.png": Drawing(name.capitalize(), caption_of(draw)) for name, draw in STUDY_FIGURES.items()},
            "{fidelity}/figures/profiles.png": Drawing("Profiles", caption_of(figure_profiles)),
            **{f"{{fidelity}}/figures/fig{number}.png": numbered(number) for number in (1, 2, 3)},
        },
        always=True,
        of_the_paper=False,
    ),
    Section(
        "Trigger",
        "The amplitude of shaking at which the slope begins to fail, bracketed by a run that stands and one that fails.",
        "snakemake --cores 2 trigger",
        tables={
            "*/trigger/claim.csv": "What the search says of the paper's claim",
            "*/trigger/trigger.csv": "Critical amplitudes",
            "*/trigger/confirm.csv": "The ends of brackets at another fidelity",
        },
        figures={"*/trigger/figures/trigger.png": Drawing("Trigger", "Critical amplitude of shaking against strength ratio.")},
        of_the_paper=True,
    ),
    Section(
        "Maps",
        "Displacement and class over strength ratio, rate of the loss of strength and amplitude.",
        "snakemake --cores 2 maps",
        tables={"*/trigger/shares.csv": "Shares of strength ratio and rate that reach each class"},
        figures={
            "*/trigger/figures/shares.png": Drawing("Shares", "Shares of strength ratio and rate that reach each class."),
            "*/trigger/figures/map-class.png": Drawing("Map of the class", MAP),
            **{f"*/trigger/figures/map-{name}.png": Drawing(f"Map of the {name}", MAP) for name in MAPPED},
        },
        of_the_paper=True,
    ),
    Section(
        "Sensitivity",
        "Which parameters decide the answers.",
        "snakemake --cores 2 sensitivity",
        tables={
            "*/sensitivity/morris.csv": "Screening (Morris)",
            "*/sensitivity/tornado.csv": "One parameter at a time",
            "*/sensitivity/sobol.csv": "Shares of the variance (Sobol)",
            "*/sensitivity/cross_validation.csv": "How well the model of the answers predicts runs that it has not seen",
            "*/sensitivity/confirm.csv": "Points run again at another fidelity",
        },
        figures={
            "*/sensitivity/figures/morris.png": Drawing("Morris", "Screening (Morris)."),
            "*/sensitivity/figures/tornado.png": Drawing("Tornado", "One parameter at a time."),
            "*/sensitivity/figures/sobol.png": Drawing("Sobol", "Shares of the variance (Sobol)."),
            "*/sensitivity/figures/cross_validation.png": Drawing("Cross-validation", "Predicted and computed answers of runs left out."),
        },
    ),
    Section(
        "Speed and accuracy",
        "Displacement and run-out depend on the particle spacing and do not converge with it: read the errors against the finest run as "
        "the least that a fidelity leaves open. Measured for this release on the paper's slope.",
        "snakemake --cores 2 trade",
        measured={"presets": "The fidelities against the finest run", "trade": "Every variant"},
    ),
    Section(
        "Validation",
        "Problems with known answers, run with the same solver. Tolerances were written before the runs; what is missed stays in the "
        "table. Measured for this release.",
        "snakemake --cores 2 validation",
        measured={"validation": "Every quantity beside its reference"},
    ),
    Section(
        "Robustness",
        "One key at a time at the ends of its range, in a slope that collapses and in one that moves by metres; fixed time steps around "
        "the limit that theory gives. Measured for this release.",
        "snakemake --cores 2 extremes",
        measured={"extremes": "Every sweep, with the worst of its sound runs", "time_steps": "Time steps"},
    ),
    Section(
        "Limits",
        "The model is two-dimensional, has no pore pressure, no dilation and no length scale: soil that softens fails in bands as thin "
        "as the kernel, so displacement and run-out depend on the resolution. The box is rigid and reflects waves; near the threshold its "
        "fixed walls decide. The table says what one choice changed alone does to the answers (in brackets, against the scene as it is).",
        "snakemake --cores 2 limits",
        measured={"limits": "One choice changed at a time"},
    ),
)
"""The sections in their order on the page."""


def sections_of(of_the_paper: bool) -> list[Section]:
    """The sections of a study over the paper's dimensions, or over others."""
    return [section for section in SECTIONS if section.of_the_paper in (None, of_the_paper)]


def existing(folder: Path | str, sections: Iterable[Section] = SECTIONS) -> list[str]:
    """Files of all sections that exist, for the page of a folder ``results/<study>/<fidelity>``; sorted within each pattern."""
    folder = Path(folder)
    return [
        str(path)
        for section in sections
        for pattern in (*section.tables, *section.figures)
        for path in sorted(folder.parent.glob(pattern.format(fidelity=folder.name)))
        if not path.name.startswith(".")
    ]


def certain(folder: Path | str, sections: Iterable[Section] = SECTIONS) -> list[str]:
    """Files that every study makes, of sections with ``always``."""
    folder = Path(folder)
    patterns = [pattern for section in sections if section.always for pattern in (*section.tables, *section.figures)]
    return [str(folder.parent / pattern.format(fidelity=folder.name)) for pattern in patterns]


def of(patterns: Mapping[str, Held], files: Iterable[str], folder: Path | str) -> Iterator[tuple[str, Held]]:
    """Those of ``files`` that patterns match for the page of a folder, with what is held for them, in the order of the patterns."""
    study, fidelity = Path(folder).parent, Path(folder).name
    paths = {file: PurePath(file).relative_to(study) for file in files}
    for pattern, held in patterns.items():
        wanted = PurePath(pattern.format(fidelity=fidelity))
        yield from ((file, held) for file, path in paths.items() if len(path.parts) == len(wanted.parts) and path.match(str(wanted)))
