"""Answers that must follow from each other: a few scenes a relation, and five hundred in the long tests."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

import answers
import numpy as np
import of_strength
import pytest
from answers import Case
from of_strength import never_less, weaker
from relations import BY_SUBJECT, RELATIONS

from sph.scene.schema import Scene, make_scene
from sph.solver.run import Result, run

NOT_BY_PLACES = {
    "line_in_files",
    "record_in_units",
    "sliding_block_follows",
    "restart_of_another_scene",
    "weaker_soil_never_moves_less",
    "weaker_remains_never_move_less",
    "stronger_shaking_never_fails_later",
    "weaker_soil_never_fails_later",
}
"""Relations that do not compare places of particles, or refuse instead."""


def fitting(name: str, folder: Path, count: int) -> list[Case]:
    """The first scenes that a relation fits."""
    cases = (Case(number, folder) for number in range(100))
    return [case for case, _ in zip((case for case in cases if RELATIONS[name].fits(case)), range(count), strict=False)]


@pytest.mark.parametrize("name", RELATIONS)
def test_relation(name: str, tmp_path: Path) -> None:
    """On the first scene that it fits, and in the long tests on hundreds."""
    (case,) = fitting(name, tmp_path, 1)
    RELATIONS[name].check(case)


@pytest.mark.long
@pytest.mark.parametrize("name", [name for name in RELATIONS if name not in NOT_BY_PLACES])
def test_a_wrong_answer_is_noticed(name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Every run gives places that are wrong by a millimetre more than those of the run before."""
    error = 0.0

    def wrong(*arguments: object, **how: object) -> Result:
        nonlocal error
        error += 1e-3
        result: Result = run(*arguments, **how)  # type: ignore[arg-type]
        for ds in (result.trajectory, result.restart):
            ds["x"] = ds["x"] + np.array(error, ds["x"].dtype)
        return result

    for module in (answers, *BY_SUBJECT):
        monkeypatch.setattr(module, "run", wrong, raising=False)
    with pytest.raises(AssertionError):
        RELATIONS[name].check(fitting(name, tmp_path, 1)[0])


def test_weaker_soil_that_moves_less_is_noticed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """On every lattice; where the two ranges meet, it is chance."""
    case = fitting("weaker_soil_never_moves_less", tmp_path, 1)[0]
    strong = {**case.data, "soil": {**case.data["soil"], "cohesion": 20.0}}
    weak = weaker(strong, 0.5)
    short = run(make_scene({**strong, "duration": 1.0, "motion": {"kind": "none"}}))
    scenes: list[Scene] = []

    def kept(scene: Scene) -> Result:
        scenes.append(scene)
        return short

    monkeypatch.setattr(answers, "run", kept)
    monkeypatch.setattr(of_strength, "mean_displacement", lambda _: scenes[-1].soil.cohesion)
    never_less(case, weak, strong)
    with pytest.raises(AssertionError, match="the weaker moves 10 to 10 m, the stronger 20 to 20 m"):
        never_less(case, strong, weak)
    assert len({scene.numerics.spacing for scene in scenes}) == len(of_strength.LATTICES)
    chance = iter(np.linspace(1.0, 2.0, 10))
    monkeypatch.setattr(of_strength, "mean_displacement", lambda _: scenes[-1].soil.cohesion * next(chance))
    never_less(case, weaker(strong, 0.55), weak)


@pytest.mark.long
def test_many_scenes(request: pytest.FixtureRequest) -> None:
    """Every relation is tried, and holds."""
    script = Path(__file__).with_name("check.py")
    done = subprocess.run(
        [sys.executable, str(script), "--scenes", str(request.config.getoption("--scenes"))], capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stdout + done.stderr
    assert set(re.findall(r"tried +0 failed  (\w+)$", done.stdout, re.MULTILINE)) == set(RELATIONS)
