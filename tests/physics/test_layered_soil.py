"""Layers of other soil: weight, waves at an interface, momentum, strength, and that equal layers change nothing."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from comparison import momenta, same_bits
from small_scenes import ABOVE_A_WALL, NOTHING

from cases.case import Result
from cases.columns import transfer
from sph.scene.configuration import merge
from sph.scene.schema import Scene, make_scene
from sph.solver.particles import overburden
from sph.solver.physics.material import lightness, material_of
from sph.solver.run import Run, run
from sph.solver.simulation import Simulation
from sph.stability.standing import divided_strength, weakened
from sph.storage import trajectory

LIGHT = {"density": 1500.0, "youngs_modulus": 4e5}
HEAVY = {"density": 2250.0, "youngs_modulus": 1.2e6}


def test_layers_of_the_same_soil_change_nothing(small_slope: Any) -> None:
    same = small_slope({"layers": {"cover": {"region": {"kind": "depth", "bottom": 8.0}}}})
    plain, layered = run(small_slope({})).trajectory, run(same).trajectory
    assert plain["failed_fraction"][-1] > 0.3
    assert set(layered["layer"].values) == {0, 1} and not plain["layer"].values.any()
    for name in ("x", "y", "stress_xx", "density", "t_f"):
        # The same sums, compiled anew: rounding may differ, and grows as debris is stirred.
        np.testing.assert_allclose(layered[name].values[:8], plain[name].values[:8], rtol=1e-5, atol=1e-6)
    np.testing.assert_array_equal(plain["failed"].values[-1], layered["failed"].values[-1])


def resting(**changes: Any) -> Scene:
    """Layers between periodic sides on a base that holds them, with the terms of ``test_weak_on_strong.py``."""
    data = {
        "duration": 16.0,
        "walls": {"base": "no_slip", "sides": "periodic"},
        "soil": {"poisson_ratio": 0.3, "cohesion": 1e6, "friction_angle": 0.0, "viscosity": 2.0},
        "coupling": {"S_R": 0.5, "gamma": 0.0},
        **NOTHING,
        "damping": {"ratio": 0.05, "frequencies": [1.0, 6.0]},
    }
    return make_scene(merge(data, changes))


@pytest.mark.long
def test_a_wave_is_reflected_by_the_ratio_of_impedances() -> None:
    # rho V_s: 1500 kg/m3 with E = 0.4 GPa below, 2250 kg/m3 with 1.2 GPa above.
    scene = resting(
        name="bar",
        duration=0.2,
        geometry={"shape": "block", "width": 4.0, "height": 60.0},
        soil=LIGHT,
        layers={"rock": {"region": {"kind": "elevation", "bottom": 30.0}, "soil": HEAVY | {"cohesion": 5e5}}},
        gravity={"acceleration": 1e-6, "ramp": 0.0, "duration": 0.01, "damping": 0.0},  # water asks for some
        motion={"kind": "none"},
        damping=NOTHING["damping"],
        numerics={"spacing": 0.5, "time_step": 1e-4, "artificial_viscosity": {"alpha": 0.0}},
        probes={"A": [2.0, 30.0]},
    )
    below, above = scene.soil, scene.layers["rock"].soil
    z_below, z_above = (soil.density * soil.s_wave_speed for soil in (below, above))
    simulation = Simulation(scene)
    state, y, width = simulation.state, simulation.particles.y, 3.0
    # A pulse in the lower soil that travels upwards: velocity f(y - V t) with the stress that belongs to it.
    pulse = 0.01 * np.exp(-0.5 * ((y - 14.0) / width) ** 2)
    state.vx[:] = pulse
    state.solid_xy[:] = -z_below * pulse
    simulation.prepare()
    simulation.balance()
    arrival = (30.0 - 14.0) / below.s_wave_speed
    simulation.advance_steps(scene.steps(round((arrival + 4.5 * width / below.s_wave_speed) / 1e-4) * 1e-4))
    lower, upper = y < 30.0, y > 30.0
    reflected = state.vx[lower][np.argmax(np.abs(state.vx[lower]))]
    transmitted = state.vx[upper][np.argmax(np.abs(state.vx[upper]))]
    # Velocities: reflected (Z1 - Z2) / (Z1 + Z2), transmitted 2 Z1 / (Z1 + Z2).  The pulse disperses by about a per cent on
    # its way (see test_waves), and the interface is as wide as the kernel: 4 % of the incoming pulse.
    assert reflected / 0.01 == pytest.approx((z_below - z_above) / (z_below + z_above), abs=0.04)
    assert transmitted / 0.01 == pytest.approx(2 * z_below / (z_below + z_above), abs=0.04)


def two_layers(spacing: float) -> Scene:
    """20 m of soft soil over 20 m of stiffer soil on a rigid base, shaken by a pulse."""
    soft = {"density": 1800.0, "youngs_modulus": 1e5, "cohesion": 5e5}
    return resting(
        name="two_layers",
        geometry={"shape": "block", "width": 6.0 * spacing, "height": 40.0},
        soil={"density": 2000.0, "youngs_modulus": 8e5},
        layers={"soft": {"region": {"kind": "elevation", "bottom": 20.0}, "soil": soft}},
        gravity={"acceleration": 1e-6, "ramp": 0.0, "duration": 0.01, "damping": 0.0},  # water asks for some
        motion={"kind": "ricker", "amplitude": 1.0, "frequency": 3.0, "peak": 0.6},
        numerics={"spacing": spacing},
        probes={"surface": [3.0 * spacing, 40.0]},
        outputs={"frame_interval": 4.0, "series_interval": 0.005},
    )


def two_layer_amplification(scene: Scene, frequency: np.ndarray) -> np.ndarray:
    """Surface over base (n,) of the two layers at frequencies (n,) in Hz: Kramer (1996), section 7.2.1.3, with the Rayleigh pair as it is.

    Stiffness damping makes the modulus G (1 + i omega beta).  Mass damping acts on the motion relative to the base.
    """
    assert scene.damping is not None
    omega = 2.0 * np.pi * frequency
    mass, stiffness = scene.damping.mass_coefficient, scene.damping.stiffness_coefficient

    def wave(soil: Any) -> tuple[np.ndarray, np.ndarray]:
        modulus = soil.shear_modulus_si * (1.0 + 1j * omega * stiffness)
        return omega * np.sqrt(soil.density * (1.0 - 1j * mass / omega) / modulus), modulus

    (above, soft), (below, stiff), height = wave(scene.layers["soft"].soil), wave(scene.soil), 20.0
    moved, sheared = np.cos(above * height), -np.sin(above * height) * above * soft
    base = moved * np.cos(below * height) + sheared / (below * stiff) * np.sin(below * height)
    carried = -1j * mass / (omega - 1j * mass)
    return np.abs((1.0 - carried) / base + carried)


@pytest.mark.long
@pytest.mark.parametrize(("spacing", "pitch", "height"), [(1.0, 0.005, 0.05), (0.5, 0.0025, 0.015)], ids=["1 m", "0.5 m"])
def test_two_layers_resonate_where_theory_has_them(spacing: float, pitch: float, height: float) -> None:
    # Both modes, in frequency and in amplification: the error is of second order in the spacing.  Between particles as they lie the
    # frequencies are 0.8 % high at 1 m and 1 % at 0.5 m, since the lattice carries waves too fast; near resonance that is 2 to 3.5 %.
    scene = two_layers(spacing)
    frequency, found = transfer(Result(scene, run(scene).trajectory))
    exact = two_layer_amplification(scene, frequency)
    for lowest, highest in ((0.6, 2.2), (2.6, 5.5)):
        mode = (frequency > lowest) & (frequency < highest)
        at, wanted = (int(np.argmax(of[mode])) for of in (found, exact))
        assert frequency[mode][at] == pytest.approx(frequency[mode][wanted], rel=pitch)
        assert found[mode][at] == pytest.approx(exact[mode][wanted], rel=height)


@pytest.mark.long
def test_momentum_and_energy_of_layers_that_are_stirred(free_block: Any) -> None:
    scene = free_block(
        ABOVE_A_WALL
        | {
            "soil.cohesion": 5.0,
            "soil.youngs_modulus": 2e4,
            "layers": {"heavy": {"region": {"kind": "elevation", "bottom": 15.0}, "soil": {"density": 4000.0, "youngs_modulus": 6e4}}},
            "damping.ratio": 0.0,
            "numerics.time_step": 2e-4,
            "outputs.series_interval": 2e-4,
            "numerics.artificial_viscosity": {"alpha": 0.5},
        }
    )
    started = Run(scene)
    simulation = started.simulation
    state, particles, generator = simulation.state, simulation.particles, np.random.default_rng(3)
    n = particles.n_soil
    assert {round(m) for m in particles.mass[:n]} == {1964, 4000}
    state.vx[:n] = generator.normal(size=n)
    state.vy[:n] = generator.normal(size=n)
    simulation.prepare()
    start, scale = momenta(particles, state), particles.mass @ np.hypot(state.vx, state.vy)
    simulation.advance_steps(500)
    # Lightness is rounded, so that forces are equal and opposite to rounding only.
    assert np.abs(momenta(particles, state) - start)[:2].max() < 1e-11 * scale
    result = started.go().trajectory
    energies = ("kinetic_energy", "elastic_energy", "potential_energy", "dissipated_energy")
    total = sum(result[name].values for name in energies)
    assert np.abs(total - total[0]).max() < 0.02 * result["kinetic_energy"].values.max()


def test_the_weight_of_layers() -> None:
    scene = resting(
        name="column",
        duration=0.5,
        geometry={"shape": "block", "width": 8.0, "height": 20.0},
        soil=LIGHT,
        layers={
            "fill": {"region": {"kind": "depth", "bottom": 5.0}, "soil": HEAVY},
            "base": {"region": {"kind": "elevation", "top": 8.0}, "soil": {"density": 2600.0, "youngs_modulus": 5e6, "cohesion": 5e5}},
        },
        gravity={"ramp": 0.0, "duration": 0.5, "damping": 20.0, "initial_stress": "geostatic"},
        motion={"kind": "none"},
        numerics={"spacing": 1.0},
        probes={"A": [4.0, 10.0]},
    )
    # Summed over parts of at most a quarter of a metre, of which one may straddle a boundary.
    exact = np.array([2250.0 * 4.5, 2250.0 * 5 + 1500.0 * 5, 2250.0 * 5 + 1500.0 * 7 + 2600.0 * 3.5])
    assert overburden(scene, np.full(3, 4.0), np.array([15.5, 10.0, 4.5])) == pytest.approx(exact, rel=0.005)
    ds = run(scene).trajectory
    column = (ds["kind"].values == 0) & (np.abs(ds["x0"].values - 4.5) < 0.1)
    y, stress = ds["y0"].values[column], -ds["stress_yy"].values[-1][column]
    expected = 9.81 * overburden(scene, ds["x0"].values[column], y)
    # The kernel smooths the step of the weight at an interface, and the stress that it smooths alternates from row to row by some
    # per cent (a zero-energy mode, as beside the base): means of two rows, away from base and ground by a kernel's radius.
    error = (0.5 * (stress[1:] + stress[:-1])) / (0.5 * (expected[1:] + expected[:-1])) - 1.0
    middle = (y[1:] > 3.0) & (y[1:] < 17.0)
    assert middle.sum() == 14 and np.abs(error[middle]).max() < 0.03
    assert ds["density"].values[-1][column][y < 7.5].mean() == pytest.approx(2600.0, rel=1e-3)


def test_each_layer_has_its_own_strength_and_coupling(small_slope: Any) -> None:
    layers = {
        "weak": {"region": {"kind": "depth", "bottom": 8.0}, "soil": {"cohesion": 20.0, "viscosity": 7.0}, "S_R": 0.1, "gamma": 3.0},
        "stiff": {"region": {"kind": "elevation", "top": 6.0}, "soil": {"youngs_modulus": 3e6}},
    }
    scene = small_slope({"layers": layers, "coupling.S_R": 0.5})
    simulation = Simulation(scene)
    terms, layer = simulation.terms, simulation.particles.layer
    plain = {
        0: small_slope({"coupling.S_R": 0.5}),
        1: small_slope({"soil.cohesion": 20.0, "soil.viscosity": 7.0, "coupling.S_R": 0.1, "coupling.gamma": 3.0}),
        2: small_slope({"soil.youngs_modulus": 3e6, "coupling.S_R": 0.5}),
    }
    assert set(layer) == set(plain)
    for i in range(0, layer.size, 7):
        expected = Simulation(plain[layer[i]]).terms.soil
        found = material_of(terms.layers, terms.soil, i)
        assert found == expected
        assert lightness(terms.layers, i) == 1.0
    divided, ratio = divided_strength(scene, 2.0), weakened(scene, 0.5)
    assert [soil.cohesion for soil in divided.soils] == [75.0, 10.0, 75.0]
    assert [soil.cohesion for soil in ratio.soils] == pytest.approx([75.0, 2.0, 75.0])


def test_a_layer_s_own_coupling_does_not_act_before_the_first_failure(small_slope: Any, tmp_path: Path) -> None:
    one, other = (
        small_slope({"layers": {"cover": {"region": {"kind": "depth", "bottom": 8.0}, "S_R": S_R, "gamma": gamma}}})
        for S_R, gamma in ((0.1, 100.0), (0.5, 1.0))
    )
    pre_failure = run(one, until="first_failure")
    assert pre_failure.status == "paused"
    trajectory.write(tmp_path / "pre_failure.nc", pre_failure.trajectory, pre_failure.restart)
    whole, branched = run(other), run(other, restart=tmp_path / "pre_failure.nc")
    same_bits(branched, whole)
    assert whole.trajectory["displacement_x"].values[-1].min() > run(one).trajectory["displacement_x"].values[-1].min() + 1.0


def test_a_weak_layer_fails_first(small_slope: Any) -> None:
    weak = {"weak": {"region": {"kind": "polygon", "points": [[40, 8], [90, 8], [90, 14], [40, 14]]}, "soil": {"cohesion": 10.0}}}
    ds = run(small_slope({"layers": weak})).trajectory
    soil = ds["kind"].values == 0
    t_f, layer = ds["t_f"].values[soil], ds["layer"].values[soil]
    first = np.nanargmin(t_f)
    assert layer[first] == 1 and np.nanmin(t_f[layer == 1]) < np.nanmin(t_f[layer == 0])
