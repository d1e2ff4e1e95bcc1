"""The numbers of a run in the table of a study: its metrics, their expected errors, and the displacement of a sliding block."""

from __future__ import annotations

from sph.checks.after_run import after_run, liquefied
from sph.experiments.variants.advice import expected_metrics
from sph.experiments.variants.design import scheme, settings_text
from sph.experiments.variants.likeness import unlike
from sph.measures.metrics import MetricSettings, Value, measure
from sph.output.run import Run
from sph.scene.strict_json import parse_json
from sph.study.baseline import baseline_metrics
from sph.study.tables import FINDINGS

_known: dict[str, dict[str, float]] = {}
"""Errors to expect by how a scene is simulated and in what it is unlike the measured slope, which the runs of a study often share."""


def run_values(run: Run, settings: MetricSettings, yield_acceleration: float) -> dict[str, Value]:
    """The columns ``sph.study.tables.VALUES`` of a run, from the run and the yield acceleration of its slope (m/s2)."""
    scene = run.scene
    numerics = settings_text(scheme(scene)) + str(unlike(scene))
    if numerics not in _known:
        _known[numerics] = expected_metrics(scene)
    return measured(run, settings) | _known[numerics] | baseline_metrics(scene, yield_acceleration)


def measured(run: Run, settings: MetricSettings) -> dict[str, Value]:
    """Metrics of a run, and the codes of the findings before and after it."""
    values = measure(run, settings)
    codes = [*parse_json(run.attrs.get("findings", "[]")), *(each.code for each in [*after_run(run.scene, values), *liquefied(run)])]
    return values | {FINDINGS.name: " ".join(codes)}
