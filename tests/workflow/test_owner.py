"""A folder of results belongs to one scene file: by dry runs, and by a job that is run."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
import yaml
from test_workflow import made, planned_jobs, snakemake

from sph.scene.schema import Scene
from sph.study.plan import OWNER, claim_results, load_study


def study(scene: str, **changes: Any) -> dict[str, Any]:
    return {"study": "ground", "scene": scene, "grid": {"S_R": ["0.5"]}, "searches": "none"} | changes


@pytest.fixture
def folder(tmp_path: Path, small_slope: Callable[[dict[str, Any]], Scene]) -> Path:
    """Working folder with the scenes of two people."""
    for name, angle in (("a", 60.0), ("b", 45.0)):
        (tmp_path / name).mkdir()
        scene = small_slope({"geometry.slope_angle": angle})
        (tmp_path / name / "scene.yaml").write_text(yaml.safe_dump(scene.model_dump(mode="json")))
        (tmp_path / name / "study.yaml").write_text(yaml.safe_dump(study(f"{name}/scene.yaml")))
    return tmp_path


def test_results_of_another_scene_file_are_not_replaced(folder: Path) -> None:
    first, second = study("a/scene.yaml"), study("b/scene.yaml")
    plan = load_study(first, [folder])
    load_study(second, [folder])  # nothing is there yet
    claim_results(plan, folder)
    with pytest.raises(ValueError, match=r"study: 'ground': .*a/scene.yaml.*b/scene.yaml"):
        load_study(second, [folder])
    load_study(second | {"study": "other"}, [folder])
    claim_results(load_study(first | {"scene": "./a/../a/scene.yaml"}, [folder]), folder)  # the same file, written otherwise
    note = folder / "results" / "ground" / OWNER
    assert note.read_text() == "a/scene.yaml\n"
    note.unlink()
    load_study(second, [folder])


def test_a_study_and_a_scene_that_their_user_edits_go_on(folder: Path) -> None:
    claim_results(load_study(study("a/scene.yaml"), [folder]), folder)
    path = folder / "a" / "scene.yaml"
    path.write_text(path.read_text().replace("slope_angle: 60.0", "slope_angle: 55.0"))
    changed = study("a/scene.yaml", grid={"S_R": ["0.3", "0.5"], "gamma": ["1", "100"]})
    assert load_study(changed, [folder]).scene()["geometry"]["slope_angle"] == 55.0


def test_the_workflow_notes_the_scene_file_and_refuses_another(folder: Path) -> None:
    note = folder / "results" / "ground" / OWNER
    mine, others = (("--configfile", str(folder / name / "study.yaml")) for name in "ab")
    assert planned_jobs(folder, *others)["simulate"] == 1
    assert not note.exists(), "a dry run writes nothing"
    made(folder, "results/ground/own/stages/gravity.nc", *mine, cores=1)
    assert note.read_text() == "a/scene.yaml\n"
    refused = snakemake(folder, "--dry-run", *others)
    assert refused.returncode != 0 and "holds results of the scene a/scene.yaml" in refused.stderr + refused.stdout
