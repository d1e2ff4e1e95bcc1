"""The verification book: what is missed, then a page per reference case, as Markdown and PDF."""

from __future__ import annotations

import inspect
import math
import textwrap
from collections.abc import Iterable, Mapping, Sequence
from datetime import UTC, datetime
from pathlib import Path
from typing import Any, NamedTuple

import matplotlib
import matplotlib.image
import netCDF4
import pandas as pd
from matplotlib.backends.backend_pdf import PdfPages
from matplotlib.figure import Figure
from matplotlib.transforms import Bbox

from cases.case import COMPUTATION, Case
from sph.figures.profile import draw_circles, survey_axes
from sph.figures.style import DPI, STYLE
from sph.scene.schema import Scene
from sph.solver.particles import SOIL, place_particles
from sph.storage.files import whole
from sph.study.runs import SIMULATION
from sph.study.verdicts import MISSES

PAGE = (210 / 25.4, 297 / 25.4)
"""Width and height of a page, inches."""
HEAD = ("quantity", "computed", "reference", "error by resolution, coarse to fine", "tolerance", "verdict")


REFERENCES = {
    "published": "Published reference",
    "formula": "Published formula or method, our numbers in it",
    "own": "Our own closed form",
}
"""What is said of a case's ``reference``."""
MISSED_HEAD = ("case", "quantity", "computed", "reference", "error", "tolerance")


class Code(NamedTuple):
    """What made the runs of a case, and when."""

    version: str
    solver: str
    """digest of the solver"""
    date: str
    """day on which the last of the files was written, UTC"""

    def __str__(self) -> str:
        return f"sph {self.version}, solver {self.solver}, {self.date}"


class Cost(NamedTuple):
    """What the runs of a case at one resolution took."""

    level: str
    steps: int
    """time steps of all runs; 0 for a search, which does not keep them"""
    seconds: float


class Page(NamedTuple):
    """What the book says of a case."""

    name: str
    case: Case
    rows: pd.DataFrame
    """its rows of the suite's table"""
    costs: Sequence[Cost]
    code: Code | None
    """what made its runs; None for a case of functions alone"""
    scene: Scene | None
    """the scene of its first run at the coarsest resolution; None for a case of functions alone"""


def costs_of(levels: Sequence[str], paths: Sequence[Path | str]) -> list[Cost]:
    """Steps and seconds by resolution, from the files of the runs and the resolution of each."""
    found: dict[str, Cost] = {}
    for level, path in zip(levels, paths, strict=True):
        with netCDF4.Dataset(path) as data:
            particles = len(data.dimensions["particle"]) if "particle" in data.dimensions else 0
            steps = round(float(data.getncattr("particle_steps")) / particles) if particles and "particle_steps" in data.ncattrs() else 0
            seconds = float(data.getncattr("wall_time_s"))
        before = found.get(level, Cost(level, 0, 0.0))
        found[level] = Cost(level, before.steps + steps, before.seconds + seconds)
    return list(found.values())


def code_of(paths: Sequence[Path | str]) -> Code:
    """What made the files of some runs; more than one version or solver are named one after another."""
    versions, solvers, written = set(), set(), []
    for path in paths:
        with netCDF4.Dataset(path) as data:
            versions.add(str(getattr(data, "source", "sph unknown")).removeprefix("sph "))
            solvers.add(str(getattr(data, "solver_digest", "not recorded")))
        written.append(Path(path).stat().st_mtime)
    return Code(" and ".join(sorted(versions)), " and ".join(sorted(solvers)), datetime.fromtimestamp(max(written), UTC).date().isoformat())


def missed_rows(pages: Iterable[Page]) -> list[tuple[str, ...]]:
    """Cells under ``MISSED_HEAD`` of every quantity that is missed, the worst first, a run that diverged before all."""
    rows = [row for page in pages for row in page.rows.to_dict("records") if row["verdict"] == MISSES]
    rows.sort(
        key=lambda row: abs(row["error"]) / row["tolerance"] if row["tolerance"] and row["error"] == row["error"] else math.inf,
        reverse=True,
    )
    cells = [(str(row["case"]), *_cells(row)) for row in rows]
    return [
        (case, text, computed, reference, errors.split(", ")[-1], tolerance)
        for case, text, computed, reference, errors, tolerance, _ in cells
    ]


