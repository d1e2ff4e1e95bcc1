"""Builds the page: facts, sections and runs in ``page.html``, all in one file."""

from __future__ import annotations

import base64
import datetime
import io
import math
import os
import re
import zlib
from collections.abc import Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

import pandas as pd
from jinja2 import Environment, PackageLoader, StrictUndefined
from jinja2.utils import htmlsafe_json_dumps
from markupsafe import Markup, escape
from PIL import Image

from sph.checks.after_run import held, is_bounded
from sph.checks.equilibrium import found_equilibrium
from sph.experiments.variants.second_spacing import read_spacing
from sph.figures import caption as caption_of
from sph.figures.arrangement import failed_words
from sph.figures.before_after import NARROW, WIDE, figure_before_after
from sph.figures.style import DPI, NOTHING, WIDTH
from sph.measures.metrics import CLASSES, STABLE, MetricSettings, class_words
from sph.measures.places import PlaceAt
from sph.output.run import Run
from sph.page.answer import SPACINGS, answer, as_it_is, strongest
from sph.page.explorer import explorer
from sph.page.matrix import TO_COME, Matrix, matrix
from sph.page.second_spacing import differs, with_second_class
from sph.page.sections import DOCS, Drawing, Section, of
from sph.page.tables import MAX_VALUES, Code, Table, chosen_keys, client_table, csv_table, layer_table, run_columns, scene_table
from sph.scene.schema import Scene
from sph.scene.strict_json import finite, parse_json
from sph.scene.units import beside_g
from sph.storage.files import whole
from sph.storage.netcdf import read_attributes
from sph.storage.trajectory import Status
from sph.study.dimensions import CASE, Dimension, point_name, scene_key, title_of
from sph.study.tables import Layout, read_table
from sph.study.verdicts import AT_LEAST, CONSTRUCTED, FAILS, FITTED, HOLDS, MISSES, NOT_COVERED, NOT_YET

LARGEST = 10_000_000
"""Largest page, characters; the runs are kept in as much detail as fits."""
HIGH = 25 / 6
"""Inches of the height of the picture of the slope, as high as ``page.css`` shows it, so that its words are as large as they are drawn."""
REST = 1000
"""Characters of it left for what joins the runs to the rest."""
DATA = "@@data@@"
"""Place of the runs in the page."""
MARKS: dict[str, str] = {
    HOLDS: "good", FAILS: "bad", MISSES: "bad", Status.DIVERGED: "bad", NOT_YET: "open", AT_LEAST: "open", NOT_COVERED: "open",
    FITTED: "open", CONSTRUCTED: "open",
    NOTHING: "nothing",
}  # fmt: skip
"""Verdicts and empty cells that tables mark, by the style of the mark."""


class StudyFiles(NamedTuple):
    """A finished study: what it is called and where its files are."""

    name: str
    fidelity: str
    folder: str  # of its results
    table: str  # study.csv
    layout: Layout  # of the table
    dimensions: Sequence[Dimension]
    size: int  # number of its runs
    runs: Mapping[str, str]  # files of those that the page shows, by name: all but in a large study
    scenes: Mapping[str, Scene]  # of their files; one that is left out is that in the file
    stages: Sequence[tuple[str, str]]  # gravity stage and pre-failure run of each run shown, in the same order
    files: Sequence[str]  # of the sections
    sections: Sequence[Section]
    shown: Mapping[str, Sequence[str]] = {}  # runs from which a figure of the study was drawn, by its name
    metrics: MetricSettings = MetricSettings()
    client: bool = False  # the page is without keys, paths, commands and what has still to be made
    project: str = ""  # of a client's page
    author: str = ""
    assumed: Mapping[str, str] = {}  # what of the scene nobody has measured, by its key
    alternatives: Mapping[str, Mapping[str, Any]] = {}  # scene keys of each
    design: float | None = None  # amplitude that is answered first, m/s2; None: the largest
    missing: Mapping[str, Missing] = {}  # runs that are not done yet, and so not in the table, by name
    to_come: Sequence[str] = ()  # codes of the findings that are still searched
    renewed: int = 0  # seconds after which the page is to be read again, since it grows; 0: it is finished

    @property
    def probe(self) -> str:
        """The probe that is measured."""
        return self.metrics.probe

    @property
    def places(self) -> Mapping[str, PlaceAt]:
        """The places that debris may reach."""
        return self.metrics.places

    def read(self, path: Path | str) -> Run:
        """The run of a file."""
        return Run.read(path, self.scenes.get(str(path)))


class Missing(NamedTuple):
    """A run that is not done yet."""

    point: Mapping[str, str]  # values of its dimensions
    stand: str  # how it stands, in words


