"""The workflow as a module of another one, as ``snakedeploy deploy-workflow`` writes it."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
import yaml
from test_workflow import ROOT, planned_jobs, write_config

from sph.scene.schema import Scene

MODULE = """
configfile: "study.yaml"

module slope:
    snakefile: "{snakefile}"
    config: config

use rule * from slope{renamed}
"""


@pytest.mark.long
@pytest.mark.parametrize(("snakefile", "prefix"), [("workflow/Snakefile", ""), ("Snakefile", "slope_")])
def test_another_workflow_plans_the_same_jobs(
    tmp_path: Path, small_slope: Callable[[dict[str, Any]], Scene], snakefile: str, prefix: str
) -> None:
    (tmp_path / "slope.yaml").write_text(yaml.safe_dump(small_slope({}).model_dump(mode="json")))
    config = write_config(tmp_path)
    (tmp_path / "Snakefile").write_text(MODULE.format(snakefile=ROOT / snakefile, renamed=f" as {prefix}*" if prefix else ""))
    own = ("--snakefile", str(tmp_path / "Snakefile"))
    assert planned_jobs(tmp_path, *own) == {prefix + name: count for name, count in planned_jobs(tmp_path, *config).items()}


@pytest.mark.long
def test_the_place_of_the_catalog_plans_the_shipped_study() -> None:
    jobs = planned_jobs(ROOT, "--snakefile", str(ROOT / "workflow" / "Snakefile"), "--forceall")
    assert jobs == planned_jobs(ROOT, "--forceall") and jobs["simulate"] == 24
