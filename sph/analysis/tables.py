"""Tables and their files: that of a study, and flat ones of any columns.

A study has one row a run in the CSV and one value a grid point in the netCDF.

Grid values are written as in the configuration ("0.10") in the CSV and become numbers once, here, as coordinates
of the dataset; the labels travel with them as ``S_R_label`` and so on.
"""

from __future__ import annotations

from collections.abc import Hashable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import xarray as xr

from sph import trajectory
from sph.analysis.metrics import GRID, METRICS
from sph.files import whole
from sph.trajectory import Variable

ROW = ("row",)
"""The dimension of a flat table."""


def text_column(name: str, text: str) -> Variable:
    """Column of words of a flat table."""
    return Variable(name, ROW, "str", "1", text)


def number_column(name: str, units: str, text: str) -> Variable:
    """Column of numbers of a flat table."""
    return Variable(name, ROW, "f8", units, text)


def count_column(name: str, text: str) -> Variable:
    """Column of whole numbers of a flat table."""
    return Variable(name, ROW, "i4", "1", text)


AXES: tuple[Variable, ...] = (
    Variable("S_R", ("S_R",), "f8", "1", "strength ratio of the fluid state, Eqs. 14-15"),
    Variable("gamma", ("gamma",), "f8", "s-1", "rate of the loss of strength, Eq. 9"),
    Variable("amplitude", ("amplitude",), "f8", "m s-2", "amplitude of the ground acceleration"),
)
EXPECTED: tuple[Variable, ...] = tuple(
    Variable(
        f"expected_{name}_error",
        GRID,
        "f8",
        "1",
        f"largest relative deviation of {what} from the reference of the ladder, over its cases, measured on the ladder's slope with "
        "the same numerics, walls, damping, fluid and gravity stage; NaN if no rung of the measured table has these",
    )
    for name, what in (("displacement", "displacement_magnitude"), ("runout", "runout"))
)
"""What the ladder lets one expect of a run; see ``sph.analysis.advice``."""
BASELINE: tuple[Variable, ...] = (
    Variable(
        "yield_acceleration",
        GRID,
        "f8",
        "m s-2",
        "constant horizontal acceleration at which the slope fails at its full strength, c_s and phi_s (pseudo-static search)",
    ),
    Variable(
        "newmark_displacement",
        GRID,
        "f8",
        "m",
        "slip of a rigid block with that yield acceleration under the run's motion (Newmark 1965), which loses no strength; "
        "infinite where the slope fails without shaking",
    ),
)
"""The sliding block beside the run; see ``sph.analysis.baseline``."""
VALUES = METRICS + EXPECTED + BASELINE
COLUMNS = [row.name for row in AXES + VALUES]


def study_table(rows: Sequence[Mapping[str, Any]]) -> pd.DataFrame:
    """Frame with the columns ``COLUMNS``, sorted by S_R, gamma and amplitude, these kept as strings.

    Raises ValueError for no rows, a missing or unknown column, a grid value that is no number, and two rows at one grid point.
    """
    if not rows:
        raise ValueError("rows: a study needs at least one run")
    for number, row in enumerate(rows):
        missing, unknown = [name for name in COLUMNS if name not in row], sorted(set(row) - set(COLUMNS))
        if missing or unknown:
            raise ValueError(f"row {number}: missing columns {missing}, unknown columns {unknown}")
    frame = pd.DataFrame([dict(row) for row in rows], columns=COLUMNS)
    frame[list(GRID)] = frame[list(GRID)].astype(str)
    points = pd.DataFrame({name: [_number(name, label) for label in frame[name]] for name in GRID})
    if points.duplicated().any():
        raise ValueError(f"rows: two runs at {points[points.duplicated()].iloc[0].to_dict()}")
    return frame.loc[points.sort_values(list(GRID)).index].reset_index(drop=True)


