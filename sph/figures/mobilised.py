"""How near to its strength soil is when the gravity stage ends, before any shaking."""

from __future__ import annotations

import textwrap

from matplotlib.colors import Normalize
from matplotlib.figure import Figure

from sph.figures.profile import OUTSIDE, draw_profile, frame_limits
from sph.figures.style import WIDTH, add_note, colour_map, plain, styled
from sph.measures.fields import FIELDS
from sph.measures.mobilised import mobilised_by_layer
from sph.output.run import Run

MAX_LETTERS = 95
"""Most characters in a line of the title."""


@styled
def figure_mobilised(run: Run, fidelity: str = "") -> Figure:
    """Share of its peak strength that soil mobilises at the end of the gravity stage, before any shaking: the radius of the Mohr circle
    over that at yield.  The title gives each layer's mean over a disc half as wide as the slope is high, placed where it is largest."""
    scene, frame = run.scene, run.gravity_frame
    left, right, lower, upper = frame_limits(run, frame)
    panel = (WIDTH - 1.6) * (upper - lower) / (right - left)
    figure = Figure(figsize=(WIDTH, panel + OUTSIDE + 0.6), layout="compressed")
    ax = figure.subplots()
    circles = draw_profile(ax, run, frame, "mobilised", Normalize(0.0, 1.0), colour_map("lajolla_r"))
    shown = FIELDS["mobilised"]
    figure.colorbar(circles, ax=ax, label=textwrap.fill(f"{shown.label} ({shown.units})", 22), pad=0.015, fraction=0.03, aspect=20)
    shares = {scene.soil.name or name if name == "soil" else name: share for name, share in mobilised_by_layer(run, frame).items()}
    of_layers = ", ".join(f"{plain(name)} {100 * share:.0f} %" for name, share in shares.items())
    title = f"Strength mobilised under gravity alone, t = {float(run['time'][frame]):g} s: {of_layers}"
    ax.set_title("\n".join(textwrap.wrap(title, MAX_LETTERS)), loc="left")
    add_note(figure, [scene], fidelity)
    return figure
