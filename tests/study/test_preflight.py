"""What is found of scenes before any run: records, stability, the table of a study; and runs whose soil fails before the shaking."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from typer.testing import CliRunner

from sph.checks.cover_rows import covers
from sph.checks.finding import Finding, codes, finding
from sph.checks.layers import broken_at, own_spacings
from sph.checks.messages import MESSAGES, Severity, meaning, words
from sph.checks.motion import POLARITY_RATIO, drifting, mean_period, other_direction
from sph.checks.scene import PLACEHOLDER, PLACEHOLDER_SOIL, choices, findings
from sph.checks.stability import QUESTIONS, TIMES, WITHIN, Peak, at_peak, of_softening, stability, strength_needed
from sph.command.cli import app
from sph.experiments.study_row import run_values
from sph.measures.metrics import MetricSettings
from sph.output.run import Run
from sph.scene.configuration import dotted, merge
from sph.scene.gravity import FAILED_AREA, GRAVITY, UNSHAKEN
from sph.scene.ground_motion import GroundMotion
from sph.scene.natural_periods import natural_frequency
from sph.scene.schema import Scene, load_scene, make_scene
from sph.scene.strict_json import parse_json
from sph.scene.uncertain import STEEPEST
from sph.solver.checkpoint import run_digest, run_to_file
from sph.solver.run import run
from sph.stability.extrapolation import UNASKED_RATIO, Extrapolated, extrapolated
from sph.stability.newmark import sliding_block
from sph.stability.safety import DEFAULT_RULE, factor_of_safety, yield_acceleration
from sph.stability.search import Trial
from sph.stability.standing import FailureRule, loses_strength, static_scene
from sph.storage import trajectory
from sph.storage.trajectory import Status
from sph.study.cost import cost
from sph.study.preflight import (
    COVER_ROWS,
    QUICK_TOLERANCE,
    Row,
    quick_spacings,
    read_preflight,
    search_seconds,
    search_spacings,
    standing_scene,
    stop_for_errors,
    study_equilibrium,
    study_findings,
    study_limits,
    study_stability,
    write_preflight,
)

SCENES = Path(__file__).parents[2] / "config" / "scenes"

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


def of_study(scenes: Mapping[str, Scene], say: Callable[[str], None], searches: Sequence[str] = tuple(QUESTIONS)) -> list[Row]:
    """What is tested and searched beside the runs of a study."""
    rows = study_stability(scenes, say)
    return rows + study_equilibrium(scenes, rows, say) + study_limits(scenes, rows, say, searches)


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
    assert words(wrong["record-offset"]).key == "motion.baseline={}" and "0.0591 g" in words(wrong["record-offset"]).measured
    mended = findings(record_scene(BURST + 0.58, **{"motion.baseline": {"degree": 0}}))
    assert not {"record-offset", "record-drift", "record-displacement"} & {each.code for each in mended}


@pytest.mark.parametrize(("interval", "told"), [(0.01, False), (0.1, False), (0.11, True), (1.0, True)])
def test_samples_far_apart_are_told(interval: float, told: bool, tmp_path: Path) -> None:
    sparse = {"kind": "record", "start": 3.0, "data": {"interval": interval, "x": [0.0, 1.0, -1.0, 0.0]}}
    found = {each.code: each for each in findings(scene(motion=sparse, duration=45.0))}
    assert ("record-sparse" in found) == told
    path = tmp_path / "a.csv"
    path.write_text("time,acc (m/s2)\n" + "".join(f"{interval * at:.2f},{value}\n" for at, value in enumerate((0, 1, -1, 0))))
    for command in (["motion", str(path)], ["newmark", str(path), "--ay", "0.5m/s2"]):
        assert ("samples of the record are so far apart" in CliRunner().invoke(app, command).stderr) == told


def test_the_direction_of_a_record_is_told_where_it_matters() -> None:
    # Short strong pulses to one side, long weak ones to the other.
    one_sided = np.where(TIME % 4.0 < 0.5, -4.0, 4.0 * 0.5 / 3.5)
    strength = POLARITY_RATIO * 4.0
    turned, as_it_is = (sliding_block(TIME, sign * one_sided, strength).permanent for sign in (-1.0, 1.0))
    assert as_it_is == 0.0 < turned
    (told,) = [each for each in findings(record_scene(one_sided)) if each.code == "record-polarity"]
    assert (told.severity, words(told).key) == ("note", "motion.factor=-1") and told.numbers["reversed"] == pytest.approx(turned)
    assert "record-polarity" not in {each.code for each in findings(record_scene(-one_sided))}
    # A study of the one direction is warned by the slope's own yield acceleration, unless it has the other one as well.
    alone = {"as it is": record_scene(one_sided)}
    (warned,) = other_direction(alone, strength).values()
    assert (
        warned.severity == "warning" and "both directions" in words(warned).wanted and warned.numbers["reversed"] == pytest.approx(turned)
    )
    assert other_direction(alone, 4.0) == {} == other_direction(alone, 0.0), "the slope does not slide; its yield acceleration is not known"
    assert other_direction(alone | {"reversed": record_scene(one_sided, **{"motion.factor": -1.0})}, strength) == {}


def test_the_mean_period_is_that_of_a_sine_and_of_two_by_their_power() -> None:
    time = np.arange(0.0, 40.0, 0.005)
    assert mean_period(GroundMotion(time, np.sin(2.0 * np.pi * 2.0 * time))) == pytest.approx(0.5, rel=0.01)
    # Amplitudes 2 at 1 Hz and 1 at 4 Hz: (4 x 1 s + 1 x 0.25 s) / 5.
    two = 2.0 * np.sin(2.0 * np.pi * time) + np.sin(8.0 * np.pi * time)
    assert mean_period(GroundMotion(time, two)) == pytest.approx(0.85, rel=0.01)
    assert mean_period(GroundMotion(time, np.zeros_like(time))) == 0.0


@pytest.mark.parametrize(("ratio", "told"), [(0.09, ""), (0.11, "underestimates"), (1.5, "does not represent")])
def test_a_slope_that_is_no_rigid_block_is_told(ratio: float, told: str) -> None:
    period = 1.0 / natural_frequency(scene(), scene().geometry.crest)
    shaken = scene(**{"motion.frequency": ratio / period})
    found = [each for each in findings(shaken) if each.code == "block-not-rigid"]
    assert [each.severity for each in found] == ["note"] * bool(told) and all(told in words(each).what for each in found)


# ---------------------------------------------------------------- codes


def test_codes_are_those_of_the_list_each_once_in_its_order() -> None:
    some = [finding(code) for code in ("time-step", "fails-unshaken", "time-step")]
    assert parse_json(codes(some)) == ["fails-unshaken", "time-step"]
    assert parse_json(codes([])) == []
    assert all(map(meaning, MESSAGES))


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


def test_thin_layers_have_two_rows_in_the_quick_tests() -> None:
    coarse, fine = quick_spacings(scene(**{"numerics.spacing": 0.4}))
    assert (coarse, fine) == pytest.approx((1.0, 2.0 / 3.0)), "no coarser than the rule allows, a tenth of H, and two thirds of that"
    for thickness, expected in ((1.6, 2.0 / 3.0), (1.2, 10.0 / 17), (0.4, 0.4)):
        clay = {"clay": {"region": {"kind": "elevation", "bottom": 437.0, "top": 437.0 + thickness}, "soil": {"cohesion": 18.0}}}
        assert quick_spacings(scene(**{"numerics.spacing": 0.4, "layers": clay})) == pytest.approx((1.0, expected))


@pytest.fixture
def known(monkeypatch: pytest.MonkeyPatch) -> float:
    """Slopes that need no run: they stand, at residual strength where more than half of it is left; the cohesion at which F is 1, kPa."""
    critical = 17.3  # as limit equilibrium has it

    def trial(value: float, stands: bool) -> Trial:
        return Trial(value, stands, 0.0 if stands else 1e3, 0.0, "complete", 0.0)

    monkeypatch.setattr("sph.study.preflight.at_peak", lambda scene: Peak(trial(1.0, True), 1.0, mobilised={"soil": 0.5}))
    monkeypatch.setattr("sph.checks.stability.at_residual", lambda static: trial(static.coupling.S_R, static.coupling.S_R > 0.5))
    monkeypatch.setattr("sph.stability.safety.stand", lambda static, rule, value: trial(value, static.soil.cohesion > critical))
    return critical


def test_each_slope_and_each_residual_strength_is_tested_once(known: float, monkeypatch: pytest.MonkeyPatch) -> None:
    searched: list[Extrapolated] = []

    def recorded(*arguments: Any, **options: Any) -> Extrapolated:
        searched.append(extrapolated(*arguments, **options))
        return searched[-1]

    monkeypatch.setattr("sph.checks.stability.extrapolated", recorded)
    scenes = {f"{ratio}-{rate}": scene(**{"coupling.S_R": ratio, "coupling.gamma": rate}) for ratio in (0.3, 0.9) for rate in (1.0, 9.0)}
    said: list[str] = []
    rows = of_study(scenes, said.append, ["factor-of-safety"])
    assert [(row.finding.code, row.runs, row.worst_run) for row in rows] == [
        ("stands-unshaken", 4, "0.3-1.0"),
        ("mobilised-strength", 4, "0.3-1.0"),
        ("fails-at-residual", 2, "0.3-1.0"),
        ("limit-equilibrium-residual", 2, "0.3-1.0"),
        ("stands-at-residual", 2, "0.9-1.0"),
        ("limit-equilibrium-residual", 2, "0.9-1.0"),
        ("limit-equilibrium", 4, "0.3-1.0"),
        ("factor-of-safety", 4, "0.3-1.0"),
    ]
    assert len(said) == 8, "a slope and the strength it uses, two residual strengths by both, a search, limit equilibrium beside it"
    (found,) = searched
    assert found.spacings == quick_spacings(scenes["0.3-1.0"]) and found.spacings[0] / found.spacings[1] == pytest.approx(UNASKED_RATIO)
    assert all(search.upper - search.lower <= QUICK_TOLERANCE * search.value for search in found.searches)
    assert words(rows[7].finding).measured == f"{found.value:.2f} ± {found.error:.2f}, {found.how}"


def test_each_slope_is_searched_and_a_factor_within_its_error_of_one_is_a_warning(known: float) -> None:
    scenes = {f"{cohesion}": scene(**{"soil.cohesion": cohesion}) for cohesion in (18.0, 40.0)}
    rows = [row for row in of_study(scenes, lambda line: None, ["factor-of-safety"]) if row.finding.code == "factor-of-safety"]
    assert [row.worst_run for row in rows] == ["18.0", "40.0"]
    for row, near in zip(rows, (True, False), strict=True):
        value, error = row.finding.numbers["value"], row.finding.numbers["error"]
        assert value == pytest.approx(float(row.worst_run) / known, abs=error)
        assert (row.finding.severity == Severity.WARNING) == near == (value - error < 1.0) == bool(row.finding.keys)


def test_slopes_that_are_not_searched_are_told(known: float, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("sph.study.preflight.LONGEST", 0.5 * cost(static_scene(standing_scene(scene()), DEFAULT_RULE)).seconds)
    scenes = {f"{ratio}": scene(**{"coupling.S_R": ratio, "soil.cohesion": 25.0 if ratio < 0.5 else 40.0}) for ratio in (0.3, 0.9)}
    rows = of_study(scenes, lambda line: None, [])
    assert ("stability-unknown", "0.9") in {(row.finding.code, row.worst_run) for row in rows}


@pytest.mark.long
def test_the_first_screen_is_not_on_the_unsafe_side() -> None:
    """The quick limits reach down to what a search at the scene's own spacing extrapolates."""
    slope = scene(**{"numerics.spacing": 0.75})
    rows = {row.finding.code: row.finding.numbers for row in of_study({"one": slope}, lambda line: None)}
    for code, find in (("factor-of-safety", factor_of_safety), ("yield-acceleration", yield_acceleration)):
        closer = extrapolated(find, slope)
        assert abs(rows[code]["value"] - closer.value) <= rows[code]["error"] + closer.error, (code, rows[code], closer)


