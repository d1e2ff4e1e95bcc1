"""The runs as the page holds them: positions of the soil over time, quantised, and the motion of the probe.

Positions are whole numbers of a quantum (``QUANTA`` to a spacing) from the middle of the picture, 16 bit, of which each frame holds the
difference from the one before; these and the fields ``sph.measures.fields.SHARES``, 8 bit, are compressed (zlib) and written in base64.
What is not a number or lies outside the range is ``LOST``.  Frames begin at the end of the gravity stage, from which displacements count.
"""

from __future__ import annotations

import base64
import zlib
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from matplotlib.colors import to_hex

from sph.checks.after_run import liquefied
from sph.checks.messages import sentence
from sph.figures.profile import frame_limits, layer_outlines, surface_line
from sph.figures.style import soil_colours
from sph.measures.fields import FIELDS, SHARES
from sph.measures.places import PlaceAt, foot_of
from sph.output.run import Run
from sph.scene.geometry import SLOPES
from sph.scene.ground_line import GroundLine
from sph.scene.motion import NoMotion
from sph.scene.strict_json import to_json
from sph.storage.trajectory import Status

QUANTA = 200
"""Quanta to a spacing."""
LOST = -(2**15)
"""Stands for a position that is not a number or outside the range."""
RANGE = 2**15 - 1
SAMPLES = 150
"""Intervals of the curve of the probe."""
COLOURS = 64
"""Colours of the scale."""


class Quanta(NamedTuple):
    """The grid of positions."""

    middle: np.ndarray  # (2,) m
    size: float  # m


class Detail(NamedTuple):
    """Which frames and particles of a run are kept."""

    frames: int | None  # every n-th frame, counted back from the last; None: the first and the last
    particles: int  # every n-th particle

    def words(self) -> str:
        """The rule in words."""
        frames = {1: "every stored frame", None: "the first and the last frame"}.get(self.frames, f"one in {self.frames} stored frames")
        return f"{frames}, {'every particle' if self.particles == 1 else f'one in {self.particles} particles'}"


DETAILS = tuple(Detail(frames, 1) for frames in (1, 2, 4, 8, None)) + tuple(Detail(None, 2**n) for n in range(1, 8))
"""From all to little: the first with which the runs fit into the page is taken."""


def explorer(
    paths: Sequence[Path | str],
    probe: str,
    room: int,
    places: Mapping[str, PlaceAt] | None = None,
    read: Callable[[Path | str], Run] = Run.read,
) -> dict[str, Any]:
    """What the page needs to draw the runs of a study and its ``places``, as JSON in at most ``room`` characters.

    Files are ``read`` one at a time, again for every detail that is tried.  ``runs`` is empty if even the least detail takes more.  Raises
    ValueError for a file that is not a run and a probe that it lacks.
    """
    first = read(paths[0])
    surroundings, limits = surroundings_of(first, places), np.array(frame_limits(first, 0))
    shared = surroundings | {
        "probe": probe,
        "colours": [to_hex(colour) for colour in soil_colours()(np.linspace(0.0, 1.0, COLOURS))],
    }
    room -= _size(shared)
    for detail in DETAILS:
        runs = list(_within(room, (run_data(read(path), probe, detail, surroundings, places) for path in paths)))
        if len(runs) == len(paths):
            break
    else:
        runs = []
    seen = np.array([limits, *(run["limits"] for run in runs if run["limits"])])
    return shared | {
        "detail": detail.words() if runs else "no drawing",
        "stride": detail.particles,
        "left": seen[:, 0].min(),
        "right": seen[:, 1].max(),
        "lower": seen[:, 2].min(),
        "upper": seen[:, 3].max(),
        "shares": {name: FIELDS[name].label for name in SHARES if any(name in run["shares"] for run in runs)},
        "start": min((run["times"][0] for run in runs), default=0.0),
        "end": max((run["times"][-1] for run in runs), default=0.0),
        "largest": max((run["largest"] for run in runs), default=0.0),
        "runs": runs,
    }


