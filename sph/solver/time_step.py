"""Limits of the time step: from theory before a run, measured during it.

All limits come from the largest eigenvalue of the discrete operator.  For a lattice, a plane wave
of wave number k sees the effective wave number S(k) = sum_j V_j |dW/dx| sin(k x_ij); its maximum
over k is computed from the scene's kernel and spacing, not assumed.  With omega = V_p max S:

* acoustic: leapfrog is stable for dt < 2 / omega;
* stiffness damping, taken half a step back: dt < (sqrt(b^2 + 4) - b) / omega with
  b = beta_R omega (the root of omega^2 dt (dt / 4 + beta_R / 2) = 1);
* artificial viscosity acts on pairs, at most at the rate alpha V_p sum_j V_j |dW/dx| (in a mode that alternates
  along x only the pairs of one side approach), and adds to the damping of that highest mode;
* capped viscosity: 0.125 h^2 rho / eta_max.

Particles out of their lattice have stiffer modes: in the debris of the paper's scene the largest frequency is 1.2 times
that of the lattice at h = 1.3 spacings and 2.2 times at h = 2.3, at the same density.  So the largest frequency is also measured
on the present arrangement, by power iteration on the undamped elastic operator, a few iterations at every frame from where the last
frame left it (``stiffest_frequency``).  A run records the limit beside its step, and with ``adaptive_step`` keeps to it; one with
a fixed step says when it was exceeded.  Stiffness damping counts in the lattice limit only: failed soil has lost it.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from sph.scene.schema import MAX_STEPS, Scene
from sph.solver.compiled.jit import entry
from sph.solver.optional import Limit
from sph.solver.physics.artificial_viscosity import viscous_rate
from sph.solver.physics.elasticity import Strain, elastic_rate
from sph.solver.physics.gradient_correction import store_stress, velocity_gradient
from sph.solver.physics.kernels import Lattice, lattice_of
from sph.solver.physics.material import FLUID_LAWS, material_of
from sph.solver.physics.momentum import stress_accelerations, velocity_gradients
from sph.solver.terms import TERMS, State

if TYPE_CHECKING:
    from sph.solver.neighbours import Pairs
    from sph.solver.terms import Terms


def lattice_wave_number(scene: Scene, lattice: Lattice | None = None) -> float:
    """Largest effective wave number (1/m) of the discrete gradient on the initial lattice."""
    x, volume, factor = lattice or lattice_of(scene)
    k = np.linspace(0.0, np.pi / scene.numerics.spacing, 721)
    return float(np.abs(volume * (factor * x) @ np.sin(np.outer(x, k))).max())


def wave_speed_ratio(scene: Scene, wavelength: float) -> float:
    """Speed of elastic waves of a length (m) on the initial lattice over that in the soil; 0 for waves that it cannot carry."""
    x, volume, factor = lattice_of(scene)
    k = 2.0 * np.pi / wavelength
    if wavelength < 2.0 * scene.numerics.spacing:
        return 0.0
    return max(float(-volume * (factor * x) @ np.sin(k * x)) / k, 0.0)


def limits(scene: Scene) -> list[Limit]:
    """The limits that a scene has, s, each with its reason; damping terms add up in the order of ``TERMS``."""
    speed, lattice = scene.largest_p_wave_speed, lattice_of(scene)
    wave_number = lattice_wave_number(scene, lattice)
    omega = speed * wave_number
    found = [Limit("acoustic", 2.0 / omega, f"V_p = {speed:.0f} m/s, largest wave number {wave_number:.2f} 1/m")]
    b = 0.0
    for term in TERMS:
        if term.damping is not None and term.wanted(scene):
            damping = term.damping(scene, lattice, omega)
            b += damping.ratio
            found.append(Limit(damping.name, _damped(b, omega), damping.reason))
    law = FLUID_LAWS[scene.coupling.fluid.law]
    if law.limit is not None:
        found.append(law.limit(scene))
    return found


def _damped(b: float, omega: float) -> float:
    return 4.0 / (math.sqrt(b * b + 4.0) + b) / omega


class PresentLimit:
    """Limit of a scene's time step for particles as they lie."""

    def __init__(self, scene: Scene) -> None:
        self.lattice = min(limit.seconds for limit in limits(scene))
        self.viscous_rate = viscous_rate(scene)

    def seconds(self, frequency: float) -> float:
        """Limit (s) if the stiffest mode has this angular frequency (rad/s); never above that of the lattice."""
        return min(self.lattice, _damped(self.viscous_rate / frequency, frequency))