@pytest.mark.long
def test_an_unshaken_failure_has_one_definition() -> None:
    """More failed soil than a hundredth of H2, in the status of a run and in the finding before it; a particle at yield is none."""
    fine = scene(**{"numerics.spacing": 0.5})
    assert not fine.fails_unshaken(4) and fine.fails_unshaken(5), "5 particles of 0.25 m2 on a slope of 10 m"
    assert DEFAULT_RULE.area == FAILED_AREA
    for cohesion in (40.0, 25.0, 12.0, 1.0):
        slope = scene(**{"soil.cohesion": cohesion, "duration": 3.5, "numerics.spacing": 1.25, "numerics.time_step": 5e-4})
        found = {row.finding.code for row in of_study({"one": slope}, lambda line: None, [])}
        ended = run(standing_scene(slope)).status
        assert (ended == Status.FAILED_UNSHAKEN) == bool(found & {"fails-unshaken", "softens-unshaken"}), (cohesion, found, ended)


def test_a_dimension_that_does_not_reach_a_layer_is_told() -> None:
    clay = {"layers": {"clay": {"region": {"kind": "depth", "top": 3.0, "bottom": 6.0}, "soil": {"cohesion": 18.0}, "S_R": 0.6}}}
    scenes = {str(ratio): scene(**{"coupling.S_R": ratio}, **clay) for ratio in (0.3, 0.5)}
    (row,) = [row for row in study_findings(scenes) if row.finding.code == "own-strength-ratio"]
    assert (row.runs, row.finding.severity, words(row.finding).key) == (2, "warning", "layers.clay.S_R")
    assert "own-strength-ratio" not in {row.finding.code for row in study_findings({"one": scenes["0.3"]})}


