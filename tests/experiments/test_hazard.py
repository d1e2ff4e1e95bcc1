"""Annual frequencies from fragilities and hazard curves, against numerical integration and closed forms."""

from __future__ import annotations

import math
import tempfile
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest
import yaml
from hypothesis import given
from hypothesis import strategies as st
from record_files import FACTORS
from scipy.integrate import quad  # type: ignore[import-untyped]

from sph.experiments.registry import load_study
from sph.experiments.trigger.annual import annual_columns, annual_table, frequency_bounds
from sph.experiments.trigger.critical import AT_LOWEST, BRACKETED, NEVER, UNDECIDED
from sph.experiments.trigger.design import TriggerPlan, load_trigger
from sph.experiments.trigger.fragility import Lognormal
from sph.experiments.trigger.hazard import INTENSITIES, Hazard, annual_frequency, read_hazard
from sph.scene.configuration import read_yaml
from sph.study.tables import read_csv, write_csv

ROOT = Path(__file__).resolve().parents[2]
SITE = Hazard(np.array([0.2, 0.5, 1.0, 2.0, 5.0, 10.0]), np.array([0.2, 0.06, 0.06, 8e-3, 5e-4, 1e-5]))
"""One segment is flat: no shaking has its peak there."""


def integrated(fit: Lognormal, hazard: Hazard) -> float:
    """Integral of P |dH| by quadrature in ln x, a row at a time."""
    total = 0.0
    for low, high in zip(range(len(hazard.intensity) - 1), range(1, len(hazard.intensity)), strict=True):
        ends = np.log(hazard.intensity[[low, high]])
        k = -np.diff(np.log(hazard.frequency[[low, high]]))[0] / np.diff(ends)[0]

        def rate(log: float, k: float = k, start: float = ends[0], level: float = hazard.frequency[low]) -> float:
            return float(fit.exceedance(np.array([math.exp(log)]))[0]) * k * level * math.exp(-k * (log - start))

        total += quad(rate, *ends, epsabs=0.0, epsrel=1e-12, points=[math.log(fit.median)], limit=500)[0]
    return total


@pytest.mark.parametrize(
    "fit", [Lognormal(3.0, 0.4), Lognormal(0.3, 1.2), Lognormal(8.0, 0.05), Lognormal(40.0, 0.6), Lognormal(0.01, 0.3)]
)
def test_the_closed_form_is_the_integral(fit: Lognormal) -> None:
    found = annual_frequency(np.array([fit]), SITE)
    assert found[0] == pytest.approx(integrated(fit, SITE), rel=1e-6)


def test_a_power_law_over_all_intensities() -> None:
    # H = c x^-k from 0 to infinity: c theta^-k exp(k^2 beta^2 / 2), Cornell's closed form.
    wide = np.array([1e-6, 1.0, 1e6])
    found = annual_frequency(np.array([[2.0, 0.3], [3.0, 0.5]]), Hazard(wide, 1e-2 * wide**-2.5))
    assert found == pytest.approx(
        [1e-2 * 2.0**-2.5 * math.exp(0.5 * (2.5 * 0.3) ** 2), 1e-2 * 3.0**-2.5 * math.exp(0.5 * (2.5 * 0.5) ** 2)]
    )


def test_a_threshold_is_exceeded_as_often_as_the_hazard_says() -> None:
    at_three = 8e-3 * (3.0 / 2.0) ** (math.log(5e-4 / 8e-3) / math.log(2.5))  # log-log between 2 and 5
    assert SITE.at(3.0) == pytest.approx(at_three)
    found = annual_frequency(np.array([[3.0, 1e-4]]), SITE)[0]
    assert found == pytest.approx(at_three - 1e-5, rel=1e-3), "but for what is beyond the last row"


def test_the_parts_of_a_curve_add_up() -> None:
    parts = [annual_frequency(np.array([[3.0, 0.4]]), SITE.between(low, high))[0] for low, high in ((0.0, 1.5), (1.5, 99.0))]
    assert sum(parts) == pytest.approx(annual_frequency(np.array([[3.0, 0.4]]), SITE)[0], rel=1e-9)


