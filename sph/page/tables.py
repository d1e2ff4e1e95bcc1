"""Tables of the page: of the runs, of the scene and from CSV files."""

from __future__ import annotations

import csv
import math
import operator
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import pandas as pd
from pydantic import BaseModel

from sph.checks.after_run import in_motion, is_at_least, is_held, is_open
from sph.experiments.variants.advice import percent
from sph.figures.style import NOTHING, metres
from sph.scene.layers import BelowRegion, DepthRegion, PolygonRegion, Region
from sph.scene.schema import Scene
from sph.scene.scheme import SOFTENING
from sph.scene.soil import LIQUEFIES, Soil
from sph.scene.units import beside_g
from sph.scene.walls import wall_words
from sph.storage.trajectory import Variable
from sph.study.dimensions import Dimension, named, readable, shown_unit

MAX_ROWS = 500
"""Most rows that the page shows of a CSV file."""
KEYS = (
    "duration",
    "geometry.",
    "walls.",
    "motion.",
    "damping.",
    "seams.",
    "water.",
    SOFTENING,
    "numerics.spacing",
    "numerics.smoothing_ratio",
    "numerics.time_step",
)
"""Beginnings of the scene keys that the page shows at once, beside the table of layers; ``SOFTENING`` also where it is not set,
since failure at once decides the answer."""
OF_CLIENT = {
    "duration": "time simulated",
    "geometry.slope_height": "height of the slope",
    "geometry.slope_angle": "angle of the slope",
    "geometry.base": "elevation of the model's base",
    "walls.base": "base of the model",
    "walls.sides": "sides of the model",
    "walls.bedrock.density": "density of the bedrock",
    "walls.bedrock.s_wave_speed": "shear wave speed of the bedrock",
    "walls.bedrock.p_wave_speed": "pressure wave speed of the bedrock",
    "water.pressure": "pore pressure of soil that moves",
    "water.level": "elevation of the water table",
    "water.r_u": "ratio of water pressure to overburden r_u",
    "motion.file": "record",
    "motion.amplitude": "peak horizontal acceleration",
    "motion.frequency": "frequency of the shaking",
    "coupling.softening.slip_at_peak": "slip at which strength begins to fall",
    "coupling.softening.slip_at_residual": "slip at which the residual strength is reached",
    "damping.ratio": "damping ratio",
    "damping.frequencies": "at the frequencies",
    "numerics.spacing": "size of a particle",
}
"""The scene keys that a client's page shows, in an engineer's words."""
SENTENCE = "sentence"
"""Column of a CSV file that says in words what the row holds."""
MAX_NUMBERS = 12
"""Most numbers that the page shows of a list of them: those of a line or a record are counted."""
MAX_VALUES = 12
"""Most values of a dimension that the page shows one by one."""


class Code(str):
    """A cell that is a name in the program."""


class Table(NamedTuple):
    """Words of a table."""

    caption: str
    head: Sequence[str]
    rows: Sequence[Sequence[str]]
    note: str = ""
    source: str = ""  # file it was read from
    sentences: Sequence[str] = ()  # what its rows say, which stands above it

    @property
    def wordy(self) -> bool:
        """Whether a cell holds a sentence: on a narrow screen every row then becomes a card."""
        return any(len(cell) > 70 for row in self.rows for cell in row)


def filled(table: Table) -> Table:
    """The table without columns in which nothing is known."""
    kept = [at for at in range(len(table.head)) if any(row[at] != NOTHING for row in table.rows)]
    head, *rows = ([row[at] for at in kept] for row in (table.head, *table.rows))
    return table._replace(head=head, rows=rows)


def turned(table: Table) -> Table:
    """The table with its rows as columns: for few rows of many columns, which a phone and a sheet of paper have no room for."""
    head, *rows = zip(table.head, *table.rows, strict=True)
    return table._replace(head=head, rows=rows)