RESIDUAL = {"residual_cohesion": 0.0, "residual_friction_angle": 10.0}


@pytest.mark.parametrize(
    ("soil", "clay", "told"),
    [
        (RESIDUAL, {}, True),  # the clay inherits them
        ({"residual_cohesion": 0.0}, {}, False),  # S_R still divides the friction angle
        ({}, RESIDUAL, False),  # the soil above the clay feels it
    ],
)
def test_a_strength_ratio_that_no_soil_feels_is_told(soil: dict[str, float], clay: dict[str, float], told: bool) -> None:
    layers = {"clay": {"region": {"kind": "depth", "top": 3.0, "bottom": 6.0}, "soil": clay}}
    scenes = {str(ratio): scene(**{"coupling.S_R": ratio}, soil=soil, layers=layers) for ratio in (0.3, 0.5)}
    rows = [row for row in study_findings(scenes) if row.finding.code == "own-strength-ratio"]
    assert [(row.runs, words(row.finding).measured) for row in rows] == [(2, "residual strengths are given")] * told


def test_the_soil_of_sph_new_is_told_under_any_title() -> None:
    values = PLACEHOLDER_SOIL | {"shear_wave_speed": PLACEHOLDER_SOIL["s_wave_speed"], "viscosity": 2.0}
    keys = {name: value for name, value in SLOPE.items() if name != "scheme"} | {"damping": None, "title": "Mine"}
    keys["soil"] = {name: value for name, value in values.items() if name != "s_wave_speed"}
    told = [{each.code for each in findings(make_scene(merge(keys, {"soil": changed})))} for changed in ({}, {"cohesion": 21.0})]
    assert ["soil-not-replaced" in codes for codes in told] == [True, False]


