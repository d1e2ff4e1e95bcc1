"""Contact walls: soil may leave them, lies on them as on a no-slip wall, and slides as its own strength allows."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from placed import Placed

from sph.measures.metrics import MetricSettings, measure
from sph.scene.schema import make_scene
from sph.solver.run import run

BOX: dict[str, Any] = {
    "scheme": "paper",
    "name": "box",
    "duration": 5.0,
    "geometry": {"shape": "block", "width": 8.0, "height": 6.0},
    "walls": {"base": "contact", "sides": "contact", "top": "contact"},
    "numerics": {"spacing": 1.0, "smoothing_ratio": 1.3, "precision": "double"},
}


@pytest.mark.uncompiled
@pytest.mark.parametrize("correction", [None, {"min_determinant": 0.3}], ids=["plain", "corrected"])
@pytest.mark.parametrize("top", ["contact", "no_slip"])
def test_contact_takes_no_energy_whoever_is_let_go(top: str, correction: dict[str, float] | None) -> None:
    box = Placed(BOX, {"walls.top": top, "numerics.gradient_correction": correction})
    box.take_no_energy()
    contact = box.pairs.contact[: box.n]
    touching, gone = np.hypot(contact[:, 0], contact[:, 1]) > 0.0, contact[:, 2] > 0.0
    assert 0 < gone.sum() < touching.sum() and not gone[~touching].any()


@pytest.mark.uncompiled
@pytest.mark.parametrize(
    ("stress", "velocity", "tension", "leaves"),
    [
        (1.0, 1.0, 0.0, True),  # pulled, and moving up
        (1.0, -1.0, 0.0, False),  # pulled, but coming down
        (-1.0, 1.0, 0.0, False),  # pressed
        (1.0, 1.0, 1.01, False),  # pulled by less than the wall bears
        (1.0, 1.0, 0.99, True),
    ],
)
def test_the_wall_lets_go_of_what_it_would_pull(stress: float, velocity: float, tension: float, leaves: bool) -> None:
    # A stress of so many kPa, and a velocity away from the base.
    box = Placed(BOX, {"walls.sides": "none", "walls.top": "none", "walls.tension": tension})
    box.state.syy[: box.n] = 1e3 * stress / box.scene.soil.density**2
    box.state.vy[: box.n] = velocity
    box.strain()
    box.accelerate()
    lowest = (box.y < 1.0) & (np.abs(box.x - 4.0) < 1.0)
    assert np.all(box.pairs.contact[: box.n, 2][lowest] == float(leaves))
    # Bonded, constant stress is in equilibrium there; let go, the free surface pulls upwards.
    unit = 1e3 / box.scene.soil.density**2 * np.abs(box.pairs.wall).max()
    assert np.all((box.state.ay[: box.n][lowest] > 0.1 * unit) == leaves)


def thrown(base: str) -> float:
    """How high (m) a block rises that starts upwards from a base at 2 m/s."""
    scene = make_scene(
        {
            "scheme": "paper",
            "name": "thrown",
            "duration": 0.2,
            "geometry": {"shape": "bodies", "width": 8.0, "height": 6.0, "bodies": [{"kind": "polygon", "points": BLOCK}]},
            "walls": {"base": base, "sides": "none"},
            "soil": {"cohesion": 1e4, "youngs_modulus": 5e3},
            "gravity": {"ramp": 0.0, "duration": 0.01, "damping": 0.0},
            "initial_velocity": {"along": "y", "position": [0.0], "x": [0.0], "y": [2.0]},
            "numerics": {"spacing": 0.5, "smoothing_ratio": 1.3, "time_step": 5e-4},
            "outputs": {"frame_interval": 0.1, "series_interval": 0.01},
        }
    )
    trajectory = run(scene).trajectory
    soil = trajectory["kind"].values == 0
    y = trajectory["y"].values[:, soil].astype(float)
    # Letting go costs at most the power of a step: 1.6, 0.75 and 0.36 % at 1e-3, 5e-4 and 2.5e-4 s.
    assert measure(trajectory, MetricSettings())["energy_error"] < 0.01
    return float((y[-1] - y[0]).mean())


BLOCK = [[2.0, 0.0], [6.0, 0.0], [6.0, 3.0], [2.0, 3.0]]


@pytest.mark.long
def test_a_block_leaves_a_contact_base_and_hangs_on_a_bonded_one() -> None:
    # The wall holds the block for the first step, and what it stretches by then goes on as a vibration.
    free = 2.0 * 0.2 - 0.5 * 9.81 * 0.2**2
    assert thrown("contact") == pytest.approx(free, rel=0.1)
    assert thrown("fixed") < 0.5 * free


def test_a_tension_without_contact_walls_is_refused() -> None:
    with pytest.raises(ValueError, match=r"walls\.tension: 2\.0 kPa .*contact"):
        make_scene(BOX | {"walls": {"base": "no_slip", "sides": "none", "top": "none", "tension": 2.0}})
