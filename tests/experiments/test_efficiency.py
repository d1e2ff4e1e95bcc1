"""Dispersions of measures of the shaking whose critical values are known."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest
import yaml

from sph.experiments.registry import load_study
from sph.experiments.trigger.critical import BRACKETED, UNDECIDED
from sph.experiments.trigger.design import Searched, load_trigger
from sph.experiments.trigger.efficiency import ARIAS, MEASURE_COLUMNS, PGA, PGV, measures_table, motion_measures
from sph.experiments.trigger.fragility import CONFIDENCE, TAILS, Conversion, resampled
from sph.scene.configuration import merge, read_yaml
from sph.scene.gravity import GRAVITY
from sph.scene.schema import make_scene
from sph.study.dimensions import Dimension
from sph.study.tables import read_csv, write_csv

ROOT = Path(__file__).resolve().parents[2]
SEARCHED = Searched((Dimension("seed", "-", "", False), Dimension("amplitude", "m/s2", "", False)), "amplitude")
REFERENCE = 9.0
MOTIONS = 60


def searched(velocities: np.ndarray, width: float = 0.01) -> tuple[pd.DataFrame, np.ndarray]:
    """Brackets in the peak acceleration of motions whose critical velocities are given, and the velocities of the motions at the
    reference: these vary by beta = 0.5 at one peak."""
    at_reference = 0.8 * np.exp(0.5 * np.random.default_rng(7).normal(size=velocities.size))
    critical = REFERENCE * velocities / at_reference
    lower = width * np.floor(critical / width)
    table = pd.DataFrame({"seed": [str(n) for n in range(velocities.size)], "lower": lower, "upper": lower + width})
    return table.assign(case="as it is", collapse_class="collapse", outcome=BRACKETED), at_reference


def motions(at_reference: np.ndarray) -> dict[tuple[str, ...], dict[str, float]]:
    """Arias intensities that follow the velocity's square."""
    return {("as it is", str(n)): {PGA: REFERENCE, PGV: value, ARIAS: 3.0 * value**2} for n, value in enumerate(at_reference)}


def test_the_measure_that_decides_scatters_least(tmp_path: Path) -> None:
    # The slope goes at a peak velocity of 0.3 m/s with beta = 0.2; the motions' velocities at one peak scatter by 0.5 besides.
    velocities = 0.3 * np.exp(0.2 * np.random.default_rng(3).normal(size=MOTIONS))
    table, at_reference = searched(velocities)
    found = measures_table(table, motions(at_reference), REFERENCE, SEARCHED)
    write_csv(found, tmp_path / "measures.csv")
    pd.testing.assert_frame_equal(read_csv(tmp_path / "measures.csv", MEASURE_COLUMNS, "measures"), found, check_dtype=False)
    by_name = found.set_index("measure")
    logs = np.log(velocities)
    assert by_name.loc[PGV, "median"] == pytest.approx(math.exp(logs.mean()), rel=2e-3)
    assert by_name.loc[PGV, "dispersion"] == pytest.approx(logs.std(), rel=5e-3)
    # Arias intensity is 3 v^2: the same order of motions, twice the dispersion, the same over its power.
    assert by_name.loc[ARIAS, "median"] == pytest.approx(3.0 * math.exp(2.0 * logs.mean()), rel=4e-3)
    assert by_name.loc[ARIAS, "dispersion"] == pytest.approx(2.0 * logs.std(), rel=5e-3)
    assert by_name.loc[ARIAS, "dispersion_over_power"] == pytest.approx(by_name.loc[PGV, "dispersion"], rel=1e-6)
    peaks = np.log(table["lower"] + 0.005)
    assert by_name.loc[PGA, "dispersion"] == pytest.approx(peaks.std(ddof=0), rel=5e-3)
    assert found["rank"].tolist() == [1, 2, 3] and found["measure"].iloc[-1] == PGA and by_name.loc[PGA, "searched"] == 1
    assert by_name["unit"].to_dict() == {PGA: "m s-2", PGV: "m s-1", ARIAS: "m s-1"}
    for row in found.to_dict("records"):
        assert row["dispersion_lower"] < row["dispersion"] < row["dispersion_upper"]


def test_searched_arias_intensities_give_the_same_peaks() -> None:
    velocities = 0.3 * np.exp(0.2 * np.random.default_rng(3).normal(size=MOTIONS))
    table, at_reference = searched(velocities)
    by_peak = measures_table(table, motions(at_reference), REFERENCE, SEARCHED).set_index("measure")
    # The same search in Arias intensity: every motion at 12 m/s, and its ends where the peaks are.
    at_arias = {key: {name: value for name, value in found.items() if name != ARIAS} for key, found in motions(at_reference).items()}
    scale = np.sqrt(12.0 / np.array([found[ARIAS] for found in motions(at_reference).values()]))
    at_arias = {
        key: {name: value * times for name, value in found.items()} for (key, found), times in zip(at_arias.items(), scale, strict=True)
    }
    of_arias = Conversion(12.0 / (REFERENCE * scale) ** 2, 2.0)
    table = table.assign(lower=of_arias.measured(table["lower"].to_numpy()), upper=of_arias.measured(table["upper"].to_numpy()))
    dimensions = Searched((SEARCHED.all[0], Dimension("motion.arias_intensity", "m/s", "", False)), "motion.arias_intensity")
    found = measures_table(table, at_arias, 12.0, dimensions).set_index("measure")
    for name in (PGA, PGV, ARIAS):
        assert found.loc[name, "median"] == pytest.approx(by_peak.loc[name, "median"], rel=1e-6)
        assert found.loc[name, "dispersion_over_power"] == pytest.approx(by_peak.loc[name, "dispersion_over_power"], rel=1e-6)
    assert found.loc[ARIAS, "power"] == 2.0 and found.loc[ARIAS, "searched"] == 1