def test_what_decides_by_its_default_is_told_of_ones_own_slopes() -> None:
    keys = {name: value for name, value in SLOPE.items() if name != "scheme"} | {"damping": None}
    keys["soil"] = {**SLOPE["soil"], "density": 1900.0, "youngs_modulus": 2e5, "poisson_ratio": 0.3, "viscosity": 2.0}
    own = make_scene(merge(keys, {"title": f"Mine {PLACEHOLDER}"}))
    told = {each.code: each for each in findings(own)}
    assert {"rigid-box", "no-dilation", "no-process-zone", "soil-not-replaced"} <= set(told)
    assert words(told["rigid-box"]).measured == "base no-slip, sides free-slip"
    assert [(label, text.split(" (")[0]) for label, text in choices(own)] == [
        ("initial stress", "gravity ramped up in elastic soil, K0 = 0.429 = nu /"),
        ("onset of failure", "as soon as the stress reaches the strength"),
        ("solid state of failed soil", "elastic-plastic, never beyond the peak strength"),
        ("dilation angle", "0 degree"),
        ("walls", "base no-slip, sides free-slip: a rigid box"),
    ]
    decided = {
        "title": "Mine",
        "soil": {"dilation_angle": 5.0},
        "walls": {"base": "absorbing", "sides": "absorbing"},
        "coupling": {"softening": {"slip_at_peak": 1e-3, "width": 3.0}},
    }
    assert not {"rigid-box", "no-dilation", "no-process-zone", "soil-not-replaced"} & {
        each.code for each in findings(make_scene(merge(keys, decided)))
    }
    assert not {"rigid-box", "no-dilation"} & {each.code for each in findings(scene())}, "the paper's scheme takes them from the paper"


def test_a_slope_that_fails_unshaken_is_an_error_and_is_not_searched() -> None:
    weak = scene(**{"soil.cohesion": 1.0, "soil.friction_angle": 5.0})
    (row,) = of_study({"weak": weak}, lambda line: None)
    assert (row.finding.code, row.finding.severity) == ("fails-unshaken", "error")
    assert words(row.finding).measured.endswith("at a spacing of 1 m"), "that of the runs, which costs little"


