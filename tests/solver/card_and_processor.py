"""Runs of tiny scenes on numba's simulator of a card and by the processor's solver, both as plain Python; a script of ``test_cuda.py``.

Called with names of ``CASES``; prints, as JSON, by case: the largest difference of each array of the state over its largest value,
and how often pairs and candidates were renewed.
"""

from __future__ import annotations

import json
import sys
from typing import Any

import numpy as np
from comparison import VARIANTS
from small_scenes import SLOPE

from sph.scene.configuration import dotted, merge
from sph.scene.schema import Scene, make_scene
from sph.solver.simulation import Simulation
from sph.solver.state import ARMED, FAILED

STEPS = 8
COMMON: dict[str, Any] = {
    "numerics.spacing": 7.5,
    "numerics.precision": "double",
    "numerics.smoothing_ratio": 1.3,
    "numerics.short_range_repulsion": {},
    "walls.layers": 3,
    "numerics.neighbour_skin": 0.1,
}
CASES: dict[str, dict[str, Any]] = {
    "paper": {},
    "states": VARIANTS["all states"] | {"numerics.artificial_viscosity.reconstruction": "linear", "walls.base": "contact"},
    "absorbing": {
        "walls.base": "absorbing",
        "walls.sides": "absorbing",
        "soil.dilation_angle": 5.0,
        "coupling.solid_after_failure": "elastic_plastic",
        "coupling.softening": {"slip_at_peak": 1e-4, "slip_at_residual": 0.01, "width": 15.0, "shape": "exponential"},
        "numerics.gradient_correction": {"min_determinant": 0.3},
    },
    "periodic": {
        "geometry": {"shape": "block", "width": 60.0, "height": 30.0},
        "walls.base": "free_slip",
        "walls.sides": "periodic",
        "walls.friction": {"base": 0.3},
        "coupling.fluid.law": "capped_viscosity",
        "numerics.kernel": "wendland_c2",
        "numerics.artificial_stress": {},
        "water": {"pressure": "by_place", "level": 10.0},
    },
    "driven": {
        "walls.base": "none",
        "walls.sides": "none",
        "geometry": {"shape": "block", "width": 60.0, "height": 30.0},
        "prescribed_velocity_gradient": {"xy": 20.0},
    },
}


def scene_of(case: str, number: int = 0) -> Scene:
    """The scene of a run of a case."""
    return make_scene(merge(SLOPE, dotted(COMMON | CASES[case] | {"coupling.S_R": (0.1, 0.3)[number]})))


def start(simulation: Simulation, number: int) -> None:
    """Soil that is armed, pressed together and shaken up, so that it fails and its neighbours become others, and more."""
    simulation.prepare()
    simulation.step = simulation.scene.steps(1.2)
    if number:
        simulation.divide(2)
    soil = np.arange(simulation.particles.n_soil)
    simulation.state.vx[soil] = 80.0 * np.sin(soil + number)
    y = simulation.particles.y[soil]
    simulation.state.vy[soil] = 30.0 * (y.mean() - y) - 40.0 * np.cos(soil)
    simulation.state.phase[soil] = ARMED


def compare(case: str, runs: int) -> dict[str, Any]:
    """What comes of a case."""
    from sph.solver.cuda import ensemble as on

    on.SPARE = 1.0  # so that rows overflow as soil is compressed
    ensemble = on.Ensemble(runs, threads=8)

    def on_card(number: int) -> Simulation:
        simulation: Simulation = ensemble.simulation(scene_of(case, number), enforce_limit=False)
        start(simulation, number)
        for steps in (STEPS - 3, 3):
            simulation.advance_steps(steps)
        return simulation

    made = ensemble.carry([lambda number=number: on_card(number) for number in range(runs)])
    differences: dict[str, float] = {}
    failed = 0
    for number, card in enumerate(made):
        if isinstance(card, BaseException):
            raise card
        processor = Simulation(scene_of(case, number), enforce_limit=False)
        start(processor, number)
        processor.advance_steps(STEPS)
        for name, there in processor.state._asdict().items():
            here = getattr(card.state, name)
            assert np.array_equal(np.isnan(here), np.isnan(there)), name
            if name.startswith("solid"):  # which the processor may go on with where it has no weight any more
                here, there = (np.where(processor.state.beta > 0.0, each, 0.0) for each in (here, there))
            largest = np.nanmax(np.abs(there.astype(float)), initial=0.0)
            apart = np.nanmax(np.abs(there.astype(float) - here), initial=0.0)
            differences[name] = max(differences.get(name, 0.0), float(apart / largest) if largest > 0.0 else float(apart))
        failed += int(np.count_nonzero(card.state.phase == FAILED))
        assert card.steps_made == processor.steps_made
    return {"differences": differences, "renewed": ensemble.renewed.tolist(), "rooms": ensemble.rooms, "failed": failed}


if __name__ == "__main__":
    print(json.dumps({case: compare(case, 2 if case == "paper" else 1) for case in sys.argv[1:]}))
