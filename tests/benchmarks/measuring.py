"""What the benchmarks share: the paper's scene, medians of alternating calls, and the way numbers are handed out."""

from __future__ import annotations

import argparse
import json
import platform
import time
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from sph.scene.configuration import dotted
from sph.scene.schema import Scene, load_scene
from sph.solver.simulation import Simulation

PAPER = Path(__file__).parents[2] / "config" / "scenes" / "paper.yaml"
REPEATS = 20

AT_REST: dict[str, Any] = {
    "duration": 0.2,
    "gravity.ramp": 0.05,
    "gravity.duration": 0.1,
    "motion.start": 0.1,
    "outputs.frame_interval": 0.1,
    "numerics.time_step": 1e-5,
}
"""The slope while gravity is brought on, with a step that is stable at any spacing used here: 20,000 steps in which nothing moves
far enough for pairs to be renewed."""


def scene_of(path: Path, overrides: Mapping[str, Any], settings: list[str] | None = None) -> Scene:
    """A scene file with other values for some keys in dotted form, and some more as KEY=VALUE."""
    return load_scene(path, dotted({**overrides, **dict(setting.split("=", 1) for setting in settings or [])}))


def paper(overrides: Mapping[str, Any], settings: list[str] | None = None) -> Scene:
    """The paper's scene, likewise."""
    return scene_of(PAPER, overrides, settings)


def at_rest(spacing: float, threads: int = 1) -> Simulation:
    """A run of the paper's slope of that spacing (m), ready to be advanced."""
    run = Simulation(paper(AT_REST | {"numerics.spacing": spacing}), threads)
    run.prepare()
    return run


def medians(calls: Mapping[str, Callable[[], Any]], repeats: int = REPEATS) -> dict[str, float]:
    """Seconds of calls by name: medians of ``repeats`` rounds through all of them, so that a busy machine slows all alike."""
    times: dict[str, list[float]] = {name: [] for name in calls}
    for call in calls.values():
        call()
    for _ in range(repeats):
        for name, call in calls.items():
            start = time.perf_counter()
            call()
            times[name].append(time.perf_counter() - start)
    return {name: float(np.median(values)) for name, values in times.items()}


def processor() -> str:
    """Name of this machine's processor, as it calls itself."""
    known = Path("/proc/cpuinfo")
    lines = known.read_text(encoding="utf-8").splitlines() if known.is_file() else []
    named = [line.split(":", 1)[1].strip() for line in lines if line.startswith("model name")]
    return named[0] if named else platform.processor() or platform.machine()


def command_line(text: str | None) -> argparse.ArgumentParser:
    """Parser of a benchmark with its docstring and the options that all have."""
    parser = argparse.ArgumentParser(description=text, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--json", type=Path, help="file for the numbers")
    return parser


def hand_out(found: dict[str, Any], table: str, path: Path | None) -> None:
    """Print the numbers as a table and write them as JSON."""
    print(table)
    if path is not None:
        path.write_text(json.dumps(found, indent=2) + "\n", encoding="utf-8")
