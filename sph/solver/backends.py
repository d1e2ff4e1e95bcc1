"""What advances a scene: the processor, or a graphics card; and several scenes at once."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from typing import Any

from sph.scene.names import check_known
from sph.scene.schema import Scene
from sph.solver.checkpoint import run_to_file
from sph.solver.run import Backend, Result, run
from sph.solver.simulation import Simulation

BACKENDS = ("cpu", "cuda")


def backend_of(name: str) -> Backend | None:
    """What makes the simulation of one scene; None for the processor.  ValueError for another name, and where there is no card."""
    check_known("backend", [name], BACKENDS)
    if name == "cpu":
        return None
    from sph.solver.cuda.ensemble import Ensemble

    return Ensemble(1)


def run_many(
    scenes: Sequence[Scene], backend: str = "cuda", paths: Sequence[Path | str] | None = None, say: Callable[[str], None] = print
) -> list[Result]:
    """Simulate scenes, on a card as many at a time as its memory holds; their results in order.

    Those of one variant of the solver and one number of particles advance together.  With ``paths`` each is written into a file of its own
    and goes on after a kill, as by ``run_to_file``.  What goes wrong with one, as a time step above its limit, is raised when the others
    are done.
    """
    check_known("backend", [backend], BACKENDS)
    if paths is not None and len(set(map(str, paths))) != len(scenes):
        raise ValueError(f"paths: {len(set(map(str, paths)))} different ones for {len(scenes)} scenes; give each its own")

    def call(number: int, made_by: Backend | None) -> Result:
        scene = scenes[number]
        return run(scene, backend=made_by) if paths is None else run_to_file(scene, paths[number], say=say, backend=made_by)

    if backend == "cpu":
        return [call(number, None) for number in range(len(scenes))]
    from sph.solver.cuda.ensemble import Ensemble

    found: list[Any] = [None] * len(scenes)
    for together in _together(scenes):
        ensemble = Ensemble(len(together))
        made = ensemble.carry([partial(call, number, ensemble) for number in together])
        for number, result in zip(together, made, strict=True):
            found[number] = result
    for result in found:
        if isinstance(result, BaseException):
            raise result
    return found


def _together(scenes: Sequence[Scene]) -> list[list[int]]:
    """Numbers of the scenes that advance together: alike, and as many as the card's memory holds."""
    from sph.solver.cuda.ensemble import card, most_runs, variant

    card()
    alike: dict[Any, list[int]] = {}
    most: dict[Any, int] = {}
    for number, scene in enumerate(scenes):
        simulation = Simulation(scene, enforce_limit=False)
        kind = variant(simulation)
        alike.setdefault(kind, []).append(number)
        if kind not in most:
            most[kind] = most_runs(simulation)
    return [numbers[first : first + most[kind]] for kind, numbers in alike.items() for first in range(0, len(numbers), most[kind])]
