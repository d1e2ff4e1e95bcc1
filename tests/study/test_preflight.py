"""What is found of scenes before any run: records, stability, the table of a study; and runs whose soil fails before the shaking."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from sph.experiments.study_row import run_values
from sph.measures.metrics import MetricSettings
from sph.scene.configuration import dotted, merge
from sph.scene.ground_motion import GroundMotion
from sph.scene.schema import Scene, make_scene
from sph.scene.strict_json import parse_json
from sph.solver.checkpoint import run_digest, run_to_file
from sph.stability.newmark import sliding_block
from sph.stability.safety import DEFAULT_RULE, factor_of_safety
from sph.storage import trajectory
from sph.storage.trajectory import Status
from sph.study.findings import CODES, POLARITY_RATIO, Finding, Severity, codes, drifting, findings
from sph.study.preflight import QUESTIONS, Row, coarser, read_preflight, study_findings, study_stability, write_preflight

SLOPE: dict[str, Any] = {
    "scheme": "paper",
    "name": "cut",
    "duration": 6.0,
    "geometry": {"shape": "ground_line", "points": [[100, 440], [120, 440], [130, 450], [150, 450]], "base": 435},
    "soil": {"cohesion": 25.0, "friction_angle": 20.0},
    "coupling": {"S_R": 0.3, "gamma": 10.0},
    "motion": {"kind": "tapered_sine", "start": 3.0, "ramp": 0.5, "decay_start": 4.0, "end": 5.0, "frequency": 2.0, "amplitude": 3.0},
    "numerics": {"spacing": 1.0, "smoothing_ratio": 1.3, "time_step": 1e-3},
}
"""A slope of 1 : 1, 10 m high, of some 400 particles."""
TIME = np.arange(4000) * 0.01
BURST = 3.0 * np.sin(2 * np.pi * 2.0 * TIME) * np.sin(np.pi * TIME / 40.0) ** 2


def scene(**settings: Any) -> Scene:
    return make_scene(merge(SLOPE, dotted(settings)))


def found(acceleration: np.ndarray) -> list[str]:
    return [each.code for each in drifting(GroundMotion(TIME, acceleration), "motion.baseline={}")]


# ---------------------------------------------------------------- records


def test_a_record_is_told_by_what_is_wrong_with_it() -> None:
    assert found(BURST) == []
    # The recorder's zero is wrong by 0.58 m/s2: the ground would be doing 23 m/s after 40 s.
    assert found(BURST + 0.58) == ["record-offset", "record-displacement"]
    # The end of a pulse is missing: too short to be an offset.
    assert found(np.where(TIME < 20.12, BURST, 0.0)) == ["record-drift", "record-lasting"]
    # A metre of fling, as beside a fault: velocity comes back to zero, displacement does not.
    fling = np.where((TIME > 10) & (TIME < 12), np.pi / 2 * np.sin(np.pi * (TIME - 10)), 0.0)
    assert found(fling) == ["record-lasting"]
    assert found(4.0 * fling) == ["record-displacement"]


def record_scene(acceleration: np.ndarray, **settings: Any) -> Scene:
    record = {"kind": "record", "start": 3.0, "data": {"interval": 0.01, "x": acceleration.tolist()}}
    return scene(**{"motion": record, "duration": 45.0, **settings})


def test_the_record_of_a_scene_is_looked_at_as_processed() -> None:
    wrong = {each.code: each for each in findings(record_scene(BURST + 0.58))}
    assert wrong["record-offset"].key == "motion.baseline={}" and "0.0591 g" in wrong["record-offset"].measured
    mended = findings(record_scene(BURST + 0.58, **{"motion.baseline": {"degree": 0}}))
    assert not {"record-offset", "record-drift", "record-displacement"} & {each.code for each in mended}


def test_the_direction_of_a_record_is_told_where_it_matters() -> None:
    # Short strong pulses to one side, long weak ones to the other.
    one_sided = np.where(TIME % 4.0 < 0.5, -4.0, 4.0 * 0.5 / 3.5)
    strength = POLARITY_RATIO * 4.0
    turned, as_it_is = (sliding_block(TIME, sign * one_sided, strength).permanent for sign in (-1.0, 1.0))
    assert as_it_is == 0.0 < turned
    (told,) = [each for each in findings(record_scene(one_sided)) if each.code == "record-polarity"]
    assert (told.severity, told.key) == ("note", "motion.factor=-1") and f"{turned:.2g} m" in told.measured
    assert "record-polarity" not in {each.code for each in findings(record_scene(-one_sided))}


# ---------------------------------------------------------------- codes


def test_codes_are_those_of_the_list_each_once_in_its_order() -> None:
    some = [Finding(code, "note", "", "") for code in ("time-step", "fails-unshaken", "time-step")]
    assert parse_json(codes(some)) == ["fails-unshaken", "time-step"]
    assert parse_json(codes([])) == []
    assert all(code.severity in list(Severity) and code.text for code in CODES.values())


def test_findings_lie_in_the_file_and_decide_nothing_of_the_run(tmp_path: Path) -> None:
    short = scene(**{"duration": 3.5})
    plain = run_to_file(short, tmp_path / "plain.nc", "gravity", seconds=0)
    told = run_to_file(short, tmp_path / "told.nc", "gravity", seconds=0, attrs={"findings": codes(findings(short))})
    for name in plain.trajectory.variables:
        np.testing.assert_array_equal(plain.trajectory[name], told.trajectory[name])
    for name in plain.restart.variables:
        np.testing.assert_array_equal(plain.restart[name], told.restart[name])
    attrs = trajectory.read(tmp_path / "told.nc").attrs
    assert "motion-cut-off" in parse_json(attrs["findings"])
    assert attrs["run_digest"] == plain.trajectory.attrs["run_digest"] == run_digest(short, "gravity", {})


# ---------------------------------------------------------------- stability of a study


def test_each_slope_and_each_residual_strength_is_tested_once() -> None:
    scenes = {f"{ratio}-{rate}": scene(**{"coupling.S_R": ratio, "coupling.gamma": rate}) for ratio in (0.3, 0.9) for rate in (1.0, 9.0)}
    said: list[str] = []
    rows = study_stability(scenes, ["factor-of-safety"], said.append)
    assert [(row.finding.code, row.runs, row.first_run) for row in rows] == [
        ("stands-unshaken", 4, "0.3-1.0"),
        ("fails-at-residual", 2, "0.3-1.0"),
        ("stands-at-residual", 2, "0.9-1.0"),
        ("factor-of-safety", 1, "0.3-1.0"),
    ]
    assert len(said) == 4, "a slope, two residual strengths, a search"
    value = factor_of_safety(coarser(scenes["0.3-1.0"]), 0.05).value
    assert rows[-1].finding.measured.startswith(f"{value:.2f}, at a spacing of ") and DEFAULT_RULE.displacement == 0.05


def test_a_slope_that_fails_unshaken_is_an_error_and_is_not_searched() -> None:
    weak = scene(**{"soil.cohesion": 1.0, "soil.friction_angle": 5.0})
    (row,) = study_stability({"weak": weak}, list(QUESTIONS), lambda line: None)
    assert (row.finding.code, row.finding.severity) == ("fails-unshaken", "error")


def test_what_has_no_slope_is_told_with_the_reason() -> None:
    still = scene(**{"gravity.acceleration": 0.0})
    (row,) = study_stability({"still": still}, list(QUESTIONS), lambda line: None)
    assert row.finding.code == "stability-unknown" and "without gravity every slope stands" in row.finding.measured


def test_the_table_has_errors_first_and_comes_back_as_written(tmp_path: Path) -> None:
    rows = study_findings({"short": scene(**{"duration": 4.0}), "long": scene()})
    assert {(row.finding.code, row.runs) for row in rows} >= {("motion-cut-off", 1), ("no-process-zone", 2)}
    error = Row(Finding("fails-unshaken", "error", "the slope, with a comma", "fails", "to stand", "soil"), 2, "short")
    write_preflight(tmp_path / "preflight.csv", [*rows, error])
    back = read_preflight(tmp_path / "preflight.csv")
    assert back[0] == error and set(back) == {*rows, error}
    assert [row.finding.severity for row in back] == sorted((row.finding.severity for row in back), key=list(Severity).index)
    (tmp_path / "other.csv").write_text("a,b\n1,2\n")
    with pytest.raises(ValueError, match="are not those of the preflight"):
        read_preflight(tmp_path / "other.csv")


# ---------------------------------------------------------------- soil that fails before the shaking


@pytest.mark.parametrize(
    "settings",
    [
        {},
        {"coupling.initiation": {"slip": 1e-3, "length": 3.0}},
        {"gravity.initial_stress": "geostatic", "gravity.ramp": 0.0},
    ],
    ids=["paper", "process zone", "geostatic"],
)
def test_a_slope_that_collapses_in_the_gravity_stage_says_so_in_its_status(tmp_path: Path, settings: dict[str, Any]) -> None:
    weak = scene(**{"soil.cohesion": 1.0, "soil.friction_angle": 5.0}, **settings)
    path = {until: tmp_path / f"{until}.nc" for until in ("gravity", "first_failure", "end")}
    run_to_file(weak, path["gravity"], "gravity", seconds=0)
    run_to_file(weak, path["first_failure"], "first_failure", path["gravity"], seconds=0)
    run = run_to_file(weak, path["end"], "end", path["first_failure"], seconds=0, attrs={"findings": codes(findings(weak))})
    assert run.status == Status.FAILED_UNSHAKEN
    assert "of the soil yields under gravity alone" in run.trajectory.attrs["status_reason"]
    values = run_values(trajectory.read(path["end"]), MetricSettings(), float("nan"))
    assert values["status"] == "failed_unshaken" and float(values["failed_unshaken"]) > 0.1
    assert float(values["gravity_stage_displacement"]) > 0.1 and values["first_failure_time"] == pytest.approx(3.0)
    assert values["findings"] == " ".join(code for code in CODES if code in {each.code for each in findings(weak)})