def surroundings_of(run: Run, places: Mapping[str, PlaceAt] | None = None) -> dict[str, Any]:
    """What is drawn around the soil, ``places`` with where they stand (m), the outlines of layers, the grid of its positions (``quantum``
    and ``middle``, m) and how these lie in the survey (``origin``, m, and ``direction``): the same for runs of one slope."""
    scene, geometry, limits = run.scene, run.scene.geometry, np.array(frame_limits(run, 0))
    low, high = limits[::2], limits[1::2]
    return {
        "spacing": scene.numerics.spacing,
        "quantum": max(scene.numerics.spacing / QUANTA, float(np.max(high - low)) / RANGE),
        "middle": (0.5 * (low + high)).tolist(),
        "surface": [corners.tolist() for corners in surface_line(scene)],
        "layers": [np.round(outline, 2).T.tolist() for outline in layer_outlines(scene)],
        "places": [[name.replace("_", " "), *foot_of(at, geometry)] for name, at in (places or {}).items()]
        if isinstance(geometry, SLOPES)
        else [],
        "box": [np.round(run[name][~run.soil], 3).tolist() for name in ("x0", "y0")],
        "origin": list(scene.geometry.origin),
        "direction": scene.geometry.direction,
        "upwards": "elevation (m)" if isinstance(scene.geometry, GroundLine) else "height (m)",
        "shaking": None if isinstance(scene.motion, NoMotion) else [scene.motion.start, scene.motion.end],
    }


def run_data(
    run: Run, probe: str, detail: Detail, shared: Mapping[str, Any], places: Mapping[str, PlaceAt] | None = None
) -> dict[str, Any]:
    """A run packed: ``times`` (s) of its frames, ``positions`` (frames, 2, particles) with the probe's particle first, ``shares``
    (frames, particles) of the fields ``SHARES`` that it stores, ``curve`` (3, samples): time (s), horizontal and vertical displacement (m)
    of the probe; ``limits`` (m) of the picture and ``largest`` displacement (m) of a particle, empty and 0 for a diverged run; ``reason``
    of its status; ``liquefied``: what of its layers has, in words; ``own``: its surroundings where they differ from the ``shared`` ones."""
    surroundings = surroundings_of(run, places)
    quanta = Quanta(np.array(surroundings["middle"]), surroundings["quantum"])
    history = run.history(probe)
    start, last = run.gravity_frame, run["time"].size - 1
    frames = np.array(sorted({start, last, *range(last, start, -(detail.frames or max(last, 1)))}))
    at = int(run["probe_particle"][run.probes.index(probe)])
    soil = np.flatnonzero(run.soil)
    shown = np.concatenate([[at], soil[soil != at][:: detail.particles]])
    positions = np.stack([run[name][np.ix_(frames, shown)].astype(float) for name in ("x", "y")], axis=1)
    shares = {name: np.nan_to_num(run[name][np.ix_(frames, shown)], nan=0.0) for name in SHARES if name in run.stored}
    every = slice(None, None, -max(1, (history.time.size - 1) // SAMPLES))
    curve = np.stack([values[every][::-1] for values in (history.time, history.displacement_horizontal, history.displacement_vertical)])
    diverged = run.status == Status.DIVERGED
    moved = np.hypot(*(positions - positions[0]).transpose(1, 0, 2))
    return {
        "limits": [] if diverged else np.round(frame_limits(run, -1), 3).tolist(),
        "largest": 0.0 if diverged else float(np.nanmax(moved)),
        "own": {name: value for name, value in surroundings.items() if value != shared[name]},
        "reason": str(run.attrs["status_reason"]),
        "liquefied": [sentence(found, keys=False) for found in liquefied(run)],
        "times": np.round(run["time"][frames], 6).tolist(),
        "particles": int(shown.size),
        "positions": packed(quantised(positions, quanta)),
        "shares": {name: packed(np.round(255 * np.clip(values, 0.0, 1.0)).astype(np.uint8)) for name, values in shares.items()},
        "curve": base64.b64encode(zlib.compress(curve.astype("<f4").tobytes(), 9)).decode(),
    }


def quantised(positions: np.ndarray, quanta: Quanta) -> np.ndarray:
    """Positions (frames, 2, particles) in m as whole numbers of quanta from the middle; ``LOST`` in both directions where one is lost."""
    with np.errstate(invalid="ignore"):
        numbers = np.round((positions - quanta.middle[:, None]) / quanta.size)
        inside = (np.abs(numbers) <= RANGE).all(axis=1, keepdims=True)  # false for NaN
    return np.where(inside, numbers, LOST).astype(np.int16)


def packed(values: np.ndarray) -> str:
    """Integers (frames, ...) as differences from frame to frame, wrapping around, compressed."""
    steps = np.diff(values, axis=0, prepend=np.zeros_like(values[:1]))
    return base64.b64encode(zlib.compress(steps.astype(values.dtype.newbyteorder("<")).tobytes(), 9)).decode()


def _within(room: int, runs: Iterator[dict[str, Any]]) -> Iterator[dict[str, Any]]:
    """Runs as long as they together stay within a number of characters."""
    for run in runs:
        room -= _size(run)
        if room < 0:
            return
        yield run


def _size(data: Any) -> int:
    return len(to_json(data))