def critical(count: int = 12) -> pd.DataFrame:
    values = 3.0 * np.exp(0.4 * np.random.default_rng(2).normal(size=count))
    lower = 0.25 * np.floor(values / 0.25)
    return pd.DataFrame({"case": "as it is", "collapse_class": "damaged", "lower": lower, "upper": lower + 0.25, "outcome": BRACKETED})


def test_the_table_says_how_often_and_what_is_left_out(tmp_path: Path) -> None:
    table = annual_table(critical(), SITE, 1.0, 5.0, "m/s²")
    write_csv(table, tmp_path / "annual.csv")
    pd.testing.assert_frame_equal(read_csv(tmp_path / "annual.csv", annual_columns("1"), "annual frequencies"), table)
    (row,) = table.to_dict("records")
    # The fit is 3 and 0.4 within its sampling error, so the frequency that of these within the interval.
    assert row["frequency_lower"] < integrated(Lognormal(3.0, 0.4), SITE) < row["frequency_upper"]
    assert row["frequency_lower"] < row["frequency"] < row["frequency_upper"]
    assert (row["first"], row["last"], row["beyond_last"]) == (0.2, 10.0, 1e-5) and row["probability_at_first"] < 1e-6
    assert 0.9 < row["share_searched"] < 1.0
    assert (
        "reaches class damaged or worse" in row["sentence"] and "Stronger shaking than 10 m/s² adds at most 1e-05 a year" in row["sentence"]
    )
    assert f"once in {float(format(1.0 / row['frequency'], '.2g')):,.10g} years" in row["sentence"] and "Weaker" not in row["sentence"]
    (late,) = annual_table(critical(), SITE.between(2.0, 10.0), 1.0, 5.0, "m/s²")["sentence"]
    assert "Weaker shaking than 2 m/s², at which the chance is" in late


def test_without_a_fit_there_is_no_frequency() -> None:
    never = critical(3).assign(outcome=NEVER, lower=5.0, upper=math.nan)
    (row,) = annual_table(never, SITE, 1.0, 5.0, "m/s²").to_dict("records")
    assert math.isnan(row["frequency"]) and row["frequency_least"] == 0.0
    assert row["frequency_most"] == pytest.approx(5e-4), "all of them just above 5"
    assert row["sentence"] == (
        "The brackets do not determine a fit. From them alone, the slope reaches class damaged or worse between 0 and 0.0005 times a year "
        "under this hazard curve."
    )


def test_brackets_alone_bound_the_frequency() -> None:
    """Of four motions one is reached at the lowest, 2, one between 2 and 5, one never up to 5, and one diverged."""
    found = critical(4).assign(
        outcome=[AT_LOWEST, BRACKETED, NEVER, UNDECIDED], lower=[math.nan, 2.0, 5.0, math.nan], upper=[2.0, 5.0, math.nan, math.nan]
    )
    at = {0.2: SITE.at(0.2), 2.0: 8e-3, 5.0: 5e-4}
    least, most = frequency_bounds(found, SITE)
    assert least == pytest.approx((at[2.0] + at[5.0]) / 4)
    assert most == pytest.approx((at[0.2] + at[2.0] + at[5.0] + at[0.2]) / 4)
    (row,) = annual_table(critical(), SITE, 1.0, 5.0, "m/s²").to_dict("records")
    assert row["frequency_least"] < row["frequency"] + row["beyond_last"] < row["frequency_most"], "narrow brackets lie about the fit"


def test_a_search_beyond_the_hazard_curve_leaves_its_last_frequency_possible() -> None:
    """The curve ends at 10; a motion that does not reach it at 12 may do so at more, at most as often as 10 is exceeded."""
    never = critical(2).assign(outcome=NEVER, lower=12.0, upper=math.nan)
    assert frequency_bounds(never, SITE) == (0.0, pytest.approx(1e-5))
    later = critical(2).assign(outcome=BRACKETED, lower=11.0, upper=12.0)
    assert frequency_bounds(later, SITE) == (0.0, pytest.approx(1e-5))


