"""Observed order of convergence, on sequences made with a known order."""

from __future__ import annotations

import math

import numpy as np
import pandas as pd
import pytest

from sph.experiments.variants.convergence import CONVERGENCE, SAFETY, convergence_table, observed_convergence


def manufactured(spacings: list[float], order: float, limit: float = 10.0, factor: float = 0.7) -> list[float]:
    return [limit + factor * h**order for h in spacings]


@pytest.mark.parametrize("spacings", [[1.0, 0.5, 0.25], [0.25, 0.5, 0.75], [1 / 6, 0.25, 0.5], [2.0, 1.5, 1.0]])
@pytest.mark.parametrize("order", [0.6, 1.0, 1.5, 2.0, 2.9])
def test_order_and_limit_of_a_manufactured_sequence_are_found(spacings: list[float], order: float) -> None:
    found = observed_convergence(spacings, manufactured(spacings, order))
    assert found.order == pytest.approx(order, rel=1e-8)
    assert found.extrapolated == pytest.approx(10.0, rel=1e-9)
    finest = manufactured([min(spacings)], order)[0]
    assert found.gci == pytest.approx(SAFETY * (finest - 10.0) / finest, rel=1e-8), "the index is the safety times the true error"
    assert f"order {order:.2g}" in found.verdict


def test_the_published_example_is_reproduced() -> None:
    """Celik et al. (2008), Table 1, first column: 18000, 8000 and 4500 cells in the plane, r = 1.5 and 1.333."""
    found = observed_convergence([1.0, 1.5, 2.0], [6.063, 5.972, 5.863])
    assert found.order == pytest.approx(1.53, abs=0.005)
    assert found.extrapolated == pytest.approx(6.1685, abs=5e-4)
    assert found.gci == pytest.approx(0.022, abs=5e-4)


def test_only_the_three_finest_count_in_any_order() -> None:
    spacings = [2.0, 0.25, 1.0, 0.5]
    values = [-99.0, *manufactured([0.25, 1.0, 0.5], 2.0)]
    assert observed_convergence(spacings, values).order == pytest.approx(2.0)


@pytest.mark.parametrize(
    ("values", "wanted"),
    [
        ([10.0, 11.0, 10.5], ("does not converge", "oscillates", "9.5 %")),
        ([10.0, 10.0, 10.5], ("does not converge", "oscillates")),
        ([10.0, 11.0, 11.5], ("does not converge", "grow")),
        ([10.0, 10.9, 11.9], ("does not converge", "order 0.15", "0.5 to 3")),
        ([10.0, 10.01, 10.5], ("does not converge", "order 5.6", "0.5 to 3")),
        ([10.0, 10.0, 10.0], ("does not depend on the spacing",)),
    ],
)
def test_what_does_not_converge_is_said(values: list[float], wanted: tuple[str, ...]) -> None:
    found = observed_convergence([0.25, 0.5, 1.0], values)
    for text in wanted:
        assert text in found.verdict
    if "does not converge" in found.verdict:
        assert math.isnan(found.extrapolated) and math.isnan(found.gci)
        assert found.spread == pytest.approx((max(values) - min(values)) / np.mean(values))


@pytest.mark.parametrize(
    ("spacings", "values", "message"),
    [([1.0, 0.5], [1.0, 2.0], "three"), ([1.0, 1.0, 0.5], [1.0, 2.0, 3.0], "different"), ([1.0, 0.5, 0.0], [1.0, 2.0, 3.0], "positive")],
)
def test_too_few_or_equal_spacings_are_refused(spacings: list[float], values: list[float], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        observed_convergence(spacings, values)


def test_the_table_has_a_row_a_quantity_and_case_and_leaves_gaps_out() -> None:
    spacings = [1.0, 0.5, 0.25, 0.125]
    rows = [
        {
            "parameter": "spacing",
            "case": case,
            "spacing": h,
            "displacement_magnitude": value,
            "runout": value if case == "weak" or h > 0.25 else math.nan,
            "onset_after_start": 1.5,
        }
        for case in ("weak", "strong")
        for h, value in zip(spacings, manufactured(spacings, 1.0), strict=True)
    ]
    table = convergence_table(pd.DataFrame([*rows, {**rows[0], "parameter": "walls"}]), "spacing")
    assert list(table.columns) == [row.name for row in CONVERGENCE] and len(table) == 6
    by = table.set_index(["quantity", "case"])
    assert by.loc[("runout", "weak"), "order"] == pytest.approx(1.0)
    assert by.loc[("runout", "weak"), "spacings"] == "0.125 0.25 0.5 1"
    assert "2 spacings" in by.loc[("runout", "strong"), "verdict"]
    assert "does not depend" in by.loc[("onset_after_start", "weak"), "verdict"]
