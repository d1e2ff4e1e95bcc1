"""The page put together: facts, sections and runs in ``page.html``, everything inside one file."""

from __future__ import annotations

import base64
import io
import json
import math
import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import pandas as pd
import xarray as xr
from jinja2 import Environment, PackageLoader, StrictUndefined
from jinja2.utils import htmlsafe_json_dumps
from markupsafe import Markup, escape
from PIL import Image

from sph import trajectory
from sph.analysis.advice import expected_sentence
from sph.analysis.metrics import CLASSES, GRID
from sph.analysis.study import GRID_KEYS
from sph.analysis.tables import read_table
from sph.files import whole
from sph.page.explorer import explorer
from sph.page.sections import SECTIONS, Section, of
from sph.page.tables import Table, chosen_keys, csv_table, reference_table, run_columns, scene_table
from sph.trajectory import scene_of

LARGEST = 10_000_000
"""Largest page, characters; the runs are kept in as much detail as fits."""
REST = 1000
"""Characters of it left for what joins the runs to the rest."""
DATA = "@@data@@"
"""Place of the runs in the page."""
MARKS = {"holds": "good", "fails": "bad", "misses": "bad", "diverged": "bad", "not yet": "open", "not covered": "open"}
"""Verdicts that tables mark, by the style of the mark."""


class StudyFiles(NamedTuple):
    """A finished study: what it is called and where its files are."""

    name: str
    fidelity: str
    folder: str  # of its results
    table: str  # study.csv
    points: Sequence[Mapping[str, str]]  # grid point of every run, as written
    runs: Sequence[str]  # in the order of the points
    gravity: str  # the stage that all runs share
    trunks: Mapping[str, str]  # the stages that the runs of an amplitude share
    files: Sequence[str]  # of the sections
    shown: Mapping[str, Sequence[str]] = {}  # runs from which a figure was drawn, by the stem of its file
    probe: str = "A"


class Picture(NamedTuple):
    """A figure in the page."""

    name: str
    data: str  # URI
    width: int
    height: int
    caption: str
    source: str  # file
    runs: Sequence[str]  # from which it was drawn, where that is known

    @property
    def alt(self) -> str:
        """What it shows, in short: its caption up to the first stop."""
        return f"{self.name}: {re.split('[,;.:]', self.caption)[0]}"


class Part(NamedTuple):
    """A section with what was found of it."""

    section: Section
    tables: Sequence[Table]
    pictures: Sequence[Picture]

    @property
    def id(self) -> str:
        """Anchor on the page."""
        return re.sub(r"\W+", "-", self.section.title.lower())

    @property
    def missing(self) -> bool:
        """Its command has not been run."""
        return not self.tables and not self.pictures


class Cost(NamedTuple):
    """What the runs cost: computing time of the solver on one core, diverged runs included."""

    seconds: float  # stages that runs share counted once
    apart: float  # had every run been made from the start
    particle_steps_per_second: tuple[float, float]  # slowest and fastest run


def write_page(path: Path | str, study: StudyFiles) -> int:
    """Write the page of a study, whole or not at all; returns its size in bytes."""
    page = build_page(study).encode("utf-8")
    with whole(path) as temporary:
        temporary.write_bytes(page)
    return len(page)


def build_page(study: StudyFiles, sections: Sequence[Section] = SECTIONS, largest: int = LARGEST) -> str:
    """HTML of the page of a study, at most ``largest`` characters unless tables and figures alone take more.

    Raises ValueError for a file that cannot be read and for a table whose rows are not the points of the study.
    """
    table = read_table(study.table)
    run_at = {tuple(point[name] for name in GRID): run for point, run in zip(study.points, study.runs, strict=True)}
    points = list(table[list(GRID)].itertuples(index=False, name=None))
    if set(points) != set(run_at):
        raise ValueError(f"{study.table}: its rows are not the {len(run_at)} runs of the study; run again what wrote it")
    runs = [run_at[point] for point in points]
    files = [Path(run).relative_to(study.folder).as_posix() for run in runs]
    columns = run_columns(study.probe)
    rows = [[text(row) for text in columns.values()] for row in table.to_dict("records")]
    scene = scene_of(trajectory.read_run(runs[0]))
    keys = scene_table(scene, {key: ", ".join(dict.fromkeys(table[column])) for column, key in GRID_KEYS.items()})
    page = template().render(
        study=study,
        scene=scene,
        scene_table=keys,
        key_table=chosen_keys(keys),
        classes={name: int((table["collapse_class"] == name).sum()) for name in CLASSES},
        diverged=int(table["diverged"].sum()),
        axes={column: list(dict.fromkeys(table[column])) for column in GRID},
        columns=list(columns),
        run_rows=list(zip(files, rows, table["diverged"], strict=True)),
        expected=expected_sentence(scene),
        parts=[found_part(section, study) for section in sections],
        cost=cost_of(table, study),
        versions=versions_of(runs),
    )
    facts: dict[str, dict[str, Any]] = {
        "|".join(point): {"facts": row, "file": file} for point, row, file in zip(points, rows, files, strict=True)
    }
    data: dict[str, Any] = {"columns": list(columns), "folder": study.folder, "points": facts}
    data |= explorer(runs, study.probe, largest - len(page) - len(as_json(data)) - REST)
    for point, run in zip(facts.values(), data.pop("runs"), strict=False):
        point["run"] = run
    before, _, after = page.rpartition(DATA)
    return before + as_json(data) + after


