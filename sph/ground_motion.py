"""Ground motions as samples: records in files, and the motion of a scene."""

from __future__ import annotations

import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from sph.loading import make_loading
from sph.scene import Scene, load_scene

SCENES, RECORDS = (".yaml", ".yml"), (".csv",)
"""Endings of the files that hold a ground motion."""
LARGEST_RECORD = 100_000_000
"""Largest file of a record, bytes."""
LARGEST_TIME, LARGEST_ACCELERATION, SHORTEST_INTERVAL = 1e6, 1e6, 1e-9
"""Largest time (s) and acceleration (m/s2) of a record, either sign, and the shortest interval between its samples (s)."""
LONGEST_INTERVAL = 1e-3
"""Longest interval between the samples of a scene's motion, s."""


class GroundMotion(NamedTuple):
    """Horizontal acceleration of the ground, linear between the samples."""

    time: np.ndarray  # (n,) increasing, s
    acceleration: np.ndarray  # (n,) m/s2

    @property
    def peak(self) -> float:
        """Largest absolute acceleration, m/s2."""
        return float(np.abs(self.acceleration).max())

    def scaled(self, peak: float) -> GroundMotion:
        """The same motion with another peak (m/s2); raises ValueError unless both are positive and finite."""
        if self.peak == 0 or not 0 < peak < math.inf:
            raise ValueError(f"peak: {peak} m/s2 for a motion with {self.peak:g} m/s2; both must be positive and finite")
        return self._replace(acceleration=self.acceleration * (peak / self.peak))


def read_motion(path: Path | str, overrides: Mapping[str, Any] | None = None) -> GroundMotion:
    """Motion of a scene file, with nested overrides laid over it, or of a record; the ending tells which."""
    path = Path(path)
    ending = path.suffix.lower()
    if ending in SCENES:
        return motion_of(load_scene(path, overrides))
    if ending not in RECORDS:
        raise ValueError(f"{path}: must be a scene ({', '.join(SCENES)}) or a record ({', '.join(RECORDS)})")
    if overrides:
        raise ValueError(f"{path}: is a record and has no keys to set (found {', '.join(overrides)})")
    return read_record(path)


def motion_of(scene: Scene) -> GroundMotion:
    """A scene's motion over its duration, at the time steps or parts of them no longer than ``LONGEST_INTERVAL``."""
    loading = make_loading(scene, substeps=math.ceil(scene.numerics.time_step / LONGEST_INTERVAL - 1e-9))
    return GroundMotion(loading.time, loading.ground)


def read_record(path: Path | str) -> GroundMotion:
    """Record in a CSV file: lines of time (s) and acceleration (m/s2), after at most one line of names.

    Raises ValueError with file, line and what is expected.
    """
    try:
        with Path(path).open("rb") as file:
            text = file.read(LARGEST_RECORD + 1)
        if len(text) > LARGEST_RECORD:
            raise ValueError(f"it is larger than {LARGEST_RECORD:,} bytes")
        lines = text.decode("utf-8-sig").splitlines()
    except (OSError, ValueError) as error:
        raise ValueError(f"{path}: cannot be read as text: {error}") from error
    samples: list[tuple[float, float]] = []
    for number, line in enumerate(lines, 1):
        cells = [_number(cell) for cell in line.split(",")]
        if not line.strip() or (number == 1 and not any(cell is not None for cell in cells)):
            continue
        where = f"{path}, line {number}"
        if len(cells) != 2:
            raise ValueError(f"{where}: must have 2 columns, time (s) and acceleration (m/s2), has {len(cells)} (found {line[:80]!r})")
        time, acceleration = cells
        if time is None or acceleration is None or not math.isfinite(time) or not math.isfinite(acceleration):
            raise ValueError(f"{where}: must be two finite numbers, time (s) and acceleration (m/s2) (found {line[:80]!r})")
        if abs(time) > LARGEST_TIME or abs(acceleration) > LARGEST_ACCELERATION:
            raise ValueError(f"{where}: must not exceed {LARGEST_TIME:g} s and {LARGEST_ACCELERATION:g} m/s2 (found {line[:80]!r})")
        if samples and not time - samples[-1][0] >= SHORTEST_INTERVAL:
            raise ValueError(
                f"{where}: time {time} s must be greater than {samples[-1][0]} s before it, by {SHORTEST_INTERVAL:g} s at least"
            )
        samples.append((time, acceleration))
    if len(samples) < 2:
        raise ValueError(f"{path}: must hold at least two samples of time (s) and acceleration (m/s2) (found {len(samples)})")
    return GroundMotion(*np.array(samples).T)


def _number(text: str) -> float | None:
    try:
        return float(text)
    except ValueError:
        return None
