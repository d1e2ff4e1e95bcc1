"""What the page shows besides the runs: sections of tables and figures, found at paths below the results of a study.

A section whose files do not exist names the command that makes them.  To add one, add a row to ``SECTIONS``.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path, PurePath
from typing import NamedTuple

from sph.analysis.figures import FIGURES, caption


class Section(NamedTuple):
    """A part of the page; patterns are those of ``Path.glob`` without ``**``, relative to the folder of the results, captions in words."""

    title: str
    text: str
    command: str  # makes its files
    tables: Mapping[str, str] = {}  # caption by pattern of CSV files
    figures: Mapping[str, str] = {}  # caption by pattern of PNG files
    measured: Mapping[str, str] = {}  # caption by name in sph.command.reference.TABLES: what the release holds
    always: bool = False  # made with every study


SECTIONS: tuple[Section, ...] = (
    Section(
        "The paper's claims",
        "Each claim is turned into a test on numbers; a claim that fails is shown as such.",
        "snakemake --cores 2",
        tables={"claims.csv": "Claim, test, what was measured, verdict"},
        always=True,
    ),
    Section(
        "Figures",
        "Figures 1 to 7 of the paper as this study gives them. The note in each says from which scene and resolution it comes.",
        "snakemake --cores 2",
        figures={f"figures/fig{number}.png": caption(draw) for number, draw in FIGURES.items()},
        always=True,
    ),
    Section(
        "Trigger",
        "The smallest amplitude of shaking at which the slope fails.",
        "snakemake --cores 2 trigger",
        tables={"trigger/*.csv": "Amplitude that triggers failure"},
        figures={f"{folder}/*.png": "Amplitude that triggers failure" for folder in ("trigger", "trigger/figures")},
    ),
    Section(
        "Maps",
        "Where the slope moves over the plane of strength ratio and amplitude.",
        "snakemake --cores 2 maps",
        tables={"maps/*.csv": "Displacement over the plane"},
        figures={f"{folder}/*.png": "Displacement over the plane" for folder in ("maps", "maps/figures")},
    ),
    Section(
        "Sensitivity",
        "Which parameters the answers depend on most.",
        "snakemake --cores 2 sensitivity",
        tables={"sensitivity/*.csv": "Sensitivity"},
        figures={f"{folder}/*.png": "Sensitivity" for folder in ("sensitivity", "sensitivity/figures")},
    ),
    Section(
        "Speed and accuracy",
        "Displacement and run-out depend on the particle spacing and do not converge with it: read the errors against the finest run as "
        "the least that a fidelity leaves open. Measured for this release on the paper's slope.",
        "snakemake --cores 2 trade",
        measured={"presets": "The fidelities against the finest run of the ladder", "trade": "Every rung of the ladder"},
    ),
    Section(
        "Validation",
        "Problems with known answers, run with the same solver. Tolerances were written before the runs; what is missed stays in the "
        "table. Measured for this release.",
        "snakemake --cores 2 validation",
        measured={"validation": "Every quantity beside its reference"},
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


def existing(folder: Path | str, sections: Iterable[Section] = SECTIONS) -> list[str]:
    """Files of all sections that exist below a folder of results, sorted within each pattern."""
    return [
        str(path)
        for section in sections
        for pattern in (*section.tables, *section.figures)
        for path in sorted(Path(folder).glob(pattern))
        if not path.name.startswith(".")
    ]


def certain(folder: Path | str, sections: Iterable[Section] = SECTIONS) -> list[str]:
    """Files that every study makes, of sections with ``always``."""
    return [f"{folder}/{path}" for section in sections if section.always for path in (*section.tables, *section.figures)]


def of(patterns: Mapping[str, str], files: Iterable[str], folder: Path | str) -> Iterator[tuple[str, str]]:
    """Those of ``files`` that patterns below a folder match, each once, with its caption."""
    left = {file: PurePath(file).relative_to(folder) for file in files}
    for pattern, words in patterns.items():
        for file in [file for file, path in left.items() if matches(path, pattern)]:
            del left[file]
            yield file, words


def matches(path: PurePath, pattern: str) -> bool:
    """Whether a relative path is one that ``Path.glob(pattern)`` finds, of a pattern without ``**``."""
    return len(path.parts) == len(PurePath(pattern).parts) and path.match(pattern)
