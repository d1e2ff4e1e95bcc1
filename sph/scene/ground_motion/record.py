"""A recorded ground motion in a scene: the section ``motion`` of kind ``record``.

The scene names files; when it is validated it takes their samples into itself (``data``), so that a trajectory can be repeated from
its file alone.  A scene with ``data`` reads no file.
"""

from __future__ import annotations

import functools
import math
import os
from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any, Literal, NamedTuple, get_args

import numpy as np
from pydantic import BeforeValidator, Field, model_validator

from sph.scene.configuration import Section, check_file, key
from sph.scene.ground_motion import in_borehole, read_components
from sph.scene.ground_motion.direction import Direction
from sph.scene.ground_motion.measures import measure
from sph.scene.ground_motion.processing import MAX_SAMPLES, BandPass, Baseline, Resample, Trim, process
from sph.scene.ground_motion.spectrum import pseudo_acceleration
from sph.scene.ground_motion.stochastic import INTERVAL, Stochastic, synthesised
from sph.scene.ground_motion.text import MAX_ACCELERATION
from sph.scene.ground_motion.titles import MAX_TITLE, record_title
from sph.scene.ground_motion.units import Unit
from sph.scene.units import Acceleration

UNEVEN = 0.1
"""Largest distance of a sample from an even spacing, over the interval: times are written with few digits."""
MAX_GAPS = 0.1
"""Largest share of steps longer than usual that are gaps in an even record, and no uneven record."""
DIGITS = 9
"""Digits of the samples in a scene; recorders have six or seven."""

ComponentName = Annotated[
    str,
    BeforeValidator(lambda value: str(value) if type(value) is int else value, json_schema_input_type=int | str),
    Field(min_length=1, max_length=80),
]
Sample = Annotated[float, Field(ge=-MAX_ACCELERATION, le=MAX_ACCELERATION)]


class RecordData(Section):
    """The samples of a record, as read."""

    interval: float = key("interval of the samples", "s", ge=1e-6, le=10)
    x: tuple[Sample, ...] = key("horizontal acceleration", "m/s2", min_length=2, max_length=MAX_SAMPLES)
    y: tuple[Sample, ...] | None = key("vertical acceleration, positive upwards", "m/s2", default=None)
    instrument: Literal["borehole"] | None = key(
        "borehole: the motion is that within the ground, at the depth of the instrument; null: at the surface, or not known", default=None
    )

    @model_validator(mode="after")
    def _as_long(self) -> RecordData:
        if self.y is not None and len(self.y) != len(self.x):
            raise ValueError(f"data: y has {len(self.y)} samples, x has {len(self.x)}")
        return self


class Vertical(Section):
    """The vertical component."""

    file: str | None = key(
        "file of the vertical component, found like that of the record; null: the vertical component in the record's own file, as the "
        "third column of a CSV",
        default=None,
        min_length=1,
    )
    unequal_length: Literal["cut", "pad"] | None = key(
        "what is done where the files of the two components differ in length: cut, both end with the shorter one; pad, zeros follow the "
        "shorter one, from which an offset must have been removed; null: they are refused",
        default=None,
    )
    factor: float = key("factor on the vertical component, in addition to the scaling of the record", ge=-1e3, le=1e3, default=1.0)


class SpectralAcceleration(Section):
    """The spectral acceleration to which a record is scaled."""

    period: float = key("period of the oscillator", "s", gt=0, le=100)
    value: Acceleration = key("pseudo-acceleration of the oscillator", "m/s2", ge=0, le=1e4)
    damping: float = key("damping ratio of the oscillator", gt=0, lt=1, default=0.05)


