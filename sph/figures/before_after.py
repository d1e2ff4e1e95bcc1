"""A slope before and after a run."""

from __future__ import annotations

from collections.abc import Mapping
from textwrap import fill

from matplotlib.figure import Figure

from sph.figures.arrangement import LEGEND_LINE, draw_ground, draw_layers, draw_seams, draw_water, layer_legend
from sph.figures.profile import OUTSIDE, draw_places, draw_profile, field_norm, frame_limits, mark_probes, survey_axes
from sph.figures.style import WIDTH, plain, styled
from sph.measures.fields import FIELDS, with_end
from sph.measures.places import PlaceAt
from sph.output.run import Run

TITLE = 60
"""Most characters in a line of a title over the width of the figure."""
STEEP = 0.3
"""Height over width of a section from which on both stand side by side."""


@styled
def figure_before_after(run: Run, title: str, places: Mapping[str, PlaceAt] | None = None) -> Figure:
    """The section before the shaking with its layers, seams and water, and the soil at the end of the run, coloured by its displacement
    since the gravity stage.  Rings are the particles that are followed, posts the places that debris may reach.

    ``title`` names the run, ``places`` are as in ``metrics.places``.
    """
    scene = run.scene
    left, right, lower, upper = limits = frame_limits(run, -1)
    steep = (upper - lower) / (right - left) > STEEP
    panel = (WIDTH - 1.6) * (upper - lower) / (right - left) / (2 if steep else 1)
    height = (1 if steep else 2) * (max(panel, 0.6) + OUTSIDE) + LEGEND_LINE * len(scene.soils) + 0.5
    figure = Figure(figsize=(WIDTH, height), layout="compressed")
    before, after = figure.subplots(*((1, 2) if steep else (2, 1)), sharex=True, sharey=True)
    draw_layers(before, scene)
    draw_ground(before, scene)
    draw_seams(before, scene)
    draw_water(before, scene, named=True)
    norm = field_norm({title: run}, "displacement", -1)
    circles = draw_profile(after, run, -1, "displacement", norm)
    for ax, frame in ((before, run.gravity_frame), (after, -1)):
        mark_probes(ax, run, frame)
        draw_places(ax, scene, places or {})
        survey_axes(ax, scene, limits)
        ax.label_outer()
    before.set_title("Before", loc="left")
    after.set_title(plain(fill(f"After: {with_end(title, run)}", TITLE // 2 if steep else TITLE)), loc="left")
    figure.colorbar(circles, ax=after, label=f"displacement ({FIELDS['displacement'].units})", pad=0.015, fraction=0.03)
    layer_legend(figure, scene)
    return figure