class Picture(NamedTuple):
    """A figure in the page."""

    name: str
    data: str  # URI
    width: int
    height: int
    caption: str
    source: str  # file
    runs: Sequence[str]  # from which it was drawn, where that is known
    narrow: Picture | None = None  # the same for a phone, where one is drawn
    said: str = ""  # of what it shows in this study

    @property
    def alt(self) -> str:
        """What it shows, in words."""
        return f"{self.name}: {self.caption}"


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
        """Whether its command has still to be run."""
        return not self.tables and not self.pictures


class Cost(NamedTuple):
    """What the runs cost: computing time of the solver on one core, diverged runs included."""

    seconds: float  # stages that runs share counted once; NaN where the page does not show all runs
    apart: float  # had every run been made from the start
    particle_steps_per_second: tuple[float, float]  # slowest and fastest run


def write_page(path: Path | str, study: StudyFiles) -> int:
    """Write the page of a study, whole or not at all; returns its size in bytes."""
    page = build_page(study).encode("utf-8")
    with whole(path) as temporary:
        temporary.write_bytes(page)
    return len(page)


def build_page(study: StudyFiles, largest: int = LARGEST) -> str:
    """HTML of the page of a study, at most ``largest`` characters unless tables and figures alone take more.

    Raises ValueError for a file that cannot be read and for a table whose rows are not the runs of the study.
    """
    whole_table, axes = read_table(study.table, study.layout), [found.name for found in study.dimensions]
    points = [dict(zip(axes, values, strict=True)) for values in whole_table[axes].itertuples(index=False, name=None)]
    whole_table.index = pd.Index(whole_table[CASE] if study.layout.named else [point_name(point) for point in points])

    def found(pattern: str) -> list[str]:
        return [file for file, _ in of({pattern: None}, study.files, study.folder)]

    again = next(map(read_spacing, found(SPACINGS)), None)
    whole_table = with_second_class(whole_table, again, axes)
    if len(whole_table) != study.size - len(study.missing) or not set(study.runs) <= set(whole_table.index):
        raise ValueError(f"{study.table}: its rows are not the {study.size} runs of the study; repeat the command that wrote it")
    table = whole_table[whole_table.index.isin(list(study.runs))]
    runs = [study.runs[name] for name in table.index]
    files = [Path(run).relative_to(study.folder).as_posix() for run in runs]
    known = table.to_dict("records")
    columns = [each for each in run_columns(study.dimensions, study.probe) if any(each.words(row) != NOTHING for row in known)]
    rows = [[column.words(row) for column in columns] for row in known]
    shown = list(table[axes].itertuples(index=False, name=None))
    titles = [title_of(study.dimensions, dict(zip(axes, values, strict=True))) for values in shown]
    # A grid of which every run is shown is chosen by its dimensions, anything else from a list of runs.
    listed = not study.layout.labels or len(table) < study.size
    keyed = list(table.index) if listed else list(map("|".join, shown))
    scene = study.read(runs[0]).scene
    varied = {scene_key(found.name): _values(whole_table[found.name], found.unit) for found in study.dimensions}
    keys = scene_table(scene, varied)
    over = [found.phrase for found in study.dimensions]

    first, cells = (
        farthest(table),
        matrix(_with_missing(whole_table, study), study.dimensions, study.probe, list(table.index), study.design),
    )
    page = template().render(
        study=study,
        scene=scene,
        scene_table=None if study.client else keys,
        today=datetime.date.today().isoformat() if study.client else "",
        key_table=client_table(keys) if study.client else chosen_keys(keys),
        layer_table=layer_table(scene, varied),
        answer=answer(
            whole_table,
            study.dimensions,
            scene,
            study.probe,
            found,
            study.client,
            len(study.missing),
            study.to_come,
            study.assumed,
            study.alternatives,
            again,
            study.design,
        ),
        overview=None
        if first is None
        else overview(study, first, titles[list(table.index).index(first)], cells, farthest_words(table, first)),
        missing=[f"{title_of(study.dimensions, each.point)}: {each.stand}" for each in study.missing.values()],
        matrix=cells,
        class_words=class_words(study.metrics, scene),
        opens={} if first is None else {"run": first, **table.loc[first, axes].to_dict()},
        classes={name: int((whole_table["collapse_class"] == name).sum()) for name in CLASSES},
        diverged=int(whole_table["diverged"].sum()),
        may_fail=int(((whole_table["collapse_class"] == STABLE) & held(whole_table)).sum()),
        over=over,
        axes=[]
        if listed
        else [
            (each, words, [(value, each.shown(value)) for value in _written(table[each.name])])
            for each, words in zip(study.dimensions, over, strict=True)
        ],
        listed=list(zip(keyed, titles, strict=True)) if listed else [],
        columns=[column.heading for column in columns],
        run_rows=list(zip(files, rows, table["status"].isin((Status.DIVERGED, Status.FAILED_UNSHAKEN)), strict=True)),
        docs={} if study.client else docs_links(study.folder),
        parts=[part for part in (found_part(section, study) for section in study.sections) if not (study.client and part.missing)],
        cost=cost_of(whole_table, study),
        versions=versions_of(runs),
    )
    facts: dict[str, dict[str, Any]] = {
        key: {"facts": row, "status": status, "file": file, "title": title}
        for key, row, status, file, title in zip(keyed, rows, table["status"], files, titles, strict=True)
    }
    as_csv = table[study.layout.names].to_csv(index=False, na_rep="NaN", lineterminator="\n")
    data: dict[str, Any] = {
        "columns": [column.heading for column in columns],
        "numbers": [column.heading for column in columns if column.result],
        "axes": ["run"] if listed else axes,
        "folder": study.folder,
        "client": study.client,
        "points": facts,
        "table": base64.b64encode(zlib.compress(as_csv.encode(), 9)).decode(),
    }
    data |= explorer(runs, study.probe, largest - len(page) - len(as_json(data)) - REST, study.places, study.read)
    if study.client:
        data["shares"] = {name: label.removesuffix(" r_u") for name, label in data["shares"].items() if name != "beta"}
    for point, run in zip(facts.values(), data.pop("runs"), strict=False):
        point["run"] = run
    before, _, after = page.rpartition(DATA)
    return before + as_json(data) + after