class Record(Section):
    """A recorded ground motion, or a synthetic one in its place."""

    kind: Literal["record"] = key("recorded motion, or a synthetic one in its place")
    file: str | None = key(
        "file of the horizontal component (PEER .AT2, K-NET .EW .NS ..., SMC .smc, COSMOS and CSMIP .V1 .V2, ESM .ASC, GeoNet .V2A, AFAD "
        "and UNAM .txt, samples without times .th .acc, .csv), relative to the scene's folder or the working folder; with data the name of "
        "their source",
        default=None,
        min_length=1,
        max_length=1000,
    )
    name: str | None = key(
        "what the record is called in figures and tables, as 'Kobe 1995, KJMA'; null: earthquake and station as the head of its file names "
        "them (PEER, ESM, K-NET, a line '# record: ...' of a CSV), else the file",
        default=None,
        min_length=1,
        max_length=MAX_TITLE,
    )
    component: ComponentName | None = key(
        "horizontal component in a file that holds several (CSMIP, GeoNet, AFAD, UNAM): its name in the file, as N-S, or its number",
        default=None,
    )
    unit: Unit | None = key(
        "m/s2, cm/s2, gal or g, for files that do not state their unit, such as CSV without column names; m/s or cm/s for samples that are "
        "velocities, in CSV or without times, which are differentiated",
        default=None,
    )
    vertical: Vertical | None = key("vertical component; null: none", default=None)
    start: float = key("time at which the record, as processed, begins", "s", ge=0, le=1e4)
    amplitude: Acceleration | None = key(
        "peak horizontal acceleration to which the record, as processed, is scaled; null: as recorded", "m/s2", ge=0, le=1e4, default=None
    )
    peak_velocity: float | None = key(
        "instead of amplitude: peak horizontal velocity to which the record is scaled", "m/s", ge=0, le=100, default=None
    )
    arias_intensity: float | None = key(
        "instead of amplitude: Arias intensity of the horizontal component to which the record is scaled", "m/s", ge=0, le=1e4, default=None
    )
    spectral_acceleration: SpectralAcceleration | None = key(
        "instead of amplitude: spectral acceleration of the horizontal component to which the record is scaled", default=None
    )
    factor: float = key(
        "factor on all components; negative reverses their polarity; 1 or -1 if the record is scaled", ge=-1e3, le=1e3, default=1.0
    )
    baseline: Baseline | None = key("removal of drift, before all other processing and once more at the end; null: none", default=None)
    band_pass: BandPass | None = key("band-pass filter, after the baseline; null: none", default=None)
    trim: Trim | None = key("cut to the strong part, after the filter; null: not cut", default=None)
    resample: Resample | None = key("other interval of the samples, after the trim; null: none", default=None)
    stochastic: Stochastic | None = key("synthetic motion in place of a file, from a stochastic model; null: none", default=None)
    data: RecordData | None = key("the samples; null: read from the files", default=None)

    @model_validator(mode="before")
    @classmethod
    def _read(cls, values: Any) -> Any:
        if not isinstance(values, Mapping) or values.get("data") is not None or not isinstance(values.get("file"), str):
            return values
        if not values["file"]:
            return values  # refused below, with its key
        vertical = values.get("vertical")
        second = vertical.get("file") if isinstance(vertical, Mapping) else None
        unit, component = values.get("unit"), values.get("component")
        unequal = vertical.get("unequal_length") if isinstance(vertical, Mapping) else None
        if unit not in (None, *get_args(Unit)) or not isinstance(second, str | None) or not isinstance(component, str | int | None):
            return values  # refused below, with its key
        if unequal not in (None, "cut", "pad"):
            return values  # likewise
        files = [name for name in (values["file"], second) if name]
        data = read_data(
            *(_identity(name) for name in files),
            unit=unit,
            third_column=vertical is not None and not second,
            component=None if component is None else str(component),
            unequal=unequal,
        )
        named: dict[str, Any] = {"file": Path(values["file"]).name, "data": data}
        if values.get("name") is None:
            named["name"] = record_title(values["file"])
        if second:
            named["vertical"] = {**values["vertical"], "file": Path(second).name}
        return {**values, **named}

    @model_validator(mode="after")
    def _bears_processing(self) -> Record:
        if self.stochastic is not None and (self.file is not None or self.data is not None):
            raise ValueError(f"stochastic: stands in place of {'file' if self.file is not None else 'data'}; leave one of them out")
        if self.data is None and self.stochastic is None:
            raise ValueError("file: is required where there are neither data nor stochastic")
        if self.vertical is not None and (self.data is None or self.data.y is None):
            raise ValueError(
                "vertical: there is neither a second file nor a vertical component as long as the horizontal one in the first, as the "
                "third column of a CSV; name one in vertical.file, which may be the same file"
            )
        spectral = self.spectral_acceleration and self.spectral_acceleration.value
        asked = zip(SCALES.items(), (self.amplitude, self.peak_velocity, self.arias_intensity, spectral), strict=True)
        scaled = [f"{name}: {value:g} {unit}" for (name, unit), value in asked if value is not None]
        if len(scaled) > 1:
            raise ValueError(f"{scaled[1]}: the record is scaled to {scaled[0]} already; leave one of them out")
        if scaled and abs(self.factor) != 1.0:
            raise ValueError(f"factor: {self.factor:g} with {scaled[0]} must be 1 or -1; leave one of them out")
        processed(self)
        return self

    @property
    def peak(self) -> float:
        """Largest horizontal acceleration, as processed, m/s2."""
        return float(np.abs(processed(self).horizontal).max())

    @property
    def end(self) -> float:
        """Time at which the record ends, s."""
        return float(self.start + processed(self).time[-1])

    def acceleration(self, time: np.ndarray) -> np.ndarray:
        """Horizontal acceleration of the box at times (s), m/s2: linear between the samples, 0 before and after the record."""
        return self._at(time, processed(self).horizontal)

    def vertical_acceleration(self, time: np.ndarray) -> np.ndarray:
        """Vertical acceleration of the box at times (s), m/s2, positive upwards."""
        return self._at(time, processed(self).vertical)

    def _at(self, time: np.ndarray, samples: np.ndarray) -> np.ndarray:
        return np.interp(time - self.start, processed(self).time, samples, left=0.0, right=0.0)


