"""V1: a column between frictionless walls carries sigma_yy = rho g z and sigma_xx = nu / (1 - nu) sigma_yy."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

from sph.scene.schema import make_scene
from sph.solver.run import run

WIDTH, HEIGHT, SPACING = 10.0, 20.0, 1.0
DENSITY, POISSON, G = 2000.0, 0.3, 9.81
BOTTOM_STRESS = DENSITY * G * HEIGHT


@cache
def column(smoothing_ratio: float, layers: int, kernel: str = "cubic_spline") -> dict[str, np.ndarray]:
    """Depth and stresses (compression positive) of the soil after the gravity stage.

    E = 500 MPa: strains of 0.06 %, and V_p = 580 m/s keeps the run short.  The strength keeps it elastic.
    """
    scene = make_scene(
        {
            "scheme": "paper",
            "name": "column",
            "duration": 4.0,
            "geometry": {"shape": "block", "width": WIDTH, "height": HEIGHT},
            "walls": {"base": "fixed", "sides": "free_slip", "layers": layers},
            "soil": {"density": DENSITY, "youngs_modulus": 5e5, "poisson_ratio": POISSON, "cohesion": 1e5},
            "gravity": {"ramp": 1.0, "duration": 3.0, "damping": 20.0, "acceleration": G},
            "numerics": {"spacing": SPACING, "smoothing_ratio": smoothing_ratio, "kernel": kernel, "time_step": 5e-4},
        }
    )
    ds = run(scene, until="gravity").trajectory
    assert ds.attrs["status"] == "paused"
    soil = ds["kind"].values == 0
    last = {name: ds[name].values[-1][soil].astype(float) for name in ds.data_vars if ds[name].dims == ("frame", "particle")}
    assert not last["failed"].any(), "the column must stay elastic"
    return {
        "depth": HEIGHT - ds["y0"].values[soil],
        "xx": -last["stress_xx"],
        "yy": -last["stress_yy"],
        "zz": -last["stress_zz"],
        "xy": last["stress_xy"],
        "speed": np.hypot(last["velocity_x"], last["velocity_y"]),
        "support": 2 * smoothing_ratio * SPACING,
    }


def middle(c: dict[str, np.ndarray]) -> np.ndarray:
    """Between a quarter and three quarters of the height, where kernels are complete."""
    return (c["depth"] > 0.25 * HEIGHT) & (c["depth"] < 0.75 * HEIGHT)


# Walls as thick as the support, so that no kernel sees beyond them.
CASES = pytest.mark.parametrize("case", [(2.3, 5), (1.3, 3)], ids=["ratio 2.3", "ratio 1.3"])


def literal_misses(numbers: str) -> pytest.MarkDecorator:
    """The same cases where the literal smoothing length is known to miss."""
    mark = pytest.mark.xfail(strict=True, reason=f"zero-energy modes at the literal smoothing length: {numbers}")
    return pytest.mark.parametrize("case", [pytest.param((2.3, 5), marks=mark), (1.3, 3)], ids=["ratio 2.3", "ratio 1.3"])


@CASES
def test_mean_stresses_at_mid_height(case: tuple[float, int]) -> None:
    # Pair forces carry exactly the weight above and the law fixes sigma_xx / sigma_yy, so the means over the
    # middle of the column must agree but for the kernel's moment on a lattice (1 % at 1.3, less at 2.3) and the
    # truncated kernels at surface and base, half a spacing of overburden in 10 m: 5 % in all.
    c = column(*case)
    zone = middle(c)
    overburden = DENSITY * G * c["depth"][zone].mean()
    assert c["yy"][zone].mean() == pytest.approx(overburden, rel=0.05)
    assert c["xx"][zone].mean() == pytest.approx(POISSON / (1 - POISSON) * overburden, rel=0.05)
    assert c["zz"][zone].mean() == pytest.approx(POISSON / (1 - POISSON) * overburden, rel=0.05)


@pytest.mark.xfail(
    strict=True,
    reason="zero-energy modes: rows alternate; largest error 19 % (yy), 23 % (xx) at ratio 2.3 and 9 %, 15 % at 1.3",
)
@CASES
def test_stresses_of_every_particle_at_mid_height(case: tuple[float, int]) -> None:
    # As above for single particles, which see half a spacing of overburden less or more at most: 3 %.
    c = column(*case)
    zone = middle(c)
    overburden = DENSITY * G * c["depth"][zone]
    np.testing.assert_allclose(c["yy"][zone], overburden, rtol=0.03)
    np.testing.assert_allclose(c["xx"][zone], POISSON / (1 - POISSON) * overburden, rtol=0.03)


@CASES
def test_stress_grows_linearly_with_depth(case: tuple[float, int]) -> None:
    # Slope of a straight line through all of the middle zone: alternating rows cancel to about their size over the number of
    # rows (10): 5 % as for the means.
    c = column(*case)
    zone = middle(c)
    slope = np.polyfit(c["depth"][zone], c["yy"][zone], 1)[0]
    assert slope == pytest.approx(DENSITY * G, rel=0.05)


def test_walls_thinner_than_the_support_are_refused() -> None:
    # Mirrored stress in two layers (2 m) under the literal smoothing length (support 4.6 m) leaves sum_j g_ij
    # in x at the soil's edge, and sigma_xx = 0 is the only equilibrium: found -0.3 kPa for 84.
    with pytest.raises(ValueError, match=r"walls\.layers: 2 "):
        column(2.3, 2)


def test_at_rest_at_the_end_of_the_stage() -> None:
    # The ramp lasts several periods (4 H / V_p = 0.12 s) and the extra damping acts for another second
    # after it: what is left must be far below the settlement rate g / omega = 0.2 m/s of a sudden load: 0.5 %.
    assert column(1.3, 3)["speed"].max() < 1e-3


@pytest.mark.xfail(strict=True, reason="soft zero-energy modes (wavelengths of 2.5 to 3 spacings) drift at 1 to 2 cm/s")
def test_at_rest_at_the_literal_smoothing_length() -> None:
    assert column(2.3, 5)["speed"].max() < 1e-3


@literal_misses("1.9 %")
def test_no_shear_stress(case: tuple[float, int]) -> None:
    # Zero by symmetry in the middle, by the frictionless wall at the sides: 1 % of the bottom stress.
    c = column(*case)
    assert np.abs(c["xy"]).max() < 0.01 * BOTTOM_STRESS


@CASES
def test_near_the_surface_and_the_base(case: tuple[float, int]) -> None:
    # Within a support of the surface or the base kernels are truncated, and the stress of a particle is
    # known to within about one support of soil at most: the error must stay below that weight.
    c = column(*case)
    near = (c["depth"] < c["support"]) | (c["depth"] > HEIGHT - c["support"])
    error = np.abs(c["yy"] - DENSITY * G * c["depth"])[near]
    assert error.max() < DENSITY * G * c["support"]


@literal_misses("3.9 %")
def test_the_same_across_the_column(case: tuple[float, int]) -> None:
    # Frictionless walls leave the problem one-dimensional: rows are uniform to 3 % of the bottom stress.
    c = column(*case)
    for depth in np.unique(c["depth"][middle(c)]):
        row = c["yy"][c["depth"] == depth]
        assert np.ptp(row) < 0.03 * BOTTOM_STRESS
