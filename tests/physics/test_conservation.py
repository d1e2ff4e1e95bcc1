"""V15: momentum of closed systems to rounding, and an energy budget that closes."""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np
import pytest
from comparison import momenta
from small_scenes import ABOVE_A_WALL

from sph.scene.configuration import merge
from sph.scene.schema import Scene, make_scene
from sph.solver.run import run
from sph.solver.simulation import Simulation
from sph.solver.state import FAILED, REPULSION, VISCOUS


class Closed:
    """A free block of weak soil that is jittered, spun and stirred, with every pair term on."""

    def __init__(self, free_block: Any, overrides: dict[str, Any]) -> None:
        scene: Scene = free_block(
            ABOVE_A_WALL
            | {
                "soil.cohesion": 5.0,
                "soil.youngs_modulus": 2e4,
                "coupling.S_R": 0.2,
                # Rayleigh damping of zero: mass damping would brake the block, as it should.
                "damping.ratio": 0.0,
                "numerics.time_step": 2e-4,
                # Armed at the first step, before anything yields.
                "gravity.duration": 2e-4,
                "outputs.series_interval": 2e-4,
                "numerics.artificial_viscosity": {"alpha": 0.5},
                "numerics.short_range_repulsion": {"range": 0.95, "pressure": 500.0},
            }
            | overrides
        )
        run = Simulation(scene)
        generator, n = np.random.default_rng(11), run.particles.n_soil
        run.particles.x[:n] += generator.uniform(-0.15, 0.15, n)
        run.particles.y[:n] += generator.uniform(-0.15, 0.15, n)
        self.particles, self.state = run.particles, run.state
        for name in ("x", "x_pairs", "x_candidates"):
            getattr(self.state, name)[:] = self.particles.x
        for name in ("y", "y_pairs", "y_candidates"):
            getattr(self.state, name)[:] = self.particles.y
        self.state.vx[:n] = 2.0 * generator.normal(size=n) - 0.8 * (self.particles.y[:n] - 15.0) + 3.0
        self.state.vy[:n] = 2.0 * generator.normal(size=n) + 0.8 * (self.particles.x[:n] - 5.0)
        run.prepare()
        self.start = momenta(self.particles, self.state)
        self.scale = self.particles.mass @ np.hypot(self.state.vx, self.state.vy)
        self.angular_scale = self.particles.mass @ (
            np.hypot(self.state.vx, self.state.vy) * np.hypot(self.particles.x - 5.0, self.particles.y - 15.0)
        )
        self.drift = np.zeros(3)
        self.failed = self.overlaps = 0
        for _ in range(20):
            failed, done = run.advance_steps(100)
            assert done == 100
            self.failed += failed
            self.overlaps = max(self.overlaps, self.state.work[REPULSION])
            self.drift = np.maximum(self.drift, np.abs(momenta(self.particles, self.state) - self.start))


@pytest.fixture(scope="module")
def closed(free_block: Any) -> Closed:
    return Closed(free_block, {})


def test_every_pair_term_is_at_work(closed: Closed) -> None:
    # Guards the tests below: particles fail, overlap and rub.
    assert closed.failed > 10
    assert closed.overlaps > 0
    assert closed.state.work[VISCOUS] > 0
    assert np.any(closed.state.phase == FAILED)


def test_linear_momentum_to_rounding(closed: Closed) -> None:
    # Forces of a pair are equal and opposite to the last bit or so; 2000 steps of sums over 100 particles with
    # 60 neighbours: 1e-16 sqrt(2000 * 6000) is 4e-13 of the forces' impulse, which exceeds m v by about ten.  Gradients in
    # single precision change no pair's balance, since (i, j) and (j, i) are rounded alike.
    print(f"linear momentum drift {closed.drift[:2].max() / closed.scale:.1e}")
    assert closed.drift[0] < 1e-11 * closed.scale
    assert closed.drift[1] < 1e-11 * closed.scale


def test_angular_momentum_drift_is_bounded(closed: Closed) -> None:
    # Stress forces of a pair are not central, so the scheme does not conserve angular momentum exactly (the plain
    # gradient of a rotation is not one near a free surface).  Measured 0.03 % of the scale within 0.4 s of stirring.
    print(f"angular momentum drift {closed.drift[2] / abs(closed.start[2]):.3%}")
    assert closed.drift[2] < 0.005 * closed.angular_scale


@pytest.mark.parametrize("correction", [None, pytest.param({"min_determinant": 0.3}, marks=pytest.mark.long)], ids=["plain", "corrected"])
def test_linear_momentum_of_an_elastic_spin(free_block: Any, correction: dict[str, float] | None) -> None:
    # Without failure and friction, with either gradient: the same bound.
    elastic = {"soil.cohesion": 1e6, "soil.youngs_modulus": 2e5, "coupling.S_R": 1.0}
    c = Closed(free_block, elastic | {"numerics.gradient_correction": correction})
    assert c.failed == 0
    assert c.drift[:2].max() < 1e-11 * c.scale


