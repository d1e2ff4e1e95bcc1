"""The paper's figures: the motion of particle A; the others are those of any study."""

from __future__ import annotations

from typing import Any

import matplotlib
import pytest
from matplotlib.figure import Figure
from synthetic import step_ramp, synthetic, translation

from sph.experiments.paper.figures import FIGURES, figure_gamma_histories, figure_strength_histories
from sph.figures import caption
from sph.figures.style import LINE_STYLES, written
from sph.output.run import Run


def axes(figure: Figure) -> Any:
    """The first panel, without the loose types of matplotlib's artists."""
    return figure.axes[0]


def texts(figure: Figure) -> str:
    """Every text in a figure."""
    return "\n".join(text.get_text() for text in figure.findobj(matplotlib.text.Text))


def test_every_figure_of_the_paper_has_a_function_and_a_caption() -> None:
    assert list(FIGURES) == [f"fig{number}" for number in range(1, 8)]
    for draw in FIGURES.values():
        assert len(caption(draw)) > 60 and "\n" not in caption(draw) and "ValueError" not in caption(draw)


def test_histories_show_the_vertical_displacement_named_and_told_apart_without_colour() -> None:
    runs = {f"S_R = {depth}": synthetic(translation(-1.0, -depth), step_ramp(4.0, 8.0)) for depth in (5.0, 3.0, 1.0)}
    figure = figure_strength_histories({"γ = 100": runs})
    ax = axes(figure)
    curves = ax.lines[:3]
    assert [curve.get_ydata()[-1] for curve in curves] == pytest.approx([-5.0, -3.0, -1.0])
    assert curves[0].get_xdata()[0] == pytest.approx(3.0)
    legend = ax.get_legend()
    assert legend is not None and [text.get_text() for text in legend.get_texts()] == [written(name) for name in runs]
    assert len({str(curve.get_linestyle()) + str(curve._dash_pattern) for curve in curves}) == 3
    band = ax.patches[0].get_extents().transformed(ax.transData.inverted())
    assert (band.x0, band.x1) == pytest.approx((3.0, 10.0))


def test_more_curves_than_line_styles_still_draw(slid: Run) -> None:
    figure = figure_strength_histories({"": {str(number): slid for number in range(len(LINE_STYLES) + 2)}})
    assert len(axes(figure).lines) == len(LINE_STYLES) + 3


def test_gamma_panels(slid: Run, standing: Run) -> None:
    figure = figure_gamma_histories({"S_R = 0.25": {"γ = 100": slid, "γ = 1": standing}, "S_R = 0.35": {"γ = 100": slid}})
    assert [len(ax.lines) for ax in figure.axes] == [3, 2]
    assert "(b) $S_R$ = 0.35" in texts(figure)


def test_histories_without_data_or_with_an_unknown_probe_are_refused(slid: Run) -> None:
    with pytest.raises(ValueError, match="runs"):
        figure_strength_histories({})
    with pytest.raises(ValueError, match="probe: 'B'"):
        figure_gamma_histories({"": {"γ = 1": slid}}, probe="B")


def test_a_diverged_run_says_so_and_ends_in_a_cross() -> None:
    runs = {"sound": synthetic(translation(-1.0)), "broken": synthetic(translation(-2.0), status="diverged")}
    figure, end = figure_strength_histories({"γ = 100": runs}), float(runs["broken"]["sample_time"][-1])
    assert f"broken, diverged at {end:.3g} s" in texts(figure)
    crosses = [line for line in axes(figure).lines if line.get_marker() == "x"]
    assert len(crosses) == 1 and crosses[0].get_xdata()[0] == end