def test_a_motion_that_says_nothing_and_one_without_measures() -> None:
    table, at_reference = searched(0.3 * np.exp(0.2 * np.random.default_rng(3).normal(size=MOTIONS)))
    table.loc[4, ["outcome", "lower", "upper"]] = UNDECIDED, math.nan, math.nan
    assert set(measures_table(table, motions(at_reference), REFERENCE, SEARCHED)["motions"]) == {MOTIONS - 1}
    still = motions(at_reference) | {("as it is", "7"): {PGA: 0.0, PGV: 0.0, ARIAS: 0.0}}
    assert measures_table(table, still, REFERENCE, SEARCHED).empty
    assert measures_table(table, dict.fromkeys(still, {}), REFERENCE, SEARCHED).empty


def test_one_factor_for_all_motions_only_shifts_the_samples() -> None:
    table, _ = searched(0.3 * np.exp(0.2 * np.random.default_rng(3).normal(size=20)), 0.5)
    ends = table["lower"].to_numpy(), table["upper"].to_numpy()
    own = resampled(*ends, resamples=50)
    squared = resampled(*ends, resamples=50, conversion=Conversion(np.full(20, 3.0), 2.0))
    np.testing.assert_allclose(squared, np.stack([3.0 * own[:, 0] ** 2, 2.0 * own[:, 1]], axis=1), rtol=1e-6)


@pytest.mark.long
def test_the_intervals_cover_the_truth_of_a_measure_that_was_not_searched() -> None:
    # Searched in peak acceleration in cells of 0.5 m/s2, true in velocity: of 200 intervals the share that holds beta is binomial.
    holds, count = 0, 200
    for seed in range(count):
        velocities = 0.3 * np.exp(0.2 * np.random.default_rng(100 + seed).normal(size=12))
        table, at_reference = searched(velocities, 0.5)
        conversion = Conversion(at_reference / REFERENCE, 1.0)
        samples = resampled(table["lower"].to_numpy(), table["upper"].to_numpy(), resamples=200, seed=seed, conversion=conversion)
        low, high = np.nanquantile(samples[:, 1], TAILS)
        holds += low <= 0.2 <= high
    assert abs(holds / count - CONFIDENCE) < 3.0 * math.sqrt(CONFIDENCE * (1.0 - CONFIDENCE) / count)


def test_measures_of_a_sine_are_those_of_its_formula(small_slope: Any) -> None:
    motion = {"kind": "tapered_sine", "amplitude": 2.0, "frequency": 2.0, "start": 1.0, "ramp": 0.0, "decay_start": 31.0, "end": 31.0}
    scene = make_scene(merge(small_slope({}).model_dump(mode="json"), {"motion": motion, "duration": 32.0}))
    found = motion_measures(scene, (0.5, 5.0))
    assert found[PGA] == pytest.approx(2.0, rel=1e-3)
    assert found[PGV] == pytest.approx(2.0 * 2.0 / (2.0 * math.pi * 2.0), rel=1e-2)  # from rest: twice A / w
    assert found[ARIAS] == pytest.approx(math.pi / (2.0 * GRAVITY) * 30.0 * 2.0**2 / 2.0, rel=1e-3)
    assert found["spectral acceleration at 0.5 s"] == pytest.approx(2.0 / (2.0 * 0.05), rel=1e-2)  # resonance: A / (2 zeta)
    constant = merge(small_slope({}).model_dump(mode="json"), {"motion": {"kind": "constant", "amplitude": 2.0, "start": 1.0, "ramp": 1.0}})
    assert motion_measures(make_scene(constant), (0.5,)) == {}


def test_the_motions_of_a_search_are_those_of_its_values(tmp_path: Path) -> None:
    study = load_study(read_yaml(ROOT / "config" / "studies" / "gentle_motions.yaml"), [ROOT])
    (tmp_path / "mine.yaml").write_text(
        yaml.safe_dump(
            read_yaml(ROOT / "config" / "studies" / "gentle_motions" / "trigger.yaml")
            | {"at": {"motion.stochastic.seed": [1, 2]}, "periods": [0.3]}
        )
    )
    plan = load_trigger(str(tmp_path / "mine.yaml"), study, [ROOT])
    scenes = plan.shaken
    assert list(scenes) == [("as it is", "1"), ("as it is", "2")]
    found = [motion_measures(scene.build(), plan.trigger.periods) for scene in scenes.values()]
    assert [each[PGA] for each in found] == pytest.approx([plan.trigger.intensity.highest] * 2, rel=5e-3)
    assert found[0][PGV] != found[1][PGV] and "spectral acceleration at 0.3 s" in found[0]
