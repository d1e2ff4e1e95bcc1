"""Empirical laws of liquefaction against their published forms, and the keys of sand that can liquefy (V27)."""

from __future__ import annotations

import re
from typing import Any

import numpy as np
import pytest

from sph.scene.configuration import dotted, merge
from sph.scene.liquefaction import (
    ATMOSPHERE,
    LARGEST_RESISTANCE,
    STRENGTHS,
    blow_count_of_density,
    clay_resistance,
    clean_sand,
    clean_sand_residual,
    cyclic_resistance,
    kramer_wang,
    overburden_factor,
    residual_ratio,
    sand_resistance,
    stress_reduction,
    volume_coefficient,
    volume_coefficient_of_density,
)
from sph.scene.schema import make_scene

SAND: dict[str, Any] = {
    "name": "sand",
    "scheme": "paper",
    "geometry": {"shape": "block", "width": 10.0, "height": 20.0},
    "soil": {"cohesion": 0.0, "friction_angle": 33.0, "blow_count": 10.0},
    "water": {"pressure": "carried", "level": 15.0, "excess_pressure": {"liquefaction": {}}},
}


def test_both_forms_of_the_volume_coefficient_agree() -> None:
    # The constants are rounded: 7600 / 15^2.5 is 8.72, not 8.7.
    for density in (35.0, 50.0, 75.0):
        assert volume_coefficient(blow_count_of_density(density)) == pytest.approx(volume_coefficient_of_density(density), rel=3e-3)


def test_residual_strengths() -> None:
    expected = {4: (0.0533, 0.0537), 8: (0.0778, 0.0808), 10: (0.0909, 0.0989), 12: (0.1047, 0.1258), 15: (0.1271, 0.2167)}
    for blows, ratios in expected.items():
        assert (residual_ratio(blows), residual_ratio(blows, True)) == pytest.approx(ratios, abs=6e-5)
        for name, ratio in zip(("idriss_boulanger", "idriss_boulanger_no_redistribution"), ratios, strict=True):
            np.testing.assert_allclose(STRENGTHS[name](blows, np.array([100e3])), 100e3 * ratio, rtol=1e-3)
    np.testing.assert_allclose(kramer_wang(10.0, np.array([50e3, 100e3, 200e3])), [9.74e3, 13.96e3, 20.53e3], atol=5.0)


def test_fines() -> None:
    assert [clean_sand_residual(12.0, fines) - 12.0 for fines in (0.0, 10.0, 17.5, 25.0, 50.0, 75.0, 90.0)] == [0, 1, 1.5, 2, 4, 5, 5]
    assert clean_sand(10.0, 0.0) == clean_sand(10.0, 1.0) == pytest.approx(10.0)
    assert clean_sand(10.0, 35.0) - 10.0 == pytest.approx(5.5, abs=0.1), "as its chart shows for 35 % and more"


def test_cyclic_resistance_grows_as_its_curve() -> None:
    assert [round(cyclic_resistance(blows), 3) for blows in (5.0, 10.0, 15.0, 20.0)] == [0.086, 0.118, 0.156, 0.206]


@pytest.mark.parametrize(
    ("keys", "message"),
    [
        ({"water.excess_pressure": None}, "soil.blow_count: 10 needs water.excess_pressure"),
        ({"water.pressure": "by_place", "soil.dilation_angle": 5.0}, "soil.dilation_angle: above 0 with water.excess_pressure"),
        ({"soil.blow_count": None}, "water.excess_pressure: needs a soil or a layer with blow_count"),
        ({"soil.relative_density": 50.0}, "relative_density: 50 % beside blow_count: 10"),
        ({"soil.blow_count": None, "soil.fines_content": 20.0}, "fines_content: 20 needs a blow_count"),
        ({"soil.liquefied_strength": 5.0, "soil.liquefied_strength_ratio": 0.1}, "liquefied_strength_ratio: 0.1 beside"),
        ({"soil.cohesion": 20.0, "soil.friction_angle": 0.0}, "of soil without friction_angle"),
        ({"soil.liquefied_strength": 5.0, "water.excess_pressure.liquefaction": None}, "soil.liquefied_strength: needs"),
        ({"coupling.initial_state": "fluid"}, "with coupling.initial_state: fluid"),
        ({"water.excess_pressure.liquefaction.strength": "kramer_wang", "soil.blow_count": 18.0}, "kramer_wang holds up to"),
    ],
)
def test_what_does_nothing_or_contradicts_is_refused(keys: dict[str, Any], message: str) -> None:
    with pytest.raises(ValueError, match=re.escape(message)):
        make_scene(merge(SAND, dotted(keys)))


def test_a_layer_takes_the_blow_count_over_or_leaves_it_out() -> None:
    layers = {"dense": {"blow_count": 30.0}, "by_density": {"blow_count": None, "relative_density": 45.0}, "clay": {"blow_count": None}}
    region = {"kind": "depth", "top": 2.0, "bottom": 4.0}
    scene = make_scene(merge(SAND, {"layers": {name: {"region": region, "soil": soil} for name, soil in layers.items()}}))
    assert [soil.can_liquefy for soil in scene.soils] == [True, True, True, False]
    assert [soil.equivalent_blow_count for soil in scene.soils[:3]] == [10.0, 30.0, 9.0]


def test_other_scenes_are_stored_as_they_were() -> None:
    dry = make_scene(merge(SAND, dotted({"soil.blow_count": None, "water.excess_pressure": None, "soil.K0": None})))
    plain = make_scene({**SAND, "soil": {"cohesion": 0.0, "friction_angle": 33.0}, "water": {"pressure": "carried", "level": 15.0}})
    assert '"blow_count"' in dry.stored() and "excess_pressure" in dry.stored(), "named"
    assert not any(name in plain.stored() for name in ("blow_count", "liquefied", "excess_pressure", "rebound_modulus"))


def test_simplified_procedure() -> None:
    # Magnitude 7.5 and 1 atm are the reference of the curve; r_d is 1 at the ground and falls with depth.
    assert sand_resistance(15.0, 7.5, np.array([ATMOSPHERE]))[0] == pytest.approx(cyclic_resistance(15.0), rel=2e-3)
    assert sand_resistance(15.0, 6.0, np.array([ATMOSPHERE]))[0] > sand_resistance(15.0, 7.5, np.array([ATMOSPHERE]))[0]
    assert sand_resistance(40.0, 7.5, np.array([ATMOSPHERE]))[0] == pytest.approx(LARGEST_RESISTANCE, rel=1e-4)
    reduced = stress_reduction(np.array([0.0, 5.0, 10.0, 20.0]), 7.5)
    assert reduced[0] == pytest.approx(1.0, abs=0.01) and (np.diff(reduced) < 0.0).all()
    np.testing.assert_allclose(overburden_factor(10.0, np.array([50e3, ATMOSPHERE, 200e3])), [1.065, 1.0, 0.937], atol=2e-3)


def test_cyclic_softening_of_clay() -> None:
    # Magnitude 7.2, s_u/sigma'_v 0.35, tau_max/sigma'_v 0.40, static shear a fifth of sigma'_v; the factor for magnitude is 1.013.
    resistance = clay_resistance(np.array([0.35]), 7.2, static=0.2 / 0.35)[0]
    assert resistance / 1.013 == pytest.approx(0.210, abs=5e-4) and resistance / (0.65 * 0.40) == pytest.approx(0.82, abs=5e-3)
