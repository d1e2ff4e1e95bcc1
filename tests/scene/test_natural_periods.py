"""Natural frequencies of layered ground: against closed forms, finite elements, and the recursion of Thomson and Haskell."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
import scipy
from hypothesis import given, settings
from hypothesis import strategies as st

from sph.checks.messages import words
from sph.checks.scene import findings
from sph.command.check import check, rows
from sph.command.info import describe
from sph.scene.configuration import merge
from sph.scene.natural_periods import (
    Column,
    amplification,
    column_at,
    first_peak,
    natural_frequencies,
    natural_frequency,
)
from sph.scene.schema import Scene, make_scene

CLOSED, ELEMENTS, SCANNED = 1e-9, 1e-4, 1e-3
"""Relative differences from closed forms, from 40 elements of fourth order in each layer, and from the largest of scanned values."""
FIVE = [(3.0, 120.0, 1600.0), (5.0, 210.0, 1800.0), (4.0, 160.0, 1700.0), (10.0, 330.0, 1950.0), (14.0, 520.0, 2100.0)]
"""Thickness (m), speed (m/s) and density (kg/m3) of five layers, one of them softer than what lies on it."""
LAYER = st.tuples(st.floats(1.0, 30.0), st.floats(80.0, 1500.0), st.floats(1400.0, 2400.0))


def of(*layers: tuple[float, float, float]) -> Column:
    return Column(*np.array(layers, float).T)


def by_elements(column: Column, count: int, parts: int = 40) -> np.ndarray:
    """Natural frequencies by linear finite elements whose mass is the mean of the lumped and the consistent one (of fourth order)."""
    h = np.repeat(column.thickness / parts, parts)
    density, modulus = np.repeat(column.density, parts), np.repeat(column.density * column.speed**2, parts)
    nodes = h.size + 1
    stiffness, mass = np.zeros((nodes, nodes)), np.zeros((nodes, nodes))
    for i in range(h.size):
        at = np.ix_([i, i + 1], [i, i + 1])
        stiffness[at] += modulus[i] / h[i] * np.array([[1.0, -1.0], [-1.0, 1.0]])
        mass[at] += density[i] * h[i] / 12.0 * np.array([[5.0, 1.0], [1.0, 5.0]])
    values = scipy.linalg.eigh(stiffness[:-1, :-1], mass[:-1, :-1], eigvals_only=True, subset_by_index=[0, count - 1])
    return np.asarray(np.sqrt(values) / (2.0 * np.pi))


def by_recursion(column: Column, below: float, frequency: np.ndarray) -> np.ndarray:
    """Surface over outcrop, by the amplitudes of the waves that go up and down (Kramer 1996, Eqs. 7.34 and 7.35)."""
    up, down = np.ones(frequency.size, complex), np.ones(frequency.size, complex)
    impedances = [*column.impedance, below]
    for number, (thickness, speed) in enumerate(zip(column.thickness, column.speed, strict=True)):
        ratio, turn = impedances[number] / impedances[number + 1], np.exp(2j * np.pi * frequency * thickness / speed)
        up, down = (
            0.5 * up * (1.0 + ratio) * turn + 0.5 * down * (1.0 - ratio) / turn,
            0.5 * up * (1.0 - ratio) * turn + 0.5 * down * (1.0 + ratio) / turn,
        )
    return np.asarray(1.0 / np.abs(up))


def test_one_layer_has_a_quarter_of_a_wave_in_its_first_mode() -> None:
    found = natural_frequencies(of((18.0, 240.0, 1900.0)), 3)
    np.testing.assert_allclose(found, 240.0 / (4.0 * 18.0) * np.array([1.0, 3.0, 5.0]), rtol=CLOSED)


@pytest.mark.parametrize("lower", [(12.0, 400.0, 2000.0), (12.0, 90.0, 1500.0), (60.0, 800.0, 2200.0)])
def test_two_layers_fulfil_their_frequency_equation(lower: tuple[float, float, float]) -> None:
    """tan(k1 h1) tan(k2 h2) = rho2 V2 / (rho1 V1) in every mode; and there is one mode below the n-th pole of either side."""
    upper = (8.0, 150.0, 1600.0)
    found = natural_frequencies(of(upper, lower), 4)
    a, b = (2.0 * np.pi * found * h / v for h, v, _ in (upper, lower))
    ratio = lower[1] * lower[2] / (upper[1] * upper[2])
    np.testing.assert_allclose(ratio * np.cos(a) * np.cos(b) - np.sin(a) * np.sin(b), 0.0, atol=1e-7 * max(ratio, 1.0))
    np.testing.assert_allclose(found, by_elements(of(upper, lower), 4, 80), rtol=ELEMENTS)


def test_five_layers_on_a_rigid_base() -> None:
    np.testing.assert_allclose(natural_frequencies(of(*FIVE), 4), by_elements(of(*FIVE), 4), rtol=ELEMENTS)


@settings(max_examples=25, deadline=None)
@given(st.lists(LAYER, min_size=1, max_size=6))
def test_layers_at_random_have_the_frequencies_of_finite_elements(layers: list[tuple[float, float, float]]) -> None:
    np.testing.assert_allclose(natural_frequencies(of(*layers), 2), by_elements(of(*layers), 2), rtol=ELEMENTS)
    halves = [(0.5 * h, v, rho) for h, v, rho in layers for _ in range(2)]
    np.testing.assert_allclose(natural_frequencies(of(*halves), 2), natural_frequencies(of(*layers), 2), rtol=CLOSED)


@settings(max_examples=25, deadline=None)
@given(st.lists(LAYER, min_size=1, max_size=6), st.floats(1e5, 1e7))
def test_layers_at_random_amplify_as_waves_up_and_down(layers: list[tuple[float, float, float]], below: float) -> None:
    frequency = np.linspace(0.0, 20.0, 101)
    np.testing.assert_allclose(amplification(of(*layers), below, frequency), by_recursion(of(*layers), below, frequency), rtol=1e-8)
    peak = first_peak(of(*layers), below)
    if peak is not None:
        scanned = np.array([peak.frequency, *np.linspace(0.0, 1.01 * peak.frequency, 401)])
        factor = by_recursion(of(*layers), below, scanned)
        assert factor[0] == pytest.approx(peak.amplification, rel=1e-6)
        assert factor.max() <= peak.amplification * (1.0 + 1e-6), "nothing before it or beside it is higher"


def test_one_layer_over_a_half_space_resonates_by_the_contrast() -> None:
    """1 / sqrt(cos^2 kH + alpha^2 sin^2 kH) has its first peak, 1 / alpha, at V_s / 4H; a softer half-space amplifies nothing."""
    layer = of((18.0, 240.0, 1900.0))
    found = first_peak(layer, 5.0 * 240.0 * 1900.0)
    assert found == pytest.approx((240.0 / 72.0, 5.0), rel=1e-5)
    assert first_peak(layer, 240.0 * 1900.0) is None and first_peak(layer, 0.5 * 240.0 * 1900.0) is None


@pytest.mark.parametrize("layers", [FIVE[:2], FIVE])
def test_layers_over_a_half_space(layers: list[tuple[float, float, float]]) -> None:
    below = 2400.0 * 1500.0
    frequency = np.linspace(0.0, 2.0 * natural_frequencies(of(*layers))[0], 20001)
    factor = by_recursion(of(*layers), below, frequency)
    found = first_peak(of(*layers), below)
    assert found is not None and found.frequency == pytest.approx(frequency[factor.argmax()], rel=SCANNED)
    assert found.amplification == pytest.approx(factor.max(), rel=SCANNED)


SOFT: dict[str, Any] = {
    "scheme": "paper",
    "name": "soft",
    "geometry": {"shape": "ground_line", "points": [[0, 10], [40, 10], [60, 24.1], [120, 24.1]], "base": 0},
    "soil": {"density": 2000.0, "shear_wave_speed": 800.0, "poisson_ratio": 0.25},
    "layers": {"soft": {"region": {"kind": "depth", "bottom": 20.0}, "soil": {"shear_wave_speed": 150.0}}},
    "damping": {"ratio": 0.03, "frequencies": [8.3, 41.5]},
    "gravity": {"ramp": 0.5, "duration": 1.0},
    "motion": {"kind": "tapered_sine", "amplitude": 1.0, "frequency": 2.0, "start": 1.0, "ramp": 0.5, "decay_start": 4.0, "end": 5.0},
    "duration": 6.0,
    "numerics": {"spacing": 1.0},
}


def soft(**changes: Any) -> Scene:
    return make_scene(merge(SOFT, changes))


def test_a_soft_layer_on_stiff_soil_sets_the_frequency_that_is_printed() -> None:
    """20 m of 150 m/s on 4.1 m of 800 m/s: 1.86 Hz by tan tan = rho V / rho V, not 800 / (4 x 24.1) = 8.3 Hz; 10 m of it at the toe."""
    scene = soft()
    found = natural_frequency(scene, scene.geometry.crest)
    a, b = (2.0 * np.pi * found * h / v for h, v in ((20.0, 150.0), (4.1, 800.0)))
    assert np.tan(a) * np.tan(b) == pytest.approx(800.0 / 150.0, rel=1e-6)
    assert found == pytest.approx(1.8616, rel=1e-3)
    assert natural_frequency(scene, scene.geometry.toe) == pytest.approx(150.0 / 40.0), "10 m, all soft"
    for told in (dict(describe(scene)), dict(rows(check(scene)))):
        assert told["column frequency"].startswith("1.86 Hz below the crest edge, 3.75 Hz below the toe")


@pytest.mark.parametrize(("speed", "told"), [(300.0, True), (700.0, True), (800.0, False), (2000.0, False)])
def test_bedrock_softer_than_the_ground_on_it_is_told(speed: float, told: bool) -> None:
    """By the impedance: the lowest soil has 800 m/s."""
    bedrock = {"density": soft().soils[-1].density, "s_wave_speed": speed, "p_wave_speed": 2.0 * speed}
    scene = soft(walls={"base": "absorbing", "sides": "absorbing", "layers": 4, "bedrock": bedrock})
    found = [each for each in findings(scene) if each.code == "soft-bedrock"]
    assert [words(each).key for each in found] == ["walls.bedrock"] * told
    assert "soft-bedrock" not in {each.code for each in findings(soft(walls={"base": "absorbing", "sides": "absorbing", "layers": 4}))}


def test_damping_by_the_stiff_soil_alone_is_found_and_the_layered_frequency_named() -> None:
    scene = soft()
    (found,) = [each for each in findings(scene) if each.code == "damping-off-frequency"]
    assert scene.damping is not None
    ratio = 0.03 * (8.3 * 41.5 / 1.8616 + 1.8616) / (8.3 + 41.5)
    assert scene.damping.at(1.8616) == pytest.approx(ratio) and ratio > 0.11
    assert (
        f"{100 * ratio:.3g} % instead of 3 %" in words(found).measured
        and "1.86 Hz" in words(found).what
        and "[1.86, 41.5]" in words(found).key
    )
    assert not [each for each in findings(soft(damping={"frequencies": [1.86, 41.5]})) if each.code == "damping-off-frequency"]
    assert not [each for each in findings(soft(damping=None)) if each.code == "damping-off-frequency"]


def test_a_rigid_block_is_judged_by_the_layered_frequency() -> None:
    (found,) = [each for each in findings(soft()) if each.code == "block-not-rigid"]
    assert f"a natural period of {1.0 / 1.8616:.2g} s" in words(found).measured


@pytest.mark.parametrize(
    ("rock", "words"),
    [(None, "Hz, 5.33 times"), ({"density": 2400.0, "s_wave_speed": 1500.0, "p_wave_speed": 3000.0}, "Hz, 12 times")],
)
def test_the_half_space_below_is_told(rock: dict[str, float] | None, words: str) -> None:
    """Soil that goes on reflects nothing at the base of the model: the soft layer resonates alone, at 150 / 80 Hz, by the contrast."""
    scene = soft(walls={"base": "absorbing", "sides": "absorbing", "layers": 4, "bedrock": rock})
    told = dict(describe(scene))["resonance over the half-space"]
    assert words in told and float(told.split()[0]) == pytest.approx(1.86 if rock else 1.875, abs=0.006)
    scene = soft(walls={"base": "absorbing", "sides": "absorbing", "layers": 4}, layers={"soft": {"soil": {"shear_wave_speed": 800.0}}})
    assert dict(describe(scene))["resonance over the half-space"].startswith("none")
    assert "resonance over the half-space" not in dict(describe(soft()))


def test_the_column_is_that_of_its_place_by_every_kind_of_region() -> None:
    lens = {"kind": "polygon", "points": [[50, 12], [120, 12], [120, 18], [50, 18]]}
    scene = soft(layers={"soft": {"region": {"kind": "elevation", "top": 4.0}}, "lens": {"region": lens, "soil": {"density": 1500.0}}})
    assert column_at(scene, scene.geometry.crest).thickness == pytest.approx([6.1, 6.0, 8.0, 4.0], abs=1e-6)
    assert column_at(scene, scene.geometry.toe).speed == pytest.approx([800.0, 150.0])
