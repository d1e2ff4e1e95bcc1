"""Excess pore pressure of level ground beside the simplified procedure.

``python -m tools.level_ground docs/images/level_ground.png`` runs ``SCENE`` and draws it.
"""

from __future__ import annotations

import argparse
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from sph.checks.liquefaction import factors
from sph.figures.profile import layer_colours
from sph.figures.style import DPI, WIDTH, styled
from sph.measures.fields import FIELDS
from sph.output.run import Run
from sph.scene.configuration import dotted
from sph.scene.motion import TaperedSine
from sph.scene.schema import Scene, load_scene
from sph.solver.particles import place_particles
from sph.solver.run import run

SCENE = Path(__file__).parents[1] / "config" / "scenes" / "validation" / "v27_level_sand.yaml"
EQUIVALENT = 0.65
"""Amplitude of uniform cycles over the peak of the earthquake that they stand for; fifteen of them have the magnitude ``MAGNITUDE``."""
MAGNITUDE = 7.5
TIMES = (3.0, 6.0, 9.0, 12.0, 20.0)
"""Times of the profiles, s."""


def earthquake(scene: Scene) -> Scene:
    """The scene with the peak of the earthquake that its uniform cycles stand for."""
    assert isinstance(scene.motion, TaperedSine)
    return load_scene(SCENE, dotted({"motion.amplitude": scene.motion.amplitude / EQUIVALENT}))


@styled
def figure_level_ground(ground: Run) -> Figure:
    """r_u against depth at some times, factor of safety against depth, and r_u of the layers against time."""
    scene, ratio, time = ground.scene, FIELDS["pore_pressure_ratio"], ground["time"]
    rows, height = np.unique(ground["y0"][ground.soil]), scene.geometry.height
    figure = Figure(figsize=(WIDTH, 3.6), layout="constrained")
    profile, safety, history = figure.subplots(1, 3, width_ratios=[1.1, 0.8, 1.3])
    for shade, at in zip(np.linspace(0.75, 0.0, len(TIMES)), TIMES, strict=True):
        values = ratio.of(ground, ground.last_at(time, at))
        means = [values[ground.soil & (ground["y0"] == y)].mean() for y in rows]
        profile.plot(means, height - rows, color=str(shade), label=f"{at:g} s")
    check = earthquake(scene)
    safeties = factors(check, place_particles(check), MAGNITUDE)
    for number, (name, colour) in enumerate(zip(scene.layers, layer_colours(scene)[1:], strict=True), 1):
        (of,) = (each for each in safeties if each.layer == name)
        safety.plot(of.safety, of.depth, ".", color=colour, markersize=3)
        inside = ground.soil & (ground["layer"] == number)
        means = [ratio.of(ground, frame)[inside].mean() for frame in range(time.size)]
        history.plot(time, means, color=colour, label=f"{name}, (N1)60 {scene.soils[number].blow_count:g}")
    safety.axvline(1.0, color="0.4", linewidth=0.8)
    for ax in (profile, safety):
        ax.set_ylim(height, 0.0)
    profile.set(xlabel="r_u (-)", ylabel="depth (m)", xlim=(-0.02, 1.05))
    safety.set(xlabel=f"factor of safety, M {MAGNITUDE:g} (-)", xlim=(0.0, 3.5))
    history.set(xlabel="time (s)", ylabel="mean r_u of the layer (-)", ylim=(-0.02, 1.05))
    safety.legend(*profile.get_legend_handles_labels(), loc="upper right", fontsize="small")
    history.legend(loc="lower right", fontsize="small")
    return figure


def main() -> None:
    """Run the scene and draw it."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("figure", type=Path, help="file of the figure")
    ground = Run.of(run(load_scene(SCENE)).trajectory)
    figure_level_ground(ground).savefig(parser.parse_args().figure, dpi=DPI)


if __name__ == "__main__":
    main()
