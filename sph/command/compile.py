"""What ``sph compile`` does: make the solver ready for scenes, and for the static tests of their slopes."""

from __future__ import annotations

import time
from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path

from sph.command.given import read_given
from sph.jobs.progress import reporter
from sph.scene.schema import Scene
from sph.solver.simulation import Simulation
from sph.stability.safety import DEFAULT_RULE
from sph.stability.standing import divided_strength, static_scene
from sph.study.preflight import standing_scene


def compile_all(paths: Sequence[Path]) -> None:
    """Compile for the scenes in files, all of which are read first; a line when each is ready."""
    scenes = [read_given(path, {})[0] for path in paths]
    for path, scene in zip(paths, scenes, strict=True):
        print(f"{path}: ready, {compile_for(scene, scene.name):.1f} s", flush=True)


def compile_for(scene: Scene, label: str) -> float:
    """Compile what runs of a scene and its static tests need, or load it, and say what is compiled; how long it took, s.

    OSError names the folder and the remedy if compiled code cannot be kept there.
    """
    start = time.monotonic()
    tested = [scene]
    with suppress(ValueError):  # of a scene without a slope, or too coarse for its tests
        tested.append(divided_strength(static_scene(standing_scene(scene), DEFAULT_RULE), 1.0))
    for each in tested:
        with reporter(label, each):
            Simulation(each, enforce_limit=False).prepare()
    return time.monotonic() - start