def test_a_slope_is_tested_at_the_spacing_of_its_runs_where_that_costs_little(monkeypatch: pytest.MonkeyPatch) -> None:
    slope = scene(**{"numerics.spacing": 0.5})
    assert standing_scene(slope) == slope
    monkeypatch.setattr("sph.study.preflight.OWN_SECONDS", 0.5 * cost(static_scene(slope, DEFAULT_RULE)).seconds)
    assert standing_scene(slope).numerics.spacing == quick_spacings(slope)[1] > 0.5
    weak = scene(**{"soil.cohesion": 1.0, "soil.friction_angle": 5.0, "numerics.spacing": 0.5})
    (row,) = of_study({"weak": weak}, lambda line: None)
    assert words(row.finding).measured.endswith("where the runs have 0.5 m")


def test_the_strength_that_each_layer_uses_is_told_and_a_warning_where_none_is_left(monkeypatch: pytest.MonkeyPatch) -> None:
    stands = Trial(1.0, True, 0.0, 0.0, "complete", 0.0)
    used = {"soil": 0.5, "clay": 0.991}
    monkeypatch.setattr("sph.study.preflight.at_peak", lambda static: Peak(stands, 1.0, mobilised=used))
    monkeypatch.setattr("sph.checks.stability.at_residual", lambda static: stands)
    found = [row.finding for row in of_study({"one": scene()}, lambda line: None, []) if row.finding.code == "mobilised-strength"]
    assert [(each.subject, each.severity) for each in found] == [("clay", "warning"), ("soil", "note")]
    assert words(found[0]).measured == "99 % of its peak strength" and words(found[0]).key.startswith("layers.clay.soil.K0")
    assert not words(found[1]).wanted and not words(found[1]).key


def test_a_slope_that_fails_as_it_softens_is_an_error_before_the_shaking(monkeypatch: pytest.MonkeyPatch) -> None:
    """What stands at its peak strength is tested again with its loss of strength, where soil has begun to fail and can lose any."""
    stands, falls = (Trial(1.0, stood, area, 0.0, "complete", 0.0) for stood, area in ((True, 0.0), (False, 7.0)))
    tested: list[Scene] = []

    def stand(static: Scene, rule: FailureRule, value: float) -> Trial:
        tested.append(static)
        return stands if value > 1.0 or not loses_strength(static.materials[0]) else falls

    monkeypatch.setattr("sph.checks.stability.at_residual", lambda static: stands)
    monkeypatch.setattr("sph.checks.stability.stand", stand)

    def told(*begun: int, **settings: Any) -> list[Finding]:
        monkeypatch.setattr("sph.study.preflight.at_peak", lambda static: Peak(stands, 1.0, begun=begun))
        rows = of_study({"one": scene(**settings)}, lambda line: None, [])
        return [row.finding for row in rows if row.finding.code == "fails-softened"]

    (found,) = told(0)
    assert found.severity == "error" and words(found).measured.startswith("7 m2 displaced")
    assert words(found).wanted == "to stand, as with a cohesion of 25.8 kPa and a friction angle of 20.6 degree in soil"
    assert len(tested) == 2 + found.numbers["static_tests"], "its own stiffness, the loss of strength, and other strengths"
    assert told() == [] and told(0, **{"coupling.gamma": 0.0, "coupling.solid_after_failure": "elastic_plastic"}) == []
    assert len(tested) == 2 + found.numbers["static_tests"]


@pytest.mark.long
def test_soil_that_softens_under_gravity_is_told_the_strength_with_which_it_does_not() -> None:
    """Typed as it is said it does away with the error, and brings no other; strength below that by the width of the bracket does not."""

    def told(cohesion: float, friction_angle: float, seeks: bool = False) -> list[Finding]:
        given = scene(**{"soil.cohesion": cohesion, "soil.friction_angle": friction_angle})
        return of_softening(at_peak(given), given, given, seeks)

    (weak,) = told(18.0, 20.0, seeks=True)
    assert weak.code == "softens-unshaken" and 3 <= weak.numbers["gravity_tests"] <= 6
    said = re.search(r"as with a cohesion of ([\d.]+) kPa and a friction angle of ([\d.]+) degree in soil$", words(weak).wanted)
    cohesion, angle = map(float, said.groups())  # type: ignore[union-attr]
    assert cohesion / 18.0 == pytest.approx(np.tan(np.radians(angle)) / np.tan(np.radians(20.0)), rel=0.01)
    assert told(cohesion, angle) == []
    less = 1.0 - 1.5 * WITHIN
    assert told(less * cohesion, np.degrees(np.arctan(less * np.tan(np.radians(angle)))))