class Processed(NamedTuple):
    """A record as the scene wants it."""

    time: np.ndarray  # (n,) from 0 on, s
    horizontal: np.ndarray  # (n,) m/s2
    vertical: np.ndarray  # (n,) m/s2, zeros without one


def own_peak(record: Record) -> float:
    """Largest horizontal acceleration in a record as it was read, m/s2."""
    return float(np.abs(_samples(record)[0][0]).max())


SCALES = {"amplitude": "m/s2", "peak_velocity": "m/s", "arias_intensity": "m/s", "spectral_acceleration.value": "m/s2"}
"""Keys to one of which a record is scaled, and their units."""


def _scale(record: Record, acceleration: np.ndarray, interval: float) -> float:
    """What a record's acceleration (n,) is multiplied by for the intensity that it is scaled to; ValueError where it cannot be reached."""
    if record.spectral_acceleration is not None:
        asked = record.spectral_acceleration
        own = float(pseudo_acceleration(acceleration, interval, np.array([asked.period]), asked.damping)[0])
        return _ratio("spectral_acceleration.value", asked.value, own)
    if record.peak_velocity is not None:
        return _ratio("peak_velocity", record.peak_velocity, measure(acceleration, interval).peak_velocity)
    if record.arias_intensity is not None:
        return math.sqrt(_ratio("arias_intensity", record.arias_intensity, measure(acceleration, interval).arias_intensity))
    return 1.0 if record.amplitude is None else _ratio("amplitude", record.amplitude, float(np.abs(acceleration).max()))


def _ratio(name: str, wanted: float, own: float) -> float:
    if wanted > 0.0 and not own > 0.0:
        raise ValueError(f"{name}: {wanted:g} {SCALES[name]} cannot be reached, since the record is zero throughout")
    return wanted / own if own > 0.0 else 0.0


@functools.lru_cache(maxsize=8)
def processed(record: Record) -> Processed:
    """Samples of a record after its processing; ValueError for processing that the record does not bear."""
    raw, interval = _samples(record)
    components, interval = process(raw, interval, record.baseline, record.band_pass, record.trim, record.resample)
    scale = record.factor * _scale(record, components[0], interval)
    horizontal = scale * components[0]
    vertical = scale * record.vertical.factor * components[1] if record.vertical is not None else np.zeros_like(horizontal)
    if not max(np.abs(horizontal).max(), np.abs(vertical).max()) <= MAX_ACCELERATION:
        raise ValueError(f"factor: {record.factor:g}: more than {MAX_ACCELERATION:g} m/s2")
    return Processed(interval * np.arange(horizontal.size), horizontal, vertical)


def _samples(record: Record) -> tuple[list[np.ndarray], float]:
    """Components (n,) in m/s2, the horizontal first, before their processing, and their interval (s)."""
    if record.stochastic is not None:
        return [synthesised(record.stochastic)], INTERVAL
    assert record.data is not None
    return [np.array(record.data.x)] + ([np.array(record.data.y)] if record.vertical is not None else []), record.data.interval


