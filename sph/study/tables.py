"""Tables and their files: that of a study, and flat ones of any columns.

A study has one row per run in the CSV; the netCDF has one value per grid point, or one a case where the study is a list.

Values of the dimensions are written as in the configuration ("0.10") in the CSV and become numbers once, here, as coordinates
of the dataset; the labels are kept beside them as ``S_R_label`` and so on.  The tables of a study are put together from parts, of which
only the numbers are kept: 0.4 kB a run.
"""

from __future__ import annotations

import shutil
import sys
from collections.abc import Hashable, Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pandas as pd
import xarray as xr

from sph.measures.metrics import METRICS
from sph.measures.metrics import ROW as ROW
from sph.storage import trajectory
from sph.storage.files import whole
from sph.storage.trajectory import Variable
from sph.study.dimensions import AXES, CASE


def text_column(name: str, text: str) -> Variable:
    """Column of words of a flat table."""
    return Variable(name, ROW, "str", "1", text)


def number_column(name: str, units: str, text: str) -> Variable:
    """Column of numbers of a flat table."""
    return Variable(name, ROW, "f8", units, text)


def count_column(name: str, text: str) -> Variable:
    """Column of whole numbers of a flat table."""
    return Variable(name, ROW, "i4", "1", text)


EXPECTED: tuple[Variable, ...] = tuple(
    number_column(
        f"expected_{name}_error",
        "1",
        f"largest relative deviation of {what} from the reference of the cost-accuracy study, over its cases, measured on its slope with "
        "the same numerics, walls, damping, fluid and gravity stage; NaN if no variant of the measured table has these, and for a slope "
        "unlike the measured one in height, angle, layers, water, strength, S_R or gamma",
    )
    for name, what in (("displacement", "displacement_magnitude"), ("runout", "runout"))
)
"""The errors to expect of a run, by the cost-accuracy study; see ``sph.experiments.variants.advice``."""
MAX_SLOPES = 10
"""Most slopes of a study, or of a case of a search, whose yield accelerations are searched."""
BASELINE: tuple[Variable, ...] = (
    number_column(
        "yield_acceleration",
        "m s-2",
        "constant horizontal acceleration at which the slope fails at its full strength, c_s and phi_s, by a pseudo-static search, "
        "extrapolated to spacing 0 from that of the run and twice that; 0 "
        "where it fails without any; for uncertain soil that of the mean soil, unless the study sets yield_acceleration: each; NaN "
        f"where its searches are not full, where it has more than {MAX_SLOPES} slopes, or where the search found none (its file says why)",
    ),
    number_column(
        "newmark_displacement",
        "m",
        "slip of a rigid block with that yield acceleration, which loses no strength, under the horizontal component of the run's motion "
        "(Newmark 1965); infinite where the slope fails without shaking, or under a sustained load above the yield acceleration; NaN "
        "without a yield acceleration",
    ),
)
"""The sliding block beside the run; see ``sph.study.baseline``."""
FINDINGS = text_column(
    "findings", "codes of the findings on the run's scene before the run and on its results after it, separated by blanks"
)
VALUES = (*METRICS, *EXPECTED, *BASELINE, FINDINGS)


class Layout(NamedTuple):
    """How the tables of a study are laid out."""

    axes: tuple[Variable, ...] = AXES  # what varies
    labels: tuple[tuple[str, ...], ...] = ()  # of a grid, the values of every axis in order, as written; none: a list of cases
    named: bool = False  # rows hold the name of the run, which its dimensions do not tell
    places: tuple[Variable, ...] = ()  # columns of the places that debris may reach

    @property
    def columns(self) -> list[Variable]:
        """Columns of the CSV."""
        return [CASE_COLUMN] * self.named + [*self.axes, *VALUES, *self.places]

    @property
    def names(self) -> list[str]:
        """Names of the columns."""
        return [row.name for row in self.columns]


CASE_COLUMN = Variable(CASE, (CASE,), "str", "1", "name of the run: its file is runs/<case>.nc")


def study_rows(rows: Sequence[Mapping[str, Any]], layout: Layout | None = None) -> pd.DataFrame:
    """Frame of a study or a part of it, values of its dimensions kept as strings; by default over the dimensions with short names.

    Raises ValueError for no rows, a missing or unknown column, and a value of a dimension that is not a number where all are to be.
    """
    layout = layout or Layout()
    if not rows:
        raise ValueError("rows: a study needs at least one run")
    for number, row in enumerate(rows):
        missing, unknown = [name for name in layout.names if name not in row], sorted(set(row) - set(layout.names))
        if missing or unknown:
            raise ValueError(f"row {number}: missing columns {missing}, unknown columns {unknown}")
    frame = pd.DataFrame([dict(row) for row in rows], columns=layout.names)
    for axis in layout.axes:
        frame[axis.name] = frame[axis.name].astype(str)
        _coordinates(axis, frame[axis.name])
    return frame


