"""Where a number of a table comes from (``sph explain``): its run, what that was made from and by, and whether that is what is planned now.

A table names the runs of a row, by its dimensions or by a column; the place of a run's file names its scene in the configuration.  A row
*agrees* if every run holds the scene that the configuration and the files on disk give now, was made by the solver that is installed, and
gives the row's numbers when it is measured again.  What rests on many runs together (claims, indices, brackets) is traced by the table of
its runs.

``snakemake --summary`` says what would be made again.  It knows neither rows nor columns, and takes for current an edited table, and the
file of one run copied over that of another.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import pandas as pd

from sph.checks.messages import search_words
from sph.command.study import find_study
from sph.experiments.registry import EXPERIMENTS
from sph.experiments.sensitivity.design import FOLDER as SENSITIVITY_FOLDER
from sph.experiments.sensitivity.tables import sample_columns
from sph.experiments.study_row import measured, run_values
from sph.experiments.trigger.design import FOLDER as TRIGGER_FOLDER
from sph.experiments.trigger.points import point_columns
from sph.jobs.catalogue import ALONE, Catalogue
from sph.jobs.exit_codes import DIFFERS
from sph.measures.metrics import measure
from sph.output.run import Run
from sph.scene.configuration import CONTENT_KEYS
from sph.scene.names import check_known
from sph.scene.strict_json import to_json
from sph.solver.compiled.jit import solver_digest
from sph.storage import trajectory
from sph.storage.trajectory import Variable
from sph.study.dimensions import is_number, point_name, value_of
from sph.study.plan import Plan
from sph.study.planned import differing
from sph.study.tables import read_csv


class Content(NamedTuple):
    """What a run's scene took from a file."""

    section: str
    file: str
    digest: str


class Origin(NamedTuple):
    """A run behind a number."""

    file: str
    scene_digest: str
    contents: list[Content]
    solver_digest: str
    versions: str
    status: str
    differs: list[str]  # from what is planned now; empty where it agrees


class Number(NamedTuple):
    """A column of a row."""

    column: str
    value: str  # as in the table
    unit: str
    definition: str
    again: str | None  # measured again; None for what is not measured from these runs alone
    agrees: bool


class Row(NamedTuple):
    """A row of a table and where it comes from."""

    point: dict[str, str]  # what tells it from the other rows
    origins: list[Origin]
    numbers: list[Number]

    @property
    def differs(self) -> list[str]:
        """What differs from what is planned now, a line each."""
        found = [f"{origin.file}: {line}" for origin in self.origins for line in origin.differs]
        return found + [f"{n.column}: {n.value} in the table, {n.again} measured now" for n in self.numbers if not n.agrees]


class Table(NamedTuple):
    """How the rows of a table are traced."""

    columns: Sequence[Variable]
    named: Sequence[str]  # columns that tell rows apart
    files: Callable[[Mapping[str, str]], list[str]]  # files of a row's runs
    values: Callable[[list[Run]], Mapping[str, Any]]  # columns measured from these runs


def explain(file: Path, conditions: Mapping[str, str], column: str | None, configfile: Path | None, as_json: bool) -> tuple[str, int]:
    """Rows in words or for machines, and the exit code, whether one is not as planned; of numbers the ``column`` alone where one is named.

    The file is a table or a run among results, or the configuration of a study, whose table is meant.
    """
    rows, plan = traced(file, conditions, configfile)
    known = [number.column for number in rows[0].numbers]
    if column is not None and not known:
        raise ValueError(f"--column {column!r}: must be left out for the file of a run")
    check_known("--column", [column], known)
    text = to_json(record(rows, plan), indent=1) if as_json else "\n".join(lines(rows, plan, column))
    return text, DIFFERS if any(row.differs for row in rows) else 0


def traced(file: Path, conditions: Mapping[str, str], configfile: Path | None = None) -> tuple[list[Row], Plan]:
    """The rows of a table that meet the conditions, or one row without numbers for a run's file, and the study they belong to.

    ValueError names a file that cannot be traced, an unknown column, or conditions that no row meets.
    """
    if file.suffix in (".yaml", ".yml"):
        catalogue = find_study(file, configfile)
        relative = f"{catalogue.plan.folder}/study.csv"
        file = Path(relative)
    else:
        relative, results = located(file)
        catalogue = find_study(results, configfile)
    if not file.is_file():
        raise ValueError(f"{file}: there is no such file")
    if file.suffix == ".nc":
        return [Row({}, [origin(catalogue, relative)[0]], [])], catalogue.plan
    table = table_of(catalogue, relative)
    frame = read_csv(file, table.columns, file.name)
    written = pd.read_csv(file, dtype=str, keep_default_na=False)[list(frame.columns)]
    for name in conditions:
        if name not in (columns := [column.name for column in table.columns]):
            raise ValueError(f"{file}: has no column {name!r}; it has {', '.join(columns)}")
    rows = [
        {str(name): cell for name, cell in row.items()}
        for row in written.to_dict("records")
        if all(_is(row[name], value) for name, value in conditions.items())
    ]
    if not rows:
        at = ", ".join(f"{name}={value}" for name, value in conditions.items())
        raise ValueError(f"{file}: has no row with {at}; it has {len(written)} rows, identified by {', '.join(table.named)}")
    known = functools.lru_cache(maxsize=16)(functools.partial(origin, catalogue))  # rows share a search
    return [_row(table, row, known) for row in rows], catalogue.plan


