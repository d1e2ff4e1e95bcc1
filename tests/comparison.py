"""What tests of equal runs share: solver variants that compile to other code, and a comparison of every bit."""

from __future__ import annotations

import numpy as np

from sph.solver import Result

VARIANTS = {
    "default": {},
    "gradient_correction": {"numerics.gradient_correction": {"min_determinant": 0.3}},
    "free_slip": {"walls.sides": "free_slip", "walls.layers": 4},
}
"""Overrides by name."""


def same_bits(one: Result, other: Result) -> None:
    """Assert that trajectory, restart and status of two runs are the same, to the last bit."""
    for a, b in ((one.trajectory, other.trajectory), (one.restart, other.restart)):
        assert set(a.variables) == set(b.variables)
        for name in a.variables:
            left, right = a[name].values, b[name].values
            assert left.dtype == right.dtype and left.shape == right.shape, name
            if left.dtype.kind in "OUT":
                assert left.tolist() == right.tolist()
            else:
                assert left.tobytes() == right.tobytes(), f"{name} differs by up to {np.nanmax(np.abs(left - right))}"
    assert one.restart.attrs["step"] == other.restart.attrs["step"]
    assert one.status == other.status
