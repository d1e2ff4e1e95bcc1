"""Elastic columns and slopes of soft soil: at rest where closed forms have them, for Young's moduli over three decades."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from scipy.optimize import brentq
from small_scenes import NOTHING

from sph.scene.configuration import dotted, merge
from sph.scene.gravity import GRAVITY
from sph.scene.schema import Scene, make_scene
from sph.solver.physics.kernels import kernel_of, lattice_of
from sph.solver.run import run

HEIGHT, DENSITY, RATIO, SIDEWAYS = 10.0, 1900.0, 0.3, 1.0
"""Of the column (m), its soil (kg/m3, 1), and the steady acceleration that pushes it sideways, m/s2."""


def column(stiffness: float, spacing: float, changes: dict[str, Any] | None = None) -> Scene:
    """A column of elastic soil between periodic sides, of a Young's modulus (MPa).

    Its upper half has another strength, which changes nothing before it fails, so that its terms are those of ``test_weak_on_strong.py``.
    """
    return make_scene(
        merge(
            {
                "name": "column",
                "duration": 60.0 if stiffness < 10.0 else 20.0,  # vibrations, of 1.6 s in the softest column, have died out
                "geometry": {"shape": "block", "width": 6.0 * spacing, "height": HEIGHT},
                "walls": {"base": "no_slip", "sides": "periodic"},
                "soil": {
                    "density": DENSITY,
                    "youngs_modulus": 1e3 * stiffness,
                    "poisson_ratio": RATIO,
                    "cohesion": 1e6,
                    "friction_angle": 0.0,
                    "viscosity": 2.0,
                },
                "layers": {"other": {"region": {"kind": "elevation", "bottom": 0.5 * HEIGHT}, "soil": {"cohesion": 5e5}}},
                "coupling": {"gamma": 0.0, "S_R": 0.5},
                **NOTHING,
                "damping": {"ratio": 0.05, "frequencies": [0.3, 5.0]},
                "gravity": {"ramp": 4.0, "duration": 10.0, "damping": 3.0},
                "motion": {"kind": "constant", "amplitude": SIDEWAYS, "start": 10.0, "ramp": 4.0},
                "numerics": {"spacing": spacing},
                "outputs": {"frame_interval": 2.0, "series_interval": 0.01},
            },
            dotted(changes or {}),
        )
    )


def settlement(stiffness: float, y: float) -> float:
    """Settlement (m) at height y of the column: sigma(Y) = rho g (H - Y) = K (1 / l - 1) - 4/3 G ln l with the stretch l, exactly."""
    young = 1e6 * stiffness
    bulk, shear = young / 3.0 / (1.0 - 2.0 * RATIO), young / 2.0 / (1.0 + RATIO)

    def strain(at: float) -> float:
        def open_balance(stretch: float) -> float:
            return bulk * (1.0 / stretch - 1.0) - 4.0 / 3.0 * shear * math.log(stretch) - DENSITY * GRAVITY * (HEIGHT - at)

        return 1.0 - float(brentq(open_balance, 0.5, 1.5, xtol=1e-14))

    places = (np.arange(400) + 0.5) / 400 * y
    return float(np.mean([strain(at) for at in places]) * y)


@pytest.mark.long
@pytest.mark.parametrize(("stiffness", "spacing"), [(3.0, 0.25), (5.0, 0.25), (30.0, 0.25), (3000.0, 0.5)])
def test_a_column_rests_where_it_should(stiffness: float, spacing: float) -> None:
    # Sideways u = rho a H^2 / 2 G at the top and as settled as before, to 1 %: of the lowest displacement, since the surface of the
    # kernel is half a spacing thick.  The stretch of the settled column and the rotation of its stress cancel to first order.
    trajectory = run(column(stiffness, spacing)).trajectory
    soil = trajectory["kind"].values == 0
    x, y = (trajectory[f"displacement_{axis}"].values[:, soil].astype(float) for axis in "xy")
    start = int(np.argmin(np.abs(trajectory["time"].values - 10.0)))
    first = trajectory["y"].values[0, soil] - y[0]
    top = first > HEIGHT - spacing
    height = float(first[top].mean())
    expected = -DENSITY * SIDEWAYS * (HEIGHT - 0.5 * height) * height / (1e6 * stiffness / 2.0 / (1.0 + RATIO))
    settled = -settlement(stiffness, height)
    found = (x[-1] - x[start])[top].mean(), y[start, top].mean(), (y[-1] - y[start])[top].mean()
    speed = np.hypot(trajectory["velocity_x"].values[-1, soil], trajectory["velocity_y"].values[-1, soil]).max()
    print(f"E {stiffness:g} MPa: {found[0] / expected:.4f} sideways, {found[1] / settled:.4f} settled, {found[2] / settled:.4f} after")
    assert found[0] == pytest.approx(expected, rel=0.01) and found[1] == pytest.approx(settled, rel=0.01)
    assert abs(found[2]) < 0.01 * abs(settled) and speed < 1e-3


def test_the_lattice_strains_and_carries_waves_as_the_soil_does() -> None:
    # sum_j V g x = 1 with the kernel of the initial arrangement, and what the kernel itself makes of it otherwise: 1.0105 at 1.3 spacings.
    scene = column(300.0, 0.5)
    lattice = lattice_of(scene)
    assert -(lattice.volume * lattice.factor * lattice.x**2).sum() == pytest.approx(1.0, rel=1e-12)
    current = column(300.0, 0.5, {"numerics.reference": "current"})
    assert kernel_of(current).gradient_scale == 1.0
    assert kernel_of(scene).gradient_scale == pytest.approx(1 / 1.0105, rel=1e-4)