def _opening(pages: Sequence[Page]) -> list[str]:
    """What the first page says before its table."""
    made = sorted({str(page.code) for page in pages if page.code is not None})
    rows, missed = sum(len(page.rows) for page in pages), len(missed_rows(pages))
    held = sum(not (page.rows["verdict"] == MISSES).any() for page in pages)
    return [
        f"{rows - missed} of {rows} quantities are within their tolerance, in {held} of {len(pages)} cases all of them.",
        f"Made by {'; '.join(made) or 'functions alone'}.",
        "Missed:" if missed else "Nothing is missed.",
    ]


def _cells(row: Mapping[Any, Any]) -> tuple[str, ...]:
    """Cells of a quantity under ``HEAD``: errors and tolerance in per cent of the reference, or in units where that is 0."""
    unit, exact = "" if row["units"] == "1" else f" {row['units']}", row["reference"] == 0

    def share(value: float) -> str:
        return f"{value:.2g}" if exact else f"{100 * value:.2g} %"

    errors = ", ".join(share(float(error)) for error in row["errors"].split(", "))
    return (
        row["text"], f"{row['computed']:.4g}{unit}", f"{row['reference']:.4g}{unit}", errors, share(row["tolerance"]), row["verdict"],
    )  # fmt: skip


def _said(page: Page) -> list[str]:
    """Problem, source, resolutions, cost and verdict of a case, in sentences."""
    missed = int((page.rows["verdict"] == MISSES).sum())
    found = {SIMULATION: "runs of the scene", COMPUTATION: "functions of the solver alone"}
    by = found.get(page.case.by, f"a search for the {page.case.by.replace('_', ' ')}")
    took = "; ".join(f"{cost.level}: " + f"{cost.steps} steps, " * (cost.steps > 0) + f"{cost.seconds:.3g} s" for cost in page.costs)
    caption = " ".join((inspect.getdoc(page.case.draw) or "").split())
    return [
        f"{REFERENCES[page.case.reference]}: {page.case.source}.",
        f"Ours: {page.case.ours}.",
        f"Result by {by}. Resolutions: {page.rows['levels'].iloc[0]}.",
        f"Made by {page.code}." if page.code is not None else "Computed by functions alone when the book was made.",
        f"Cost on one core: {took or 'under a second'}.",
        f"Verdict: {missed} of {len(page.rows)} missed." if missed else "Verdict: holds.",
        f"Figure: {caption}",
    ]


def markdown_book(pages: Sequence[Page]) -> str:
    """The book in Markdown; pictures are those beside it, ``figures/<case>.png``."""
    lines = ["# Verification book", "", *(word for said in _opening(pages) for word in (said, ""))]
    if missed := missed_rows(pages):
        lines += [f"| {' | '.join(MISSED_HEAD)} |", "|" + " --- |" * len(MISSED_HEAD)]
        lines += ["| " + " | ".join(cell.replace("|", "\\|") for cell in cells) + " |" for cells in missed]
        lines.append("")
    for page in pages:
        lines += [f"## {page.name}: {page.case.title}", "", *(f"* {said}" for said in _said(page)), ""]
        lines += [f"![{page.name}](figures/{page.name}.png)", "", f"| {' | '.join(HEAD)} | why this tolerance |", "|" + " --- |" * 7]
        for row in page.rows.to_dict("records"):
            cells = [*_cells(row), row["reason"]]
            cells[5] = f"**{cells[5]}**" if row["verdict"] == MISSES else cells[5]
            lines.append("| " + " | ".join(cell.replace("|", "\\|") for cell in cells) + " |")
        lines.append("")
    return "\n".join(lines)


