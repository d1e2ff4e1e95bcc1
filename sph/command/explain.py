"""Where a number of a study comes from (``sph explain``): its run, what that was made from and by, and whether that is what is planned now.

The dimensions of a row of ``study.csv`` name its runs; the place of a run's file, of any target, names its scene in the configuration.  A
row *agrees* if every run holds the scene that the configuration and the files on disk give now, was made by the solver that is installed,
and gives the row's numbers when it is measured again.

``snakemake --summary`` says what would be made again.  It knows neither rows nor columns, and takes for current an edited table, and the
file of one run copied over that of another.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import pandas as pd

from sph.checks.messages import search_words
from sph.command.study import find_study
from sph.experiments.study_row import run_values
from sph.jobs.catalogue import ALONE, Catalogue
from sph.jobs.exit_codes import DIFFERS
from sph.output.run import Run
from sph.scene.configuration import CONTENT_KEYS
from sph.scene.names import check_known
from sph.scene.strict_json import to_json
from sph.solver.compiled.jit import solver_digest
from sph.storage import trajectory
from sph.study.dimensions import is_number, point_name, value_of
from sph.study.plan import Plan
from sph.study.planned import differing
from sph.study.tables import read_table


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
        told = [f"{origin.file}: {line}" for origin in self.origins for line in origin.differs]
        return told + [f"{n.column}: {n.value} in the table, {n.again} measured now" for n in self.numbers if not n.agrees]


def explain(file: Path, conditions: Mapping[str, str], column: str | None, configfile: Path | None, as_json: bool) -> tuple[str, int]:
    """Rows in words or for machines, and the exit code, whether one is not as planned; of numbers the ``column`` alone where one is named.

    The file is the table of a study, its configuration, or a run among results.
    """
    rows, plan = traced(file, conditions, configfile)
    known = [number.column for number in rows[0].numbers]
    if column is not None and not known:
        raise ValueError(f"--column {column!r}: must be left out for the file of a run")
    check_known("--column", [column], known)
    text = to_json(record(rows, plan), indent=1) if as_json else "\n".join(lines(rows, plan, column))
    return text, DIFFERS if any(row.differs for row in rows) else 0


def traced(file: Path, conditions: Mapping[str, str], configfile: Path | None = None) -> tuple[list[Row], Plan]:
    """The rows of a study's table that meet the conditions, or one row without numbers for a run's file, and the study they belong to.

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
    plan, layout = catalogue.plan, catalogue.plan.layout
    if file.suffix == ".nc":
        return [Row({}, [origin(catalogue, relative)[0]], [])], plan
    if relative != f"{plan.folder}/study.csv":
        raise ValueError(f"{file}: is not study.csv of study {plan.study.study}, nor a run or stage (.nc), which can be explained")
    read_table(file, layout)
    written = pd.read_csv(file, dtype=str, keep_default_na=False)
    for name in conditions:
        if name not in layout.names:
            raise ValueError(f"{file}: has no column {name!r}; it has {', '.join(layout.names)}")
    rows = [
        {str(name): cell for name, cell in row.items()}
        for row in written.to_dict("records")
        if all(_is(row[name], value) for name, value in conditions.items())
    ]
    if not rows:
        at = ", ".join(f"{name}={value}" for name, value in conditions.items())
        raise ValueError(f"{file}: has no row with {at}; it has {len(written)} rows, identified by {', '.join(_named(plan))}")
    return [_row(catalogue, row) for row in rows], plan


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


def _named(plan: Plan) -> list[str]:
    """Columns that tell rows apart."""
    return ["case"] * plan.layout.named + [axis.name for axis in plan.layout.axes]


def origin(catalogue: Catalogue, file: str) -> tuple[Origin, Run | None]:
    """What a run was made from and by, and where that is not what is planned now; its trajectory, None where there is none."""
    path = catalogue.base / file
    if not path.is_file():
        return Origin(file, "", [], "", "", "", ["there is no such file"]), None
    run = Run(trajectory.read(path), origin=file)
    made = run.scene
    digest, solver = trajectory.scene_digest(made), str(run.attrs.get("solver_digest", ""))
    try:
        differs = differing(run.attrs, catalogue.row(file).built, file)
    except ValueError as error:
        differs = [str(error)]
    if run.attrs.get("scene_digest", digest) != digest:
        differs.append(f"its scene has the digest {digest}, the file records {run.attrs['scene_digest']}: it has been changed")
    if solver != solver_digest():
        differs.append(f"made by the solver {solver or 'of a version that did not record it'}; the installed solver is {solver_digest()}")
    versions = str(run.attrs.get("versions", ""))
    status = str(run.attrs.get("status", "")) or f"{run.attrs['by'].replace('_', ' ')}: {', '.join(filter(None, search_words(run.attrs)))}"
    return Origin(file, digest, contents(made.model_dump(mode="json")), solver, versions, status, differs), run


def contents(scene: Mapping[str, Any], section: str = "") -> list[Content]:
    """What the sections of a scene took from files: their names, and digests of the content, as the scene holds it."""
    taken = []
    if isinstance(scene.get("file"), str):
        held = {name: scene[name] for name in CONTENT_KEYS if scene.get(name) is not None}
        if held:
            taken.append(Content(section, scene["file"], trajectory.text_digest(held)))
    for name, part in scene.items():
        if isinstance(part, Mapping):
            taken += contents(part, f"{section}.{name}" if section else name)
    return taken


def _row(catalogue: Catalogue, row: Mapping[str, str]) -> Row:
    plan, layout = catalogue.plan, catalogue.plan.layout
    point = {name: row[name] for name in _named(plan)}
    name = row["case"] if layout.named else point_name(point)
    if name not in plan.shared.runs:
        return Row(point, [Origin("-", "", [], "", "", "", ["the present configuration has no such run"])], [])
    files = [plan.shared.runs[name].file, *([plan.searches[name].file] if name in plan.searches else [])]
    origins, runs = zip(*(origin(catalogue, file) for file in files), strict=True)
    run, *searches = runs
    again: Mapping[str, Any] = {}
    if run is not None and None not in searches:
        again = run_values(run, plan.study.metrics, float(searches[0].attrs["value"]) if searches else math.nan)
    numbers = []
    for column in layout.columns:
        if column.name not in point:
            value = again.get(column.name)
            text = None if value is None else repr(value) if isinstance(value, float) else str(value)
            told = row[column.name]
            numbers.append(Number(column.name, told, column.units, column.text, text, text is None or _is(told, text)))
    return Row(point, list(origins), numbers)


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
        *(f"content  {content.digest}  {content.section} from {content.file}" for content in each.contents),
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
                "runs": [each._asdict() | {"contents": [content._asdict() for content in each.contents]} for each in row.origins],
                "numbers": [number._asdict() for number in row.numbers],
            }
            for row in rows
        ],
    }
