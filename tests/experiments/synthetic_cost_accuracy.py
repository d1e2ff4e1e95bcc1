"""A cost-accuracy study made by hand: runs of known displacement and cost, nothing simulated."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import pandas as pd

from sph.experiments.variants.design import VariantRuns
from sph.experiments.variants.schema import CostAccuracy
from sph.experiments.variants.table import cost_accuracy_table
from sph.measures.metrics import METRICS
from sph.scene.configuration import merge, validated

SCENE: dict[str, Any] = {
    "scheme": "paper",
    "name": "slope",
    "geometry": {"shape": "slope"},
    "motion": {"kind": "tapered_sine"},
    "numerics": {"spacing": 5.0, "time_step": 1e-3},
}
CONFIG: dict[str, Any] = {
    "scene": "slope.yaml",
    "cases": {"weak": {"coupling": {"S_R": 0.1}}, "strong": {"coupling": {"S_R": 0.5}}},
    "timed_case": "weak",
    "repeats": 3,
    "reference": {"parameter": "spacing", "variant": "2 m"},
    "parameters": {
        "spacing": {
            "about": "spacing",
            "base": {"numerics": {"smoothing_ratio": 1.3}},
            "variants": {
                "5 m": {"numerics": {"spacing": 5.0}},
                "3 m": {"numerics": {"spacing": 3.0}},
                "2 m": {"numerics": {"spacing": 2.0}},
                "1.5 m": {"numerics": {"spacing": 1.5}},
            },
            "exceptions": {"1.5 m": {"repeats": 1, "cases": ["weak"]}},
        },
        "skin": {
            "about": "skin",
            "base": {"numerics": {"spacing": 3.0, "smoothing_ratio": 1.3}},
            "repeats": 1,
            "variants": {"0.3": {"numerics": {"neighbour_skin": 0.3}}, "0.6": {"numerics": {"neighbour_skin": 0.6}}},
        },
    },
}
FIDELITIES: dict[str, Any] = {"draft": {"numerics": {"smoothing_ratio": 1.3}}, "paper": {}}
DISPLACEMENTS = {
    "spacing/5-m": 12.0,
    "spacing/3-m": 10.9,
    "spacing/2-m": 10.0,
    "spacing/1.5-m": 9.7,
    "skin/0.6": 10.9,
    "fidelity/paper": 15.0,
}
"""Of A in the weak case, m; a tenth of it in the strong one.  The run-out is a metre more."""
COSTS = {"spacing/5-m": 1.0, "spacing/3-m": 4.0, "spacing/2-m": 20.0, "spacing/1.5-m": 60.0, "skin/0.6": 5.0, "fidelity/paper": 30.0}
"""Of the weak case, s."""


def made_runs(overrides: Mapping[str, Any] | None = None, fidelities: Mapping[str, Any] = FIDELITIES) -> VariantRuns:
    config = validated(CostAccuracy, merge(CONFIG, overrides or {}), "study.yaml")
    return VariantRuns(config, {config.scene: SCENE}, fidelities, "study.yaml")


def runs_of(made: VariantRuns, **changes: Mapping[str, Any]) -> dict[str, dict[str, Any]]:
    """What was measured of every run; ``changes`` by the variant's file name with '/' and '-' as '_'."""
    by_name = {"fidelity/draft": "spacing/5-m"}
    runs = {}
    for name, run in made.runs.items():
        variant = name.rpartition("/")[0]
        like = by_name.get(variant, variant)
        displacement = DISPLACEMENTS[like] * (1.0 if run.scene["coupling"]["S_R"] == 0.1 else 0.1)
        fixed = {
            "status": "complete",
            "collapse_class": "collapse" if displacement > 2.5 else "damaged",
            "displacement_magnitude": displacement,
            "runout": displacement + 1.0,
            "onset_time": 4.5,
            "shaking_start": 3.0,
            "energy_error": 1e-4,
            "time_step_ratio": 0.5,
            "wall_time": COSTS[like] * (0.9 + 0.1 * int(name[-1])),
            "particle_steps_per_second": 1e7,
            "particles": 100,
            "steps": 15000,
            "spacing": run.scene["numerics"]["spacing"],
        }
        runs[name] = (
            {metric.name: float("nan") for metric in METRICS} | fixed | changes.get(variant.replace("/", "_").replace("-", "_"), {})
        )
    return runs


def made_frame(made: VariantRuns | None = None, **changes: Mapping[str, Any]) -> pd.DataFrame:
    """Table of the hand-made study."""
    made = made or made_runs()
    return cost_accuracy_table(made.rows, runs_of(made, **changes), made.parameters.baseline, "test machine, 2 cores")
