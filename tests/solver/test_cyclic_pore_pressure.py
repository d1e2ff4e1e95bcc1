"""Pore pressure by cyclic shear, particle by particle: published values, and what its frame of reference must not change (V27)."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
import pytest

from sph.scene.configuration import merge
from sph.scene.liquefaction import cyclic_resistance, residual_ratio, volume_coefficient
from sph.scene.schema import make_scene
from sph.solver.particles import place_particles
from sph.solver.physics.cyclic_pore_pressure import (
    CyclicPorePressure,
    CyclicState,
    compact,
    excess_pressure,
    fails,
    mark_liquefied,
)
from sph.solver.physics.elasticity import Strain, pressure
from sph.solver.physics.material import Material, make_material, material_of
from sph.solver.simulation import Simulation
from sph.solver.state import ARMED

pytestmark = pytest.mark.uncompiled

SAND: dict[str, Any] = {
    "name": "sand",
    "scheme": "paper",
    "geometry": {"shape": "block", "width": 10.0, "height": 20.0},
    "soil": {
        "density": 2000.0,
        "shear_wave_speed": 200.0,
        "poisson_ratio": 0.3,
        "cohesion": 0.0,
        "friction_angle": 35.0,
        "blow_count": 10.0,
    },
    "water": {"pressure": "carried", "level": 15.0, "excess_pressure": {"liquefaction": {}}},
}
VERTICAL, DT = 100e3, 1e-3
PARTICLE = np.uint64(0)
Element = NamedTuple("Element", [("phase", np.ndarray), ("density", np.ndarray), *((name, np.ndarray) for name in CyclicState._fields)])
"""What the term needs of the state, of one particle."""


class Sample:
    """An undrained element under uniform effective stress, whose shear strain is prescribed."""

    def __init__(self, blow_count: float = 10.0, exponent: float = 0.5, residual: float = -1.0, strain: float = math.inf) -> None:
        scene = make_scene(SAND)
        one, self.soil = np.ones(1), make_material(scene.materials[0], scene.coupling, DT)
        self.term = CyclicPorePressure(
            coefficient=volume_coefficient(blow_count) * one,
            modulus=2000.0 * 200.0**2 * 3.5 * one,  # K + 4/3 G for a Poisson's ratio of 0.3
            shear_modulus=self.soil.shear_modulus * one,
            fluid=np.array([self.soil.fluid[:2]]),
            law_modulus=8,
            vertical=VERTICAL * one,
            residual=residual * one,
            exponent=exponent,
            least=0.1,
            pressure_ratio=0.7,
            shear_strain=strain,
            start=0.0,
            density=2000.0,
        )
        start = {name: np.full(1, -1.0 if name == "liquefied_at" else 0.0) for name in CyclicState._fields}
        self.state = Element(np.full(1, ARMED, np.uint8), np.full(1, 2000.0 * (1.0 + VERTICAL / self.soil.bulk_modulus)), **start)
        self.layers, self.angle = Simulation(scene).terms.layers, 0.0

    def shear(self, added: float, direction: float = 0.0, spin: float = 0.0) -> None:
        """Add a shear strain in a direction of the plane of (e_xx - e_yy, 2 e_xy), and turn by a spin after it."""
        self.angle += spin
        angle = direction - 2.0 * self.angle
        diff, xy = 0.5 * added * math.cos(angle) / DT, 0.5 * added * math.sin(angle) / DT
        strain = Strain(diff, -diff, xy, spin, DT)
        compact(self.term, self.layers, self.state, PARTICLE, strain, 1.0)

    def cycle(self, strains: np.ndarray, direction: float = 0.0, spin: float = 0.0) -> None:
        """Follow a history of shear strain from its first value."""
        for added in np.diff(strains):
            self.shear(float(added), direction, spin)

    @property
    def material(self) -> Material:
        return material_of(self.layers, self.soil, PARTICLE)

    @property
    def is_liquefied(self) -> bool:
        reached = np.zeros(1, bool)
        mark_liquefied(self.term, self.state, PARTICLE, reached)
        return bool(reached[0])

    @property
    def ratio(self) -> float:
        """r_u."""
        return float(excess_pressure(self.term, self.state, PARTICLE)) / VERTICAL


def sine(amplitude: float, cycles: float, parts: int = 24) -> np.ndarray:
    """A sine with its peaks among the samples, and past the last one."""
    return amplitude * np.sin(2.0 * math.pi * np.arange(round(cycles * parts) + 1) / parts)


@pytest.mark.parametrize(
    ("blow_count", "expected"),
    [
        (5.0, (0.1058, 0.3309, 0.4779, 0.5744)),
        (10.0, (0.0445, 0.1391, 0.2009, 0.2415)),
        (15.0, (0.0268, 0.0838, 0.1211, 0.1455)),
        (20.0, (0.0187, 0.0585, 0.0845, 0.1015)),
    ],
)
def test_volumetric_strain_of_simple_shear(blow_count: float, expected: tuple[float, ...]) -> None:
    # After 1, 5, 10 and 15 cycles of 0.1 %, %; in simple shear, under a strain of the axes, and between them.
    for direction in (0.5 * math.pi, 0.0, 0.7):
        sample, done = Sample(blow_count), 0
        for cycles, value in zip((1, 5, 10, 15), expected, strict=True):
            sample.cycle(
                sine(1e-3, 1) if not done else np.tile(sine(1e-3, 1)[:-1], cycles - done + 1)[: 24 * (cycles - done) + 1], direction
            )
            done = cycles
            assert 100.0 * sample.state.compaction[0] == pytest.approx(value, abs=6e-5)
    closed = 1e-3 / (0.4 / volume_coefficient(blow_count)) * math.log(1.0 + 0.4 * 15)
    assert sample.state.compaction[0] == pytest.approx(closed, rel=0.02), "the closed form is that of a continuous rate"


def test_turning_soil_is_like_soil_that_stands() -> None:
    still, turning = Sample(), Sample()
    still.cycle(sine(1e-3, 5, 200))
    turning.cycle(sine(1e-3, 5, 200), spin=2e-3)
    assert turning.angle > 1.9 and turning.state.compaction[0] == pytest.approx(still.state.compaction[0], rel=1e-3)


def test_steady_shear_raises_nothing_and_small_cycles_within_a_large_one_add_nothing() -> None:
    sample = Sample()
    sample.cycle(np.linspace(0.0, 0.05, 200))
    assert sample.ratio == 0.0 and sample.state.last_range[0] == 0
    ripple, plain = Sample(), Sample()
    for sample, height in ((ripple, 0.04e-3), (plain, 0.0)):
        for _ in range(5):
            slow = sine(1e-3, 1, 400)
            sample.cycle(slow + height * np.sin(np.arange(slow.size)) * np.abs(slow) / 1e-3)
    assert ripple.state.compaction[0] == pytest.approx(plain.state.compaction[0], rel=0.06), "the peaks are up to 4 % higher"


def test_water_takes_over_what_the_skeleton_gives_up() -> None:
    sample = Sample(blow_count=5.0, exponent=0.0)
    for _ in range(20):
        sample.cycle(sine(1e-3, 1))
        effective = pressure(sample.soil.bulk_modulus, sample.state.density[0], sample.term.density)
        assert effective + VERTICAL * sample.ratio == pytest.approx(VERTICAL, rel=1e-9), "total pressure"
        risen = sample.term.modulus[0] * sample.state.compaction[0]
        assert VERTICAL * sample.ratio == pytest.approx(min(risen, VERTICAL), rel=1e-9)
    assert sample.ratio == 1.0, "no more than the initial vertical effective stress"
    assert sample.material.shear_modulus == sample.soil.shear_modulus, "with an exponent of 0 it stays"


def test_stiffness_falls_with_the_effective_stress() -> None:
    sample = Sample()
    sample.cycle(sine(3e-4, 3))
    left = math.sqrt(1.0 - sample.ratio)
    assert 0.3 < sample.ratio < 0.9 and sample.material.shear_modulus == pytest.approx(left * sample.soil.shear_modulus)
    assert sample.material.fluid_law.shear_modulus == sample.material.shear_modulus and sample.material.fluid == sample.soil.fluid
    sample.cycle(sine(3e-3, 20))
    assert sample.ratio == 1.0 and sample.material.shear_modulus == pytest.approx(0.1 * sample.soil.shear_modulus), "the least share"


def test_liquefied_sand_keeps_its_residual_strength() -> None:
    by_pressure, by_strain, other = Sample(residual=9e3), Sample(residual=9e3, strain=0.08), Sample()
    by_pressure.cycle(sine(1e-3, 4))
    by_strain.cycle(np.linspace(0.0, 0.0799, 100))
    other.cycle(sine(1e-3, 4))
    assert not by_strain.is_liquefied
    assert not fails(by_strain.term, by_strain.state, PARTICLE, True), "at its yield surface it only yields"
    by_strain.cycle(np.linspace(0.0, 2e-4, 3))
    for sample in (by_pressure, by_strain):
        assert sample.is_liquefied and fails(sample.term, sample.state, PARTICLE, False)
        assert (sample.material.fluid.cohesion_term, sample.material.fluid.sine) == (
            9e3,
            0.0,
        ) and sample.material.solid == sample.soil.solid
    assert by_strain.ratio == 0.0 and other.ratio > 0.7 and not other.is_liquefied
    assert fails(other.term, other.state, PARTICLE, True) and not fails(other.term, other.state, PARTICLE, False)


def sheared_by_stress(blow_count: float, modulus: float = 1.0, exponent: float = 0.5) -> list[float]:
    """r_u after every half cycle at a cyclic stress ratio of the cyclic resistance, as long as the element can bear that stress.

    ``modulus`` is M_r over that of the skeleton.
    """
    sample, stress = Sample(blow_count, exponent), cyclic_resistance(blow_count) * VERTICAL
    sample.term.modulus[:] *= modulus
    ratios, strain, sign = [0.0], 0.0, 1.0
    while stress < VERTICAL * (1.0 - sample.ratio) * math.sin(math.radians(35.0)) and len(ratios) < 200:
        peak = sign * stress / sample.material.shear_modulus
        sample.cycle(np.array([strain, peak, 0.5 * peak]))
        ratios, strain, sign = [*ratios, sample.ratio], 0.5 * peak, -sign
    return ratios


def cycles(ratios: list[float]) -> float:
    """Cycles of a history of r_u."""
    return 0.5 * (len(ratios) - 1)


def test_cycles_to_liquefaction_at_the_cyclic_resistance() -> None:
    # The curve of resistance is for 15 cycles (magnitude 7.5, 1 atm).  Nothing in the law is fitted to it; the band is a factor of three.
    found = {blow_count: cycles(sheared_by_stress(blow_count)) for blow_count in (8.0, 10.0, 15.0, 20.0)}
    assert all(5.0 <= number <= 45.0 for number in found.values()), found
    # Five blows are outside the band, as the page on water tells.  The modulus of rebound is the cause: C1 grows faster towards few blows
    # than the resistance falls, and the skeleton's modulus at small strain is too large for sand that compacts by tenths of a per cent.
    assert cycles(sheared_by_stress(5.0)) == cycles(sheared_by_stress(5.0, exponent=0.0)) - 0.5 == 4.0
    assert cycles(sheared_by_stress(5.0, modulus=0.5)) == 11.0


def seed(share: float) -> float:
    """r_u after a share of the cycles to liquefaction: Seed, Martin and Lysmer (1975), with the mean exponent of 0.7."""
    return 0.5 + math.asin(2.0 * share ** (1.0 / 0.7) - 1.0) / math.pi


@pytest.mark.parametrize("blow_count", [5.0, 10.0, 20.0])
def test_pressure_rises_as_in_a_test_of_known_cycles(blow_count: float) -> None:
    # Where a cyclic test gives the number of cycles, M_r can be chosen so that the law needs as many; between start and end r_u is then to
    # be that of Seed's curve within 0.2.
    values = [round(seed(share), 3) for share in (0.1, 0.25, 0.5, 0.75, 0.9)]
    assert values == [0.124, 0.242, 0.417, 0.606, 0.756]
    low, high = 0.1, 4.0
    for _ in range(8):
        middle = math.sqrt(low * high)
        low, high = (middle, high) if cycles(sheared_by_stress(blow_count, middle)) > 15.0 else (low, middle)
    ratios = sheared_by_stress(blow_count, high)
    assert cycles(ratios) == pytest.approx(15.0, abs=0.5)
    shares = np.linspace(0.0, 1.0, len(ratios))
    for share in (0.1, 0.25, 0.5, 0.75):
        assert np.interp(share, shares, ratios) == pytest.approx(seed(share), abs=0.2)


def test_coefficients_of_a_scene() -> None:
    clay = {"region": {"kind": "elevation", "top": 5.0}, "soil": {"blow_count": None}}
    silty = {"region": {"kind": "elevation", "bottom": 5.0, "top": 8.0}, "soil": {"fines_content": 25.0, "rebound_modulus": 50e3}}
    scene = make_scene(merge(SAND, {"layers": {"clay": clay, "silty": silty}}))
    particles, term = place_particles(scene), Simulation(scene).terms.cyclic_pore_pressure
    height, soil = particles.y[: particles.first_no_slip], np.arange(particles.first_no_slip) < particles.n_soil
    clean, fines = soil & (height > 8.0) & (height < 15.0), soil & (height > 5.0) & (height < 8.0)
    assert set(term.coefficient[clean]) == {volume_coefficient(10.0)} and (term.coefficient[fines] < volume_coefficient(14.0)).all()
    assert not term.coefficient[~(clean | fines)].any() and (term.residual[~(clean | fines)] == -1.0).all()
    assert set(term.modulus[fines]) == {50e6} and term.modulus[clean][0] == pytest.approx(2000.0 * 200.0**2 * 3.5)
    vertical = 2000.0 * 9.81 * (20.0 - height) - 9810.0 * np.maximum(15.0 - height, 0.0)
    np.testing.assert_allclose(term.vertical[clean], vertical[clean], rtol=1e-9)
    np.testing.assert_allclose(term.residual[clean], residual_ratio(10.0) * vertical[clean], rtol=1e-9)
    np.testing.assert_allclose(term.residual[fines], residual_ratio(12.0) * vertical[fines], rtol=1e-9)
    assert term.law_modulus == 8, "as the elements above have it"
    drained = math.tan(math.radians(35.0)) * vertical[clean]
    for key, value, expected in (("", 5.0, np.minimum(5e3, drained)), ("_ratio", 0.9, drained)):
        numbers = make_scene(merge(SAND, {"soil": {f"liquefied_strength{key}": value}}))
        found = Simulation(numbers).terms.cyclic_pore_pressure.residual
        np.testing.assert_allclose(found[clean], expected, rtol=1e-9)


def test_water_by_place_leaves_what_shaking_raises_to_the_soil() -> None:
    # Five metres of standing water change no effective stress; what a particle carries along is the rise alone.
    flooded = make_scene(merge(SAND, {"water": {"pressure": "by_place", "level": 25.0}}))
    full = make_scene(merge(SAND, {"water": {"level": 20.0}}))
    terms, carried = Simulation(flooded).terms, Simulation(full).terms
    assert terms.seepage is not None and not terms.pore_pressure.pressure.any()
    assert carried.seepage is None and carried.pore_pressure.pressure.any()
    np.testing.assert_allclose(terms.cyclic_pore_pressure.vertical, carried.cyclic_pore_pressure.vertical, rtol=1e-12)
    np.testing.assert_allclose(terms.cyclic_pore_pressure.residual, carried.cyclic_pore_pressure.residual, rtol=1e-12)
