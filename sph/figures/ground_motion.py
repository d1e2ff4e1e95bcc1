"""A ground motion: acceleration, velocity, displacement, growth of the Arias intensity, and response spectrum."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from matplotlib.figure import Figure

from sph.figures.style import LINE_STYLES, WIDTH, also_in_g, curve_colours, label_panels, plain, styled, write_note
from sph.scene.ground_motion.measures import arias_share
from sph.scene.ground_motion.processing import integral
from sph.scene.ground_motion.spectrum import DAMPING, PERIODS, pseudo_acceleration

MIN_RANGE = 30.0
"""Least ratio of the ends of the axis of a spectrum."""
LABELS = ("acceleration\n(m/s²)", "velocity\n(m/s)", "displacement\n(m)", "share of Arias\nintensity (%)")


@styled
def figure_ground_motion(components: Mapping[str, np.ndarray], interval: float, note: str = "") -> Figure:
    """Histories of accelerations (n,) in m/s2 every ``interval`` seconds, by name, and their spectra at 5 % damping.

    Velocity and displacement are those of a ground at rest at the start.  Raises ValueError where nothing moves.
    """
    if not any(values.any() for values in components.values()):
        raise ValueError("motion: the ground does not move, so there is nothing to draw")
    figure = Figure(figsize=(WIDTH, 4.8), layout="constrained")
    axes = figure.subplot_mosaic([[label, "spectrum"] for label in LABELS], width_ratios=[1.25, 1.0])
    colours = curve_colours(len(components))
    for number, (name, acceleration) in enumerate(components.items()):
        look = {"color": colours[number], "linestyle": LINE_STYLES[number], "linewidth": 0.9, "label": name, "zorder": 3 - number}
        time, velocity = interval * np.arange(acceleration.size), integral(acceleration, interval)
        histories = (acceleration, velocity, integral(velocity, interval), 100.0 * arias_share(acceleration))
        for label, history in zip(LABELS, histories, strict=True):
            axes[label].plot(time, history, **look)
        axes["spectrum"].plot(PERIODS, pseudo_acceleration(acceleration, interval), **look | {"linewidth": 1.4})
    for label in LABELS:
        axes[label].set(ylabel=label, xlim=(0.0, time[-1]))
        axes[label].axhline(0.0, color="0.6", linewidth=0.5, zorder=1)
        axes[label].tick_params(labelbottom=label == LABELS[-1])
    axes[LABELS[-1]].set(xlabel="time (s)", ylim=(0.0, 103.0), yticks=[0, 50, 100])
    axes["spectrum"].set(xscale="log", yscale="log", xlabel="period (s)", ylabel="pseudo-spectral acceleration (m/s²)")
    axes["spectrum"].set_xlim(PERIODS[0], PERIODS[-1])
    for axis in (axes["spectrum"].xaxis, axes["spectrum"].yaxis, also_in_g(axes["spectrum"], "y")):
        axis.set_major_formatter("{x:g}")
        axis.set_minor_formatter("")
    bottom, top = axes["spectrum"].get_ylim()
    axes["spectrum"].set_ylim(min(bottom, top / MIN_RANGE), top)
    axes["spectrum"].grid(which="both", color="0.9", linewidth=0.4)
    also_in_g(axes[LABELS[0]], "y")
    if len(components) > 1:
        axes["spectrum"].legend(loc="lower left")
    figure.align_ylabels([axes[label] for label in LABELS])
    label_panels((axes[LABELS[0]], axes["spectrum"]), ("histories", f"response spectrum, {100 * DAMPING:g} % damping"))
    write_note(figure, plain(note))
    return figure