def draw_opening(pages: Sequence[Page]) -> Figure:
    """The first page: how many quantities hold, by which code, and all that is missed."""
    figure = Figure(figsize=PAGE)
    figure.text(0.08, 0.95, "Verification book", fontsize=15, weight="bold")
    words = "\n".join(textwrap.fill(said, 100) for said in _opening(pages))
    figure.text(0.08, 0.92, words, fontsize=9, va="top", linespacing=1.5)
    missed = missed_rows(pages)
    if missed:
        height = min(0.018 * (len(missed) + 1), 0.78)
        ax = figure.add_axes((0.06, 0.86 - 0.016 * words.count("\n") - height, 0.88, height))
        ax.set_axis_off()
        table = ax.table(
            [[cells[0], textwrap.shorten(cells[1], 75), *cells[2:]] for cells in missed],
            colLabels=MISSED_HEAD, colWidths=[0.07, 0.49, 0.11, 0.11, 0.11, 0.11], cellLoc="left", loc="center", bbox=Bbox.unit(),
            edges="horizontal",
        )  # fmt: skip
        table.auto_set_font_size(False)
        table.set_fontsize(6.5)
    return figure


def draw_page(page: Page, picture: Path | str) -> Figure:
    """A page of the book: words, the scene before its first step, the picture of the case, the table."""
    figure = Figure(figsize=PAGE)
    figure.text(0.08, 0.95, f"{page.name}  {page.case.title}", fontsize=13, weight="bold")
    words = "\n".join(textwrap.fill(said, 118) for said in _said(page))
    figure.text(0.08, 0.937, words, fontsize=7.5, va="top", linespacing=1.35)
    top = 0.925 - 0.0125 * (words.count("\n") + 1)
    if page.scene is not None:
        ax = figure.add_axes((0.12, top - 0.17, 0.80, 0.15))
        particles, spacing = place_particles(page.scene), page.scene.numerics.spacing
        for kind, colour, mask in (("soil", "0.75", particles.kind == SOIL), ("walls", "0.25", particles.kind != SOIL)):
            if mask.any():
                draw_circles(ax, particles.x[mask], particles.y[mask], spacing, facecolors=colour, edgecolors="none", label=kind)
        x, y = particles.x, particles.y
        survey_axes(ax, page.scene, (x.min() - spacing, x.max() + spacing, y.min() - spacing, y.max() + spacing))
        ax.set_title(f"Initial particles, spacing {spacing:g} m: soil light, walls dark", fontsize=7)
        top -= 0.22
    height = 0.0145 * (len(page.rows) + 1)
    image = matplotlib.image.imread(picture)
    share = min(0.84, (top - height - 0.09) * PAGE[1] / PAGE[0] * image.shape[1] / image.shape[0], image.shape[1] / DPI / PAGE[0])
    tall = share * PAGE[0] / PAGE[1] * image.shape[0] / image.shape[1]
    ax = figure.add_axes(((1 - share) / 2, top - tall, share, tall))
    ax.imshow(image)
    ax.set_axis_off()
    ax = figure.add_axes((0.06, top - tall - 0.025 - height, 0.88, height))
    ax.set_axis_off()
    table = ax.table(
        [[textwrap.shorten(cells[0], 70), *cells[1:]] for cells in map(_cells, page.rows.to_dict("records"))],
        colLabels=HEAD, colWidths=[0.38, 0.10, 0.10, 0.26, 0.08, 0.08], cellLoc="left", loc="center", bbox=Bbox.unit(), edges="horizontal",
    )  # fmt: skip
    table.auto_set_font_size(False)
    table.set_fontsize(6)
    for number, verdict in enumerate(page.rows["verdict"], 1):
        if verdict == MISSES:
            table[number, 5].get_text().set_fontweight("bold")
    return figure


def save_book(pages: Sequence[Page], pictures: Sequence[Path | str], path_to_markdown: Path | str, path_to_pdf: Path | str) -> None:
    """Write the book, whole or not at all; a picture per page."""
    with whole(path_to_markdown) as temporary:
        temporary.write_text(markdown_book(pages), encoding="utf-8")
    with (
        whole(path_to_pdf) as temporary,
        matplotlib.rc_context(STYLE),
        PdfPages(temporary, metadata={"Title": "Verification book", "CreationDate": None}) as book,
    ):
        book.savefig(draw_opening(pages))
        for page, picture in zip(pages, pictures, strict=True):
            book.savefig(draw_page(page, picture))
