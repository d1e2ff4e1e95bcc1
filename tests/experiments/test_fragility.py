"""Fits of fragility curves against distributions that are known."""

from __future__ import annotations

import math
from itertools import combinations

import numpy as np
import pandas as pd
import pytest
from matplotlib.colors import to_hex, to_rgb
from scipy.stats import CensoredData, lognorm

from sph.experiments.trigger.critical import AT_LOWEST, BRACKETED, BRAKED, NEVER, UNDECIDED
from sph.experiments.trigger.design import Searched
from sph.experiments.trigger.figures_fragility import figure_fragility
from sph.experiments.trigger.fragility import CONFIDENCE, NO_FIT, TAILS, Lognormal, fitted, fragility, lognormality, resampled, steps
from sph.study.dimensions import Dimension

THETA, BETA = 3.0, 0.4
MOTIONS = 400
WIDTH = 0.125
SAMPLES = 200
"""Samples of which the intervals are counted that hold the truth."""
ERRORS = 4.0
"""Standard errors that an estimate may be off."""


def capacities(seed: int = 0, count: int = MOTIONS) -> np.ndarray:
    return THETA * np.exp(BETA * np.random.default_rng(seed).normal(size=count))


def bracketed(values: np.ndarray, width: float = WIDTH) -> tuple[np.ndarray, np.ndarray]:
    lower = width * np.floor(values / width)
    return lower, lower + width


def near(found: Lognormal, count: int, loss: float = 1.0) -> None:
    """Within the sampling error of ``count`` values: BETA / sqrt(n) of ln theta, BETA / sqrt(2 n) of beta, times what censoring loses."""
    assert abs(math.log(found.median / THETA)) < ERRORS * loss * BETA / math.sqrt(count)
    assert abs(found.dispersion - BETA) < ERRORS * loss * BETA / math.sqrt(2 * count)


def test_median_and_dispersion_are_found_again() -> None:
    values = capacities()
    found = fitted(*bracketed(values))
    near(found, MOTIONS)
    # Narrow brackets: the moments of the logarithms, but for the brackets' width squared.
    logs = np.log(values)
    narrow = fitted(*bracketed(values, 1e-4))
    assert narrow.median == pytest.approx(math.exp(logs.mean()), rel=1e-4)
    assert narrow.dispersion == pytest.approx(logs.std(), rel=1e-3)


def test_those_never_reached_and_those_reached_at_the_lowest_are_censored() -> None:
    lower, upper = bracketed(capacities())
    never, lowest = lower >= 3.5, upper <= 2.0  # a third, and an eighth
    near(fitted(np.where(never, 3.5, np.where(lowest, 0.0, lower)), np.where(never, np.inf, np.where(lowest, 2.0, upper))), MOTIONS, 2.0)


@pytest.mark.crosscheck
def test_the_fit_is_that_of_scipy() -> None:
    lower, upper = bracketed(capacities(4, 20), 0.25)
    lower, upper = np.where(upper <= 2.0, 0.0, lower), np.where(lower >= 3.5, math.inf, upper)
    closed = (lower > 0.0) & (upper < math.inf)
    intervals = np.column_stack([lower, upper])[closed]
    known = CensoredData(interval=intervals, left=upper[lower == 0.0], right=lower[upper == math.inf])
    assert known.num_censored() == 20 and 0 < closed.sum() < 18
    dispersion, _, median = lognorm.fit(known, floc=0.0)
    assert tuple(fitted(lower, upper)) == pytest.approx((median, dispersion), rel=2e-4), "its simplex stops at 1e-4"


def test_wide_brackets_carry_less_but_do_not_deceive() -> None:
    near(fitted(*bracketed(capacities(), 1.0)), MOTIONS, 1.5)


@pytest.mark.parametrize(
    ("lower", "upper"),
    [
        ([2.0], [2.1]),  # one
        ([2.0, 2.0, 1.9], [2.1, 2.2, 2.05]),  # 2.02 lies in all
        ([4.0, 4.0], [math.inf, math.inf]),  # never reached
        ([2.0, 3.0], [3.0, 4.0]),  # 3 ends both
        ([0.0, 2.0], [1.0, math.inf]),  # the wider the likelier
    ],
)
def test_what_does_not_determine_a_distribution_gives_none(lower: list[float], upper: list[float]) -> None:
    assert all(map(math.isnan, fitted(np.array(lower), np.array(upper))))
    assert all(map(math.isnan, NO_FIT))


def test_the_intervals_are_those_of_the_sampling_and_repeat() -> None:
    # Standard error of ln theta of 50 values: BETA / sqrt(50); that of 300 samples scatters by 4 %, that of one sample's beta by 10 %.
    ends = bracketed(capacities(3, 50))
    samples = resampled(*ends, resamples=300, seed=5)
    np.testing.assert_array_equal(samples[:20], resampled(*ends, resamples=300, seed=5)[:20])
    assert np.log(samples[:, 0]).std() == pytest.approx(BETA / math.sqrt(50), rel=0.45)


