"""What tests of runs share: solver variants that compile to other code, a comparison of every bit, momenta."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import xarray as xr

from sph.solver.particles import Particles
from sph.solver.run import Result
from sph.solver.terms import State
from sph.storage.trajectory import read, read_restart

VARIANTS = {
    "default": {},
    "gradient_correction": {"numerics.gradient_correction": {"min_determinant": 0.3}},
    "free_slip": {"walls.sides": "free_slip", "walls.layers": 4},
    "at rest": {"soil.K0": 0.8, "gravity.initial_stress": "geostatic", "gravity.ramp": 0.0},
    # The terms of the soil that keep arrays of their own in the state, in one scene.
    "all states": {
        "coupling.solid_after_failure": "elastic_plastic",
        "coupling.gamma": 0.0,
        "coupling.softening": {"slip_at_peak": 1e-4, "slip_at_residual": 0.01, "width": 7.5},
        "numerics.reference": "initial",
        "numerics.interfaces": "weaker",
        "soil.youngs_modulus": 5e4,
        "water": {"pressure": "carried", "r_u": 0.05, "excess_pressure": {"liquefaction": {}}},
        "layers": {
            "weak": {
                "region": {"kind": "depth", "bottom": 8.0},
                "soil": {"cohesion": 100.0, "friction_angle": 18.0, "blow_count": 5.0},
            }
        },
        "seams": {
            "clay": {
                "points": [[30.0, 2.0], [105.0, 24.0]],
                "cohesion": 40.0,
                "friction_angle": 14.0,
                "residual_cohesion": 5.0,
                "slip_at_residual": 0.5,
            }
        },
    },
}
"""Overrides by name."""


def same_bits(one: Result, other: Result) -> None:
    """Assert that trajectory, restart and status of two runs are the same, to the last bit."""
    same_variables(one.trajectory, other.trajectory)
    same_variables(one.restart, other.restart)
    assert one.restart.attrs["step"] == other.restart.attrs["step"]
    assert one.status == other.status


def same_variables(one: xr.Dataset, other: xr.Dataset) -> None:
    """Assert that two datasets hold the same bits."""
    assert set(one.variables) == set(other.variables)
    for name in one.variables:
        left, right = one[name].values, other[name].values
        assert left.dtype == right.dtype and left.shape == right.shape, name
        if left.dtype.kind in "OUT":
            assert left.tolist() == right.tolist(), name
        else:
            assert left.tobytes() == right.tobytes(), f"{name} differs by up to {np.nanmax(np.abs(left - right))}"


BESIDE = {"wall_time_s", "particle_steps_per_second", "findings"}
"""Attributes that tell how long a run took, and what the command found of its scene before it."""


def same_files(one: Path, other: Path) -> None:
    """Assert that two trajectories are the same to the last bit, with attributes and restart state, but for what stands beside a run."""
    for group in (read, read_restart):
        left, right = group(one).dataset(), group(other).dataset()
        same_variables(left, right)
        left_attrs, right_attrs = ({k: v for k, v in ds.attrs.items() if k not in BESIDE} for ds in (left, right))
        assert left_attrs == right_attrs


def momenta(particles: Particles, state: State) -> np.ndarray:
    """Linear momentum x, y (kg/s per m of thickness) and angular momentum about the origin."""
    m = particles.mass
    return np.array([m @ state.vx, m @ state.vy, m @ (state.x * state.vy - state.y * state.vx)])
