"""Quantities of a frame that metrics and figures share."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from sph.measures.mobilised import mobilised
from sph.output.run import Run
from sph.scene.names import check_known
from sph.scene.schema import Scene
from sph.storage.trajectory import Status


def with_end(name: str, run: Run) -> str:
    """A name for figures, with the time at which the guard stopped the run, or with the remark that the slope fails without shaking."""
    ends = {Status.DIVERGED: f"diverged at {float(run['sample_time'][-1]):.3g} s", Status.FAILED_UNSHAKEN: "fails without shaking"}
    return ", ".join(filter(None, (name, ends.get(run.attrs["status"]))))


class Field(NamedTuple):
    """A particle field that can be plotted: label, unit and how it follows from a frame."""

    label: str
    units: str
    of: Callable[[Run, int], np.ndarray]


def check_probe(probe: str, scene: Scene, where: str) -> None:
    """ValueError beginning with ``where`` for a probe to be measured that a scene lacks."""
    if probe not in scene.probes:
        known = ", ".join(scene.probes) or "none"
        raise ValueError(
            f"{where}: metrics.probe: {probe!r} is not one of the scene's probes ({known}); name one of these in the study's metrics, or "
            f"add {probe} to the scene's probes, as A: crest_edge, beside the others"
        )


def _speed(run: Run, frame: int) -> np.ndarray:
    return np.hypot(run["velocity_x"][frame], run["velocity_y"][frame])


def _mean_pressure(run: Run, frame: int) -> np.ndarray:
    return -1e-3 * sum(run[f"stress_{axes}"][frame] for axes in ("xx", "yy", "zz")) / 3.0


def _pressure_ratio(run: Run, frame: int) -> np.ndarray:
    """That of a run without excess pore pressure is 0 everywhere."""
    return run["pore_pressure_ratio"][frame] if "pore_pressure_ratio" in run.stored else np.zeros(run["y0"].shape)


LAYER = "layer"
"""The field whose values are numbers of layers: 0 is the scene's own soil."""

FIELDS: dict[str, Field] = {
    LAYER: Field("layer", "-", lambda run, frame: run["layer"].astype(float)),
    "failed": Field("failed soil: 1", "-", lambda run, frame: run["failed"][frame].astype(float)),
    "initial_height": Field("initial elevation", "m", lambda run, frame: run["y0"] + run.scene.geometry.origin[1]),
    "displacement": Field("displacement since the gravity stage", "m", lambda run, frame: np.hypot(*run.displacement(frame))),
    "speed": Field("speed relative to the box", "m/s", _speed),
    "beta": Field("weight of the solid state β", "-", lambda run, frame: run["beta"][frame]),
    "pressure": Field("mean pressure", "kPa", _mean_pressure),
    "pore_pressure_ratio": Field("excess pore pressure ratio r_u", "-", _pressure_ratio),
    "mobilised": Field("mobilised share of the peak strength", "-", mobilised),
}

SHARES = ("beta", "pore_pressure_ratio")
"""Fields between 0 and 1 that runs store, under the same names, and the page's explorer can show in the colours of the soil."""


def check_field(name: str) -> None:
    """ValueError for a name that ``FIELDS`` lacks."""
    check_known("field", [name], FIELDS)