@functools.lru_cache(maxsize=8)
def read_data(
    *files: tuple[str, tuple[int, ...]], unit: Unit | None, third_column: bool, component: str | None = None, unequal: str | None = None
) -> RecordData:
    """Samples in one or two files, each with what tells it from others and from what it was before; ValueError names it."""
    below = [name for name, _ in files if in_borehole(name)]
    if len(below) == 1 < len(files):
        above = next(name for name, _ in files if name not in below)
        raise ValueError(
            f"vertical.file: {below[0]} was recorded in the borehole, {above} was not; name the two components of one instrument, as "
            ".EW2 and .UD2 of the surface"
        )
    interval, first, columns = read_even(files[0][0], unit, third_column, component=component)
    if len(files) > 1:
        other, begins, vertical = read_even(files[1][0], unit, False, "vertical")
        if abs(other / interval - 1.0) > 1e-6:
            raise ValueError(f"vertical.file: {files[1][0]}: has a sample every {other:g} s, {files[0][0]} every {interval:g} s")
        if abs(begins - first) > UNEVEN * interval:
            raise ValueError(f"vertical.file: {files[1][0]}: begins at {begins:g} s, {files[0][0]} at {first:g} s")
        columns = [columns[0], vertical[0]]
        shorter, longer = sorted(column.size for column in columns)
        if shorter != longer and unequal is None:
            raise ValueError(
                f"vertical.file: {files[1][0]}: holds {columns[1].size:,} samples, {files[0][0]} {columns[0].size:,}; set "
                "vertical.unequal_length to cut, so that both end with the shorter one, or to pad, so that zeros follow it"
            )
        columns = [column[:shorter] if unequal == "cut" else np.pad(column, (0, longer - column.size)) for column in columns]
    if columns[0].size > MAX_SAMPLES:
        raise ValueError(f"{files[0][0]}: holds {columns[0].size:,} samples, at most {MAX_SAMPLES:,} in a scene; cut or resample it")
    rounded = [tuple(float(f"{value:.{DIGITS}g}") for value in column) for column in columns]
    return RecordData(interval=interval, x=rounded[0], y=rounded[1] if len(rounded) > 1 else None, instrument="borehole" if below else None)


def read_even(
    path: str, unit: Unit | None, third_column: bool = True, wanted: Direction = "horizontal", component: str | None = None
) -> tuple[float, float, list[np.ndarray]]:
    """Interval and first time (s) and components of a record, the wanted first, with the vertical if asked for.

    ValueError if it is not evenly sampled.
    """
    time, *columns = read_components(path, unit, wanted, component)
    check_gaps(path, time)
    interval = float(f"{(time[-1] - time[0]) / (time.size - 1):.{DIGITS}g}")
    uneven = np.abs(time - time[0] - interval * np.arange(time.size)) > UNEVEN * interval
    if uneven.any():
        at = int(uneven.argmax())
        raise ValueError(f"{path}: sample {at + 1}, at {time[at]:g} s: samples must be evenly spaced, here by {interval:g} s")
    return interval, float(time[0]), columns[: 1 + third_column]


def check_gaps(path: str, time: np.ndarray) -> None:
    """Refuse a record in which samples are missing between others, with the first place."""
    steps = np.diff(time)
    usual = float(np.median(steps))
    gaps = np.flatnonzero(steps > 1.5 * usual)
    if 0 < gaps.size <= MAX_GAPS * steps.size:
        at, others = int(gaps[0]), f", and {gaps.size - 1} more behind it" if gaps.size > 1 else ""
        raise ValueError(
            f"{path}: has a gap of {steps[at]:g} s between sample {at + 1}, at {time[at]:g} s, and the next, at {time[at + 1]:g} s"
            f"{others}; elsewhere samples are {usual:g} s apart: fill in the missing samples, or use the part before or behind"
        )


def _identity(name: str) -> tuple[str, tuple[int, ...]]:
    """A file, told by its place on the disk and its last change; its date alone may be that of an older file copied over it."""
    try:
        state = os.stat(name)
        check_file(name)
    except (OSError, ValueError) as error:
        raise ValueError(f"file: {name!r} cannot be read: {getattr(error, 'strerror', None) or error}") from error
    return name, (state.st_dev, state.st_ino, state.st_ctime_ns, state.st_size)
