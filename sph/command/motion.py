"""What ``sph motion`` computes and prints: the measures of a ground motion, as recorded or as processed by a scene."""

from __future__ import annotations

import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from sph.command.repeat import read_given
from sph.scene.ground_motion import RECORDS, GroundMotion, loading_of
from sph.scene.ground_motion.measures import Measures, measure
from sph.scene.ground_motion.record import read_even
from sph.scene.ground_motion.units import Unit
from sph.study.findings import drifting, implausible, in_both, of_motion


class Shaking(NamedTuple):
    """Accelerations of the ground by component."""

    name: str
    files: list[str]  # that were read
    interval: float  # s
    components: dict[str, np.ndarray]  # each (n,) m/s2
    warnings: tuple[str, ...] = ()  # what a user of the scene should know


def read_shaking(path: Path, overrides: Mapping[str, Any], unit: Unit | None) -> Shaking:
    """The shaking in a record as it is, or in a scene (YAML or trajectory) over its duration, processed and scaled, by the ending.

    ValueError for a file that is neither, for overrides of a record and a unit of a scene.
    """
    if path.suffix.lower() in RECORDS:
        if overrides:
            raise ValueError(f"{path}: is a record and has no keys to set (found {', '.join(overrides)})")
        interval, _, columns = read_even(str(path), unit)
        components = dict(zip(("horizontal", "vertical"), columns, strict=False))
        motion = GroundMotion(interval * np.arange(columns[0].size), columns[0])
        found = implausible(components, "the unit of the record") + drifting(motion, "the record, or motion.baseline of a scene with it")
        name = os.fsencode(path.name).decode("utf-8", "replace")
        return Shaking(name, [str(path)], interval, components, tuple(diagnostic.sentence() for diagnostic in found))
    if unit is not None:
        raise ValueError(f"--unit {unit}: {path} is no record; --set motion.unit={unit} gives the unit of a scene's record")
    scene, files = read_given(path, overrides)
    loading = loading_of(scene)
    components = {"horizontal": loading.ground} | ({"vertical": loading.vertical} if loading.vertical.any() else {})
    heed = tuple(diagnostic.sentence() for diagnostic in of_motion(scene))
    return Shaking(scene.name, files, float(loading.time[1]), components, heed)


def measures(shaking: Shaking) -> dict[str, Measures]:
    """Measures by component."""
    return {name: measure(values, shaking.interval) for name, values in shaking.components.items()}


def rows(found: Mapping[str, Measures]) -> list[list[str]]:
    """Rows of text: measure, then its value for every component."""
    texts = {
        "peak acceleration (PGA)": [in_both(m.peak_acceleration) for m in found.values()],
        "peak velocity (PGV)": [f"{m.peak_velocity:.4g} m/s" for m in found.values()],
        "peak displacement (PGD)": [f"{m.peak_displacement:.4g} m" for m in found.values()],
        "Arias intensity": [f"{m.arias_intensity:.4g} m/s" for m in found.values()],
        "significant duration D5-75": [f"{m.duration_5_75:.4g} s" for m in found.values()],
        "significant duration D5-95": [f"{m.duration_5_95:.4g} s" for m in found.values()],
        "velocity at the end": [f"{m.final_velocity:.2g} m/s" for m in found.values()],
    }
    return [[name, *values] for name, values in texts.items()]