def located(file: Path) -> tuple[str, Path | None]:
    """A result relative to its working folder, and its study's folder; ValueError for a file outside ``results``."""
    path = file.resolve()
    at = next((number for number, part in reversed(list(enumerate(path.parts))) if part == "results"), None)
    if at is None:
        raise ValueError(f"{file}: is not in a folder 'results', so it belongs to no study; 'sph info {file}' shows its scene")
    folder = Path(*path.parts[:at])
    relative = path.relative_to(folder)
    alone = Path(*relative.parts[:2]).as_posix() in ALONE
    if alone and folder != Path.cwd():
        raise ValueError(f"{file}: belongs to no study; run the command in {folder}, where the configuration is")
    return relative.as_posix(), None if alone else Path(*path.parts[: at + 3])


def table_of(catalogue: Catalogue, file: str) -> Table:
    """How a table, by its file relative to the working folder, is traced; ValueError for one whose rows are not single runs."""
    plan, settings, place = catalogue.plan, catalogue.plan.study.metrics, Path(file).parent
    sampled = Path(plan.folder, SENSITIVITY_FOLDER)
    alone = {f"{folder}/{name}.csv": (name, trace) for folder, name in ALONE.items() if (trace := EXPERIMENTS[name].trace)}
    if file == f"{plan.folder}/study.csv":
        return _study(plan)
    if place.name == TRIGGER_FOLDER and Path(file).name in ("points.csv", "maps.csv") and place.parts[0] == "results":
        trigger = catalogue.trigger

        def searched(row: Mapping[str, str]) -> list[str]:
            return [run.file for run in trigger.runs_at([(row["case"], {axis: row[axis] for axis in trigger.names})])]

        columns = point_columns(trigger.dimensions.all, settings.places)
        return Table(columns, ["case", *trigger.names], searched, lambda runs: measured(runs[0], settings))
    if Path(file) == sampled / "sample.csv" or place == sampled / "samples":
        sensitivity, files = catalogue.sensitivity, {run.id: run.file for run in catalogue.sampled.values()}
        return Table(
            sample_columns(sensitivity.axes, sensitivity.quantities),
            ["run"],
            lambda row: [files[row["run"]]],
            lambda runs: {"reason": runs[0].attrs["status_reason"], **measure(runs[0], settings)},
        )
    if file in alone:
        name, trace = alone[file]
        design = catalogue.design(name)
        of = trace.runs(design)
        return Table(
            trace.columns,
            trace.named,
            lambda row: [design.runs[run].file for run in of[tuple(row[name] for name in trace.named)]],
            lambda runs: trace.measure(runs[0], settings) if runs else {},
        )
    raise ValueError(
        f"{file}: its rows are not single runs of study {plan.study.study} at fidelity {plan.study.fidelity}; what can be explained: "
        "runs and stages (.nc), and study.csv, trigger/points.csv, trigger/maps.csv, sensitivity/sample.csv, "
        f"sensitivity/samples/*.csv, {', '.join(f'{name}.csv' for name, _ in alone.values())} in their folders"
    )


def _study(plan: Plan) -> Table:
    layout = plan.layout

    def files(row: Mapping[str, str]) -> list[str]:
        name = row["case"] if layout.named else point_name({axis.name: row[axis.name] for axis in layout.axes})
        return [plan.shared.runs[name].file, *([plan.searches[name].file] if name in plan.searches else [])]

    def values(runs: list[Run]) -> Mapping[str, Any]:
        return run_values(runs[0], plan.study.metrics, float(runs[1].attrs["value"]) if len(runs) > 1 else math.nan)

    named = ["case"] * layout.named + [axis.name for axis in layout.axes]
    return Table([row._replace(dtype="str") if row in layout.axes else row for row in layout.columns], named, files, values)