def test_a_curve_in_g_is_read_in_si(tmp_path: Path) -> None:
    (tmp_path / "site.csv").write_text("# of the code's map\namplitude (g),annual frequency\n0.1,0.01\n0.2,0.002\n")
    found = read_hazard(tmp_path / "site.csv", "amplitude")
    np.testing.assert_allclose(found.intensity, [0.981, 1.962])
    assert found.frequency.tolist() == [0.01, 0.002]
    (tmp_path / "arias.csv").write_text("Arias (m/s);frequency\n0,5;0,01\n2;0,001\n")
    assert read_hazard(tmp_path / "arias.csv", "motion.arias_intensity").intensity.tolist() == [0.5, 2.0]


VELOCITY, SPECTRAL = "motion.peak_velocity", "motion.spectral_acceleration.value"


def test_a_velocity_in_cm_s_is_read_in_m_s(tmp_path: Path) -> None:
    """Maps of PGV are in cm/s."""
    for name, size, dimension in (
        ("PGV (cm/s)", 0.01, VELOCITY),
        ("PGV (m/s)", 1.0, VELOCITY),
        ("pgv_cm_s", 0.01, VELOCITY),
        ("Arias intensity [m/s]", 1.0, "motion.arias_intensity"),
    ):
        (tmp_path / "site.csv").write_text(f"{name},annual frequency (1/year)\n5,0.02\n150,0.0001\n")
        np.testing.assert_allclose(read_hazard(tmp_path / "site.csv", dimension).intensity, [5.0 * size, 150.0 * size], err_msg=name)
    for name in ("PGV (mm/s)", "PGA (g)", "PGV (in/s)"):
        (tmp_path / "site.csv").write_text(f"{name},annual frequency\n5,0.02\n150,0.0001\n")
        with pytest.raises(ValueError, match="it must be m/s or cm/s"):
            read_hazard(tmp_path / "site.csv", VELOCITY)
    (tmp_path / "site.csv").write_text("peak velocity,annual frequency\n5,0.02\n150,0.0001\n")
    with pytest.raises(ValueError, match=r"must state the unit, as in 'PGV \(cm/s\)'"):
        read_hazard(tmp_path / "site.csv", VELOCITY)


@pytest.mark.parametrize(
    "name",
    [
        *[
            "probability in 50 years",
            "PoE",
            "P(50yr)",
            "exceedance in 50 yr",
            "probability of exceedance",
            "rate (%)",
            "return period",
            "RP",
        ],
        *["AFE (1e-3/yr)", "rate per century", "Tr (years)", "T (yr)", "MRI", "rate (per 1000 yr)", "annual rate x 1000", "frequency (Hz)"],
        *["log10 AFE", "annual rate / 100", "AFE * 10", "annual frequency (percent)", "rate 10⁻³", "annual probability of non-exceedance"],
        *["H2", "annual frequency of PGA"],
    ],
)
def test_what_is_no_annual_frequency_is_refused(tmp_path: Path, name: str) -> None:
    """10 % in 50 years are -ln(0.9) / 50 = 0.0021 a year, not 0.1."""
    (tmp_path / "site.csv").write_text(f"amplitude (g),{name}\n0.1,0.3\n0.4,0.02\n", encoding="utf-8")
    with pytest.raises(ValueError, match="must be the name of an annual frequency") as refused:
        read_hazard(tmp_path / "site.csv", "amplitude")
    assert f"site.csv, line 1, second column: {name!r}" in str(refused.value)


@pytest.mark.parametrize(
    "name", ["rate", "frequency (1/yr)", "AFE", "lambda (1/a)", "H", "annual rate of exceedance [yr⁻¹]", "rate per year"]
)
def test_an_annual_frequency_is_read_as_it_is(tmp_path: Path, name: str) -> None:
    (tmp_path / "site.csv").write_text(f"amplitude (g),{name}\n0.1,0.3\n0.4,0.02\n", encoding="utf-8")
    assert read_hazard(tmp_path / "site.csv", "amplitude").frequency.tolist() == [0.3, 0.02]


