"""Shear tests: strengths and slips of made tests are found again, the keys are a scene's, and what is no test is refused."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml
from calling import call

from sph.command.shear_test import fit_loss, read_tests, strength
from sph.jobs.exit_codes import REFUSED
from sph.scene.configuration import merge
from sph.scene.schema import make_scene
from sph.solver.physics.loss_by_slip import ExponentialLossBySlip, LinearLossBySlip, remaining_weight
from sph.storage.files import whole

STIFFNESS = 30e3
"""kPa/m."""
PEAK, RESIDUAL = (12.0, 30.0), (1.0, 18.0)
"""c (kPa) and phi (degree)."""
SLIPS = 3e-3, 8e-2
"""At the peak and at the residual strength, m."""
SCENE: dict[str, Any] = {
    "name": "slope",
    "duration": 5.0,
    "geometry": {"shape": "ground_line", "points": [[0, 10], [40, 10], [60, 20], [100, 20]], "base": 0.0},
    "soil": {"density": 1900.0, "youngs_modulus": 1e5, "poisson_ratio": 0.3, "viscosity": 2.0},
    "damping": None,
    "numerics": {"spacing": 1.0},
}


def shear_stress(normal: float, line: tuple[float, float]) -> float:
    return line[0] + normal * math.tan(math.radians(line[1]))


def readings(normal: float, shape: str = "exponential", noise: float = 0.0, end: float = 0.3, seed: int = 0) -> np.ndarray:
    """Displacement (mm) and stress (kPa) of a test (n, 2), the loss of strength by the solver's own law."""
    law = (LinearLossBySlip if shape == "linear" else ExponentialLossBySlip)(1.0, SLIPS[0], SLIPS[1] - SLIPS[0])
    slip = np.concatenate([np.zeros(8), np.linspace(2e-4, 2e-2, 60), np.geomspace(2.1e-2, end, 60)])
    weight = np.array([remaining_weight(law, 1.0, each) for each in slip])
    peak, residual = shear_stress(normal, PEAK), shear_stress(normal, RESIDUAL)
    stress = residual + (peak - residual) * weight
    stress[:8] *= np.linspace(0.0, 0.9, 8)
    displacement = slip + stress / STIFFNESS
    return np.column_stack([1e3 * displacement, stress + noise * np.random.default_rng(seed).standard_normal(slip.size)])


def write(path: Path, table: np.ndarray, head: str = "displacement (mm),shear stress (kPa)") -> Path:
    with whole(path) as temporary:
        np.savetxt(temporary, table, delimiter=",", header=head, comments="", fmt="%.6g")
    return path


def three(folder: Path, **made: Any) -> list[Path]:
    return [write(folder / f"box{normal}.csv", readings(normal, seed=normal, **made)) for normal in (50, 100, 200)]


@pytest.mark.parametrize("shape", ["linear", "exponential"])
def test_made_tests_are_found_again(shape: str, tmp_path: Path) -> None:
    """Without noise within 2 %; with noise of 0.5 kPa, of which the peaks take the largest, the strengths within 1.5 kPa and 1 degree, the
    slip at the residual strength within 12 % and that at the peak within 25 %."""
    for noise, within, at_peak in ((0.0, 0.02, 0.02), (0.5, 0.12, 0.25)):
        shown = call("fit-shear", *three(tmp_path, shape=shape, noise=noise), "--normal-stress", "50,100,200", "--json")
        found = json.loads(shown.stdout)
        best, other = sorted(found["fits"], key=lambda name: found["fits"][name]["misfit"])
        assert best == shape == found["keys"]["coupling"]["softening"]["shape"], other
        fit = found["fits"][shape]
        assert fit["slip_at_peak"] == pytest.approx(SLIPS[0], rel=at_peak)
        assert fit["slip_at_residual"] == pytest.approx(SLIPS[1], rel=within)
        assert fit["misfit"] == pytest.approx(1e3 * noise, rel=0.25, abs=30.0), "the noise, in Pa"
        assert fit["D_95"] == pytest.approx(SLIPS[1] if shape == "exponential" else 7.615e-2, rel=within)
        assert [test["stiffness"] for test in found["tests"]] == pytest.approx(3 * [1e3 * STIFFNESS], rel=0.01 if not noise else 0.1)
        for name, line in (("peak", PEAK), ("residual", RESIDUAL)):
            for key, wanted, size in zip(("cohesion", "friction_angle"), line, (1e3, 1.0), strict=True):
                value, low, high = found["strength"][name][key]
                assert low <= value <= high
                away = (1500.0 if key == "cohesion" else 1.0) if noise else 0.02 * size * wanted
                assert value == pytest.approx(size * wanted, abs=away), (name, key)