@pytest.mark.long
@pytest.mark.parametrize(("count", "highest"), [(12, 4.0), (40, math.inf)])
def test_the_intervals_cover_the_truth_at_their_rate(count: int, highest: float) -> None:
    # Of SAMPLES intervals the share that holds the truth is binomial: within three standard errors of the stated one.  Up to 4.0: of 3
    # values in 10 only a lower end is known.
    holds = np.zeros(2)
    for seed in range(SAMPLES):
        lower, upper = bracketed(capacities(1000 + seed, count), 0.25)
        never = lower >= highest
        samples = resampled(np.where(never, highest, lower), np.where(never, math.inf, upper), resamples=200, seed=seed)
        low, high = np.nanquantile(samples, TAILS, axis=0)
        holds += (low <= [THETA, BETA]) & (high >= [THETA, BETA])
    assert np.abs(holds / SAMPLES - CONFIDENCE).max() < 3.0 * math.sqrt(CONFIDENCE * (1.0 - CONFIDENCE) / SAMPLES)


def test_the_check_tells_lognormal_from_other_values() -> None:
    assert lognormality(capacities(1, 100))[1] > 0.01
    assert lognormality(np.concatenate([np.full(50, 1.0), np.full(50, 4.0)]) * np.linspace(1, 1.01, 100))[1] < 0.01
    assert all(map(math.isnan, lognormality(np.array([1.0, 2.0, 3.0]))))


def critical() -> pd.DataFrame:
    lower, upper = bracketed(capacities(2, 12), 0.25)
    table = pd.DataFrame({"lower": lower, "upper": upper, "outcome": BRACKETED, "changes": 1, "diverged": 0})
    table.loc[0, ["outcome", "upper"]] = NEVER, math.nan
    table.loc[1, ["outcome", "lower"]] = AT_LOWEST, math.nan
    table.loc[2, ["outcome", "lower", "upper", "diverged"]] = UNDECIDED, math.nan, math.nan, 4
    table.loc[3, "changes"] = 3
    return table.assign(
        case="as it is", collapse_class="collapse", intensity="amplitude", critical_intensity=0.5 * (table["lower"] + table["upper"])
    )


def test_the_table_counts_all_motions_and_says_it_in_words() -> None:
    table, curves = fragility(critical(), "m/s²")
    assert (curves["probability_lower"] <= curves["probability_upper"]).all()
    assert curves["probability"].is_monotonic_increasing
    (row,) = table.to_dict("records")
    counts = ("motions", "bracketed", "at_lowest", "never", "undecided", "braked", "not_monotone", "diverged")
    assert [row[name] for name in counts] == [12, 9, 1, 1, 1, 0, 1, 4]
    assert row["median_lower"] < row["median"] < row["median_upper"]
    in_g = [f"{row[name] / 9.81:.3g}" for name in ("median", "median_lower", "median_upper")]
    level = f"{row['median']:.3g} m/s² or {in_g[0]} g ({in_g[1]} to {in_g[2]} g, 90% interval)"
    assert f"50 % chance of reaching class collapse at {level}" in row["sentence"]
    assert "12 motions, 1 of them never reaching it" in row["sentence"] and "braked" not in row["sentence"]


def test_braked_motions_have_at_most_an_upper_end() -> None:
    """One whose debris reaches the place at the highest intensity counts as one reached at the lowest, one that never does not at all."""
    known = critical()
    braked = known.copy()
    braked.loc[1, "outcome"] = braked.loc[2, "outcome"] = BRAKED
    (row,), (same,) = (fragility(table, "m/s²")[0].to_dict("records") for table in (braked, known))
    assert (row["braked"], row["at_lowest"], row["undecided"]) == (2, 0, 0)
    assert row["median"] == same["median"] and row["dispersion"] == same["dispersion"]
    assert "2 with debris that is braked" in row["sentence"]


def test_probability_at_the_median_and_a_dispersion_above() -> None:
    found = Lognormal(THETA, BETA).exceedance(np.array([THETA, THETA * math.exp(BETA)]))
    np.testing.assert_allclose(found, [0.5, 0.841345], rtol=1e-6)


def test_the_steps_count_open_brackets() -> None:
    low, _, share = steps(np.array([0.0, 2.0, 1.0, 4.0]), np.array([1.0, 2.5, 1.5, math.inf]))
    np.testing.assert_array_equal(low, [1.0, 2.0])
    np.testing.assert_array_equal(share, [1.5 / 4, 2.5 / 4])


def test_places_and_lengths_have_curves_of_their_own_colours() -> None:
    names = ("minor", "collapse", "runout: road", "runout: house", "displacement: 0.1")
    rows = pd.concat([critical().assign(collapse_class=name) for name in names])
    table, curves = fragility(rows, "m/s²")
    searched = Searched((Dimension("amplitude", "m/s2", "", False), Dimension("seed", "-", "", False)), "amplitude")
    figure = figure_fragility(rows, table, curves, searched)
    drawn = [line for line in figure.axes[0].lines if line.get_label()[0] != "_"]
    assert [line.get_label().split("\n")[0] for line in drawn[-3:]] == [
        "road reached by debris",
        "house reached by debris",
        "a displacement of 0.1 m",
    ]
    ends = [float(np.max(line.get_xdata())) for line in drawn]
    assert max(ends) <= rows[["lower", "upper"]].max().max() < curves["intensity"].max(), "nothing is drawn that was not simulated"
    looks = [(to_hex(line.get_color()), line.get_linestyle()) for line in drawn]
    assert len({colour for colour, _ in looks}) == 5
    assert min(abs(grey(one) - grey(other)) for (one, _), (other, _) in combinations(looks[2:], 2)) > 0.03, "in print"


def grey(colour: str) -> float:
    """Luma of a colour, as a printer without colours shows it (ITU-R BT.601)."""
    return float(np.dot(to_rgb(colour), (0.299, 0.587, 0.114)))
