"""Figures 1-7 of the paper: the first three and the profiles are those of any study, the motion of particle A is here."""

from __future__ import annotations

from collections.abc import Callable, Mapping

from matplotlib.figure import Figure

from sph.figures import RUN_FIGURES, figure_profiles
from sph.figures.history import draw_vertical_histories
from sph.figures.style import WIDTH, add_note, label_panels, styled, written
from sph.output.run import Run
from sph.study.schema import INPUT_FIGURES


def _histories(panels: Mapping[str, Mapping[str, Run]], probe: str, fidelity: str) -> Figure:
    if not panels or not all(panels.values()):
        raise ValueError("runs: a figure of histories needs at least one in every panel")
    figure = Figure(figsize=(WIDTH, 2.9), layout="constrained")
    axes = figure.subplots(1, len(panels), sharey=True, squeeze=False)[0]
    for ax, runs in zip(axes, panels.values(), strict=True):
        lines = draw_vertical_histories(ax, {written(name): run for name, run in runs.items()}, probe)
        ax.margins(y=0.14)
        if len(panels) > 1:
            ax.legend(handles=lines, loc="upper left", bbox_to_anchor=(0.0, -0.2), ncols=len(lines), handlelength=3.2, borderaxespad=0)
    if len(panels) == 1:
        axes[0].legend(handles=lines, loc="center left", bbox_to_anchor=(1.01, 0.5), handlelength=3.2)
    axes[0].set_ylabel(f"vertical displacement of {probe} (m)")
    label_panels(axes, map(written, panels))
    add_note(figure, [run.scene for runs in panels.values() for run in runs.values()], fidelity)
    return figure


def figure_strength_profiles(runs: Mapping[str, Run], fidelity: str = "") -> Figure:
    """Slope profiles after the horizontal excitation, at the end of the run, for several strength reduction factors S_R.  The colours
    indicate the initial height of the particles, except those of the box, which are white; the line is the initial surface, A is the
    particle at the original crest edge.

    ``runs`` by panel title (Fig. 4).  Raises ValueError without runs.
    """
    return figure_profiles(runs, fidelity)


def figure_gamma_profiles(runs: Mapping[str, Run], fidelity: str = "") -> Figure:
    """Slope profiles after the horizontal excitation, at the end of the run, for a large and a small coupling parameter γ, coloured as in
    Figure 4.

    ``runs`` by panel title (Fig. 5).  Raises ValueError without runs.
    """
    return figure_profiles(runs, fidelity)


@styled
def figure_strength_histories(panels: Mapping[str, Mapping[str, Run]], probe: str = "A", fidelity: str = "") -> Figure:
    """Vertical displacement of particle A at the original crest edge for several strength reduction factors S_R, since the end of the
    gravity stage and relative to the box; the band is the interval of shaking.

    ``panels`` by title, e.g. ``{"γ = 100 s⁻¹, 6.0 m/s²": {"S_R = 0.10": run, ...}}`` (Fig. 6).  Raises ValueError for an empty
    panel and an unknown probe.
    """
    return _histories(panels, probe, fidelity)


@styled
def figure_gamma_histories(panels: Mapping[str, Mapping[str, Run]], probe: str = "A", fidelity: str = "") -> Figure:
    """Vertical displacement of particle A at the original crest edge for a large and a small coupling parameter γ, since the end of the
    gravity stage and relative to the box; the band is the interval of shaking.  The paper's text gives S_R = 0.25, its caption 0.35.

    ``panels`` by title, e.g. ``{"S_R = 0.25": {"γ = 100": run, "γ = 1": run}, ...}`` (Fig. 7).  Raises ValueError for an empty
    panel and an unknown probe.
    """
    return _histories(panels, probe, fidelity)


FIGURES: dict[str, Callable[..., Figure]] = {
    **{f"fig{number}": RUN_FIGURES[name] for number, name in enumerate(INPUT_FIGURES, 1)},
    "fig4": figure_strength_profiles,
    "fig5": figure_gamma_profiles,
    "fig6": figure_strength_histories,
    "fig7": figure_gamma_histories,
}
"""The function of each figure, by the name of its file."""
