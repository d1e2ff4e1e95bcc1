"""What of a figure lies over one another: texts, and legends over data."""

from __future__ import annotations

from itertools import combinations

from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.legend import Legend
from matplotlib.text import Text
from matplotlib.transforms import Bbox

SLACK = 1.0
"""Pixels by which boxes may touch."""


def overprints(figure: Figure) -> list[tuple[str, str]]:
    """Pairs of texts that lie over one another, texts that the edge of the figure cuts, and legends that lie over the field of an axes;
    slanted texts are left out."""
    canvas = FigureCanvasAgg(figure)
    canvas.draw()
    hidden = {item for ax in figure.findobj(Axes) if not ax.get_visible() for item in ax.findobj()}
    hidden |= {item for ax in figure.findobj(Axes) if not ax.axison for axis in (ax.xaxis, ax.yaxis) for item in axis.findobj()}
    every = [each for ax in figure.findobj(Axes) for each in (ax, *ax.child_axes)]
    for axis in (axis for ax in every for axis in (ax.xaxis, ax.yaxis)):  # numbers beyond its ends are not drawn
        low, high = sorted(axis.get_view_interval())
        ticks = [*axis.get_major_ticks(), *axis.get_minor_ticks()]
        slack = 1e-9 * (high - low)
        beyond = [tick for tick in ticks if not low - slack <= tick.get_loc() <= high + slack]
        hidden |= {label for tick in beyond for label in (tick.label1, tick.label2)}
    shown = [item for item in figure.findobj(Text) if item.get_visible() and item.get_text().strip() and item not in hidden]
    whole = figure.bbox
    boxes = [(item.get_text(), _within(item, canvas)) for item in shown if item.get_rotation() % 90.0 == 0.0]
    found = [(one, other) for (one, box), (other, beside) in combinations(boxes, 2) if _overlap(box, beside)]
    fields = [("field", ax.get_window_extent()) for ax in figure.axes if ax.get_visible() and not ax.get_label().startswith("<colorbar")]
    legends = [("legend", item.get_window_extent()) for item in figure.findobj(Legend)]
    found += [(one, "edge") for one, box in boxes if min(box.x0, box.y0) < -SLACK or max(box.x1 - whole.x1, box.y1 - whole.y1) > SLACK]
    return found + [(one, other) for one, box in legends for other, field in fields if _overlap(box, field)]


def _within(text: Text, canvas: FigureCanvasAgg) -> Bbox:
    return text.get_window_extent(canvas.get_renderer())


def _overlap(one: Bbox, other: Bbox) -> bool:
    return min(one.x1, other.x1) - max(one.x0, other.x0) > SLACK and min(one.y1, other.y1) - max(one.y0, other.y0) > SLACK
