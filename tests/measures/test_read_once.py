"""What planning a study and measuring a run work out: every scene once, particles never again."""

from __future__ import annotations

import json
import sys
from collections import Counter
from pathlib import Path
from typing import Any

import pytest
from synthetic import synthetic, translation

import sph.experiments.study_row
from sph.experiments.registry import load_study
from sph.jobs.catalogue import Catalogue
from sph.measures.metrics import MetricSettings
from sph.scene import schema
from sph.solver import particles
from sph.stability.record import SAFETY
from sph.storage import trajectory
from sph.study.cost import needs
from sph.study.planned import planned

ROOT = Path(__file__).resolve().parents[2]
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


def test_planning_the_papers_study_builds_each_scene_once(monkeypatch: pytest.MonkeyPatch) -> None:
    """At the fidelities, of the runs and of the stages between them, whatever jobs ask of a cluster and tables of the dimensions."""
    monkeypatch.chdir(ROOT)
    calls = counted(monkeypatch, (schema, "make_scene"))
    plan = load_study("config/config.yaml")
    runs = Catalogue(plan, [Path()]).own.values()
    of_dimensions = len(plan.study.fidelities) + len({frozenset(run.point.items()) for run in runs if run.point})
    for run in runs:
        assert needs(run.built, run.needs, 1).runtime <= needs(run.built, run.needs, 2).runtime
    needs(plan.slope.built, SAFETY)
    assert [each.unit for each in plan.dimensions] == ["-", "1/s", "m/s2"] and plan.layout.axes
    statics = 2  # at the spacing of the runs, which is the fine one of the searches, and at the coarse one
    assert of_dimensions == 4 + 24 + 3 and calls == {"make_scene": of_dimensions + statics}