@pytest.mark.parametrize("enough", [1.1, 1.6, 2.5])
def test_the_strength_needed_is_that_of_the_soils_that_failed(enough: float, monkeypatch: pytest.MonkeyPatch) -> None:
    """By a test whose answer is known; angles end at what a scene may have, and growth of the cohesion is scaled as well."""
    sand = {"region": {"kind": "depth", "top": 3.0, "bottom": 6.0}, "soil": {"cohesion": 0.0, "friction_angle": 42.0}}
    clay = {
        "region": {"kind": "depth", "top": 6.0},
        "soil": {"friction_angle": 0.0, "cohesion": 30.0, "cohesion_growth": {"gradient": 2.0}},
    }
    layered = scene(layers={"sand": sand, "clay": clay})
    tried: list[float] = []

    def softened(made: Scene, factor: float) -> Trial:
        tried.append(factor)
        assert made.soil == layered.soil, "it has not failed"
        return Trial(factor, factor >= enough, 0.0, 0.0, "complete", 0.0)

    monkeypatch.setattr("sph.checks.stability._softened", softened)
    numbers = strength_needed((1, 2), layered)
    assert numbers["static_tests"] == len(tried) <= 6
    text = words(finding("fails-softened", displaced_area=1.0, status="", spacing=1.0, run_spacing=1.0, **numbers)).wanted
    if enough > TIMES[0]:
        assert text == "to stand; 2 times the peak strength of sand, clay is not enough" and len(tried) == 2
        return
    factor = min(each for each in tried if each >= enough)
    angle = min(np.degrees(np.arctan(factor * np.tan(np.radians(42.0)))), STEEPEST)
    assert enough <= factor <= (1.0 + WITHIN) * enough
    assert numbers["clay.cohesion"] == pytest.approx(factor * 30e3, rel=0.01) and numbers["clay.gradient"] == pytest.approx(
        factor * 2e3, rel=0.01
    )
    assert np.degrees(numbers["sand.friction_angle"]) == pytest.approx(angle, abs=0.1) and "sand.cohesion" not in numbers
    assert re.fullmatch(
        r"to stand, as with a friction angle of [\d.]+ degree in sand and a cohesion of [\d.]+ kPa, growing by [\d.]+ kPa/m in clay", text
    )


def test_a_static_test_may_lose_strength_as_the_scene_does() -> None:
    slope = scene(layers={"clay": {"region": {"kind": "depth", "top": 3.0, "bottom": 6.0}, "gamma": 3.0}})
    kept, lost = (static_scene(slope, DEFAULT_RULE, softens=softens) for softens in (False, True))
    assert (kept.coupling.gamma, kept.layers["clay"].gamma) == (0.0, None)
    assert (lost.coupling, lost.layers["clay"].gamma) == (slope.coupling, 3.0)
    same = {"coupling", "layers"}
    assert kept.model_dump(exclude=same) == lost.model_dump(exclude=same)


def test_the_quick_searches_break_no_layer_that_is_whole(monkeypatch: pytest.MonkeyPatch) -> None:
    """What is nearly two rows at the scene's spacing would be less than one at twice that: finer spacings, or no search if they cost much.
    So does that for the sliding block, beside the runs."""
    seam = scene(layers=thin_layers(clay=0.7), **{"geometry.base": 425.0, "numerics.spacing": 0.4})
    assert quick_spacings(seam) == pytest.approx((1.0, 0.4)) and search_spacings(seam) == pytest.approx((10.0 / 15, 0.4))
    assert broken_at(seam, search_spacings(seam)) == [] != broken_at(seam, quick_spacings(seam))
    stands = Trial(1.0, True, 0.0, 0.0, "complete", 0.0)
    searched: list[Sequence[float]] = []

    def unsearched(*arguments: Any, **options: Any) -> None:
        searched.append(options["asked"])
        raise ValueError("no search in this test")

    for place in ("sph.study.preflight", "sph.checks.stability"):
        monkeypatch.setattr(f"{place}.at_peak", lambda static: Peak(stands, 0.4))
    monkeypatch.setattr("sph.checks.stability.at_residual", lambda static: stands)
    monkeypatch.setattr("sph.checks.stability.extrapolated", unsearched)
    said: list[str] = []
    found = {row.finding.code: row.finding for row in of_study({"one": seam}, said.append)}
    assert searched == [search_spacings(seam)] * len(QUESTIONS)
    assert "layer-broken" not in found
    assert broken_at(seam, own_spacings(seam)) == [] and own_spacings(seam) == pytest.approx((10.0 / 15, 0.4))
    assert "layer-broken" in {each.code for each in stability(seam)}
    searched.clear()
    monkeypatch.setattr("sph.study.preflight.DEARER", 1.1)
    told = [row.finding for row in of_study({"one": seam}, said.append) if row.finding.code == "stability-unknown"]
    assert [each.subject for each in told] == list(QUESTIONS) and not searched and search_seconds(seam, (9, 6)) == 0.0
    assert "gives thin soil its rows of particles" in words(told[0]).measured and "1.2 times as long" in words(told[0]).measured


