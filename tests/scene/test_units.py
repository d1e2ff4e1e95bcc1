"""Heads of columns at random: a unit is understood, and a factor never dropped."""

from __future__ import annotations

import tempfile
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from record_files import FACTORS

from sph.scene.ground_motion import read_components
from sph.scene.ground_motion.units import ACCELERATIONS
from sph.scene.survey import METRES
from sph.scene.units import GRAVITY, SECONDS, Units, read_head

SPELT = {
    "g": GRAVITY, "G": GRAVITY, "g's": GRAVITY, "%g": 0.01 * GRAVITY, "percent g": 0.01 * GRAVITY, "m/s2": 1.0, "m/s^2": 1.0, "m/s²": 1.0,
    "m s⁻²": 1.0, "m/sec/sec": 1.0, "m/s**2": 1.0, "cm/s2": 0.01, "cm/sec^2": 0.01, "gal": 0.01, "Gals": 0.01,
}  # fmt: skip
NAMED = ["acc", "Acceleration", "ax", "EW", "N90E", "HNE", "Accel_H1", "Acc. EW2", "PGA_rock"]
FORMS = ["{} ({})", "{} [{}]", "{} in {}", "{} / {}"]


@given(st.sampled_from(NAMED), st.sampled_from(sorted(SPELT)), st.sampled_from(FORMS))
def test_a_unit_is_understood_however_it_is_spelt(name: str, unit: str, form: str) -> None:
    assert read_head(form.format(name, unit), ACCELERATIONS).size == pytest.approx(SPELT[unit], rel=1e-12)


@given(st.sampled_from(NAMED), st.sampled_from(sorted(SPELT)), st.sampled_from(FORMS), st.sampled_from(FACTORS), st.integers(0, 5))
def test_a_factor_is_refused_wherever_it_stands(name: str, unit: str, form: str, factor: str, place: int) -> None:
    """Behind the unit, within its brackets on either side, before them; in a file with the line and the remedy."""
    head = form.format(name, unit)
    head = [
        f"{head} {factor}", f"{head} ({factor})", f"{name} ({unit} {factor})", f"{name} {factor} ({unit})", f"{name} ({factor} {unit})",
        f"{name}_{factor} [{unit}]",
    ][place]  # fmt: skip
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "a.csv"
        path.write_text(f"time (s);{head}\n0;1\n1;2\n", encoding="utf-8")
        for stated in (None, "g"):
            with pytest.raises(ValueError) as refused:
                read_components(path, stated)
            assert f"{path}, line 1: " in str(refused.value) and (
                "convert " in str(refused.value) or "name the columns" in str(refused.value)
            )


@pytest.mark.parametrize(("units", "head"), [(SECONDS, "time (s)"), (METRES, "elevation (m)"), (ACCELERATIONS, "ax"), (METRES, "Z")])
def test_a_factor_of_any_quantity_is_refused(units: Units, head: str) -> None:
    for factor in FACTORS:
        with pytest.raises(ValueError, match="may state a factor|is not understood"):
            read_head(f"{head} {factor}", units)
            pytest.fail(factor)


@pytest.mark.parametrize(
    "head",
    [
        "acc (-g)",
        "log acc (g)",
        "acc (g) scaled by 2",
        "acc^2 (g)",
        "acc (g/s)",
        "acc (m/s2/s)",
        "acc g*",
        "deci g",
        "acc (10 g)",
        "acc g2",
        "acc (g^2)",
        "acc [m²/s²]",
        "acc (1/g)",
    ],
)
def test_what_is_no_unit_alone_is_refused(head: str) -> None:
    with pytest.raises(ValueError, match="may state a factor|is not understood"):
        assert read_head(head, ACCELERATIONS).size is None
        raise ValueError("is not understood: no unit is found")


@pytest.mark.parametrize(
    ("head", "units", "size"),
    [
        ("Elevation (m) NAVD88", METRES, 1.0), ("x [m] EPSG:25832", METRES, 1.0), ("Ch 3 (g)", ACCELERATIONS, GRAVITY),
        ("acc x1 (g)", ACCELERATIONS, GRAVITY), ("acc E1 (gal)", ACCELERATIONS, 0.01), ("time [ms]", SECONDS, 1e-3), ("t/s", SECONDS, 1.0),
        ("Accel, 360 (cm/s/s)", ACCELERATIONS, 0.01),
    ],
)  # fmt: skip
def test_numbers_that_belong_to_a_name_are_no_factors(head: str, units: Units, size: float) -> None:
    assert read_head(head, units).size == size


def test_what_is_left_of_a_head_has_no_unit() -> None:
    assert read_head("PGA_g", ACCELERATIONS).rest.strip(" _") == "pga"
    np.testing.assert_equal(read_head("acc", ACCELERATIONS).size, None)
