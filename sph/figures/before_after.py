"""A slope before and after a run."""

from __future__ import annotations

import math
from collections.abc import Mapping
from textwrap import fill

from matplotlib.figure import Figure

from sph.figures.arrangement import (
    LEGEND_LINE,
    draw_failed,
    draw_ground,
    draw_layers,
    draw_seams,
    draw_surfaces,
    draw_water,
    layer_legend,
    legend_columns,
)
from sph.figures.profile import (
    OUTSIDE,
    draw_places,
    draw_profile,
    field_norm,
    frame_limits,
    mark_probes,
    survey_axes,
    with_room,
)
from sph.figures.style import WIDTH, styled, written
from sph.measures.fields import with_end
from sph.measures.places import PlaceAt
from sph.output.run import Run
from sph.stability.slip_search import LimitEquilibrium

TITLE = 60
"""Most characters in a line of a title over the width of the figure."""
STEEP = 0.3
"""Height over width of a section from which on both stand side by side."""
NARROW, WIDE = 0.5 * WIDTH, 1.15 * WIDTH
"""Width of the picture on a phone and on a wide screen, inches."""


@styled
def figure_before_after(
    run: Run,
    title: str,
    places: Mapping[str, PlaceAt] | None = None,
    equilibrium: LimitEquilibrium | None = None,
    width: float = WIDTH,
) -> Figure:
    """The section before the shaking with its layers, seams and water, the critical slip surfaces and the soil that is to fail, and the
    soil at the end of the run, coloured by its displacement since the gravity stage.  Rings are the particles that are followed, posts the
    places that debris may reach.

    ``title`` names the run, ``places`` are as in ``metrics.places``, slip surfaces those of ``equilibrium``, ``width`` is in inches.  Both
    stand side by side in a wide figure of a steep section.
    """
    scene = run.scene
    left, right, lower, upper = frame_limits(run, -1)
    narrow = width <= NARROW
    steep = (upper - lower) / (right - left) > STEEP and not narrow
    across = (width - 1.6) / (2 if steep else 1)
    left, right, lower, upper = limits = with_room((left, right, lower, upper), scene, places or {}, across)
    panel = across * (upper - lower) / (right - left)
    height = (1 if steep else 2) * (max(panel, 0.6) + OUTSIDE) + 0.5
    figure = Figure(figsize=(width, height), layout="compressed")
    before, after = figure.subplots(*((1, 2) if steep else (2, 1)), sharex=True, sharey=True)
    draw_layers(before, scene)
    draw_ground(before, scene)
    draw_seams(before, scene)
    draw_water(before, scene, named=True)
    fails = draw_failed(before, run)
    shown = [*fails, *draw_surfaces(before, equilibrium)]
    figure.set_figheight(height + LEGEND_LINE * math.ceil((len(scene.soils) + len(shown)) / legend_columns(width, named=True)))
    norm = field_norm({title: run}, "displacement", -1)
    circles = draw_profile(after, run, -1, "displacement", norm)
    for ax, frame in ((before, run.gravity_frame), (after, -1)):
        mark_probes(ax, run, frame)
        draw_places(ax, scene, places or {})
        survey_axes(ax, scene, limits)
        ax.label_outer()
    before.set_title("Before, with the soil that will fail" if fails else "Before", loc="left")
    after.set_title(written(fill(f"After: {with_end(title, run)}", TITLE // 2 if steep or narrow else TITLE)), loc="left")
    figure.colorbar(circles, ax=after, label="displacement (m)", pad=0.015, fraction=0.03)
    layer_legend(figure, scene, more=shown, named=True)
    return figure