# ---------------------------------------------------------------- energy


INITIAL: dict[str, Any] = {"artificial_viscosity": {"reconstruction": "linear"}, "reference": "initial"}
SCHEMES: dict[str, dict[str, Any]] = {
    "fixed": {"walls": {"sides": "fixed"}},
    "double": {"walls": {"sides": "fixed"}, "numerics": {"precision": "double"}},
    "elastic_plastic": {"walls": {"sides": "fixed"}, "coupling": {"solid_after_failure": "elastic_plastic", "gamma": 10.0}},
    "free_slip": {"walls": {"sides": "free_slip"}},
    "corrected": {"walls": {"sides": "fixed"}, "numerics": {"gradient_correction": {"min_determinant": 0.3}}},
    "no_slip": {
        "walls": {"base": "no_slip", "sides": "no_slip"},
        "numerics": INITIAL,
        "coupling": {"solid_after_failure": "elastic_plastic", "softening": {"slip_at_peak": 1e-4, "width": 7.5}},
    },
    "seam": {
        "walls": {"base": "no_slip", "sides": "free_slip"},
        "numerics": INITIAL,
        "coupling": {"solid_after_failure": "elastic_plastic"},
        "seams": {"clay": {"points": [[30.0, 2.0], [105.0, 24.0]], "cohesion": 60.0, "friction_angle": 18.0}},
    },
}
"""The walls and terms with which the budget is tested."""


@cache
def collapse(scheme: str) -> dict[str, np.ndarray]:
    """Series of a slope of weak soil that is shaken until it collapses."""
    scene = make_scene(
        merge(
            {
                "scheme": "paper",
                "name": "collapse",
                "duration": 5.0,
                "geometry": {"shape": "slope"},
                "walls": {"layers": 4},
                "soil": {"cohesion": 120.0},
                "coupling": {"S_R": 0.1, "gamma": 100.0},
                "gravity": {"ramp": 0.5, "duration": 1.0},
                "motion": {"kind": "tapered_sine", "amplitude": 8.0, "start": 1.0, "ramp": 0.5, "decay_start": 3.0, "end": 3.5},
                "numerics": {"spacing": 2.5, "time_step": 5e-4},
            },
            SCHEMES[scheme],
        )
    )
    ds = run(scene).trajectory
    assert ds.attrs["status"] == "complete"
    assert float(ds["failed_fraction"][-1]) > 0.3
    assert float(ds["probe_displacement_y"][-1, 0]) < -1.0, "it must collapse for the budget to mean something"
    return {name: ds[name].values for name in ds.data_vars if ds[name].dims == ("sample",)}


LONG = ("double", "elastic_plastic", "corrected", "no_slip", "seam")
VARIANTS = pytest.mark.parametrize("scheme", [pytest.param(name, marks=pytest.mark.long) if name in LONG else name for name in SCHEMES])


def released(s: dict[str, np.ndarray]) -> float:
    """Energy that went through the slope: work of gravity and of shaking at their largest, J/m."""
    return float(np.abs(s["potential_energy"]).max() + np.abs(s["shaking_work"]).max())


@VARIANTS
def test_energy_budget_closes(scheme: str) -> None:
    # Forces and stress power are conjugate, so what is left is the error of time integration: the last half step's
    # work, of order omega dt times a small share of the energies.  Measured 0.002 to 0.007 %; a term left out or
    # counted twice, even mass damping alone, is above 1 %.
    s = collapse(scheme)
    rest = s["kinetic_energy"] + s["elastic_energy"] + s["potential_energy"] + s["dissipated_energy"] - s["shaking_work"]
    print(f"{scheme}: budget closes to {np.abs(rest).max() / released(s):.3%}")
    assert np.abs(rest).max() < 1e-3 * released(s)


@VARIANTS
def test_dissipated_energy_does_not_decrease(scheme: str) -> None:
    # Yield, damping, loss of strength and artificial viscosity only take energy; the fall from the highest value so far
    # is bounded by what the budget itself leaves open: 0.1 % of the energy released.
    s = collapse(scheme)
    lost = s["dissipated_energy"]
    fall = np.maximum.accumulate(lost) - lost
    print(f"{scheme}: largest fall {fall.max() / released(s):.3%}, dissipated {lost[-1] / released(s):.1%}")
    assert fall.max() < 1e-3 * released(s)
    assert lost[-1] > 0.4 * released(s), "a collapse ends in dissipation, if some of it still moves after 5 s"