@entry
def stiffest_frequency(state: State, pairs: Pairs, terms: Terms, gradient: np.ndarray, iterations: int) -> float:
    """Largest angular frequency (rad/s) of elastic waves among the particles as they lie; a lower bound that iterations improve.

    ``state`` is one whose velocities hold the mode, which is improved in place, and whose stresses and accelerations are free to use;
    ``terms`` are those without viscosity and contact.
    """
    n = state.x.size
    square = 0.0
    for _ in range(iterations):
        for i in range(terms.n_moving, n):
            state.vx[i] = 0.0
            state.vy[i] = 0.0
        norm = 0.0
        for i in range(terms.n_moving):
            norm += state.vx[i] ** 2 + state.vy[i] ** 2
        scale = 1.0 / math.sqrt(norm)
        for i in range(terms.n_moving):
            state.vx[i] *= scale
            state.vy[i] *= scale
        velocity_gradients(state, pairs, terms, gradient, np.int64(0), n)
        for i in range(terms.n_stressed):
            s = 1.0 / state.density[i]
            l_xx, l_xy, l_yx, l_yy = velocity_gradient(terms.gradient_correction, pairs, state.density, gradient, i)
            soil = material_of(terms.layers, terms.soil, i)
            rate = elastic_rate(soil.shear_modulus, Strain(l_xx, l_yy, 0.5 * (l_xy + l_yx), 0.0, 0.0))
            mean = (soil.bulk_modulus * (l_xx + l_yy) - 0.5 * rate.zz) * s * s
            store_stress(
                terms.gradient_correction, pairs.correction, i, state, mean + rate.diff * s * s, mean - rate.diff * s * s, rate.xy * s * s
            )
        stress_accelerations(state, pairs, terms, gradient, np.int64(0), terms.n_moving)
        square = 0.0
        for i in range(terms.n_moving):
            square += state.ax[i] ** 2 + state.ay[i] ** 2
            state.vx[i] = -state.ax[i]
            state.vy[i] = -state.ay[i]
    return square**0.25


def mode_of(state: State) -> State:
    """A state that shares positions and lists with another, moves in its stiffest mode and has stresses of its own."""
    own = ("ax", "ay", "sxx", "syy", "sxy", "syx", "viscous_x", "viscous_y")
    return state._replace(vx=state.mode_x, vy=state.mode_y, **{name: np.zeros_like(state.x) for name in own})


def check_time_step(scene: Scene) -> None:
    """Refuse a time step above a limit, or a limit that an adaptive one meets in too many steps; ValueError names key, value and limit."""
    adaptive = scene.numerics.adaptive_step
    if adaptive is not None:
        smallest = min(limits(scene), key=lambda limit: limit.seconds)
        if scene.duration > MAX_STEPS * adaptive.courant * smallest.seconds:
            raise ValueError(
                f"numerics.adaptive_step: the limit by {smallest.name}, {smallest.seconds:.3g} s ({smallest.reason}), makes more than "
                f"{MAX_STEPS:,} steps of duration: {scene.duration} s; choose a shorter duration or a larger numerics.spacing"
            )
        return
    for limit in limits(scene):
        if scene.numerics.time_step >= limit.seconds:
            raise ValueError(
                f"numerics.time_step: {scene.numerics.time_step:g} s exceeds the limit by {limit.name}, "
                f"{limit.seconds:.3g} s ({limit.reason}); choose a smaller step"
            )