def csv_table(path: Path | str, caption: str, variables: Iterable[Variable] = (), aside: Collection[str] = ()) -> Table:
    """Table of a CSV file without the columns ``aside``, numbers to four digits, headings with the units that are declared; ValueError
    names a file that is not one.

    The column of sentences is taken out of it, each with the case of its row where there are several.
    """
    try:
        with open(path, newline="", encoding="utf-8") as file:
            head, *rows = csv.reader(file, strict=True)
    except (OSError, ValueError, csv.Error) as error:
        raise ValueError(f"{path}: cannot be read as a table: {error}; delete it and repeat the command that wrote it") from error
    if any(len(row) != len(head) for row in rows):
        raise ValueError(
            f"{path}: cannot be read as a table: not all of its rows have {len(head)} columns; repeat the command that wrote it"
        )
    kept = [at for at, name in enumerate(head) if name not in aside]
    head, *rows = ([row[at] for at in kept] for row in (head, *rows))
    sentences = list[str]()
    if SENTENCE in head:
        at, case = head.index(SENTENCE), head.index("case") if "case" in head else None
        several = case is not None and len({row[case] for row in rows}) > 1
        sentences = [f"{row[case]}: {row[at]}" if several and case is not None else row[at] for row in rows[:MAX_ROWS]]
        sentences = list(dict.fromkeys(sentences))
        head, *rows = (row[:at] + row[at + 1 :] for row in (head, *rows))
    note = f"The first {MAX_ROWS} of {len(rows)} rows." if len(rows) > MAX_ROWS else ""
    units = {row.name: f"{row.name} ({row.units})" for row in variables if row.units != "1"}
    shown = [[short(cell) for cell in row] for row in rows[:MAX_ROWS]]
    return Table(caption, [units.get(name, name) for name in head], shown, note, str(path), sentences)


def short(cell: str) -> str:
    """A cell of a CSV file for reading: numbers as written if they are short, else to four digits; NaN as a dash."""
    if cell == "NaN":
        return NOTHING
    try:
        return cell if len(cell) <= 7 else f"{float(cell):.4g}"
    except ValueError:
        return cell


def _share(value: float) -> str:
    return NOTHING if math.isnan(value) else percent(value)


def _status(row: Mapping[Any, Any]) -> str:
    met = f", debris at {row['reached_side'].replace(' ', ', ')}" if row["reached_side"] else ""
    braked = ", debris\N{NO-BREAK SPACE}braked" if is_held(row) and not row["diverged"] else ""
    energy = ", energy\N{NO-BREAK SPACE}error too\N{NO-BREAK SPACE}large" if is_open(row["energy_error"]) else ""
    moving = ", still\N{NO-BREAK SPACE}moving" if in_motion(row) else ""
    return str(row["status"]) + moving + met + braked + energy


def moves_on(runs: pd.DataFrame) -> str:
    """How much of the debris of runs in motion moves at their end, and for how long, in words."""
    time, share = runs["time_to_rest"], 100.0 * float(runs["moving_share"].max())
    steady = int(time.isna().sum())
    longer = f"needs some {time.max():.2g} s more to rest"
    if steady:
        longer = "does not slow down yet" + f" in {steady} of them" * (steady < len(runs))
    return f"{'up to ' * (len(runs) > 1)}{share:.0f} % of the debris, which {longer}" if share >= 0.5 else longer


def _at_least(row: Mapping[Any, Any], name: str) -> str:
    """A length of a run, as a lower bound where its debris met the box, was braked or still moves; one that is not known has no bound."""
    return metres(row[name], is_at_least(row))


class Column(NamedTuple):
    """A column of the table of runs."""

    heading: str
    words: Callable[[Mapping[Any, Any]], str]  # of a row of a study's table
    result: bool = False  # also shown beside the drawing of the run


def run_columns(dimensions: Iterable[Dimension], probe: str) -> list[Column]:
    """Columns of the table of runs."""
    return [
        *(Column(found.label, lambda row, found=found: found.shown(row[found.name])) for found in dimensions),  # type: ignore[misc]
        Column("class", operator.itemgetter("collapse_class")),
        Column("status", _status),
        Column(f"displacement of {probe} (m)", lambda row: _at_least(row, "displacement_magnitude"), True),
        Column("run-out (m)", lambda row: _at_least(row, "runout"), True),
        Column("by the energy line (m)", lambda row: metres(row["energy_line_runout"]), True),
        Column("by Corominas (m)", lambda row: metres(row["corominas_runout"]), True),
        Column("Newmark block (m)", lambda row: metres(row["newmark_displacement"]), True),
        Column("expected error of displacement", lambda row: _share(row["expected_displacement_error"]), True),
        Column("expected error of run-out", lambda row: _share(row["expected_runout_error"]), True),
        Column("computing time (s)", lambda row: f"{row['wall_time']:.3g}"),
    ]


def key_rows(section: BaseModel, path: str = "") -> Iterator[tuple[str, str, str, str]]:
    """Rows (key, value, unit, meaning) of a scene or a part of it."""
    for name, field in type(section).model_fields.items():
        if field.exclude:  # another form of a key
            continue
        value, extra = getattr(section, name), field.json_schema_extra
        unit = str(extra.get("unit", "-")) if isinstance(extra, dict) else "-"
        for key, part in value.items() if isinstance(value, Mapping) else ((None, value),):
            at = f"{path}{name}" if key is None else f"{path}{name}.{key}"
            if isinstance(part, BaseModel):
                yield from key_rows(part, f"{at}.")
            else:
                yield at, beside_g(_value_words(part), unit), unit, field.description or ""


