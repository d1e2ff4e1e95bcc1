"""V24: a slope of brittle soil under a sine much slower than its natural period, the dynamic counterpart of V22."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from cases.case import Case, Found, Kind, Level, Quantity, at_spacings
from cases.slopes import SEISMIC_BOUNDS
from sph.figures.style import WIDTH, styled
from sph.scene.gravity import FAILED_AREA, GRAVITY
from sph.scene.motion import reference_amplitude
from sph.scene.schema import Scene
from sph.stability.standing import displacements, slope_height

COLLAPSE = 0.1
"""Displacement over the slope's height H from which on soil has gone, as that of the class ``collapse``: brittle soil moves by less than
0.01 H, or by far more."""
LIMIT = sum(SEISMIC_BOUNDS["dry"]) / 2.0
"""Middle of the bounds of the critical seismic coefficient k_c of the dry slope (Loukidis, Bandini and Salgado 2003)."""


def collapsed(scene: Scene, data: xr.Dataset) -> bool:
    """Whether soil that has moved by more than ``COLLAPSE`` H since the gravity stage covers more than ``FAILED_AREA`` H2."""
    height = slope_height(scene)
    gone = np.count_nonzero(displacements(data, scene.gravity.duration) > COLLAPSE * height)
    return bool(gone * scene.numerics.spacing**2 > FAILED_AREA * height**2)


def limit_between(values: np.ndarray, gone: np.ndarray) -> float:
    """Middle between the largest value (n,) at which a slope stands and the smallest at which it has ``gone`` (n,), in the values' unit.

    NaN where it stands at all of them, at none, or at one above another at which it goes.
    """
    if gone.all() or not gone.any() or values[~gone].max() > values[gone].min():
        return math.nan
    return 0.5 * float(values[~gone].max() + values[gone].min())


def _ladder(level: Level) -> tuple[np.ndarray, np.ndarray]:
    """Amplitudes over g (n,) of a level's runs and which collapsed (n,)."""
    rows = [(reference_amplitude(result.scene.motion) / GRAVITY, collapsed(result.scene, result.data)) for result in level.values()]
    return np.array([k for k, _ in rows]), np.array([gone for _, gone in rows])


def measure_slow_sine(level: Level) -> dict[str, Found]:
    """Amplitude over g at which the slope collapses, beside its critical seismic coefficient."""
    return {"slow_sine": Found("amplitude of a sine of 8 natural periods over g", "1", limit_between(*_ladder(level)), LIMIT)}


@styled
def draw_slow_sine(levels: Mapping[str, Level]) -> Figure:
    """Largest displacement of the soil over H against the amplitude of the slow sine over g; hollow where the slope stands.

    The band lies between the bounds of the critical seismic coefficient.
    """
    figure = Figure(figsize=(0.65 * WIDTH, 2.9), layout="constrained")
    ax = figure.subplots()
    ax.axvspan(*SEISMIC_BOUNDS["dry"], color="0.85", linewidth=0.0)
    for marker, level in zip("os^", levels.values(), strict=False):
        values, gone = _ladder(level)
        each = level.values()
        moved = np.array([displacements(run.data, run.scene.gravity.duration).max() / slope_height(run.scene) for run in each])
        for verdict, face in ((gone, "black"), (~gone, "white")):
            ax.plot(values[verdict], moved[verdict], linestyle="", marker=marker, markersize=4, color="black", markerfacecolor=face)
    ax.set(xlabel="amplitude over g", ylabel="largest displacement over H", yscale="log")
    return figure


V24 = Case(
    title="Brittle soil under a slow sine",
    scene="config/scenes/validation/v24_slow_sine.yaml",
    source=(
        "pseudo-static limit: the slope goes where the peak of a slow sine is k_c g, of the bounds by Loukidis, Bandini and Salgado "
        "(2003), 0.423 to 0.454"
    ),
    reference="published",
    ours="stiffness, loss of strength, motion, what counts as collapse, and the middle of the bounds as reference",
    measure=measure_slow_sine,
    draw=draw_slow_sine,
    # A ladder of amplitudes; what is compared is the middle between the largest that stands and the smallest that collapses.  One run of
    # this soil had been seen before the tolerance was written: with 0.42 g the slope stood.  With slips of 2 and 20 mm it had gone at
    # 0.35 g.
    runs={f"k_{per_cent}": {"motion": {"amplitude": f"0.{per_cent}g"}} for per_cent in range(38, 51, 2)},
    levels={"2.5 m": {}, **at_spacings({"1.25 m": 1.25})},
    quantities={
        "slow_sine": Quantity(
            Kind.CRITICAL_AMPLITUDE,
            0.073,
            0.073,
            "5 % for inertia and for the cycles that slip takes, and half a step of the ladder, 2.3 %",
        )
    },
)