def joined_dataset(frames: Iterable[pd.DataFrame], layout: Layout, attrs: Mapping[str, Any] | None = None) -> xr.Dataset:
    """Dataset of a study from parts of its table, which are read one at a time.

    A grid has its dimensions, by numbers or words, and NaN or '' where a point is missing; a list has the dimension ``CASE``, along
    which the dimensions of the study are coordinates.
    """
    values: dict[str, list[np.ndarray]] = {}
    at: list[np.ndarray] = []
    places = [pd.Index(labels) for labels in layout.labels]
    for frame in frames:
        at.append(np.array([place.get_indexer(pd.Index(frame[axis.name])) for place, axis in zip(places, layout.axes, strict=False)]))
        for row in layout.columns:
            if row.dtype == "str":
                part = np.array([sys.intern(word) for word in frame[row.name]], dtype=object)
            else:
                part = frame[row.name].to_numpy(dtype=object if row in layout.axes else float)
            values.setdefault(row.name, []).append(part)
    columns = {name: np.concatenate(values.pop(name)) for name in list(values)}
    ds = xr.Dataset(attrs={"Conventions": "CF-1.10", **(attrs or {})})
    for place, axis in enumerate(layout.axes):
        written = np.array(layout.labels[place], dtype=object) if layout.labels else columns[axis.name]
        ds = ds.assign_coords({axis.name: (axis.dims, _coordinates(axis, written), _attributes(axis))})
        if axis.dtype != "str":
            label_attrs = {"long_name": f"{axis.name} as written in the configuration"}
            ds = ds.assign_coords({f"{axis.name}_label": (axis.dims, written, label_attrs)})
    shape = tuple(map(len, layout.labels))
    dims = tuple(axis.name for axis in layout.axes) if layout.labels else (CASE,)
    for row in layout.columns:
        if row not in layout.axes:
            filled = columns[row.name]
            if layout.labels:
                filled = np.full(shape, "" if row.dtype == "str" else np.nan, dtype=filled.dtype)
                filled[tuple(np.concatenate(at, axis=1))] = columns[row.name]
            ds[row.name] = (dims, filled, _attributes(row))
    return ds.assign_coords({CASE: ds[CASE]}) if layout.named else ds


def join_study(
    paths: Sequence[Path | str], layout: Layout, path_nc: Path | str, path_csv: Path | str, attrs: Mapping[str, Any] | None = None
) -> None:
    """Put the parts of a study's table (CSV) together, as netCDF and CSV; each file appears whole or not at all."""
    trajectory.write(path_nc, joined_dataset((read_table(path, layout) for path in paths), layout, attrs))
    with whole(path_csv) as temporary, temporary.open("wb") as joined:
        for number, path in enumerate(paths):
            with open(path, "rb") as part:
                head = part.readline()
                if number == 0:
                    joined.write(head)
                shutil.copyfileobj(part, joined)


def write_csv(frame: pd.DataFrame, path: Path | str) -> None:
    """Write a table, whole or not at all, in full precision, with NaN written out."""
    with whole(path) as temporary:
        frame.to_csv(temporary, index=False, na_rep="NaN", lineterminator="\n")


def read_study(path: Path | str) -> xr.Dataset:
    """Dataset of a study, in memory; ValueError names a file that is not one."""
    try:
        with xr.open_dataset(path, engine="netcdf4") as ds:
            study = ds.load()
    except Exception as error:  # as in sph.storage.trajectory
        raise ValueError(
            f"{path}: cannot be read as a study: {error}; if it was one, delete it and repeat the command that wrote it"
        ) from error
    trajectory.check_format(study, path)
    missing = [row.name for row in VALUES if row.name not in study.variables]
    if missing:
        raise ValueError(f"{path}: not a study of this version: it lacks {missing}; repeat the command that wrote it")
    return study


def read_table(path: Path | str, layout: Layout | None = None) -> pd.DataFrame:
    """Table of a study from its CSV, values of its dimensions and strings as written; ValueError names a file that is not one."""
    layout = layout or Layout()
    return read_csv(path, [row._replace(dtype="str") if row in layout.axes else row for row in layout.columns], "a study")


def read_csv(path: Path | str, variables: Sequence[Variable], what: str) -> pd.DataFrame:
    """Table with the columns ``variables`` from its CSV, strings as written; ValueError names a file that is not a table of ``what``."""
    columns, text = [row.name for row in variables], [row.name for row in variables if row.dtype == "str"]
    types: dict[Hashable, Any] = {row.name: {"s": "str", "i": "int64", "f": "float64"}[row.dtype[0]] for row in variables}
    try:
        nothing = {name: ["NaN"] for name in columns if name not in text}
        frame = pd.read_csv(path, dtype=types, keep_default_na=False, na_values=nothing)
    except (OSError, ValueError) as error:
        raise ValueError(f"{path}: cannot be read as the table of {what}: {error}") from error
    if list(frame.columns) != columns:
        raise ValueError(f"{path}: has the columns {list(frame.columns)}, but the table of {what} must have {columns}")
    return frame


def columns_of(path: Path | str) -> list[str]:
    """Names in the first line of a CSV; none where it cannot be read, of which ``read_csv`` says why."""
    try:
        return list(pd.read_csv(path, nrows=0, dtype=str).columns)
    except (OSError, ValueError):
        return []


def flat_dataset(frame: pd.DataFrame, variables: Sequence[Variable], attrs: Mapping[str, Any] | None = None) -> xr.Dataset:
    """Dataset of a flat table: every column is a variable along its only dimension."""
    ds = xr.Dataset(attrs={"Conventions": "CF-1.10", **(attrs or {})})
    for row in variables:
        values = frame[row.name].to_numpy(dtype=object if row.dtype == "str" else row.dtype)
        ds[row.name] = (row.dims, values, _attributes(row))
    return ds


def _attributes(row: Variable) -> dict[str, str]:
    return {"long_name": row.text} if row.dtype == "str" else {"units": row.units, "long_name": row.text}


def _coordinates(axis: Variable, labels: Iterable[str]) -> np.ndarray:
    """Values of a dimension: words, or finite numbers; ValueError names one that is neither."""
    if axis.dtype == "str":
        return np.array(list(labels), dtype=object)
    return np.array([_number(axis.name, label) for label in labels])


def _number(name: str, label: str) -> float:
    try:
        value = float(label)
    except ValueError as error:
        raise ValueError(f"{name}: {label!r} is not a number") from error
    if not np.isfinite(value):
        raise ValueError(f"{name}: {label!r} is not a finite number")
    return value
