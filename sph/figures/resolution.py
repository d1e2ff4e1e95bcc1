"""The cost-accuracy study of the scheme for one's own slopes: the figures of the other."""

from __future__ import annotations

from sph.figures.trade import figures_of

FIGURES = figures_of("resolution")
"""The figures of the experiment."""
