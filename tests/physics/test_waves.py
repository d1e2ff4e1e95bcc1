"""V2: plane P and S pulses travel at V_p = 1159.9 and V_s = 562.9 m/s (Table 1)."""

from __future__ import annotations

import math

import numpy as np
import pytest

from sph.scene.schema import Scene, make_scene
from sph.solver.particles import place_particles
from sph.solver.physics.kernels import evaluate, make_kernel
from sph.solver.simulation import Simulation
from sph.solver.terms import State

PULSE_WIDTH = 7.0
"""Standard deviation of the Gaussian, m."""


def block(width: float, height: float, smoothing_ratio: float) -> Scene:
    """A free block of the paper's soil without gravity, 10 m above a wall.

    Damping and artificial viscosity are 0 and no particle comes near another or the wall, so that they are there without an effect: one
    variant of the solver with the slope of other tests.
    """
    corners = [[0.0, 10.0], [width, 10.0], [width, 10.0 + height], [0.0, 10.0 + height]]
    return make_scene(
        {
            "scheme": "paper",
            "name": "wave",
            "duration": 0.2,
            "geometry": {"shape": "bodies", "width": width, "height": height + 20.0, "bodies": [{"kind": "polygon", "points": corners}]},
            "walls": {"base": "fixed", "sides": "none"},
            "soil": {"cohesion": 1e6},
            "gravity": {"acceleration": 0.0, "ramp": 0.0, "duration": 0.01, "damping": 0.0},
            "damping": {"ratio": 0.0},
            "numerics": {
                "spacing": 1.0,
                "smoothing_ratio": smoothing_ratio,
                "time_step": 2e-4,
                "artificial_viscosity": {"alpha": 0.0},
            },
        }
    )


def peak_times(scene: Scene, component: str, source: float, stations: list[float], duration: float) -> tuple[list[float], State]:
    """Times (s) at which the velocity at mid-height peaks at distances ``stations`` (m) from the source.

    The initial velocity is a Gaussian in x of 0.01 m/s; it splits into two pulses of half the height,
    of which the right one is followed.  Peaks are refined by a parabola through three samples.
    """
    run = Simulation(scene)
    state, particles = run.state, run.particles
    velocity = state.vx if component == "x" else state.vy
    velocity[:] = 0.01 * np.exp(-0.5 * ((particles.x - source) / PULSE_WIDTH) ** 2)
    rows = np.abs(particles.y - 0.5 * scene.geometry.height) < 1.0
    listeners = [rows & (np.abs(particles.x - (source + station)) < 0.6) for station in stations]
    run.prepare()
    heard = []
    for _ in range(scene.steps(duration)):
        assert run.advance_steps(1) == (0, 1)
        heard.append([velocity[listener].mean() for listener in listeners])
    signal = np.array(heard)
    times = []
    for column in signal.T:
        k = int(np.argmax(column))
        assert 0 < k < len(column) - 1, "the pulse did not pass within the run"
        assert 0.004 < column[k] < 0.0055, "half the initial pulse, hardly dispersed"
        before, at, after = column[k - 1 : k + 2]
        times.append((k + 1 + 0.5 * (before - after) / (before - 2 * at + after)) * scene.numerics.time_step)
    return times, state


def discrete_wave_number(scene: Scene, k: np.ndarray) -> np.ndarray:
    """Wave number (1/m) that the sums over a lattice make of k: sum_j V |dW/dx| sin(k x_j)."""
    spacing = scene.numerics.spacing
    kernel = make_kernel(scene.numerics.kernel, scene.numerics.smoothing_length)
    reach = math.ceil(2 * scene.numerics.smoothing_length / spacing)
    total = np.zeros_like(k)
    for column in range(-reach, reach + 1):
        for row in range(-reach, reach + 1):
            if column or row:
                x, y = column * spacing, row * spacing
                total -= spacing**2 * evaluate(kernel, math.hypot(x, y))[1] * x * np.sin(k * x)
    return total


