"""Limits of the time step, from theory, with the factor each one still has in hand.

All limits come from the largest eigenvalue of the discrete operator.  For a lattice, a plane wave
of wave number k sees the effective wave number S(k) = sum_j V_j |dW/dx| sin(k x_ij); its maximum
over k is computed from the scene's kernel and spacing, not assumed.  With omega = V_p max S:

* acoustic: leapfrog is stable for dt < 2 / omega;
* stiffness damping, taken half a step back: dt < (sqrt(b^2 + 4) - b) / omega with
  b = beta_R omega (the root of omega^2 dt (dt / 4 + beta_R / 2) = 1);
* artificial viscosity acts on pairs, at most at the rate 2 alpha V_p sum_j V_j |dW/dr|, and adds to
  the damping of that highest mode;
* capped viscosity: 0.125 h^2 rho / eta_max.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from sph.kernels import evaluate, make_kernel
from sph.scene import CappedViscosity, Scene


class Limit(NamedTuple):
    """One limit of the time step."""

    name: str
    seconds: float
    reason: str


def lattice_wave_number(scene: Scene) -> float:
    """Largest effective wave number (1/m) of the discrete gradient on the initial lattice."""
    x, volume, factor = _lattice(scene)
    k = np.linspace(0.0, np.pi / scene.numerics.spacing, 721)
    return float(np.abs(volume * (factor * x) @ np.sin(np.outer(x, k))).max())


def _lattice(scene: Scene) -> tuple[np.ndarray, float, np.ndarray]:
    numerics = scene.numerics
    kernel = make_kernel(numerics.kernel, numerics.smoothing_length)
    reach = int(np.ceil(2 * numerics.smoothing_length / numerics.spacing))
    offsets = np.arange(-reach, reach + 1) * numerics.spacing
    x, y = (a.ravel() for a in np.meshgrid(offsets, offsets))
    r = np.hypot(x, y)
    x, r = x[r > 0], r[r > 0]
    return x, numerics.spacing**2, np.array([evaluate(kernel, distance)[1] for distance in r])


def limits(scene: Scene) -> list[Limit]:
    """The limits that a scene has, smallest last reason included; seconds."""
    numerics, soil = scene.numerics, scene.soil
    wave_number = lattice_wave_number(scene)
    omega = soil.p_wave_speed * wave_number
    found = [Limit("acoustic", 2.0 / omega, f"V_p = {soil.p_wave_speed:.0f} m/s, largest wave number {wave_number:.2f} 1/m")]
    b = 0.0
    if scene.damping is not None:
        b += scene.damping.stiffness_coefficient * omega
        found.append(Limit("stiffness damping", _damped(b, omega), f"beta_R = {scene.damping.stiffness_coefficient:.3g} s"))
    if numerics.artificial_viscosity is not None:
        x, volume, factor = _lattice(scene)
        rate = numerics.artificial_viscosity.alpha * soil.p_wave_speed * volume * float(np.abs(factor * x).sum())
        b += rate / omega
        found.append(Limit("with artificial viscosity", _damped(b, omega), f"alpha = {numerics.artificial_viscosity.alpha}"))
    if isinstance(scene.coupling.fluid, CappedViscosity):
        cap = scene.coupling.fluid.max_viscosity
        found.append(Limit("capped viscosity", 0.125 * numerics.smoothing_length**2 * soil.density / cap, f"eta_max = {cap:.3g} Pa s"))
    return found


def _damped(b: float, omega: float) -> float:
    return float(np.sqrt(b * b + 4.0) - b) / omega


def check_time_step(scene: Scene) -> None:
    """Refuse a time step above a limit; ValueError names the key, the value and the limit."""
    for limit in limits(scene):
        if scene.numerics.time_step >= limit.seconds:
            raise ValueError(
                f"numerics.time_step: {scene.numerics.time_step:g} s exceeds the limit by {limit.name}, "
                f"{limit.seconds:.3g} s ({limit.reason}); choose a smaller step"
            )