def study_dataset(frame: pd.DataFrame, attrs: Mapping[str, Any] | None = None) -> xr.Dataset:
    """Dataset with dimensions S_R, gamma, amplitude (numbers) from a table; missing grid points are NaN, strings ''."""
    labels = {name: sorted(set(frame[name]), key=lambda label, name=name: _number(name, label)) for name in GRID}  # type: ignore[misc]
    ds = xr.Dataset(attrs={"Conventions": "CF-1.10", **(attrs or {})})
    for axis in AXES:
        values = np.array([_number(axis.name, label) for label in labels[axis.name]])
        if len(np.unique(values)) < len(values):
            raise ValueError(f"{axis.name}: one number is written in two ways in {labels[axis.name]}")
        ds = ds.assign_coords({axis.name: (axis.dims, values, _cf(axis))})
        label_attrs = {"long_name": f"{axis.name} as written in the configuration"}
        ds = ds.assign_coords({f"{axis.name}_label": (axis.dims, np.array(labels[axis.name], dtype=object), label_attrs)})
    at = tuple(np.array([labels[name].index(label) for label in frame[name]]) for name in GRID)
    shape = tuple(len(labels[name]) for name in GRID)
    for metric in VALUES:
        values = np.full(shape, "", dtype=object) if metric.dtype == "str" else np.full(shape, np.nan)
        values[at] = frame[metric.name].to_numpy(dtype=values.dtype)
        ds[metric.name] = (metric.dims, values, {"long_name": metric.text} if metric.dtype == "str" else _cf(metric))
    return ds


def write_study(frame: pd.DataFrame, path_nc: Path | str, path_csv: Path | str, attrs: Mapping[str, Any] | None = None) -> None:
    """Write the dataset and the CSV of a table; each file appears whole or not at all."""
    trajectory.write(path_nc, study_dataset(frame, attrs))
    write_csv(frame, path_csv)


def write_csv(frame: pd.DataFrame, path: Path | str) -> None:
    """Write a table, whole or not at all, in full precision, NaN spelt out."""
    with whole(path) as temporary:
        frame.to_csv(temporary, index=False, na_rep="NaN", lineterminator="\n")


def read_study(path: Path | str) -> xr.Dataset:
    """Dataset of a study, in memory; ValueError names a file that is none."""
    try:
        with xr.open_dataset(path, engine="netcdf4") as ds:
            study = ds.load()
    except Exception as error:  # as in sph.trajectory
        raise ValueError(f"{path}: cannot be read as a study: {error}; if it was one, delete it and run again what wrote it") from error
    missing = [name for name in COLUMNS if name not in study.variables]
    if missing:
        raise ValueError(f"{path}: not a study of this program, it lacks {missing}")
    return study


def read_table(path: Path | str) -> pd.DataFrame:
    """Table of a study from its CSV, grid values and strings as written; ValueError names a file that is none."""
    return read_csv(path, [row._replace(dtype="str") for row in AXES] + list(VALUES), "a study")


def read_csv(path: Path | str, variables: Sequence[Variable], what: str) -> pd.DataFrame:
    """Table with the columns ``variables`` from its CSV, strings as written; ValueError names a file that is no table of ``what``."""
    columns, text = [row.name for row in variables], [row.name for row in variables if row.dtype == "str"]
    types: dict[Hashable, Any] = {row.name: {"s": "str", "i": "int64", "f": "float64"}[row.dtype[0]] for row in variables}
    try:
        frame = pd.read_csv(path, dtype=types, keep_default_na=False, na_values={name: ["NaN"] for name in columns if name not in text})
    except (OSError, ValueError) as error:
        raise ValueError(f"{path}: cannot be read as the table of {what}: {error}") from error
    if list(frame.columns) != columns:
        raise ValueError(f"{path}: columns {list(frame.columns)} are not those of {what} {columns}")
    return frame


def flat_dataset(frame: pd.DataFrame, variables: Sequence[Variable], attrs: Mapping[str, Any] | None = None) -> xr.Dataset:
    """Dataset of a flat table: every column is a variable along its only dimension."""
    ds = xr.Dataset(attrs={"Conventions": "CF-1.10", **(attrs or {})})
    for row in variables:
        values = frame[row.name].to_numpy(dtype=object if row.dtype == "str" else row.dtype)
        ds[row.name] = (row.dims, values, {"long_name": row.text} if row.dtype == "str" else _cf(row))
    return ds


def _cf(row: Variable) -> dict[str, str]:
    return {"units": row.units, "long_name": row.text}


def _number(name: str, label: str) -> float:
    try:
        value = float(label)
    except ValueError as error:
        raise ValueError(f"{name}: {label!r} is not a number") from error
    if not np.isfinite(value):
        raise ValueError(f"{name}: {label!r} is not a finite number")
    return value