def test_the_quick_searches_give_a_cover_three_rows() -> None:
    rock = {"rock": {"region": {"kind": "depth", "top": 2.4}, "soil": {"cohesion": 500.0, "friction_angle": 40.0}}}
    covered = scene(**{"numerics.spacing": 0.4, "layers": rock})
    (cover,) = covers(covered)
    coarse, fine = search_spacings(covered)
    assert cover.thickness / quick_spacings(covered)[0] < COVER_ROWS <= cover.thickness / coarse < COVER_ROWS + 1
    assert coarse >= UNASKED_RATIO * fine and round(10.0 / fine, 9).is_integer()


def test_what_has_no_slope_is_told_with_the_reason() -> None:
    still = scene(**{"gravity.acceleration": 0.0})
    (row,) = of_study({"still": still}, lambda line: None)
    assert row.finding.code == "stability-unknown" and "without gravity every slope stands" in words(row.finding).measured


def test_the_table_has_errors_first_and_comes_back_as_written(tmp_path: Path) -> None:
    rows = study_findings({"short": scene(**{"duration": 4.0}), "long": scene()})
    assert {(row.finding.code, row.runs) for row in rows} >= {("motion-cut-off", 1), ("no-process-zone", 2)}
    error = Row(
        finding("fails-unshaken", "soil.cohesion", "geometry", displaced_area=7.1, status="a, b", spacing=1.0, run_spacing=1.0), 2, "short"
    )
    write_preflight(tmp_path / "preflight.csv", [*rows, error])
    back = read_preflight(tmp_path / "preflight.csv")
    assert back[0] == error and set(back) == {*rows, error}
    assert [row.finding.rank for row in back] == sorted(row.finding.rank for row in back)
    assert [row.finding.severity for row in back] == sorted((row.finding.severity for row in back), key=list(Severity).index)
    with pytest.raises(ValueError, match=r"^short and 1 more: error: [^\n]*\[fails-unshaken\]\nno further run is started.*on_error=go_on"):
        stop_for_errors(back)
    stop_for_errors([row for row in back if row.finding.severity != Severity.ERROR])
    (tmp_path / "other.csv").write_text("a,b\n1,2\n")
    with pytest.raises(ValueError, match="preflight"):
        read_preflight(tmp_path / "other.csv")


def thin_layers(**thickness: float) -> dict[str, Any]:
    """Layers from 430 m upwards on which the spacing of 1 m puts 3, 2 and 1 rows, in the order in which they are given."""
    layers, bottom = {}, 430.0
    for name, rows in thickness.items():
        layers[name] = {"region": {"kind": "elevation", "bottom": bottom, "top": bottom + rows}, "soil": {"cohesion": 18.0}}
        bottom += rows
    return layers


def test_each_thin_layer_of_a_study_has_its_row_the_worst_first(tmp_path: Path) -> None:
    """Three findings of one code and one key: none takes the place of another."""
    one = scene(**{"geometry.base": 425.0}, layers=thin_layers(sand=3.0, silt=2.0, clay=1.0))
    told = [each for each in findings(one) if each.code == "thin-layer"]
    assert [(each.subject, words(each).measured) for each in told] == [
        (n, f"{r} across") for n, r in (("clay", "1 particle"), ("silt", "2 particles"), ("sand", "3 particles"))
    ]
    write_preflight(tmp_path / "preflight.csv", study_findings({"one": one}))
    assert [row.finding for row in read_preflight(tmp_path / "preflight.csv") if row.finding.code == "thin-layer"] == told