def _with_missing(table: pd.DataFrame, study: StudyFiles) -> pd.DataFrame:
    """The table with a row for each run to come, in the order of the values."""
    if not study.missing:
        return table
    to_come = pd.DataFrame([each.point for each in study.missing.values()], index=list(study.missing)).assign(collapse_class=TO_COME)
    order = {axis.name: labels.index for axis, labels in zip(study.layout.axes, study.layout.labels, strict=False)}
    return pd.concat([table, to_come]).sort_values(list(order), key=lambda values: values.map(order[str(values.name)]), kind="stable")


def as_json(data: Any) -> str:
    """Data for a script element: JSON in which no character can end the element."""
    return str(htmlsafe_json_dumps(finite(data), ensure_ascii=False, separators=(",", ":"), allow_nan=False))


def found_part(section: Section, study: StudyFiles) -> Part:
    """A section with the tables and figures of the study that belong to it."""
    aside = (*section.aside, *section.keys) if study.client else section.aside
    tables = [csv_table(file, caption, section.variables, aside) for file, caption in of(section.tables, study.files, study.folder)]
    pictures = []
    shown = {f"{study.folder}/figures/{name}.png": runs for name, runs in study.shown.items()}
    for file, drawing in of(section.figures, study.files, study.folder):
        runs = [Path(run).relative_to(study.folder).as_posix() for run in shown.get(file, ())]
        pictures.append(picture(file, drawing, runs))
    return Part(section, tables, pictures)


def farthest(table: pd.DataFrame) -> str | None:
    """The run of those shown that goes farthest, of the scene as it is where there are alternatives; None where all diverged.

    Those of which the spacing decides if they stand are left out where there are others.  Of runs whose debris reached an end of the box,
    which is as far as it can go, it is that of the strongest shaking.
    """
    sound = as_it_is(table[table["diverged"] == 0])
    if sound.empty:
        return None
    if not (unsure := differs(sound)).all():
        sound = sound[~unsure]
    met = sound["reached_side"].map(is_bounded)
    if met.any():
        sound = strongest(sound[met])
    return str(sound.fillna({"runout": 0.0}).sort_values(["runout", "displacement_magnitude"], kind="stable").index[-1])


def farthest_words(table: pd.DataFrame, first: str) -> str:
    """What the run is that ``farthest`` chose."""
    own = as_it_is(table[table["diverged"] == 0])
    others = own.loc[~differs(own), "runout"]
    return f"The run that goes farthest{' in the strongest shaking' * bool(others.max() > table['runout'][first])}."


def overview(study: StudyFiles, name: str, title: str, beside: Matrix | None, chosen: str) -> Picture:
    """The slope before and after a run, which was ``chosen`` so, ``beside`` the matrix of all runs, and the same for a phone."""
    run = study.read(study.runs[name])
    equilibrium = found_equilibrium(run.scene)
    failed = failed_words(run)
    drawing = Drawing("Before and after", caption_of(figure_before_after))
    said = chosen + f" {failed}" * bool(failed)
    pictures = []
    for width in (NARROW, WIDTH if beside is not None and beside.wide else WIDE):
        drawn, draw = io.BytesIO(), partial(figure_before_after, run, title, study.places, equilibrium)
        figure = draw(width)
        if width > NARROW and figure.get_figheight() > HIGH:
            figure = draw(max(NARROW, width * HIGH / figure.get_figheight()))
        figure.savefig(drawn, format="png", dpi=DPI)
        pictures.append(picture(study.runs[name], drawing, drawn=drawn)._replace(said=said))
    narrow, wide = pictures
    return wide._replace(narrow=narrow)


