"""Two runs of a batch on numba's simulator of a card, whole and killed; a script of ``test_cuda.py`` that is given a folder."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

from small_scenes import FREE_BLOCK

from sph.scene.configuration import dotted, merge
from sph.scene.schema import Scene, make_scene
from sph.solver.backends import run_many
from sph.solver.checkpoint import run_to_file
from sph.solver.cuda import ensemble as on
from sph.storage.files import beside

CHANGES: dict[str, Any] = {
    "geometry.width": 3.0,
    "geometry.height": 3.0,
    "numerics.precision": "double",
    "gravity.duration": 0.002,
    "outputs": {"frame_interval": 0.002, "series_interval": 0.001},
    "initial_velocity": {"along": "x", "position": [0.0, 3.0], "x": [2.0, -2.0], "y": [0.0, 0.0]},
}
DURATIONS = {"short": 0.004, "long": 0.006}
"""s, of the runs by name."""


def scene_of(name: str) -> Scene:
    """A block of nine particles."""
    return make_scene(merge(FREE_BLOCK, dotted(CHANGES | {"name": name, "duration": DURATIONS[name]})))


def kill(ensemble: on.Ensemble, launches: int) -> None:
    """Have an ensemble end after so many launches."""
    serve, made = ensemble._advance, iter(range(launches))

    def advance() -> Any:
        if next(made, None) is None:
            raise InterruptedError("killed")
        return serve()

    ensemble._advance = advance  # type: ignore[method-assign]


def main(folder: Path) -> None:
    """Write the runs on the processor into a folder, those of a batch into ``whole``, and those of one that is killed into ``again``."""
    on.THREADS = 4
    scenes = [scene_of(name) for name in DURATIONS]
    for place in ("whole", "again"):
        (folder / place).mkdir()
    for scene in scenes:
        run_to_file(scene, folder / f"{scene.name}.nc")
    run_many(scenes, "cuda", [folder / "whole" / f"{name}.nc" for name in DURATIONS])
    paths = [folder / "again" / f"{name}.nc" for name in DURATIONS]
    ensemble = on.Ensemble(2)
    kill(ensemble, 3)

    def call(number: int) -> Any:
        return run_to_file(scenes[number], paths[number], seconds=1e-9, backend=ensemble)

    for result in ensemble.carry([lambda: call(0), lambda: call(1)]):
        assert isinstance(result, RuntimeError) and "killed" in str(result), result
    assert beside(paths[1], "checkpoint").exists() and not paths[1].exists()
    told: list[str] = []
    run_many(scenes, "cuda", paths, say=told.append)
    assert sum("goes on from this checkpoint" in line for line in told) == 2, told


if __name__ == "__main__":
    main(Path(sys.argv[1]))
