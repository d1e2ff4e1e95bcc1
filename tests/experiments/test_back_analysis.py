"""Back-analysis against problems whose answers are known: intervals, coverage, what is not reached, refusals, tables and figures."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest
import yaml
from test_sensitivity import CONFIG, METRIC, ROOT, SHIPPED, planned, sample_of, space_filling, unit_axes

from sph.experiments.registry import load_study
from sph.experiments.sensitivity.back_analysis import (
    ALONE,
    BACK_ANALYSIS,
    BEST,
    CONFIRMED,
    NOT_CONFIRMED,
    NOT_REACHED,
    OPEN,
    TOGETHER,
    Problem,
    back_tables,
    confirmed_columns,
    confirmed_table,
    point_columns,
    posterior_columns,
    problem_of,
)
from sph.experiments.sensitivity.design import chosen_points, load_sensitivity
from sph.experiments.sensitivity.factors import Axis, Observation, Quantity
from sph.experiments.sensitivity.figures_back import figure_back_analysis
from sph.experiments.sensitivity.posterior import CONFIDENCE, Prediction, Predictor, Target, alone, posterior, predictor
from sph.experiments.sensitivity.schema import SobolSettings
from sph.experiments.sensitivity.surrogate import TRUSTED, sobol_tables
from sph.page.tables import csv_table
from sph.scene.configuration import read_yaml
from sph.study.tables import read_csv, write_csv

HALF = 1.645
"""Half of the 90 % interval of a normal distribution, in standard deviations."""
SETTINGS = SobolSettings(folds=4, draws=50, points=64, least_q2=0.5)


def exact(slopes: list[list[float]], deviation: float = 0.0) -> Predictor:
    """Predicts sums of the shares times the slopes, (metrics, factors)."""

    def predict(shares: np.ndarray) -> Prediction:
        mean = shares @ np.transpose(slopes)
        return mean, np.full_like(mean, deviation)

    return predict


def target(*pairs: tuple[float, float]) -> Target:
    return Target(*np.transpose(pairs))


def test_one_factor_has_the_interval_of_the_line() -> None:
    found = posterior(exact([[20.0]]), target((8.0, 1.0)), 1)
    np.testing.assert_allclose(found.intervals[:, 0], [0.4 - HALF / 20, 0.4, 0.4 + HALF / 20], atol=5e-4)
    assert found.shares[found.nearest(np.array([0.9])), 0] == pytest.approx(0.4, abs=0.11 / 20)
    inside = found.mass <= 0.5  # a normal distribution's half lies within 0.674 standard deviations
    assert np.ptp(found.shares[inside]) == pytest.approx(2 * 0.674 / 20, rel=0.02)


def test_the_errors_of_observation_and_surrogate_add_in_quadrature() -> None:
    found = posterior(exact([[50.0]], 3.0), target((25.0, 4.0)), 1)
    np.testing.assert_allclose(found.intervals[:, 0], [0.5 - HALF / 10, 0.5, 0.5 + HALF / 10], atol=1e-3)


def test_two_factors_of_one_metric_are_known_only_together() -> None:
    predict, seen = exact([[10.0, 10.0]]), target((10.0, 1.0))
    found = posterior(predict, seen, 2)
    # Their sum is 1 ± 0.1, so that each is uniform but near its ends: its density is that of the normal distribution between -10 s and
    # 10 (1 - s), whose integral from 0 to 0.0718 is 0.05 of the whole.
    np.testing.assert_allclose(found.intervals, np.transpose([[0.0718, 0.5, 0.9282]] * 2), atol=5e-3)
    np.testing.assert_allclose(alone(predict, seen, np.array([0.3, 0.7]), 0), [0.3 - HALF / 10, 0.3, 0.3 + HALF / 10], atol=2e-3)
    # Of the points on the line the nearest to the scene's own values.
    np.testing.assert_allclose(found.shares[found.nearest(np.array([0.9, 0.5]))], [0.7, 0.3], atol=0.03)


def test_as_many_metrics_as_factors_are_known_one_by_one_however_exactly() -> None:
    found = posterior(exact(np.eye(3).tolist()), target((0.2, 0.002), (0.5, 0.002), (0.8, 0.002)), 3)
    width = HALF * 0.002
    np.testing.assert_allclose(found.intervals, np.add.outer([-width, 0.0, width], [0.2, 0.5, 0.8]), atol=6e-4)


@pytest.mark.long
def test_intervals_hold_the_truth_as_often_as_they_say() -> None:
    """The runs scatter, and so does what is observed: by the same scatter and by its error."""
    rng, scatter, error, count = np.random.default_rng(4), 0.5, 1.0, 200

    def metric(shares: np.ndarray) -> np.ndarray:
        return 30.0 * (1.0 - shares[:, 0]) ** 2 + 6.0 * shares[:, 1]

    shares, axes = space_filling(2, 64), unit_axes(2)
    sample = sample_of(shares, metric(shares) + scatter * rng.standard_normal(64))
    _, validation = sobol_tables(sample, axes, [METRIC], SETTINGS, 1)
    predict = predictor(sample, validation, axes, axes, [Observation(METRIC, 0.0, error)])
    truths = rng.random((count, 2))
    seen = metric(truths) + np.hypot(scatter, error) * rng.standard_normal(count)
    intervals = np.array([posterior(predict, target((value, error)), 2, points=512).intervals for value in seen])
    held = ((intervals[:, 0] <= truths) & (truths <= intervals[:, 2])).mean(axis=0)
    # Four standard errors of a share of 0.9 among 200 are 0.085.
    np.testing.assert_allclose(held, CONFIDENCE, atol=0.085)
    assert np.median(intervals[:, 2, 0] - intervals[:, 0, 0]) < 0.4 < np.median(intervals[:, 2, 1] - intervals[:, 0, 1])


def test_factors_that_are_not_sought_keep_the_scene_s_own_value() -> None:
    shares, axes = space_filling(2, 64), unit_axes(2)
    sample = sample_of(shares, 20.0 * shares[:, 0] + 8.0 * shares[:, 1])
    validation = sobol_tables(sample, axes, [METRIC], SETTINGS, 1)[1]
    predict = predictor(sample, validation, axes, axes[:1], [Observation(METRIC, 0.0, 1.0)])
    mean, deviation = predict(np.array([[0.25], [0.75]]))
    np.testing.assert_allclose(mean[:, 0], [9.0, 19.0], atol=0.1)
    assert (deviation < 0.3).all()


def test_a_surrogate_that_errs_more_than_it_says_gets_wider() -> None:
    shares, axes, observed = space_filling(1, 16), unit_axes(1), [Observation(METRIC, 0.0, 1.0)]
    sample = sample_of(shares, np.sin(6.0 * shares[:, 0]))
    validation = sobol_tables(sample, axes, [METRIC], SETTINGS, 1)[1]
    off = validation.assign(predicted=validation["computed"] + 3.0 * validation["predicted_sd"])
    within, outside = (predictor(sample, each, axes, axes, observed)(shares)[1] for each in (validation.iloc[:0], off))
    np.testing.assert_allclose(outside, 3.0 * within)


# ---------------------------------------------------------------- tables

S_R, GAMMA = Axis("S_R", "S_R", "-", 0.1, 0.5, False, 0.25), Axis("gamma", "γ", "1/s", 1.0, 100.0, True, 100.0)


def sampled(slopes: tuple[float, float]) -> pd.DataFrame:
    """Runs whose run-out is linear in the shares of S_R and γ."""
    shares = space_filling(2, 32)
    sample = sample_of(shares, 5.0 + shares @ np.array(slopes)).drop(columns=["x0", "x1"])
    return sample.assign(S_R=[S_R.value(share) for share in shares[:, 0]], gamma=[GAMMA.value(share) for share in shares[:, 1]])


def analysed(slopes: tuple[float, float], value: float, sought: list[str], error: float = 1.0) -> tuple[Problem, list[pd.DataFrame]]:
    axes, sample = [S_R, GAMMA], sampled(slopes)
    problem = problem_of(axes, sought, [Observation(METRIC, value, error)])
    return problem, list(back_tables(problem, axes, sample, *sobol_tables(sample, axes, [METRIC], SETTINGS, 1)))


def test_a_table_says_what_an_observation_determines() -> None:
    problem, (table, points, cloud) = analysed((-20.0, 0.0), -5.0, ["S_R"])
    row = table.iloc[0]
    assert list(table.columns) == [column.name for column in BACK_ANALYSIS] and len(table) == 1
    # 5 - 20 s = -5: half of the range of S_R, 0.3; 1 m is a twentieth of the range, 0.02.
    assert row[["median", "lower", "upper"]].tolist() == pytest.approx([0.3, 0.3 - HALF * 0.02, 0.3 + HALF * 0.02], abs=2e-3)
    assert (row["determined"], row["cut"], row["verdict"], row["prior"]) == (ALONE, "none", TRUSTED, "uniform")
    assert row["sentence"] == "S_R 0.3 (0.267 to 0.333, 90% interval) agrees with an observed run-out of -5 ± 1 m."
    assert list(points.columns) == [column.name for column in point_columns(problem.axes)]
    assert points["run"].tolist() == [BEST, "S_R/low", "S_R/high"] and (points["gamma"] == 100.0).all()
    assert points["predicted"].tolist() == pytest.approx([-5.0, -5.0 + HALF, -5.0 - HALF], abs=0.15)
    assert list(cloud.columns) == [column.name for column in posterior_columns(problem)] and cloud["weight"].sum() == pytest.approx(1.0)


def test_a_table_says_what_is_known_only_with_the_others_and_what_not_at_all() -> None:
    _, (together, points, _) = analysed((-20.0, 20.0), 5.0, ["S_R", "gamma"])
    assert together["determined"].tolist() == [TOGETHER] * 2 and together["prior"].tolist() == ["uniform", "log-uniform"]
    best = together.set_index("factor")["best"]
    assert S_R.share(best["S_R"]) == pytest.approx(GAMMA.share(best["gamma"]), abs=0.02)
    length = together["upper_at_best"] - together["lower_at_best"]
    assert length[0] == pytest.approx(2 * HALF * 0.02, rel=0.05)
    assert points["run"].tolist() == [BEST, "S_R/low", "S_R/high", "gamma/low", "gamma/high"]
    # Along the line both shares are equal, at the ends of the intervals as well.
    assert S_R.share(points["S_R"].to_numpy()) == pytest.approx(GAMMA.share(points["gamma"].to_numpy()), abs=0.03)
    assert "only together with the others" in together["sentence"][0]
    _, (table, _, _) = analysed((-20.0, 0.0), -5.0, ["S_R", "gamma"])
    assert table["determined"].tolist() == [ALONE, OPEN] and table["cut"].tolist() == ["none", "low and high"]
    assert table["sentence"][1].startswith("γ is not determined by an observed run-out of -5 ± 1 m: 1.2")
    assert table["median"][1] == pytest.approx(10.0, rel=0.05), "the middle of the decades"


def test_what_is_not_reached_is_said_with_the_nearest(tmp_path: Path) -> None:
    problem, (table, points, _) = analysed((-20.0, 0.0), 21.0, ["S_R"])
    row = table.iloc[0]
    assert row["determined"] == NOT_REACHED and math.isnan(row["median"]) and row["distance"] == pytest.approx(16.0, rel=0.03)
    assert row["best"] == pytest.approx(0.1, abs=1e-3) and points["run"].tolist() == [BEST]
    assert (
        row["sentence"]
        == "Nothing within S_R 0.1 to 0.5 agrees with an observed run-out of 21 ± 1 m: the nearest is run-out 5 m at S_R 0.1."
    )
    both = analysed((-20.0, 0.0), 21.0, ["S_R", "gamma"])[1][0]
    write_csv(both, tmp_path / "both.csv")
    assert len(both) == 2 and len(csv_table(tmp_path / "both.csv", "").sentences) == 1, "the page says it once"
    drawn = figure_back_analysis(
        table, analysed((-20.0, 0.0), 21.0, ["S_R"])[1][2], confirmed(problem, points, [5.0]), sampled((-20.0, 0.0)), problem
    )
    assert len(drawn.axes) == 1


def test_an_untrusted_surrogate_is_said_to_be() -> None:
    sample, axes = sampled((-20.0, 0.0)), [S_R, GAMMA]
    sample["runout"] = np.random.default_rng(1).standard_normal(len(sample))
    indices, validation = sobol_tables(sample, axes, [METRIC], SETTINGS, 1)
    problem = problem_of(axes, ["S_R"], [Observation(METRIC, 0.0, 1.0)])
    row = back_tables(problem, axes, sample, indices, validation)[0].iloc[0]
    assert row["verdict"].startswith("run-out: not to be trusted: Q² below") and row["sentence"].endswith("Q² below 0.5.")
    same = sample.assign(runout=0.0)
    rows = back_tables(problem, axes, same, *sobol_tables(same, axes, [METRIC], SETTINGS, 1))[0]
    assert "all runs have the same value" in rows["verdict"][0] and rows["determined"][0] == OPEN


def confirmed(problem: Problem, points: pd.DataFrame, runouts: list[float]) -> pd.DataFrame:
    runs = pd.DataFrame({"run": "back/" + points["run"], "runout": runouts})
    return confirmed_table(points, runs, problem)


def test_runs_confirm_or_do_not(tmp_path: Path) -> None:
    problem, (_, points, _) = analysed((-20.0, 0.0), -5.0, ["S_R"])
    table = confirmed(problem, points, [points["predicted"][0], -1.0, math.nan])
    assert list(table.columns) == [column.name for column in confirmed_columns(problem.axes)]
    assert table["verdict"].tolist() == [CONFIRMED, NOT_CONFIRMED, NOT_CONFIRMED]
    assert (
        "gives run-out -4.9" in table["sentence"][0]
        and "; predicted -" in table["sentence"][0]
        and "observed -5 ± 1 m" in table["sentence"][0]
    )
    assert "diverged" in table["sentence"][2]
    write_csv(points, tmp_path / "points.csv")
    again = chosen_points(tmp_path / "points.csv", problem.axes)
    assert again == {run: (S_R, gamma) for run, S_R, gamma in zip(points["run"], points["S_R"], points["gamma"], strict=True)}
    write_csv(table, tmp_path / "confirmed.csv")
    assert len(read_csv(tmp_path / "confirmed.csv", confirmed_columns(problem.axes), "it")) == 3
    assert len(csv_table(tmp_path / "confirmed.csv", "").sentences) == 3


def test_logarithms_are_taken_of_the_observation_too() -> None:
    seen = Observation(Quantity("displacement_magnitude", 0.1), 9.9, 1.0)
    assert seen.analysed == pytest.approx((1.0, 0.1 / math.log(10.0)))
    assert Quantity("displacement_magnitude", 0.1).metric_of(np.array([1.0])) == pytest.approx(9.9)


# ---------------------------------------------------------------- figures


def test_a_figure_of_one_factor_and_a_map_of_two_and_the_posterior_of_more() -> None:
    problem, (table, points, cloud) = analysed((-20.0, 0.0), -5.0, ["S_R"])
    curve = figure_back_analysis(table, cloud, confirmed(problem, points, [-5.0] * 3), sampled((-20.0, 0.0)), problem, "note")
    assert curve.axes[0].get_xlim() == (0.1, 0.5) and "note" in curve.get_supxlabel()
    problem, (table, points, cloud) = analysed((-20.0, 20.0), 5.0, ["S_R", "gamma"])
    drawn = figure_back_analysis(table, cloud, confirmed(problem, points, [5.0] * 5), sampled((-20.0, 20.0)), problem, "note")
    assert drawn.axes[0].get_yscale() == "log" and drawn.axes[0].get_ylim() == (1.0, 100.0)
    words = [text.get_text() for text in drawn.legends[0].get_texts()]
    assert {"50% region", "90% region", "run at the best point"} <= set(words)
    shares, axes = space_filling(3, 32), unit_axes(3)
    sample = sample_of(shares, 10.0 * shares[:, 0])
    problem = problem_of(axes, ["x0", "x1", "x2"], [Observation(METRIC, 5.0, 1.0)])
    table, points, cloud = back_tables(problem, axes, sample, *sobol_tables(sample, axes, [METRIC], SETTINGS, 1))
    assert len(figure_back_analysis(table, cloud, points, sample, problem).axes) == 3


# ---------------------------------------------------------------- configuration

RUNOUT: dict[str, Any] = {"observed": {"runout": {"value": 21.0, "error": 1.0}}}


@pytest.mark.parametrize(
    ("back", "words"),
    [
        ({"observed": {"run_out": {"value": 1.0, "error": 1.0}}}, ["back_analysis.observed", "run_out", "runout"]),
        ({"observed": {"runout": {"value": 1.0, "error": 0.0}}}, ["back_analysis.observed.runout.error", "0"]),
        ({"observed": {"runout": {"value": 1.0}}}, ["back_analysis.observed.runout.error", "required"]),
        ({"observed": {"displacement_magnitude": {"value": -0.2, "error": 1.0}}}, ["value: -0.2", "log_offset, -0.1"]),
        (RUNOUT | {"over": ["S_R", "gama"]}, ["back_analysis.over", "gama", "gamma"]),
        ({"observed": {}}, ["back_analysis.observed"]),
    ],
)
def test_refusals_name_file_key_and_value(tmp_path: Path, back: dict[str, Any], words: list[str]) -> None:
    with pytest.raises(ValueError) as raised:
        planned(tmp_path, {"back_analysis": back})
    assert all(word in str(raised.value) for word in ["sensitivity.yaml", *words]), str(raised.value)


def test_a_factor_that_the_sample_does_not_vary_is_not_sought(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match=r"back_analysis.over: 'gamma'.*S_R, height"):
        planned(tmp_path, {"sobol": {"factors": ["S_R", "height"]}, "back_analysis": RUNOUT | {"over": ["gamma"]}})


def test_the_shipped_example_stands() -> None:
    data = read_yaml(ROOT / "config" / "studies" / "back_analysis.yaml")
    plan = load_sensitivity(data["experiments"]["sensitivity"], load_study(CONFIG | data, [ROOT]), [ROOT])
    assert [axis.name for axis in plan.axes] == ["S_R", "gamma"] and plan.sought == () and plan.observations[0].error == 1.0


def test_one_factor_is_enough(tmp_path: Path) -> None:
    one = SHIPPED | {"factors": {"S_R": SHIPPED["factors"]["S_R"]}, "sobol": {"samples": 8, "factors": ["S_R"]}}
    (tmp_path / "sensitivity.yaml").write_text(yaml.safe_dump(one))
    plan = load_sensitivity("sensitivity.yaml", load_study(CONFIG, [ROOT]), [tmp_path])
    assert len(plan.design("morris")) == 20 and len(plan.design("sobol", ["S_R"])) == 8


def test_without_an_observation_the_key_to_write_is_named(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match=r"sensitivity.yaml: back_analysis: .*observed: \{runout: \{value"):
        _ = planned(tmp_path).observations
    plan = planned(tmp_path, {"back_analysis": RUNOUT | {"over": ["gamma"]}})
    assert plan.sought == ("gamma",) and plan.observations == [Observation(METRIC, 21.0, 1.0)]