def origin(catalogue: Catalogue, file: str) -> tuple[Origin, Run | None]:
    """What a run was made from and by, and where that is not what is planned now; its trajectory, None where there is none."""
    path = catalogue.base / file
    if not path.is_file():
        return Origin(file, "", [], "", "", "", ["there is no such file"]), None
    run = Run(trajectory.read(path), origin=file)
    made = run.scene
    digest, solver = trajectory.scene_digest(made), str(run.attrs.get("solver_digest", ""))
    differs, planned = [], None
    try:
        planned = catalogue.row(file)
        differs = differing(run.attrs, planned.built, file)
    except ValueError as error:
        differs = [str(error)]
    if run.attrs.get("scene_digest", digest) != digest:
        differs.append(f"its scene has the digest {digest}, the file records {run.attrs['scene_digest']}: it has been changed")
    if planned and planned.extrapolates and not run.attrs.get("extrapolates", 0):
        differs.append("searched at one spacing, by an earlier version: limits are now extrapolated from two")
    if solver != solver_digest():
        differs.append(f"made by the solver {solver or 'of a version that did not record it'}; the installed solver is {solver_digest()}")
    versions = str(run.attrs.get("versions", ""))
    status = str(run.attrs.get("status", "")) or f"{run.attrs['by'].replace('_', ' ')}: {', '.join(filter(None, search_words(run.attrs)))}"
    return Origin(file, digest, contents(made.model_dump(mode="json")), solver, versions, status, differs), run


def contents(scene: Mapping[str, Any], section: str = "") -> list[Content]:
    """What the sections of a scene took from files: their names, and digests of the content, as the scene holds it."""
    found = []
    if isinstance(scene.get("file"), str):
        held = {name: scene[name] for name in CONTENT_KEYS if scene.get(name) is not None}
        if held:
            found.append(Content(section, scene["file"], trajectory.text_digest(held)))
    for name, part in scene.items():
        if isinstance(part, Mapping):
            found += contents(part, f"{section}.{name}" if section else name)
    return found


def _row(table: Table, row: Mapping[str, str], known: Callable[[str], tuple[Origin, Run | None]]) -> Row:
    try:
        found = [known(file) for file in table.files(row)]
    except KeyError:
        found = [(Origin("-", "", [], "", "", "", ["the present configuration has no such run"]), None)]
    runs = [run for _, run in found if run is not None]
    again = table.values(runs) if len(runs) == len(found) else {}
    numbers = []
    for column in table.columns:
        if column.name not in table.named:
            value = again.get(column.name)
            text = None if value is None else repr(value) if isinstance(value, float) else str(value)
            told = row[column.name]
            numbers.append(Number(column.name, told, column.units, column.text, text, text is None or _is(told, text)))
    return Row({name: row[name] for name in table.named}, [each for each, _ in found], numbers)


def _is(written: str, value: str) -> bool:
    """Whether a cell holds a value: the same text, or the same number."""
    if written == value or {written.lower(), value.lower()} == {"nan"}:
        return True
    return is_number(written) and is_number(value) and value_of(written) == value_of(value)


def lines(rows: Sequence[Row], plan: Plan, column: str | None) -> list[str]:
    """Rows in words: one in full, many by a line each and what differs."""
    text: list[str] = []
    for row in rows:
        at = ", ".join(f"{name} {value}" for name, value in row.point.items())
        if len(rows) == 1:
            text += [at] * bool(at) + [line for each in row.origins for line in _origin_lines(each)] + _number_lines(row, plan, column)
        elif not row.differs:
            text.append(f"{at}: agrees")
        text += [f"{at}{': ' if at else ''}DIFFERS: {line}" for line in row.differs]
    agreeing = sum(not row.differs for row in rows)
    what = "the run agrees" if agreeing and not rows[0].point else "agrees" if len(rows) == 1 else f"{agreeing} of {len(rows)} rows agree"
    if agreeing < len(rows) == 1:
        return [*text, "does not agree with the present configuration, files or solver; repeat the snakemake command, which remakes the "
                "files that it finds outdated, or delete a file to force that"]  # fmt: skip
    return [*text, f"{what} with the configuration, the files on disk and the installed solver"]


def _origin_lines(each: Origin) -> list[str]:
    return [
        f"run      {each.file} ({each.status})" if each.scene_digest else f"run      {each.file}",
        f"scene    {each.scene_digest}",
        *(f"content  {found.digest}  {found.section} from {found.file}" for found in each.contents),
        f"solver   {each.solver_digest or 'not recorded'}",
        f"versions {each.versions}",
    ]


def _number_lines(row: Row, plan: Plan, column: str | None) -> list[str]:
    shown = [number for number in row.numbers if column in (None, number.column)]
    settings = ", ".join(f"{name} {value}" for name, value in plan.study.metrics.model_dump().items())
    return [f"{n.column} = {n.value} {n.unit}: {n.definition}" for n in shown] + [f"settings {settings}"] * bool(shown)


def record(rows: Sequence[Row], plan: Plan) -> dict[str, Any]:
    """Rows for machines."""
    return {
        "study": plan.study.study,
        "fidelity": plan.study.fidelity,
        "agrees": not any(row.differs for row in rows),
        "installed_solver": solver_digest(),
        "settings": plan.study.metrics.model_dump(),
        "rows": [
            {
                "row": row.point,
                "differs": row.differs,
                "runs": [each._asdict() | {"contents": [found._asdict() for found in each.contents]} for each in row.origins],
                "numbers": [number._asdict() for number in row.numbers],
            }
            for row in rows
        ],
    }