@pytest.mark.parametrize("name", ["annual probability of exceedance", "APOE", "annual PoE", "probability of exceedance in 1 year"])
def test_a_probability_in_a_year_is_turned_into_a_frequency(tmp_path: Path, name: str) -> None:
    (tmp_path / "site.csv").write_text(f"amplitude (g),{name}\n0.1,0.3\n0.4,0.02\n")
    np.testing.assert_allclose(read_hazard(tmp_path / "site.csv", "amplitude").frequency, [-math.log(0.7), -math.log(0.98)], rtol=1e-12)
    (tmp_path / "site.csv").write_text(f"amplitude (g),{name}\n0.1,1.0\n0.4,0.02\n")
    with pytest.raises(ValueError, match=r"line 2: '0.1,1.0': both numbers must be above 0, a probability below 1"):
        read_hazard(tmp_path / "site.csv", "amplitude")


@pytest.mark.parametrize("name", ["SA(0.2) (g)", "Sa(0.2s) [g]", "PSA 0.2 s (g)", "SA(T=0.2 s) in g", "spectral acceleration (0.2 s) (g)"])
def test_a_spectral_acceleration_is_none_of_the_ground(tmp_path: Path, name: str) -> None:
    (tmp_path / "site.csv").write_text(f"{name},AFE\n0.1,0.3\n0.4,0.02\n")
    found = read_hazard(tmp_path / "site.csv", SPECTRAL)
    assert found.period == 0.2
    np.testing.assert_allclose(found.intensity, [0.981, 3.924])
    for dimension in INTENSITIES:
        if dimension != SPECTRAL:
            with pytest.raises(ValueError, match=r"site.csv, line 1, first column: "):
                read_hazard(tmp_path / "site.csv", dimension)


@pytest.mark.parametrize(
    "name", ["PGA (g)", "SA (g)", "SA(g)", "SA(0.2)", "SA(0.2 s) (g x 10)", "SA(T1) (g)", "SA(200 ms) (g)", "SA(0.2 s 5%) (g)"]
)
def test_a_spectral_acceleration_states_period_and_unit(tmp_path: Path, name: str) -> None:
    (tmp_path / "site.csv").write_text(f"{name},AFE\n0.1,0.3\n0.4,0.02\n")
    with pytest.raises(ValueError, match=r"site.csv, line 1, first column: .*'SA\(0.5 s\) \(g\)'"):
        read_hazard(tmp_path / "site.csv", SPECTRAL)


WRITTEN = {
    "amplitude": (
        ["PGA", "peak ground acceleration", "Acceleration", "amplitude"],
        {"g": 9.81, "m/s2": 1.0, "cm/s^2": 0.01, "Gal": 0.01, "%g": 0.0981},
    ),
    VELOCITY: (["PGV", "peak velocity"], {"m/s": 1.0, "cm/s": 0.01}),
    "motion.arias_intensity": (["Arias intensity", "Ia"], {"m/s": 1.0, "cm/s": 0.01}),
    SPECTRAL: (["SA(1.0)", "Sa(0.3 s)"], {"g": 9.81, "m/s2": 1.0}),
}
"""Names of each intensity, and units with their sizes in SI."""
RATES = ["AFE", "annual frequency", "rate (1/yr)", "annual rate of exceedance"]


@given(st.data())
def test_heads_at_random_give_the_right_number_or_are_refused(data: st.DataObject) -> None:
    """Quantity, unit, factor and spelling: a factor in either head is refused with the file, the column and a remedy."""
    dimension, quantity = (data.draw(st.sampled_from(sorted(WRITTEN))) for _ in range(2))
    names, sizes = WRITTEN[quantity]
    name, unit = data.draw(st.sampled_from(names)), data.draw(st.sampled_from(sorted(sizes)))
    factor, rate_factor = (data.draw(st.sampled_from(["", "", *FACTORS])) for _ in range(2))
    head = data.draw(st.sampled_from(["{} ({})", "{} [{}]", "{} in {}"])).format(name, unit)
    head = data.draw(st.sampled_from([f"{head} {factor}", f"{name} {factor} ({unit})", f"{name} ({unit} {factor})"])) if factor else head
    rate = f"{data.draw(st.sampled_from(RATES))} {rate_factor}".strip()
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "site.csv"
        path.write_text(f"{head};{rate}\n0.1;0.02\n0.4;0.001\n", encoding="utf-8")
        if quantity == dimension and not factor and not rate_factor:
            found = read_hazard(path, dimension)
            np.testing.assert_allclose(found.intensity, [0.1 * sizes[unit], 0.4 * sizes[unit]])
            assert found.frequency.tolist() == [0.02, 0.001]
            return
        with pytest.raises(ValueError) as refused:
            read_hazard(path, dimension)
        first = quantity != dimension or factor
        message = str(refused.value)
        assert f"{path}, line 1, {'first' if first else 'second'} column: " in message
        assert (INTENSITIES[dimension].example if first else "convert the numbers") in message