def _value_words(value: Any) -> str:
    if isinstance(value, tuple):
        return (
            f"{len(value):,} values"
            if len(value) > MAX_NUMBERS or any(isinstance(part, tuple) for part in value)
            else ", ".join(map(_value_words, value))
        )
    return "none" if value is None else f"{value:.10g}" if isinstance(value, float) else str(value)


def scene_table(section: BaseModel, varied: Mapping[str, str]) -> Table:
    """Every key of a scene; ``varied`` says of keys which values the study gives them."""
    rows = [(Code(key), varied.get(key, value), unit, text) for key, value, unit, text in key_rows(section)]
    return Table("Every key of the scene, as a scene file names it", ("key", "value", "unit", "meaning"), rows)


def chosen_keys(table: Table) -> Table:
    """The rows of the table of a scene that describe the problem, ``KEYS``, by names that are read."""
    rows = []
    for key, value, unit, text in table.rows:
        if key == SOFTENING and value == "none":
            rows.append(("onset of failure", "at once", "", text))
        elif key.startswith(KEYS) and value != "none":
            rows.append((readable(key), wall_words(value) if key.startswith("walls.") else value, shown_unit(unit), text))
    return Table("What is simulated", ("what", "value", "unit", "meaning"), rows)


def client_table(table: Table) -> Table:
    """The rows of the table of a scene that a client is told, ``OF_CLIENT``, without keys and what is not set."""
    rows = [
        (OF_CLIENT[key], wall_words(value) if key.startswith("walls.") else value, shown_unit(unit))
        for key, value, unit, _ in table.rows
        if key in OF_CLIENT and value != "none"
    ]
    return Table("What is simulated", ("what", "value", "unit"), rows)


def layer_table(scene: Scene, varied: Mapping[str, str]) -> Table:
    """The scene's own soil and its layers with their properties, those that the study varies with all their values."""
    fields = {
        name: str((field.json_schema_extra or {}).get("unit", "-"))  # type: ignore[union-attr]
        for name, field in Soil.model_fields.items()
        if not field.exclude
        and name != "name"
        and (name != "cohesion_growth" or any(soil.gradient for soil in scene.soils))
        and (name not in LIQUEFIES or any(getattr(soil, name) is not None for soil in scene.soils))
    }
    rows = []
    for name, material, layer in zip(scene.soil_names, scene.materials, (None, *scene.layers.values()), strict=True):
        soil, path = material.soil, "" if layer is None else f"layers.{material.name}."
        ratio, rate = (
            varied.get(f"{path}{key}")
            or (varied.get(f"coupling.{key}") if layer is None or getattr(layer, key) is None else None)
            or f"{getattr(material, key):g}"
            for key in ("S_R", "gamma")
        )
        numbers = {key: soil.gradient or None if key == "cohesion_growth" else getattr(soil, key) for key in fields}
        values = (varied.get(f"{path}soil.{key}", "" if number is None else _whole(number)) for key, number in numbers.items())
        rows.append(
            (
                name,
                "elsewhere" if layer is None else region_words(layer.region),
                *values,
                f"{soil.s_wave_speed:.0f}",
                ratio,
                rate,
            )
        )
    units = [f"{readable(name)} ({shown_unit(unit)})" if shown_unit(unit) else readable(name) for name, unit in fields.items()]
    head = (
        "layer",
        "where",
        *units,
        "shear wave speed (m/s)",
        named("S_R").phrase,
        f"{named('gamma').phrase} ({named('gamma').shown_unit})",
    )
    return Table("Layers; where two overlap, the later one counts", head, rows)


def _whole(number: float) -> str:
    """A number to six digits, a large one without a power of ten."""
    return f"{number:.6g}" if abs(number) < 1e6 else f"{float(f'{number:.6g}'):.0f}"


def region_words(region: Region) -> str:
    """Where a layer lies, in words."""
    if isinstance(region, PolygonRegion):
        return f"inside a polygon of {len(region.points)} corners"
    if isinstance(region, BelowRegion):
        return f"below a boundary of {len(region.points)} points"
    if isinstance(region, DepthRegion):
        return f"from {region.top:g} m below the ground to {'the base' if region.bottom is None else f'{region.bottom:g} m'}"
    low, high = (
        ("the base" if region.bottom is None else f"{region.bottom:g} m"),
        ("the ground" if region.top is None else f"{region.top:g} m"),
    )
    return f"from elevation {low} to {high}" if region.bottom is not None else f"from the base to elevation {high}"