def speed_on_the_lattice(scene: Scene, speed: float, stations: list[float]) -> float:
    """Speed (m/s) of the peak between two stations by Fourier synthesis of the pulse with omega = speed k_discrete."""
    k = np.linspace(0.0, 6.0 / PULSE_WIDTH, 400)
    omega = speed * discrete_wave_number(scene, k)
    spectrum = np.exp(-0.5 * (k * PULSE_WIDTH) ** 2)
    times = []
    for station in stations:
        t = station / speed * np.linspace(0.9, 1.2, 6001)
        signal = np.cos(k[None, :] * station - omega[None, :] * t[:, None]) @ spectrum
        times.append(t[np.argmax(signal)])
    return (stations[1] - stations[0]) / (times[1] - times[0])


# The discrete gradient sees the wave number k as k W(k), W the kernel's transform, 1 - 0.158 (k h)^2 for the
# cubic spline.  A Gaussian pulse of width w then lags by 3 * 0.158 (h / w)^2: 5.1 % at h = 2.3 m and
# 1.6 % at h = 1.3 m; half a percent is added for the reading of the peaks.  (A first estimate here took the mean
# of k^2 over the power instead of the amplitude, half as much; the runs missed it at h = 2.3 m, 4.0 against 3.1 %.)
# Against the speed on the lattice, where that lag is taken out, only reading and time step are left: 0.5 %.
CASES = [pytest.param(2.3, 0.056, marks=pytest.mark.long), (1.3, 0.021)]


# P: the second peak passes at 45 m, after 0.039 s; the free faces above and below reach mid-height after 55 m of travel at V_p, and the
# pulse reflected at the left end trails by 60 m.  S: it passes at 38 m, after 0.0675 s; by then waves of the faces at V_p have come 78 m,
# less than the 80 m to mid-height.
PULSES = {
    "p_wave_speed": ((90.0, 110.0), "x", 30.0, [20.0, 45.0], 0.046, 1159.9),
    "s_wave_speed": ((85.0, 160.0), "y", 26.0, [18.0, 38.0], 0.075, 562.9),
}


@pytest.mark.parametrize(("smoothing_ratio", "tolerance"), CASES)
@pytest.mark.parametrize("name", PULSES)
def test_wave_speed(name: str, smoothing_ratio: float, tolerance: float) -> None:
    size, component, source, stations, duration, exact = PULSES[name]
    scene = block(*size, smoothing_ratio)
    times, _ = peak_times(scene, component, source, stations, duration)
    speed, on_the_lattice = (stations[1] - stations[0]) / (times[1] - times[0]), speed_on_the_lattice(scene, exact, stations)
    print(f"{name}, h = {smoothing_ratio} m: {speed:.1f} m/s, on the lattice {on_the_lattice:.1f}")
    assert getattr(scene.soil, name) == pytest.approx(exact, abs=0.05)
    assert speed == pytest.approx(exact, rel=tolerance)
    assert speed == pytest.approx(on_the_lattice, rel=0.005)


def test_stress_of_the_p_pulse() -> None:
    # In the right-going pulse sigma_xx = -rho V_p v: with the full P-wave modulus, not the bulk modulus.
    # (With total instead of deviatoric strain in Eq. 10 it would be 23 % off.)  The truncated half
    # of the pulse and its dispersion leave 3 % at h = 1.3.
    scene = block(90.0, 110.0, 1.3)
    _, state = peak_times(scene, "x", 30.0, [20.0], 0.030)
    particles = place_particles(scene)
    row = np.flatnonzero((np.abs(particles.y - 65.5) < 0.1) & (particles.x > 45.0))
    front = row[np.argmax(state.vx[row])]
    stress = state.sxx[front] * state.density[front] ** 2
    assert stress == pytest.approx(-scene.soil.density * scene.soil.p_wave_speed * state.vx[front], rel=0.03)
    # Plane strain: sigma_zz = nu / (1 - nu) sigma_xx.
    z = state.solid_zz[front]
    p = scene.soil.bulk_modulus_si * (state.density[front] / scene.soil.density - 1)
    assert (-p + z) / stress == pytest.approx(0.346 / 0.654, rel=0.01)
    assert math.isfinite(z)
