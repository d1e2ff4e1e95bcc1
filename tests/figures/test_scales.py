"""The second scale of an acceleration."""

from __future__ import annotations

import numpy as np
import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from sph.figures.ground_motion import figure_ground_motion
from sph.figures.style import also_in_g
from sph.scene.units import GRAVITY


@pytest.mark.parametrize("kind", ["linear", "log"])
@pytest.mark.parametrize("axis", ["x", "y"])
def test_an_acceleration_is_shown_in_g_as_well(axis: str, kind: str) -> None:
    figure = Figure()
    ax = figure.subplots()
    ax.set(xscale=kind, yscale=kind, xlim=(1.0, 2.0 * GRAVITY), ylim=(1.0, 2.0 * GRAVITY))
    scale = also_in_g(ax, axis)  # type: ignore[arg-type]
    FigureCanvasAgg(figure).draw()
    assert scale.get_label_text() == "(g)"
    assert np.sort(scale.get_view_interval()) == pytest.approx([1.0 / GRAVITY, 2.0]) and scale.get_scale().endswith("log") == (
        kind == "log"
    )


def test_a_ground_motion_is_drawn_in_both() -> None:
    figure = figure_ground_motion({"record": np.sin(np.arange(400) / 10.0)}, 0.01)
    found = {ax.get_ylabel(): [child.get_ylabel() for child in ax.child_axes] for ax in figure.axes}
    assert [label for label, children in found.items() if children == ["(g)"]] == [
        "acceleration\n(m/s²)",
        "pseudo-spectral acceleration (m/s²)",
    ]