def picture(path: str, drawing: Drawing, runs: Sequence[str] = (), drawn: io.BytesIO | None = None) -> Picture:
    """The PNG of a path, or one ``drawn`` here from it, for the page: in 256 colours, which takes a third of the space; ValueError names a
    file that is not one."""
    try:
        with Image.open(drawn or path) as image:
            small = io.BytesIO()
            image.convert("RGB").quantize(256, dither=Image.Dither.NONE).save(small, "PNG")
            width, height = image.size
    except (OSError, ValueError) as error:
        raise ValueError(f"{path}: cannot be read as a picture: {error}; delete it and repeat the command that wrote it") from error
    data = "data:image/png;base64," + base64.b64encode(small.getvalue()).decode()
    return Picture(drawing.name, data, width, height, drawing.caption, path, runs)


def cost_of(table: pd.DataFrame, study: StudyFiles) -> Cost:
    """Cost of the runs of a study's table.

    The computing time of a run includes that of its pre-failure run, which includes that of the gravity stage.
    """
    apart, speeds = math.fsum(table["wall_time"]), table["particle_steps_per_second"]
    shared = math.nan
    if len(study.runs) == study.size:
        gravities = {gravity: _seconds(gravity) for gravity in {gravity for gravity, _ in study.stages}}
        pre_failures = {file: (_seconds(file), gravities[gravity]) for gravity, file in {*study.stages}}
        own = apart - math.fsum(pre_failures[file][0] for _, file in study.stages)
        shared = own + math.fsum(gravities.values()) + math.fsum(seconds - gravity for seconds, gravity in pre_failures.values())
    return Cost(shared, apart, (float(speeds.min()), float(speeds.max())))


def _written(values: pd.Series[str]) -> list[str]:
    return list(dict.fromkeys(values))


def _values(values: pd.Series[str], unit: str) -> str:
    """Values of a dimension of a unit in a cell."""
    written = [beside_g(value, unit) for value in _written(values)]
    return ", ".join(written) if len(written) <= MAX_VALUES else f"{len(written)} values, {written[0]} to {written[-1]}"


def _seconds(path: str) -> float:
    return float(attributes(path)["wall_time_s"])


def versions_of(paths: Sequence[str]) -> dict[str, list[str]]:
    """Number of runs by what they were made with: program, versions of packages, machine."""
    found: dict[str, list[str]] = {}
    for path in paths:
        attrs = attributes(path)
        packages = ", ".join(f"{package} {version}" for package, version in parse_json(attrs["versions"]).items())
        found.setdefault(f"{packages}; {attrs['machine']}", []).append(path)
    return found


def docs_links(folder: str) -> dict[str, str]:
    """Pages of ``DOCS`` as links from the page of a folder, by title; without those that the program's folder lacks."""
    root = Path(__file__).parents[2]
    return {title: os.path.relpath(root / file, folder) for title, file in DOCS.items() if (root / file).is_file()}


def attributes(path: str) -> dict[str, Any]:
    """Attributes of a trajectory, its arrays left alone; ValueError names a file that is not one."""
    try:
        return read_attributes(path)
    except Exception as error:  # as in sph.storage.trajectory
        raise ValueError(f"{path}: cannot be read as a trajectory: {error}; delete it and repeat the command that wrote it") from error


def inline(text: str) -> Markup:
    """Text with ``**strong**`` and ```code``` as in the README, everything else as it is; also a cell that is a name as a whole."""
    if isinstance(text, Code):
        return Markup("<code>{}</code>").format(str(text))
    safe = re.sub(r"\*\*(.+?)\*\*", r"<strong>\1</strong>", str(escape(text)))
    return Markup(re.sub(r"`(.+?)`", r"<code>\1</code>", safe))


def template() -> Any:
    """The page's template, whatever it is given escaped."""
    environment = Environment(loader=PackageLoader("sph.page", "."), autoescape=True, undefined=StrictUndefined, trim_blocks=True)
    environment.filters["inline"] = inline
    environment.filters["mark"] = lambda cell: MARKS.get(cell, "")
    environment.globals["data"] = DATA
    environment.globals["part_of_package"] = lambda file: Markup((Path(__file__).with_name(file)).read_text(encoding="utf-8"))
    return environment.get_template("page.html")