def test_a_finding_of_several_runs_has_the_words_of_the_worst() -> None:
    scenes = {f"{rows}": scene(**{"geometry.base": 425.0}, layers=thin_layers(clay=rows)) for rows in (3.0, 1.0, 2.0)}
    (row,) = [row for row in study_findings(scenes) if row.finding.code == "thin-layer"]
    assert (row.runs, row.worst_run, words(row.finding).measured) == (3, "1.0", "1 particle across")


@pytest.mark.parametrize("name", [path.name for path in sorted(SCENES.glob("*.yaml"))])
def test_no_two_findings_of_a_scene_are_taken_for_one(name: str) -> None:
    """What is found of a scene is in the table of its study, row by row, of weak waves and thin layers as well."""
    given = load_scene(SCENES / name)
    coarse = given.model_copy(update={"numerics": given.numerics.model_copy(update={"spacing": 2.0 * given.numerics.spacing})})
    for one in (given, coarse):
        assert [row.finding for row in study_findings({"one": one})] == findings(one)


# ---------------------------------------------------------------- soil that fails before the shaking


def test_soil_that_fails_before_the_ground_is_shaken_has_failed_unshaken() -> None:
    t_f = np.array([3.0, 3.4, 4.9, 5.0, 6.0, np.nan, 0.0])
    late = scene(**{"motion.start": 5.0, "motion.ramp": 0.0, "motion.decay_start": 5.5, "motion.end": 6.0})
    assert late.unshaken(t_f).tolist() == [True, True, True, True, False, False, False], "at 5 s the sine is 0"
    assert scene().unshaken(t_f).tolist() == [True] + 6 * [False]
    held = np.array([True, True, False, True, True, True, True])
    assert late.unshaken(t_f, held).tolist() == [True, False, True, False, False, False, False], "what a wall carries fails at nothing"
    for motion in ({"kind": "none"}, scene().motion.model_dump() | {"amplitude": UNSHAKEN * GRAVITY}):
        assert scene(motion=motion).shaken_from == np.inf
        assert scene(motion=motion).unshaken(t_f).tolist() == 5 * [True] + 2 * [False]
    # 3 (t / 0.5) sin(4 pi t) = 0.0025 g after 18.03 ms.
    assert scene().shaken_from == pytest.approx(3.01803, abs=1.01e-3), "the first step above it"


def test_a_mechanism_that_is_small_beside_the_slope_fails_unshaken_as_well() -> None:
    """1 m2 is no failure of a slope of 10 m by area, but is much of a slip of 7 m2; stones that roll off are none."""
    fine = scene(**{"numerics.spacing": 0.5})
    assert not fine.fails_unshaken(4) and fine.fails_unshaken(4, 30, 4)
    assert not fine.fails_unshaken(4, 30, 3) and not fine.fails_unshaken(4, 9, 4)


def test_the_status_names_the_layers_that_fail_unshaken() -> None:
    seam = {"seam": {"region": {"kind": "depth", "top": 4.0, "bottom": 7.0}, "soil": {"cohesion": 1.0, "friction_angle": 5.0}}}
    found = run(scene(layers=seam, duration=3.1, **{"soil.cohesion": 60.0}))
    assert found.status == Status.FAILED_UNSHAKEN
    whole, part = map(float, re.findall(r"([\d.]+)% of", found.trajectory.attrs["status_reason"]))
    assert "% of seam)" in found.trajectory.attrs["status_reason"] and part > whole > 0.0


SLIPPING = {
    "coupling.softening": {"slip_at_peak": 1e-3, "width": 3.0},
    "coupling.solid_after_failure": "elastic_plastic",
    "walls.base": "no_slip",
    "numerics.reference": "initial",
    "numerics.artificial_viscosity": {"reconstruction": "linear"},
}
"""Soil with a process zone, otherwise with the terms of the slope of ``tests/checks/test_room.py``."""


@pytest.mark.parametrize(
    "settings",
    [
        {},
        pytest.param(SLIPPING, marks=pytest.mark.long),
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
    values = run_values(Run.read(path["end"]), MetricSettings(), float("nan"))
    assert values["status"] == "failed_unshaken" and float(values["failed_unshaken"]) > 0.1
    assert float(values["gravity_stage_displacement"]) > 0.1
    slips_first = weak.coupling.softening is not None  # its slip counts from the end of the stage
    assert values["first_failure_time"] == pytest.approx(3.0, abs=0.01 if slips_first else 3e-6)
    assert values["findings"] == " ".join(code for code in MESSAGES if code in {each.code for each in findings(weak)})
