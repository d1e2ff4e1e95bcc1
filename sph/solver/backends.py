"""What advances a scene: the processor, or a graphics card; and several scenes at once."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from sph.scene.names import check_known
from sph.scene.schema import Scene
from sph.solver.checkpoint import run_to_file
from sph.solver.run import Backend, Result, run
from sph.solver.simulation import Simulation

if TYPE_CHECKING:
    from sph.solver.cuda.ensemble import CardSimulation, Ensemble

BACKENDS = ("cpu", "cuda")
ENOUGH = 2**20
"""Particles that keep a card busy.  More at once would gain no time, and the histories of all runs lie in the memory of the machine."""


def backend_of(name: str) -> Backend | None:
    """What makes the simulation of one scene; None for the processor.  ValueError for another name, and where there is no card."""
    check_known("backend", [name], BACKENDS)
    if name == "cpu":
        return None
    from sph.solver.cuda.ensemble import Ensemble

    return Member(Ensemble(1))


class Member:
    """What advances one run of an ensemble.  ``built`` is its simulation, or why there is none; left out, it is built when asked for."""

    name = "cuda"

    def __init__(self, ensemble: Ensemble, built: CardSimulation | Exception | None = None) -> None:
        self.ensemble, self.built = ensemble, built

    def simulation(self, scene: Scene, enforce_limit: bool) -> Simulation:
        """A scene's simulation; ValueError with numbers where it does not fit on the card."""
        built, self.built = self.built, None  # who asks again wants one that nothing has been read into
        if built is None:
            from sph.solver.cuda.ensemble import most_runs

            built = self.ensemble.simulation(scene, enforce_limit)
            most_runs(built)
        if isinstance(built, Exception):
            raise built
        built.ensemble, built.enforce_limit = self.ensemble, enforce_limit
        return built


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
    found = call_together([partial(scenes.__getitem__, number) for number in range(len(scenes))], call)
    for result in found:
        if isinstance(result, BaseException):
            raise result
    return found


def call_together(scenes: Sequence[Callable[[], Scene]], call: Callable[[int, Backend], Any]) -> list[Any]:
    """What ``call`` returns for the number of each scene and what advances it on the card; an exception of one is in its place.

    Scenes are functions that build them.  One that is refused, or does not fit on the card, is called too, and told so when it asks for
    its simulation.  ValueError where there is no card.
    """
    from sph.solver.cuda.ensemble import Ensemble, card

    card()
    found: list[Any] = [None] * len(scenes)
    for batch in _batches(scenes):
        ensemble = Ensemble(len(batch))
        made = ensemble.carry([partial(call, number, Member(ensemble, built)) for number, built in batch.items()])
        for number, result in zip(batch, made, strict=True):
            found[number] = result
    return found


def _batches(scenes: Sequence[Callable[[], Scene]]) -> Iterator[dict[int, CardSimulation | Exception]]:
    """Simulations that advance together, by the scenes' numbers: alike, as many as the card's memory holds and keep it busy."""
    from sph.solver.cuda.ensemble import CardSimulation, most_runs, variant

    waiting: dict[Any, dict[int, CardSimulation | Exception]] = {}
    most: dict[Any, int] = {}
    for number, scene in enumerate(scenes):
        try:
            # Its ensemble is made when it is known how many they are.
            simulation = CardSimulation(scene(), None, enforce_limit=False)  # type: ignore[arg-type]
            kind = variant(simulation)
            if kind not in most:
                most[kind] = max(1, min(most_runs(simulation), ENOUGH // simulation.state.x.size))
        except (ValueError, OSError) as error:
            yield {number: error}
            continue
        alike = waiting.setdefault(kind, {})
        alike[number] = simulation
        if len(alike) == most[kind]:
            yield waiting.pop(kind)
    yield from waiting.values()
