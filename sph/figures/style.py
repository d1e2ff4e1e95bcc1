"""What all figures share: sizes, fonts, colours, the note of provenance, saving."""

from __future__ import annotations

import functools
import math
from collections.abc import Callable, Iterable
from pathlib import Path
from textwrap import fill
from typing import Any, Literal, ParamSpec

import matplotlib
import numpy as np
from cmcrameri import cm as crameri
from matplotlib.axes import Axes
from matplotlib.axis import Axis
from matplotlib.colors import Colormap, ListedColormap, Normalize
from matplotlib.figure import Figure

from sph.figures.labels import keep_apart
from sph.scene.schema import Scene
from sph.scene.units import GRAVITY
from sph.storage.files import whole

WIDTH = 180 / 25.4
"""Width of a figure across a journal page, inches."""
DPI = 200
"""Dots per inch of PNG figures."""

NOTHING, AT_LEAST, OPEN = "–", "≥ ", " ?"
"""Stands for what is not known; before a lower bound; behind one of nothing."""
LEAST = 0.01
"""Least length that is told, m: no spacing resolves less."""
GREY = "0.45"
SHAKING = "0.92"
"""Shade of the interval of shaking."""

STYLE: Any = {
    "font.family": "sans-serif",
    "font.size": 8.5,
    "axes.titlesize": 9,
    "axes.labelsize": 8.5,
    "xtick.labelsize": 8,
    "ytick.labelsize": 8,
    "legend.fontsize": 8,
    "axes.linewidth": 0.6,
    "xtick.major.width": 0.6,
    "ytick.major.width": 0.6,
    "lines.linewidth": 1.4,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "legend.frameon": False,
    "pdf.fonttype": 42,
}

LINE_STYLES: tuple[Any, ...] = ("-", (0, (5, 1.5)), (0, (5, 1.5, 1, 1.5)), (0, (1, 1.2)), (0, (8, 2, 2, 2)), (0, (3, 1, 1, 1, 1, 1)))
"""Curves differ by these as well as by colour, for print and for colour-blind readers."""

P = ParamSpec("P")


def styled(draw: Callable[P, Figure]) -> Callable[P, Figure]:
    """Draw a figure in the common style, its names of places apart, without touching matplotlib's settings outside."""

    @functools.wraps(draw)
    def drawn(*args: P.args, **kwargs: P.kwargs) -> Figure:
        with matplotlib.rc_context(STYLE):
            figure = draw(*args, **kwargs)
            keep_apart(figure)
            return figure

    return drawn


def colour_map(name: str = "batlow") -> Colormap:
    """A scientific colour map, by its name."""
    return getattr(crameri, name)


PALEST = 0.82
"""Part of the colour map after which soil would not show on paper."""


def soil_colours() -> Colormap:
    """The scientific colour map of soil, without colours that are too pale for debris on paper."""
    return ListedColormap(colour_map()(np.linspace(0.0, PALEST, 256)))


def curve_colours(count: int) -> list[Any]:
    """Distinct colours from dark to light, without those that a printer would leave too pale: a contrast with paper of three at least."""
    span = Normalize(0, max(count - 1, 1))
    return [colour_map()(0.6 * span(i)) for i in range(count)]


def class_colours() -> list[Any]:
    """A colour per class, from harmless (light) to collapse (dark)."""
    return [colour_map("lajolla_r")(at) for at in (0.04, 0.25, 0.5, 0.78)]


def note_text(scene: Scene) -> str:
    """Scene, resolution, walls, solid state of failed soil and duration in one line."""
    numerics = scene.numerics
    parts = [
        f"scene {scene.name}",
        f"spacing {numerics.spacing:.4g} m",
        f"kernel support {2 * numerics.smoothing_length:.4g} m",
        f"{scene.walls.sides.replace('_', '-')} side walls",
        f"failed solid {scene.coupling.solid_after_failure.replace('_', '-')}",
        f"{scene.duration:g} s" if scene.early_stop is None else f"until at rest, {scene.duration:g} s at most",
    ]
    return " · ".join(parts)


def add_note(figure: Figure, scenes: Iterable[Scene], fidelity: str = "") -> None:
    """Small grey note at the lower right: where the figure comes from.  Different scenes all appear, a line each."""
    notes = list(dict.fromkeys(note_text(scene) for scene in scenes))
    prefix = f"fidelity {fidelity} · " if fidelity else ""
    write_note(figure, prefix + "\n".join(notes))


def write_note(figure: Figure, text: str) -> None:
    """Small grey text at the lower right, in more lines than one where the figure is too narrow."""
    figure.supxlabel(text, x=0.995, ha="right", fontsize=6, color=GREY, wrap=True)


def plain(text: str) -> str:
    """Text in which '$' does not begin a formula."""
    return text.replace("$", r"\$")


def written(text: str) -> str:
    """Text as it is set in figures: '$' does not begin a formula, S_R has its subscript."""
    return plain(text).replace("S_R", "$S_R$")


def label_panels(axes: Iterable[Axes], titles: Iterable[str], width: int = 100) -> None:
    """(a), (b), ... and a title at the left above each panel, in lines of at most ``width`` characters; a single panel gets no letter."""
    pairs = list(zip(axes, titles, strict=True))
    for number, (ax, title) in enumerate(pairs):
        letter = f"({chr(ord('a') + number)}) " if len(pairs) > 1 else ""
        ax.set_title("\n".join(fill(line, width) for line in f"{letter}{title}".split("\n")), loc="left")


def also_in_g(ax: Axes, axis: Literal["x", "y"]) -> Axis:
    """A second scale, in g, opposite an axis that shows an acceleration in m/s2; it follows the first one's limits and kind."""
    functions = (_in_g, _in_metres)
    scale: Axis = (
        ax.secondary_xaxis("top", functions=functions).xaxis if axis == "x" else ax.secondary_yaxis("right", functions=functions).yaxis
    )
    scale.axes.spines[scale.get_label_position()].set_visible(True)
    scale.set_label_text("(g)")
    return scale


def _in_g(acceleration: Any) -> Any:
    return acceleration / GRAVITY


def _in_metres(multiple: Any) -> Any:
    return multiple * GRAVITY


def save(figure: Figure, *paths: Path | str) -> None:
    """Save a figure to each path (PNG at 200 dpi, PDF, SVG by the suffix); files appear whole or not at all."""
    for path in map(Path, paths):
        kind = path.suffix[1:]
        undated = {"pdf": {"CreationDate": None}, "svg": {"Date": None}}.get(kind)
        with whole(path) as temporary, matplotlib.rc_context(STYLE):
            figure.savefig(temporary, dpi=DPI, metadata=undated, format=kind)


def metres(value: float, bounded: bool = False) -> str:
    """A length in m, to three digits or a millimetre, below ``LEAST`` as that, or that it may be more where it is ``bounded``;
    that of a block which never stops has no end."""
    if bounded and not math.isnan(value):
        return AT_LEAST + metres(value) if abs(value) >= LEAST else metres(value) + OPEN
    if value == math.inf:
        return "unlimited"
    if math.isnan(value):
        return NOTHING
    digits = 3 if abs(value) < 1 else 2 if abs(value) < 10 else 1
    return f"{value:.{digits}f}" if abs(value) >= LEAST else f"< {LEAST:g}" if value else "0"
