"""Searches as files, with slopes that need no simulation."""

from __future__ import annotations

import math
from pathlib import Path

import pytest

from sph.checks.layers import own_spacings
from sph.checks.messages import search_words
from sph.scene.schema import Scene, make_scene
from sph.scene.units import in_both
from sph.stability.extrapolation import extrapolated
from sph.stability.record import run_search, search_to_file
from sph.stability.safety import yield_acceleration
from sph.stability.search import Trial
from sph.stability.standing import FailureRule
from sph.storage import trajectory
from sph.storage.trajectory import scene_of

LIMIT, SLOPE, SENSITIVE = 2.0, 0.4, 1.5
"""Yield acceleration at spacing 0 (m/s2), its error over the spacing (1/s2), and d ln a / d ln (strength)."""
SHAPE = {"shape": "slope", "slope_angle": 60.0, "slope_height": 20.0}


def scene(spacing: float) -> Scene:
    numerics = {"spacing": spacing, "time_step": 1e-4, "smoothing_ratio": 1.6}
    return make_scene({"name": "slope", "scheme": "paper", "duration": 4.0, "geometry": SHAPE, "numerics": numerics})


@pytest.fixture(autouse=True)
def tests(monkeypatch: pytest.MonkeyPatch) -> list[Trial]:
    """What is tested, in order: slopes with the limit above."""
    cohesion, made = scene(0.5).soil.cohesion, list[Trial]()

    def stand(at: Scene, rule: FailureRule, value: float) -> Trial:
        strength = at.soil.cohesion / cohesion
        stands = value < LIMIT * (1.0 + SENSITIVE * math.log(strength)) + SLOPE * at.numerics.spacing
        made.append(Trial(value, stands, 0.0 if stands else 1e3, 0.0, "complete", 1.0 + len(made)))
        return made[-1]

    monkeypatch.setattr("sph.stability.safety.stand", stand)
    return made


def test_the_file_of_an_extrapolated_search_has_value_error_and_every_trial(tmp_path: Path, tests: list[Trial]) -> None:
    search_to_file(scene(0.5), "yield_acceleration", tmp_path / "a.nc", lambda trial: None, spacings=own_spacings)
    found = trajectory.read(tmp_path / "a.nc")
    same = extrapolated(yield_acceleration, scene(0.5))
    assert found.attrs["value"] == same.value == pytest.approx(LIMIT, abs=0.03)
    assert found.attrs["error"] == same.error and abs(same.value - LIMIT) < same.error
    assert found.attrs["sensitivity"] == same.sensitivity == pytest.approx(SENSITIVE * LIMIT, rel=0.1)
    assert found.attrs["stood"] < LIMIT + 0.5 * SLOPE < found.attrs["failed"], "the bracket at the fine spacing"
    assert found.sizes["trial"] == same.runs and found.attrs["wall_time_s"] == sum(trial.wall_time for trial in tests[: same.runs])
    assert list(dict.fromkeys(zip(found["spacing"].values, found["strength"].values, strict=True))) == [(1.0, 1.0), (0.5, 1.0), (1.0, 1.1)]
    assert scene_of(found).numerics.spacing == 0.5, "the scene of the runs"
    assert search_words(found.attrs) == (in_both(same.value, same.error), "extrapolated from spacings of 1 and 0.5 m")


def test_a_search_at_one_spacing_has_that_value_and_no_error() -> None:
    found = run_search(scene(0.5), "yield_acceleration")
    assert found.attrs["value"] == pytest.approx(LIMIT + 0.5 * SLOPE, rel=0.005) and "error" not in found.attrs
    assert set(found["spacing"].values) == {0.5} and set(found["strength"].values) == {1.0}
    assert "makes slopes too strong" in search_words(found.attrs)[1]


@pytest.mark.parametrize("stop_after", [4, 18, 25])
def test_a_search_at_two_spacings_that_was_killed_repeats_no_trial(stop_after: int, tmp_path: Path, tests: list[Trial]) -> None:
    """A value may be tried at more than one spacing and strength: each is another test."""
    path, told = tmp_path / "a.nc", list[Trial]()
    whole = run_search(scene(0.5), "yield_acceleration", spacings=own_spacings).dataset()
    assert whole.sizes["trial"] == 27
    tests.clear()

    def stop(trial: Trial) -> None:
        told.append(trial)
        if len(told) == stop_after:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        search_to_file(scene(0.5), "yield_acceleration", path, stop, spacings=own_spacings)
    search_to_file(scene(0.5), "yield_acceleration", path, told.append, spacings=own_spacings)
    assert len(tests) == whole.sizes["trial"] + 1, "the last one was made, but not kept"
    assert trajectory.read(path).dataset().drop_vars("wall_time").equals(whole.drop_vars("wall_time"))


def test_spacings_of_a_study() -> None:
    """The runs' own and twice that; finer ones where the rule allows no coarser one; none for runs too coarse for any test."""
    for own, spacings in ((0.5, (1.0, 0.5)), (1.0, (2.0, 1.0)), (2.0, (2.0, 20.0 / 15))):
        assert own_spacings(scene(own)) == pytest.approx(spacings)
    refused = run_search(scene(2.5), "yield_acceleration", spacings=own_spacings)
    assert math.isnan(refused.attrs["value"]) and "too coarse to see a slope" in refused.attrs["reason"]
    assert search_words(refused.attrs)[0].startswith("not found: numerics.spacing")