def as_json(data: Any) -> str:
    """Data for a script element: JSON in which no character can end the element."""
    return str(htmlsafe_json_dumps(data, ensure_ascii=False, separators=(",", ":"), allow_nan=False))


def found_part(section: Section, study: StudyFiles) -> Part:
    """A section with those of the study's files that are its own."""
    tables = [csv_table(file, caption, section.variables) for file, caption in of(section.tables, study.files, study.folder)]
    tables += [table for name, caption in section.measured.items() if (table := reference_table(name, caption)).rows]
    pictures = []
    for file, caption in of(section.figures, study.files, study.folder):
        runs = [Path(run).relative_to(study.folder).as_posix() for run in study.shown.get(Path(file).stem, ())]
        pictures.append(picture(file, caption, runs))
    return Part(section, tables, pictures)


def picture(path: str, caption: str, runs: Sequence[str] = ()) -> Picture:
    """A PNG for the page, in 256 colours, which takes a third of the room; ValueError names a file that is none."""
    try:
        with Image.open(path) as image:
            small = io.BytesIO()
            image.convert("RGB").quantize(256, dither=Image.Dither.NONE).save(small, "PNG", optimize=True)
            width, height = image.size
    except (OSError, ValueError) as error:
        raise ValueError(f"{path}: cannot be read as a picture: {error}; delete it and run again what wrote it") from error
    data = "data:image/png;base64," + base64.b64encode(small.getvalue()).decode()
    return Picture(words(Path(path).stem), data, width, height, caption, path, runs)


def words(stem: str) -> str:
    """A file's stem in words: fig4 is Figure 4."""
    number = re.fullmatch(r"fig(\d+)", stem)
    return f"Figure {number[1]}" if number else re.sub("[_-]", " ", stem).capitalize()


def cost_of(table: pd.DataFrame, study: StudyFiles) -> Cost:
    """Cost of the runs of a study's table; a run's computing time holds that of its trunk, a trunk's that of the gravity stage."""
    gravity = _seconds(study.gravity)
    trunks = {amplitude: _seconds(path) for amplitude, path in study.trunks.items()}
    apart = math.fsum(table["wall_time"])
    own = math.fsum(table["wall_time"] - table["amplitude"].map(trunks))
    shared = gravity + math.fsum(seconds - gravity for seconds in trunks.values())
    speeds = table["particle_steps_per_second"]
    return Cost(own + shared, apart, (float(speeds.min()), float(speeds.max())))


def _seconds(path: str) -> float:
    return float(attributes(path)["wall_time_s"])


def versions_of(paths: Sequence[str]) -> dict[str, list[str]]:
    """Number of runs by what they were made with: program, versions of packages, machine."""
    found: dict[str, list[str]] = {}
    for path in paths:
        attrs = attributes(path)
        packages = ", ".join(f"{package} {version}" for package, version in json.loads(attrs["versions"]).items())
        found.setdefault(f"{packages}; {attrs['machine']}", []).append(path)
    return found


def attributes(path: str) -> dict[str, Any]:
    """Attributes of a trajectory, its arrays left alone; ValueError names a file that is none."""
    try:
        with xr.open_dataset(path, engine="netcdf4") as run:
            return {str(name): value for name, value in run.attrs.items()}
    except Exception as error:  # as in sph.trajectory
        raise ValueError(f"{path}: cannot be read as a trajectory: {error}; delete it and run again what wrote it") from error


def inline(text: str) -> Markup:
    """Text with ``**strong**`` and ```code``` as in the README, everything else as it is."""
    safe = re.sub(r"\*\*(.+?)\*\*", r"<strong>\1</strong>", str(escape(text)))
    return Markup(re.sub(r"`(.+?)`", r"<code>\1</code>", safe))


def template() -> Any:
    """The page's template, whatever it is given escaped."""
    environment = Environment(loader=PackageLoader("sph.page", "."), autoescape=True, undefined=StrictUndefined, trim_blocks=True)
    environment.filters["inline"] = inline
    environment.filters["mark"] = lambda cell: MARKS.get(cell.strip("*"), "")
    environment.globals["data"] = DATA
    environment.globals["part_of_package"] = lambda file: Markup((Path(__file__).with_name(file)).read_text(encoding="utf-8"))
    return environment.get_template("page.html")