@pytest.mark.parametrize(
    ("text", "wanted"),
    [
        ("amplitude,rate\n1,0.1\n2,0.01\n", "line 1, first column: 'amplitude' must state the unit, as in 'PGA (g)'"),
        ("amplitude (g),rate\n1,0.1\n", "1 row; a hazard curve has at least two"),
        ("amplitude (g),rate\n1,0.1\n1,0.01\n", "line 3: '1,0.01': intensities must increase"),
        ("amplitude (g),rate\n1,0.1\n2,0.2\n", "'2,0.2': intensities must increase"),
        ("amplitude (g),rate\n0,0.1\n2,0.01\n", "'0,0.1': both numbers must be above 0"),
        ("amplitude (g),rate\n1,0.1\n2,none\n", "'2,none': must be two numbers"),
        ("0.1,0.1\n0.2,0.01\n", "the first line must name two columns"),
        ("", "the first line must name two columns"),
    ],
)
def test_what_is_no_hazard_curve_is_refused(tmp_path: Path, text: str, wanted: str) -> None:
    (tmp_path / "site.csv").write_text(text)
    with pytest.raises(ValueError) as refused:
        read_hazard(tmp_path / "site.csv", "amplitude")
    assert "site.csv" in str(refused.value) and wanted in str(refused.value)


def search(folder: Path, hazard: str | None) -> TriggerPlan:
    study = load_study(read_yaml(ROOT / "config" / "studies" / "gentle_layered.yaml"), [ROOT])
    keys: dict[str, Any] = {"cases": {"as it is": {}}, "intensity": {"lowest": 1.0, "highest": 4.0, "cells": 2}, "tolerance": 0.5}
    (folder / "mine.yaml").write_text(yaml.safe_dump({**keys, "hazard": hazard}))
    return load_trigger("mine.yaml", study, [folder, ROOT])


def test_the_curve_of_a_search_is_checked_before_any_run(tmp_path: Path) -> None:
    (tmp_path / "site.csv").write_text("amplitude (g),rate\n0.1,0.01\n0.4,0.0002\n")
    assert search(tmp_path, "site.csv").hazard_file == str(tmp_path / "site.csv")
    with pytest.raises(ValueError, match="hazard: null"):
        _ = search(tmp_path, None).hazard_file
    with pytest.raises(ValueError, match="hazard: no file 'none.csv'"):
        search(tmp_path, "none.csv")
    (tmp_path / "site.csv").write_text("amplitude (m/s2),rate\n0.1,0.01\n0.4,0.0002\n")
    with pytest.raises(ValueError, match=r"0\.1 to 0\.4 m/s² of amplitude.*1 to 4"):
        search(tmp_path, "site.csv")


def test_the_curve_is_of_the_period_of_the_search(tmp_path: Path) -> None:
    study = load_study(read_yaml(ROOT / "config" / "studies" / "gentle_layered.yaml"), [ROOT])
    (tmp_path / "site.csv").write_text("SA(0.2 s) (g),rate\n0.1,0.01\n0.4,0.0002\n")
    for period, right in ((0.2, True), (0.5, False)):
        case = {"motion": {"amplitude": None, "spectral_acceleration": {"period": period}}}
        span = {"dimension": SPECTRAL, "lowest": 1.0, "highest": 4.0, "cells": 2}
        keys = {"cases": {"as it is": case}, "intensity": span, "tolerance": 0.5, "hazard": "site.csv"}
        (tmp_path / "mine.yaml").write_text(yaml.safe_dump(keys))
        if right:
            assert load_trigger("mine.yaml", study, [tmp_path, ROOT]).hazard_file
        else:
            with pytest.raises(ValueError, match=r"spectral acceleration at 0.2 s, the search of that at 0.5 s; .*period to 0.2"):
                load_trigger("mine.yaml", study, [tmp_path, ROOT])