def test_tests_of_unlike_slips_at_the_peak_are_fitted_together(tmp_path: Path) -> None:
    """Some trial fits end before one of them begins to fall, and have no peak of it."""
    tests = []
    for seed, normal in enumerate((50.0, 100.0, 200.0)):
        table = readings(normal, noise=0.6, end=0.12, seed=seed)
        table[:, 0] += 3.0 * seed * (table[:, 0] > 1.0)  # mm
        tests += read_tests(write(tmp_path / f"{normal:g}.csv", table), normal)
    assert len({round(test.slip_at_peak, 4) for test in tests}) == 3
    for shape in ("linear", "exponential"):
        found = fit_loss(tests, shape)
        assert math.isfinite(found.misfit) and all(map(math.isfinite, found.peaks)) and found.slip_at_residual > found.slip_at_peak > 0.0


def test_bounds_hold_the_truth_as_often_as_they_say() -> None:
    """Of 400 draws of four tests with a normal scatter, 95 % within three deviations; where the line meets no bound of c or phi."""
    random, normal = np.random.default_rng(1), [50.0, 100.0, 150.0, 200.0]
    held = np.zeros(2)
    for _ in range(400):
        found = strength(normal, [shear_stress(each, (40.0, 25.0)) + 2.0 * random.standard_normal() for each in normal])
        held += [found.cohesion.low <= 40.0 <= found.cohesion.high, found.friction_angle.low <= 25.0 <= found.friction_angle.high]
    assert (np.abs(held / 400 - 0.95) < 3 * math.sqrt(0.95 * 0.05 / 400)).all(), held


def test_c_and_phi_are_never_negative() -> None:
    falling, through = strength([50, 100, 200], [31, 30, 29]), strength([50, 100, 200], [24, 51, 103])
    assert falling.friction_angle.value == 0.0 and falling.cohesion.value == pytest.approx(30.0)
    assert through.cohesion == (0.0, 0.0, 0.0) and through.friction_angle.value == pytest.approx(
        math.degrees(math.atan(26_900 / 52_500))
    ), "the sum of sigma tau over that of sigma squared"


def test_the_keys_are_those_of_a_scene(tmp_path: Path) -> None:
    """As printed, with and without a normal stress; the width is that of the scene or follows from the height."""
    files = three(tmp_path)
    width = {"coupling": {"softening": {"slip_at_peak": 1.0, "width": 4.0}}}
    strengths = {"soil": {"cohesion": 12.0, "friction_angle": 30.0}}
    for options, over in (
        ([*files, "--normal-stress", "50,100,200", "--height", "10"], {}),
        ([*files, "--normal-stress", "50,100,200"], width),
        (files[:1], merge(width, strengths)),
    ):
        shown = call("fit-shear", *options)
        assert shown.exit_code == 0, shown.output
        text = shown.stdout.split("\n\n")[1]
        scene = make_scene(merge(merge(SCENE, over), yaml.safe_load(text)))
        assert scene.coupling.softening is not None and scene.coupling.softening.shape == "exponential", "a scene's default is linear"
        assert scene.coupling.softening.slip_at_residual == pytest.approx(SLIPS[1], rel=0.02)
        assert scene.coupling.softening.width == (4.0 if over else 2.2)
        if len(options) > 1:
            assert (scene.soil.cohesion, scene.soil.friction_angle) == pytest.approx(PEAK, rel=0.02)
            assert (scene.soil.residual_cohesion, scene.soil.residual_friction_angle) == pytest.approx(RESIDUAL, rel=0.02)
        else:
            ratio = shear_stress(50, RESIDUAL) / shear_stress(50, PEAK)
            assert pytest.approx(ratio, rel=0.02) == scene.coupling.S_R


