"""What measuring a run works out: its scene once, its particles never again."""

from __future__ import annotations

import json
import sys
from collections import Counter
from pathlib import Path
from typing import Any

import pytest
from synthetic import synthetic, translation

import sph.experiments.study_row
from sph.measures.metrics import MetricSettings
from sph.scene import schema
from sph.solver import particles
from sph.storage import trajectory
from sph.study.planned import planned

LAYERED = {"clay": {"region": {"kind": "depth", "top": 5.0}, "soil": {"cohesion": 60.0}, "S_R": 0.1}}


def counted(monkeypatch: pytest.MonkeyPatch, *functions: tuple[Any, str]) -> Counter[str]:
    """How often functions are called from now on, by name, wherever they have been imported."""
    calls: Counter[str] = Counter()
    for home, name in functions:
        real = getattr(home, name)

        def counting(*given: Any, real: Any = real, name: str = name, **named: Any) -> Any:
            calls[name] += 1
            return real(*given, **named)

        for module in [module for key, module in sys.modules.items() if key.startswith("sph.") and getattr(module, name, None) is real]:
            monkeypatch.setattr(module, name, counting)
    return calls


def test_a_measured_run_builds_its_scene_once(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    run = synthetic(translation(-3.0), overrides={"layers": LAYERED, "numerics": {"spacing": 2.5}})
    run.attrs["particle_steps"] = 6_000_000
    trajectory.write(tmp_path / "run.nc", run.trajectory)
    plan = planned(json.loads(run.attrs["scene"]))
    calls = counted(monkeypatch, (schema, "validated"), (particles, "place_particles"))
    values = sph.experiments.study_row.run_values(plan.read(tmp_path / "run.nc"), MetricSettings(), 3.0)
    assert values["displacement_horizontal"] == pytest.approx(-3.0)
    assert calls == {"validated": 1}
