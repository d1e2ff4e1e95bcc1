"""One trajectory at a chosen time: profile, probes, energies (``sph plot``)."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from sph.figures.arrangement import coupling_words
from sph.figures.history import shade_shaking
from sph.figures.profile import (
    PER_INCH,
    draw_places,
    draw_profile,
    field_bar,
    field_norm,
    frame_limits,
    mark_probes,
    survey_axes,
    with_room,
)
from sph.figures.style import GREY, LINE_STYLES, WIDTH, add_note, curve_colours, plain, save, styled
from sph.measures.fields import check_field
from sph.measures.places import PlaceAt
from sph.output.run import Run
from sph.solver.run import Result

ENERGIES = ("kinetic_energy", "elastic_energy", "potential_energy", "dissipated_energy", "shaking_work")


@styled
def plot_trajectory(
    run: Run,
    time: float | None = None,
    field: str = "initial_height",
    fidelity: str = "",
    places: Mapping[str, PlaceAt] | None = None,
) -> Figure:
    """One run: profile at a time, coloured by a field; displacement of the probes; energies.

    ``time`` (s) picks the last frame not later than it, None the last frame of all; ``field`` is a name of ``FIELDS``, ``places`` are as in
    ``metrics.places``.
    Raises ValueError for an unknown field and a time outside the run.
    """
    check_field(field)
    scene, frame = run.scene, _frame_at(run, time)
    shown = float(run["time"][frame])
    limits = with_room(frame_limits(run, frame), scene, places or {}, WIDTH - 2.0)
    left, right, lower, upper = limits
    panel = (WIDTH - 2.0) * (upper - lower) / (right - left)
    figure = Figure(figsize=(WIDTH, panel + 4.8), layout="constrained")
    axes = figure.subplots(3, 1, height_ratios=[panel + 0.5, 1.7, 1.7])
    circles = draw_profile(axes[0], run, frame, field, field_norm({"": run}, field, frame))
    mark_probes(axes[0], run, frame)
    draw_places(axes[0], scene, places or {})
    survey_axes(axes[0], scene, limits)
    field_bar(figure, circles, field, scene, max(12, int(PER_INCH * panel)), cax=axes[0].inset_axes((1.015, 0.0, 0.02, 1.0)))
    axes[0].set_title(f"{plain(scene.title or scene.name)}\nt = {shown:g} s, {coupling_words(scene)}, {run.status}", loc="left")
    _draw_probes(axes[1], run)
    _draw_energies(axes[2], run)
    for ax in axes[1:]:
        shade_shaking(ax, scene)
        ax.axvline(shown, color=GREY, linewidth=0.8, linestyle=":")
        ax.set_xlim(0.0, scene.duration)
        ax.legend(loc="center left", bbox_to_anchor=(1.01, 0.5), handlelength=3.2)
    axes[2].set_xlabel("time (s)")
    add_note(figure, [scene], fidelity)
    return figure


def plot(
    run: Run | Result | xr.Dataset | Path | str,
    path: Path | str | None = None,
    time: float | None = None,
    field: str = "initial_height",
    places: Mapping[str, PlaceAt] | None = None,
) -> Figure:
    """Draw a run, its result, trajectory or file, as ``plot_trajectory`` does, and write the picture (.png, .pdf, .svg) if a path is given.

    ValueError as ``plot_trajectory``, and for a file that is not a trajectory and for one in the survey's coordinates, in which it is drawn
    anyway.
    """
    shown = Run.read(run) if isinstance(run, (Path, str)) else Run.of(run.trajectory if isinstance(run, Result) else run)
    figure = plot_trajectory(shown, time=time, field=field, places=places)
    if path is not None:
        save(figure, Path(path))
    return figure


def _frame_at(run: Run, time: float | None) -> int:
    times = run["time"]
    if time is None:
        return len(times) - 1
    if not 0.0 <= time <= float(run["sample_time"][-1]) + 1e-9:
        raise ValueError(f"time: {time} s lies outside the run, which ends at {float(run['sample_time'][-1]):g} s")
    return run.last_at(times, time)


def _draw_probes(ax: Axes, run: Run) -> None:
    colours = curve_colours(2 * len(run.probes))
    for number, name in enumerate(run.probes):
        history = run.history(name)
        horizontal = run.scene.geometry.direction * history.displacement_horizontal  # along the axis of the profile
        for offset, (axis, values) in enumerate({"vertical": history.displacement_vertical, "horizontal": horizontal}.items()):
            at = 2 * number + offset
            style = LINE_STYLES[at % len(LINE_STYLES)]
            ax.plot(history.time, values, color=colours[at], linestyle=style, label=f"{name}, {axis}")
    ax.margins(y=0.15)
    ax.set_ylabel("displacement (m)")


def _draw_energies(ax: Axes, run: Run) -> None:
    largest = max(float(abs(run[name]).max()) for name in ENERGIES)
    in_unit, unit = (1e-6, "MJ/m") if largest >= 1e4 else (1.0, "J/m")  # tests of the laboratory release some joules
    for name, colour, style in zip(ENERGIES, curve_colours(len(ENERGIES)), LINE_STYLES, strict=False):
        label = name.removesuffix("_energy").replace("_", " ")
        ax.plot(run["sample_time"], in_unit * run[name], color=colour, linestyle=style, label=label)
    ax.margins(y=0.15)
    ax.set_ylabel(f"energy ({unit})")