def test_one_file_may_hold_several_tests(tmp_path: Path) -> None:
    """Told apart by the normal stress; other columns and vertical displacements are left out, and units are those of the heads."""
    rows = [np.column_stack([0.1 * table[:, 0], table[:, 1] / 1e3, np.full(len(table), normal)]) for normal, table in tables()]
    head = "shear displacement (cm);shear stress (MPa);sigma_n [kPa];vertical displacement (mm);time (s)"
    lines = [";".join(f"{value:.7g}" for value in (*row, 0.1, 5)) for part in rows for row in part]
    path = tmp_path / "all.csv"
    path.write_text("\n".join(["# box", head, *lines]))
    tests = read_tests(path)
    assert [test.normal for test in tests] == [50.0, 100.0, 200.0]
    apart = [each for file, normal in zip(three(tmp_path), (50, 100, 200), strict=True) for each in read_tests(file, normal)]
    for one, other in zip(tests, apart, strict=True):
        assert one.slip == pytest.approx(other.slip, rel=1e-3, abs=1e-7) and one.stress == pytest.approx(other.stress, rel=1e-3)
    assert fit_loss(tests, "exponential").slip_at_residual == pytest.approx(SLIPS[1], rel=0.01)


def tables() -> list[tuple[int, np.ndarray]]:
    return [(normal, readings(normal)) for normal in (50, 100, 200)]


def test_what_a_user_should_know_is_told(tmp_path: Path) -> None:
    short = call("fit-shear", write(tmp_path / "short.csv", readings(100, end=0.04)), "--normal-stress", "100")
    assert "still falls at its end" in short.stderr and "gives no cohesion" in short.stderr
    late = call("fit-shear", write(tmp_path / "late.csv", readings(100)[8:]))
    assert "no elastic part is taken off" in late.stderr and "c and phi need the normal stress" in late.stdout
    picture = tmp_path / "tests.png"
    call("fit-shear", *three(tmp_path), "--normal-stress", "50,100,200", "--plot", picture)
    assert picture.read_bytes().startswith(b"\x89PNG")


@pytest.mark.parametrize(
    ("text", "wanted"),
    [
        ("displacement,stress (kPa)\n0,0\n1,2\n", "does not say its unit; write mm, cm, m"),
        ("displacement (mm),stress (psi)\n0,0\n1,2\n", "must be kPa, Pa or MPa"),
        ("time (s),stress (kPa)\n0,0\n1,2\n", "no column of displacement"),
        ("displacement (mm),stress (kPa)\n0,0\n1,x\n", "line 3: '1,x'"),
        ("displacement (mm),stress (kPa)\n0,0\n1,5\n2,6\n3,7\n", "0 points after the largest stress"),
        ("displacement (mm),stress (kPa)\n0,0\n5,5\n9,6\n5,5\n1,4\n5,3\n9,2\n", "goes back by 4 mm"),
        ("displacement (mm),stress (kPa)\n0,0\n1,-5\n2,-6\n3,-7\n", "give shear stresses as positive"),
        ("displacement (mm),stress (kPa),normal stress (kPa)\n0,0,-5\n1,6,-5\n3,5,-5\n", "must be above 0"),
        ("displacement (mm),stress (kPa)\n", "it holds no table"),
        ("displacement (mm),stress (kPa)\n0,0\n1,6\n2,6\n3,6\n4,6\n5,6\n", "no strength is lost"),
    ],
)
def test_what_is_no_test_is_refused(text: str, wanted: str, tmp_path: Path) -> None:
    path = tmp_path / "test.csv"
    path.write_text(text)
    shown = call("fit-shear", path)
    assert shown.exit_code == REFUSED and f"{path}: " in shown.stderr and wanted in shown.stderr, shown.output


def test_options_that_do_not_fit_are_refused(tmp_path: Path) -> None:
    files = three(tmp_path)
    for options, wanted in (
        (["--normal-stress", "50,100"], "give one above 0 kPa for each of 3 files"),
        (["--normal-stress", "a"], "--normal-stress 'a'"),
        ([], "without a normal stress"),
        (["--normal-stress", "1,2,3"], "friction_angle"),
        (["--normal-stress", "50,100,200", "--plot", tmp_path / "a.txt"], "--plot"),
    ):
        shown = call("fit-shear", *files, *options)
        assert shown.exit_code == REFUSED and wanted in shown.stderr, shown.output


def test_a_steep_angle_from_one_normal_stress_is_refused_with_what_to_do(tmp_path: Path) -> None:
    """Under little stress the cohesion is most of the strength, and no one test tells it from friction."""
    path = write(tmp_path / "a.csv", readings(10.0))
    told = call("fit-shear", path, "--normal-stress", "10")
    assert told.exit_code == REFUSED and "a friction angle of 60.6 degrees, at most 50 in a scene; add tests" in told.stderr
    without = call("fit-shear", path)
    assert without.exit_code == 0 and "S_R:" in without.stdout, "the remedy that it names"
