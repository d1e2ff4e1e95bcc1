"""What the benchmarks share: the paper's slope at rest, the time of child processes, and the command line of ``gpu.py``."""

from __future__ import annotations

import argparse
import json
import resource
from pathlib import Path
from typing import Any

from sph.scene.configuration import dotted
from sph.scene.schema import load_scene
from sph.solver.simulation import Simulation

ROOT = Path(__file__).resolve().parents[2]
SCENES = ROOT / "config" / "scenes"

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


def at_rest(spacing: float, threads: int = 1) -> Simulation:
    """A run of the paper's slope of that spacing (m), ready to be advanced."""
    run = Simulation(load_scene(SCENES / "paper.yaml", dotted(AT_REST | {"numerics.spacing": spacing})), threads)
    run.prepare()
    return run


def children() -> float:
    """Processor time (s) of the child processes that have ended."""
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


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
