"""What ``sph motion`` computes and prints: the measures of a ground motion, as recorded, as processed, or as a scene has it."""

from __future__ import annotations

import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from sph.checks.finding import Finding
from sph.checks.messages import line
from sph.checks.motion import drifting, implausible, of_motion, one_sided, sparse
from sph.command.given import earlier_run, read_given
from sph.command.outputs import check_picture
from sph.command.terminal import say, table
from sph.scene.configuration import merge, validated
from sph.scene.ground_motion import RECORDS, SCENES, GroundMotion, check_record, read_components
from sph.scene.ground_motion.measures import Measures, measure
from sph.scene.ground_motion.record import Record, check_gaps, processed, read_even
from sph.scene.loading import loading_of
from sph.scene.strict_json import to_json
from sph.scene.units import in_both

READING = {"unit", "component"}
"""Keys of a treatment that say what is read in a record, and do not process it."""
CURE = ("--baseline 1", "motion.baseline={}")
"""What removes the drift of a record."""


class Shaking(NamedTuple):
    """Accelerations of the ground by component."""

    name: str
    files: list[str]  # that were read
    interval: float  # s
    components: dict[str, np.ndarray]  # each (n,) m/s2
    findings: tuple[Finding, ...] = ()  # what a user of the motion should know


def motion(path: Path, changes: Mapping[str, Any], treatment: Mapping[str, Any], direction: str, out: Path | None, as_json: bool) -> str:
    """The measures of the shaking in a file, as a table or for machines; its picture where asked for."""
    if direction not in ("recorded", "turned"):
        raise ValueError(f"--direction {direction!r}: must be recorded or turned; the measures of both are the same")
    shaking = read_shaking(path, changes, treatment, direction == "turned")
    if out is not None:
        check_picture(out, shaking.files, "--plot")
    measured = {name: measure(values, shaking.interval) for name, values in shaking.components.items()}
    if out is not None:
        from sph.figures.ground_motion import figure_ground_motion
        from sph.figures.style import save

        save(figure_ground_motion(shaking.components, shaking.interval, shaking.name), out)
    say(*(line(each) for each in shaking.findings))
    if as_json:
        return to_json({name: values._asdict() for name, values in measured.items()}, indent=1)
    return table(("", *measured), rows(measured))


def read_treated(path: Path, treatment: Mapping[str, Any]) -> tuple[np.ndarray, list[np.ndarray]]:
    """Times (n,) in s and components (n,) in m/s2, the horizontal first, of a record, read and processed as by a scene.

    ``treatment`` has the keys ``unit``, ``component``, ``baseline`` and ``band_pass`` of a scene's ``motion``, or some of them.  A record
    that is not processed may be unevenly sampled.  ValueError as from the readers, and for processing that the record does not allow.
    """
    time, *columns = read_components(path, treatment.get("unit"), component=treatment.get("component"))
    check_gaps(str(path), time)
    if not set(treatment) - READING:
        return time, columns
    section = {"kind": "record", "file": str(path), "start": 0.0, "vertical": {} if len(columns) > 1 else None, **treatment}
    made = processed(validated(Record, section, str(path)))
    return made.time, [made.horizontal, made.vertical][: len(columns)]


def laid_over(path: Path, overrides: Mapping[str, Any], treatment: Mapping[str, Any]) -> dict[str, Any]:
    """The overrides of a scene with the treatment of its record; ValueError for what is read in a record, which is for records."""
    for name in sorted(READING & set(treatment)):
        value = treatment[name]
        raise ValueError(f"--{name} {value}: {path} is not a record; for the record of a scene write --set motion.{name}={value}")
    return merge(overrides, {"motion": dict(treatment)}) if treatment else dict(overrides)


def read_shaking(path: Path, overrides: Mapping[str, Any], treatment: Mapping[str, Any], turned: bool = False) -> Shaking:
    """The shaking in a record, or in a scene (YAML or trajectory) over its duration, by the ending; processed and scaled as asked for.

    ValueError for a file that is neither, for overrides of a record and a unit of a scene.
    """
    if path.suffix.lower() in RECORDS:
        if overrides:
            raise ValueError(f"{path}: is a record, in which --set has no keys to change (found {', '.join(overrides)})")
        if set(treatment) - READING:
            time, columns = read_treated(path, treatment)
            interval = float(time[1])
        else:
            interval, _, columns = read_even(str(path), treatment.get("unit"), component=treatment.get("component"))
        components = dict(zip(("horizontal", "vertical"), columns, strict=False))
        motion = GroundMotion(interval * np.arange(columns[0].size), columns[0])
        told = implausible(components, "--unit") + sparse(interval) + drifting(motion, *CURE)
        name, files = os.fsencode(path.name).decode("utf-8", "replace"), [str(path)]
    else:
        earlier = earlier_run(path)
        if earlier is None and path.is_file() and path.suffix:
            check_record(path, SCENES)
        scene, files = read_given(path, laid_over(path, overrides, treatment), earlier)
        loading = loading_of(scene)
        components = {"horizontal": loading.ground} | ({"vertical": loading.vertical} if loading.vertical.any() else {})
        name, interval, told = scene.name, float(loading.time[1]), of_motion(scene, loading)
    told = [each for each in told if each.code != "record-polarity"]
    if turned:
        components["horizontal"] = -components["horizontal"]
    horizontal = components["horizontal"]
    told += one_sided(GroundMotion(interval * np.arange(horizontal.size), horizontal), "--direction", "motion.factor")
    return Shaking(name, files, interval, components, tuple(told))


def rows(measured: Mapping[str, Measures]) -> list[list[str]]:
    """Rows of text: measure, then its value for every component."""
    texts = {
        "peak acceleration (PGA)": [in_both(m.peak_acceleration) for m in measured.values()],
        "peak velocity (PGV)": [f"{m.peak_velocity:.4g} m/s" for m in measured.values()],
        "peak displacement (PGD)": [f"{m.peak_displacement:.4g} m" for m in measured.values()],
        "Arias intensity": [f"{m.arias_intensity:.4g} m/s" for m in measured.values()],
        "significant duration D5-75": [f"{m.duration_5_75:.4g} s" for m in measured.values()],
        "significant duration D5-95": [f"{m.duration_5_95:.4g} s" for m in measured.values()],
        "velocity at the end": [f"{m.final_velocity:.2g} m/s" for m in measured.values()],
    }
    return [[name, *values] for name, values in texts.items()]
