"""Shear tests: stress against slip with the fitted curves, and the strength against the normal stress."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import numpy as np
from matplotlib.figure import Figure

from sph.figures.style import GREY, LINE_STYLES, WIDTH, curve_colours, label_panels, plain, styled


@styled
def figure_shear_tests(
    tests: Mapping[str, tuple[np.ndarray, np.ndarray]],
    fits: Mapping[str, Mapping[str, tuple[np.ndarray, np.ndarray]]],
    points: Sequence[tuple[float, float, float]] = (),
    lines: Sequence[tuple[float, float]] = (),
) -> Figure:
    """Stresses (kPa) of tests against slip (m), the fits of each shape from the best on, and peak and residual strength.

    ``points`` are normal stress, peak and residual stress of the tests (kPa), ``lines`` cohesion (kPa) and friction angle (degree) of
    both; without them there is one panel.
    """
    figure = Figure(figsize=(WIDTH, 3.2), layout="constrained")
    panels = 2 if lines else 1
    axes = figure.subplots(1, panels, squeeze=False, width_ratios=[1.6, 1.0][:panels])[0]
    for number, (name, colour) in enumerate(zip(tests, curve_colours(len(tests)), strict=True)):
        slip, stress = tests[name]
        marker = "osd^v<>p"[number % 8]
        axes[0].plot(1e3 * slip, stress, marker, color=colour, markersize=3.5, markerfacecolor="none", label=plain(name))
        for (shape, curves), style in zip(fits.items(), LINE_STYLES, strict=False):
            at, fitted = curves[name]
            axes[0].plot(
                1e3 * at, fitted, color=colour, linestyle=style, linewidth=1.0, label=f"{shape} fit" if number == len(tests) - 1 else None
            )
    axes[0].set(xlabel="slip (mm)", ylabel="shear stress (kPa)", ylim=(0.0, None))
    axes[0].legend()
    if lines:
        normal, *strengths = np.array(points).T
        along = np.array([0.0, 1.1 * normal.max()])
        for name, strength, (cohesion, angle), style in zip(("peak", "residual"), strengths, lines, LINE_STYLES, strict=False):
            axes[1].plot(normal, strength, "o" if name == "peak" else "s", color="black", markersize=3.5, markerfacecolor="none")
            label = f"{name}: {cohesion:.1f} kPa, {angle:.1f}°"
            axes[1].plot(along, cohesion + along * math.tan(math.radians(angle)), color=GREY, linestyle=style, linewidth=1.0, label=label)
        axes[1].set(xlabel="normal stress (kPa)", ylabel="shear strength (kPa)", xlim=(0.0, along[1]), ylim=(0.0, None))
        axes[1].legend()
    label_panels(axes, ("loss of strength with slip", "strength")[: axes.size])
    return figure
