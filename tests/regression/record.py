"""Record the regression set: ``python tests/regression/record.py`` runs every case of ``expected.json`` and rewrites its metrics.

``expected.json`` holds small runs of the paper's scene: by name, the keys that differ from ``config/scenes/paper.yaml`` and some
metrics of ``sph.measures.metrics``.  They were first computed by commit 9045221, before loops were vectorised, gradients kept in
single precision and threads introduced.  ``test_regression.py`` holds every later solver to them.

Record anew only when the physics or the scheme is changed on purpose, and say so in CHANGELOG.md with the outputs that change.
An optimisation that does not pass the test is wrong, or is a change of the scheme.  A new case is added by hand, with ``"metrics": {}``.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from sph.measures.metrics import measure
from sph.scene.configuration import dotted
from sph.scene.schema import load_scene
from sph.solver.run import run

EXPECTED = Path(__file__).with_name("expected.json")
PAPER = Path(__file__).parents[2] / "config" / "scenes" / "paper.yaml"
KEPT = (
    "status",
    "collapse_class",
    "displacement_magnitude",
    "displacement_vertical",
    "runout",
    "deposit_height",
    "onset_time",
    "arrest_time",
    "first_failure_time",
    "failed_fraction",
    "probe_peak_speed",
)


def load() -> dict[str, Any]:
    """Settings and metrics by the case's name."""
    return json.loads(EXPECTED.read_text(encoding="utf-8"))


def measured(settings: dict[str, Any]) -> dict[str, Any]:
    """Metrics of a run of the paper's scene with other values for some keys, in dotted form."""
    metrics = measure(run(load_scene(PAPER, dotted(settings))).trajectory)
    return {name: metrics[name] for name in KEPT}


def main() -> None:
    """Run every case and rewrite the file, NaN as JSON's extension of that name."""
    cases = load()
    for name, case in cases.items():
        case["metrics"] = measured(case["settings"])
        print(name, case["metrics"], flush=True)
    EXPECTED.write_text(json.dumps(cases, indent=2) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
