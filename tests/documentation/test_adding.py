"""The changes that docs/development/adding.md shows: each applies to the tree, touches few files, and adds what it says."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
PAGE = (ROOT / "docs" / "development" / "adding.md").read_text(encoding="utf-8")
MAX_FILES = 7
SCENE = "{'name': 'block', 'scheme': 'paper', 'duration': 5.0, 'geometry': {'shape': 'block', 'width': 10.0, 'height': 5.0}, %s}"
CHECKS = {
    "A term": f"""
from sph.scene.schema import make_scene
from sph.solver.terms import KEYS, wanted_terms
assert KEYS["drag"] == "numerics.drag"
assert wanted_terms(make_scene({SCENE % "'numerics': {'drag': 0.5}"}))["drag"]
assert not wanted_terms(make_scene({SCENE % "'numerics': {}"}))["drag"]
from sph.solver.time_step import limits
assert [each.reason for each in limits(make_scene({SCENE % "'numerics': {'drag': 0.5}"})) if each.name == "drag"] == ["0.5 1/s"]
from collections import namedtuple
import numpy as np
from sph.solver.physics.drag import Drag, add_drag
Moving = namedtuple("Moving", "ax ay vx vy viscous_x viscous_y")
state = Moving(*(np.full(3, value) for value in (1.0, 2.0, 3.0, 4.0, 0.0, 0.0)))
add_drag(Drag(0.5), state, 0, 2)
assert state.ax.tolist() == [-0.5, -0.5, 1.0] and state.ay.tolist() == [0.0, 0.0, 2.0]
assert state.viscous_x.tolist() == [-1.5, -1.5, 0.0] and state.viscous_y.tolist() == [-2.0, -2.0, 0.0], "energy that is taken"
""",
    "A wall": f"""
from sph.scene.schema import make_scene
from sph.solver.particles import SIDE, place_particles
scene = make_scene({SCENE % "'walls': {'sides': 'rough'}"})
assert (place_particles(scene).kind == SIDE).any() and scene.walls.kinds.sides.face == 0.4
""",
    "A law": f"""
from sph.scene.schema import make_scene
from sph.solver.physics.elasticity import Deviator, Strain
from sph.solver.physics.fluid_law import fluid_deviator
from sph.solver.physics.material import make_material
from sph.solver.terms import wanted_terms
scene = make_scene({SCENE % "'soil': {'viscosity': 3.0}, 'coupling': {'fluid': {'law': 'newtonian'}}"})
assert wanted_terms(scene)["newtonian"]
soil = make_material(scene.materials[0], scene.coupling, 1e-3)
assert fluid_deviator(soil.fluid_law, soil.fluid, 0.0, Deviator(1.0, 1.0, 1.0), Strain(0.0, 0.0, 0.5, 0.0, 1e-3)) == (0.0, 3.0, 0.0)
from sph.solver.physics.newtonian import LAW
limit = LAW.limit(scene)
assert abs(limit.seconds * 3.0 / (0.125 * scene.numerics.smoothing_length**2 * scene.soil.density) - 1.0) < 1e-12
""",
    "A metric": """
from sph.measures.metrics import METRIC_BY_NAME
assert METRIC_BY_NAME["failed_at_end"].units == "1"
""",
    "An experiment": """
import re, subprocess, sys
from synthetic import synthetic
from tools.reference import TABLES
from sph.experiments.duration.measure import measure_duration
from sph.measures.metrics import MetricSettings
done = subprocess.run([sys.executable, "-m", "snakemake", "--dry-run", "duration"], capture_output=True, text=True, check=True)
assert re.findall(r"^(simulate|duration_table|duration) +([0-9]+)$", done.stdout[done.stdout.rindex("Job stats:"):], re.M) == [
    ("simulate", "6"), ("duration_table", "1"), ("duration", "1")
]
assert "results/duration/runs/S_R-0.25/5-s.nc" in done.stdout and "results/duration/duration.csv" in done.stdout
rows = [("S_R-0.25/5-s", "S_R 0.25", 5.0)]
table = measure_duration(rows, {"S_R-0.25/5-s": synthetic()}, MetricSettings())
assert table["longer"].tolist() == [5.0] and table["collapse_class"].tolist() == ["stable"]
assert TABLES["duration_keys"]().rows[-1][0] == "longer"
""",
}
"""What must hold once the change of a section is made."""


def changes() -> dict[str, str]:
    """Diff of every section that shows one."""
    sections = re.findall(r"^## (.+?)\n(.*?)(?=^## |\Z)", PAGE, re.M | re.S)
    found = {title: re.search(r"```diff\n(.*?)```", text, re.S) for title, text in sections}
    return {title: diff[1] for title, diff in found.items() if diff}


def test_every_change_is_checked() -> None:
    assert set(changes()) == set(CHECKS)


@pytest.mark.parametrize("title", CHECKS)
def test_the_change_of_a_section(title: str, tmp_path: Path) -> None:
    for part in ("sph", "tools", "workflow", "config"):
        shutil.copytree(ROOT / part, tmp_path / part, ignore=shutil.ignore_patterns("__pycache__"))
    shutil.copy(ROOT / "Snakefile", tmp_path)
    diff = changes()[title]
    files = re.findall(r"^\+\+\+ b/(\S+)", diff, re.M)
    assert 1 <= len(files) <= MAX_FILES
    number = re.search(rf"\| \[[^]]+\]\(#{title.lower().replace(' ', '-')}\) \| (\d+)", PAGE)
    assert number and int(number[1]) == len(files), "the table of the page says how many"
    subprocess.run(["git", "apply", "-p1", "--unidiff-zero", "-"], input=diff, text=True, cwd=tmp_path, check=True)
    found = os.pathsep.join([str(tmp_path), str(ROOT / "tests")])
    subprocess.run([sys.executable, "-c", CHECKS[title]], cwd=tmp_path, env=os.environ | {"PYTHONPATH": found}, check=True)
