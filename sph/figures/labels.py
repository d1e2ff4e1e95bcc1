"""Names at places of a section: none lies over another one or over the mark of another place."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import product
from typing import NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.text import Annotation, Text
from matplotlib.transforms import Bbox

NAME = "name at a place"
"""Marks such a name among the texts of a figure."""
MARK = 3.5
"""Half of the size of a mark, points."""
ASIDE, LEVEL, LEVELS = 5.0, 12.0, 4
"""Points by which a name stands aside of its mark, points to the level above, and how many of these there are."""
LEADER = {"arrowstyle": "-", "color": "0.3", "linewidth": 0.5, "shrinkA": 0.0, "shrinkB": MARK}
SIDES = {"left": 1, "center": 0, "right": -1}
"""Where a name of an alignment stands of its mark: right of it, above it, or left of it."""


def keep_apart(figure: Figure) -> None:
    """Move the names of a figure that would lie over something to the other side of their mark, or up by levels, with a leader."""
    sections = [ax for ax in figure.findobj(Axes) if isinstance(ax, Axes) and any(text.get_gid() == NAME for text in ax.texts)]
    if sections:
        figure.draw_without_rendering()
        for ax in sections:
            spread(ax)


def spread(ax: Axes) -> None:
    """The same of axes whose place in their figure is known."""
    names = [text for text in ax.texts if isinstance(text, Annotation) and text.get_gid() == NAME]
    names.sort(key=lambda name: name.get_rotation() != 90.0)  # those at posts have the least room
    others = [text for text in ax.findobj(Text) if isinstance(text, Text) and text not in names and text.get_text().strip()]
    taken = [text.get_window_extent() for text in others if text.get_visible()]
    marks = {name: _mark(ax, name) for name in names}
    for name in names:
        before = [*taken, *(mark for other, mark in marks.items() if other is not name and not _same(mark, marks[name]))]
        first = _Stand(*name.xyann, name.get_horizontalalignment(), name.get_verticalalignment(), False)
        tried = (first, *_others(name, first))
        stand = next((each for each in tried if not any(_over(_put(name, each), box) for box in before)), first)
        taken.append(_put(name, stand))
        if stand.led:
            ax.annotate("", name.xy, (stand.x, stand.y + 0.3 * LEVEL), textcoords="offset points", arrowprops=LEADER, zorder=5)


class _Stand(NamedTuple):
    """Where a name stands."""

    x: float  # from its place, points
    y: float
    side: str  # alignment
    level: str
    led: bool  # whether a leader joins it to its place


def _others(name: Annotation, first: _Stand) -> Iterator[_Stand]:
    """Where else a name may stand, the nearest first."""
    x, y = first.x, first.y
    if name.get_rotation() == 90.0:
        wide = _text(name).width * 72.0 / name.figure.dpi + 1.0
        for aside in (wide, -wide, 2.0 * wide, -2.0 * wide):
            yield _Stand(aside, y, "center", "bottom", False)  # its post leans
        return
    own = SIDES[first.side]
    sides = [side for side in ("left", "right") if SIDES[side] in (own, -own) or not own]
    sides.sort(key=lambda side: SIDES[side] != own)
    for level, side in product(range(LEVELS), sides):
        aside = SIDES[side] * (abs(x) or ASIDE)
        yield _Stand(aside, y + level * LEVEL, side, "bottom" if level else first.level, level > 0)


def _put(name: Annotation, stand: _Stand) -> Bbox:
    """Put a name where it is to stand; where it lies then."""
    name.xyann = (stand.x, stand.y)
    name.set(ha=stand.side, va=stand.level)
    return _text(name)


def _text(name: Annotation) -> Bbox:
    """Where a name lies, without its post."""
    name.get_window_extent()  # brings it to its offset
    return Text.get_window_extent(name)


def _mark(ax: Axes, name: Annotation) -> Bbox:
    """Where the mark of a name lies, a post with it."""
    x, y = ax.transData.transform(name.xy)
    half = MARK * name.figure.dpi / 72.0
    post = name.xyann[1] * name.figure.dpi / 72.0 if name.get_rotation() == 90.0 else half
    return Bbox([[x - half, y - half], [x + half, y + post]])


def _same(one: Bbox, other: Bbox) -> bool:
    return bool(np.abs(np.subtract(one.min, other.min)).max() < 1.0)


def _over(one: Bbox, other: Bbox) -> bool:
    return one.x0 < other.x1 and other.x0 < one.x1 and one.y0 < other.y1 and other.y0 < one.y1
