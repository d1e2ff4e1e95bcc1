"""The order of the time integration: leapfrog is of second order."""

from __future__ import annotations

import numpy as np
import pytest
from small_scenes import ABOVE_A_WALL, SceneBuilder

from sph.solver.simulation import Simulation

END = 0.02
"""About half a period of the slowest wave across the block (10 m at V_p of about 700 m/s), s."""
STEPS = (4e-4, 2e-4, 1e-4)


def positions(free_block: SceneBuilder, dt: float) -> np.ndarray:
    """Where the particles of an elastic block are that starts unstressed, with a smooth velocity."""
    simulation = Simulation(
        free_block(
            ABOVE_A_WALL
            | {
                "coupling.S_R": 1.0,
                "soil.youngs_modulus": 5e5,
                "numerics.time_step": dt,
                "numerics.gradient_tolerance": 0.0,
                "numerics.artificial_viscosity.alpha": 0.0,
                "damping.ratio": 0.0,
                "gravity.duration": 4e-4,
                "outputs.frame_interval": 4e-4,
                "outputs.series_interval": 4e-4,
            }
        )
    )
    simulation.state.vx[:] = 0.1 * np.cos(np.pi * simulation.particles.x / 10.0)
    simulation.prepare()
    steps = round(END / dt)
    assert simulation.advance_steps(steps) == (0, steps)
    return np.concatenate([simulation.state.x, simulation.state.y])


def test_halving_the_step_leaves_a_quarter_of_the_error(free_block: SceneBuilder) -> None:
    # Error c dt^2 + O(dt^4): the differences of three runs stand as 4 to 1.  The first acceleration is zero, so that velocities half a step
    # behind are exact at the start.
    coarse, middle, fine = (positions(free_block, dt) for dt in STEPS)
    first, second = np.abs(coarse - middle).max(), np.abs(middle - fine).max()
    print(f"differences {first:.3g} and {second:.3g} m, order {np.log2(first / second):.3f}")
    assert second > 1e-9, "far above rounding"
    assert np.log2(first / second) == pytest.approx(2.0, abs=0.1)
