"""A run in the coordinates of its survey: places, directions and the shear stress, for slopes that fall to the left and to the right."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from synthetic import synthetic, translation

import sph
from sph.output.run import MARK, Run
from sph.output.surveyed import TURNED, in_survey
from sph.scene.schema import make_scene
from sph.solver.compiled.jit import SOURCES
from sph.storage import trajectory

LEFT = [[100.0, 440.0], [150.0, 440.0], [165.0, 465.0], [200.0, 465.0]]
"""A slope of 25 m whose foot is on the left; the box begins at (100, 430)."""
RIGHT = [[-x, y] for x, y in reversed(LEFT)]
"""Its mirror image."""
SHAKEN: dict[str, Any] = {
    "scheme": "paper",
    "name": "own",
    "duration": 2.5,
    "gravity": {"ramp": 0.5, "duration": 1.0},
    "motion": {"kind": "tapered_sine", "amplitude": 8.0, "start": 1.0, "ramp": 0.5, "decay_start": 2.0, "end": 2.5},
    "numerics": {"spacing": 5.0, "time_step": 1e-3},
    "outputs": {"frame_interval": 0.25, "series_interval": 0.01},
}
SAME = [row.name for row in trajectory.VARIABLES if row.name not in (*TURNED, "x", "x0")]


def ground(points: list[list[float]], downhill: str) -> dict[str, Any]:
    return {"shape": "ground_line", "points": points, "base": 430.0, "downhill": downhill}


@pytest.fixture(scope="module")
def runs(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    """Files of the slope and of its mirror image."""
    folder, found = tmp_path_factory.mktemp("runs"), {}
    for downhill, points in (("left", LEFT), ("right", RIGHT)):
        found[downhill] = folder / f"{downhill}.nc"
        sph.run_to_file(make_scene(SHAKEN | {"geometry": ground(points, downhill)}), found[downhill], say=lambda line: None)
    return found


def test_a_mirrored_scene_gives_mirrored_arrays(runs: dict[str, Path]) -> None:
    left, right = (sph.read_run(runs[side], survey=True) for side in ("left", "right"))
    assert np.abs(left["displacement_x"].values).max() > 0.1 and np.abs(left["stress_xy"].values).max() > 1e4, "something happens"
    for name in ("x", "x0", *TURNED):
        np.testing.assert_allclose(right[name], -left[name], rtol=0, atol=1e-12, err_msg=name)
    for name in SAME:
        np.testing.assert_array_equal(right[name], left[name], err_msg=name)


@pytest.mark.parametrize(("side", "sign"), [("left", -1.0), ("right", 1.0)])
def test_the_slope_falls_as_its_survey_does(runs: dict[str, Path], side: str, sign: float) -> None:
    run = sph.read_run(runs[side], survey=True)
    at_end = run.isel(frame=-1, particle=run["kind"].values == 0)
    far = np.abs(at_end["displacement_x"].values).argmax()
    assert sign * float(at_end["displacement_x"][far]) > 0.1, "soil moves downhill"
    crest = int(run["probe_particle"][0])
    place = float(run["x0"][crest]), float(run["y0"][crest])
    assert place == pytest.approx((-sign * 165.0, 465.0), abs=5.0), "the probe at the crest edge, within a spacing"
    moved = at_end["x"] - at_end["x0"]
    np.testing.assert_allclose(moved, at_end["displacement_x"], atol=1e-5)


def test_numbers_by_hand() -> None:
    """A box that begins at (500 000, 430) m and falls to the right: x = 500 000 - x of the box."""
    points = [[499900.0, 465.0], [499935.0, 465.0], [499950.0, 440.0], [500000.0, 440.0]]
    stored = synthetic(translation(-3.0, -1.0), overrides={"geometry": ground(points, "right")}).trajectory
    found = in_survey(stored)
    soil = (stored["kind"].values == 0) & (stored["y0"].values > 10.0)
    assert found["x"].dtype == np.float64, "single precision has steps of 3 cm there"
    np.testing.assert_allclose(found["x0"], 500000.0 - stored["x0"])
    np.testing.assert_allclose(found["y0"], 430.0 + stored["y0"])
    np.testing.assert_allclose(found["displacement_x"].values[-1][soil], 3.0)
    np.testing.assert_allclose(found["displacement_y"].values[-1][soil], -1.0)
    np.testing.assert_array_equal(found["ground_acceleration"], -stored["ground_acceleration"])
    np.testing.assert_array_equal(found["ground_acceleration_y"], stored["ground_acceleration_y"])
    assert {name: found[name].dims for name in found.variables} == {name: stored[name].dims for name in stored.variables}
    assert {name: found[name].attrs.get("units") for name in TURNED} == {name: trajectory.BY_NAME[name].units for name in TURNED}
    assert found["x"].attrs == {"units": "m", "long_name": "x in the survey"}


def test_a_slope_without_a_survey_has_the_coordinates_of_its_box(slid: Run) -> None:
    found = in_survey(slid.trajectory)
    for name in slid.trajectory.variables:
        np.testing.assert_array_equal(found[name], slid[name], err_msg=str(name))


def test_what_is_in_the_survey_is_not_measured_drawn_or_turned_again(slid: Run) -> None:
    found = in_survey(slid.trajectory)
    assert MARK not in slid.attrs, "what is given stays as it is"
    for refused in (sph.measure, sph.plot, in_survey):
        with pytest.raises(ValueError, match="without survey=True"):
            refused(found)


def test_editing_it_makes_no_stored_run_outdated() -> None:
    assert not [name for name in SOURCES if "surveyed" in name or name == "storage"]
