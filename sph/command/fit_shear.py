"""What ``sph fit-shear`` prints: the strength of shear tests at the peak and after it, its loss with slip, and the keys of a scene."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import yaml

from sph.command.new import WIDTH
from sph.command.outputs import check_picture
from sph.command.shear_test import CURVES, LEVEL, SAME, STEADY, Bounded, Loss, ShearTest, Strength, fit_loss, read_tests, strength
from sph.command.terminal import aligned, say, table
from sph.scene.configuration import flat, validated
from sph.scene.soil import Softening, Soil
from sph.scene.strict_json import to_json

SOIL = {"cohesion": "kPa", "friction_angle": "degree", "residual_cohesion": "kPa", "residual_friction_angle": "degree"}
"""Keys of the soil that are fitted, and their units."""
STEEPEST = next(each.le for each in Soil.model_fields["friction_angle"].metadata if hasattr(each, "le"))
"""Largest friction angle of a scene, degrees."""


def fit_shear(paths: Sequence[Path], normal: Sequence[float] | None, height: float | None, out: Path | None, as_json: bool) -> str:
    """The fits to the tests in files, in words with the YAML to paste, or for machines; their picture where asked for.

    ``normal`` has the normal stress (kPa) of each file that has no column of it, ``height`` is that of the slope (m).  ValueError for
    what is no test, and for a strength that a scene does not take.
    """
    if normal is not None and (len(normal) != len(paths) or not all(0.0 < each < math.inf for each in normal)):
        raise ValueError(f"--normal-stress {','.join(f'{each:g}' for each in normal)}: give one above 0 kPa for each of {len(paths)} files")
    if out is not None:
        check_picture(out, paths, "--plot")
    given: Sequence[float | None] = normal or [None] * len(paths)
    tests = [test for path, own in zip(paths, given, strict=True) for test in read_tests(path, own)]
    without = [test.name for test in tests if test.normal is None]
    if without and len(tests) > 1:
        raise ValueError(
            f"{without[0]}: without a normal stress; of several tests give that of each, as a column, normal stress (kPa), or with "
            "--normal-stress 50,100,200 in the order of the files"
        )
    losses = sorted((fit_loss(tests, shape) for shape in CURVES), key=lambda each: each.misfit)
    strengths = None if without else [strength(normals(tests), stresses) for stresses in both(tests)]
    if strengths is not None and one_normal_stress(tests) and (steepest := strengths[0].friction_angle.value) > STEEPEST:
        raise ValueError(
            f"{tests[0].name}: peak: without cohesion, which one normal stress does not give, {tests[0].peak:.4g} kPa under "
            f"{normals(tests)[0]:.4g} kPa are a friction angle of {steepest:.3g} degrees, at most {STEEPEST:g} in a scene; add tests at "
            "other normal stresses, or leave the normal stress out (no column, no --normal-stress) for the slips and the residual over "
            "peak strength"
        )
    made = keys(tests, strengths, losses[0])
    width = None if height is None else float(f"{WIDTH * height:.2g}")
    check(made, width)
    if out is not None:
        from sph.figures.shear_test import figure_shear_tests
        from sph.figures.style import save

        lines = [] if strengths is None else [(each.cohesion.value, each.friction_angle.value) for each in strengths]
        points = list(zip(normals(tests), *both(tests), strict=True)) if strengths else []
        measured = {test.name: (test.slip, test.stress) for test in tests}
        fits = {each.shape: {test.name: curve(test, each, high) for test, high in zip(tests, each.peaks, strict=True)} for each in losses}
        save(figure_shear_tests(measured, fits, points, lines), out)
    say(*notes(tests, losses))
    if as_json:
        return to_json(record(tests, strengths, losses, made), indent=1)
    return f"{words(tests, strengths, losses)}\n\n{written(made, strengths, losses, width)}"


def normals(tests: Sequence[ShearTest]) -> list[float]:
    """Normal stresses, kPa."""
    return [test.normal for test in tests if test.normal is not None]


def one_normal_stress(tests: Sequence[ShearTest]) -> bool:
    """Whether all tests have the same normal stress."""
    return all(test.normal is not None for test in tests) and bool(np.ptp(normals(tests)) <= SAME * max(normals(tests)))


def both(tests: Sequence[ShearTest]) -> tuple[list[float], list[float]]:
    """Peak and residual strengths, kPa."""
    return [test.peak for test in tests], [test.residual for test in tests]


def curve(test: ShearTest, loss: Loss, peak: float) -> tuple[np.ndarray, np.ndarray]:
    """Slips (n,) in m and stresses (n,) in kPa of a fit to a test."""
    slip = np.linspace(0.0, test.slip[-1], 1000)
    return slip, test.residual + (peak - test.residual) * loss.weight(slip)


def keys(tests: Sequence[ShearTest], strengths: Sequence[Strength] | None, loss: Loss) -> dict[str, Any]:
    """The keys of a scene: strengths as the tests give them, of which the residual ones are at most those at the peak; without a normal
    stress the ratio of the two."""
    slips = {"slip_at_peak": rounded(loss.slip_at_peak), "slip_at_residual": rounded(loss.slip_at_residual), "shape": loss.shape}
    if strengths is None:
        return {"coupling": {"S_R": rounded(tests[0].residual / tests[0].peak), "softening": slips}}
    peak, residual = ([rounded(each.cohesion.value), rounded(each.friction_angle.value)] for each in strengths)
    return {"soil": dict(zip(SOIL, [*peak, *map(min, residual, peak)], strict=True)), "coupling": {"softening": slips}}


def rounded(value: float) -> float:
    """A number with three digits."""
    return float(f"{value:.3g}")


def check(made: dict[str, Any], width: float | None) -> None:
    """ValueError where a scene would not take the keys."""
    validated(Softening, {"width": 1.0 if width is None else width, **made["coupling"]["softening"]}, "--height" if width else "fit")
    if "soil" in made:
        validated(Soil, made["soil"], "strength of the tests")


def notes(tests: Sequence[ShearTest], losses: Sequence[Loss]) -> list[str]:
    """What a user of the fits should know."""
    told = [f"{test.name}: begins above half of its peak, so that no elastic part is taken off" for test in tests if test.stiffness is None]
    told += [
        f"{test.name}: the stress still falls at its end, by {100 * test.falling:.0f} % of the loss within the last half of the slip: the "
        "residual strength is lower than given here and needs more slip"
        for test in tests
        if test.falling > STEADY
    ]
    if one_normal_stress(tests):
        told.append("one normal stress gives no cohesion: it is taken as 0, and the friction angles hold near that normal stress alone")
    if losses[0].misfit > 0.1 * np.mean([test.peak - test.residual for test in tests]):
        told.append(f"neither shape fits well: {losses[0].misfit:.3g} kPa is more than a tenth of the strength that is lost; see --plot")
    return told


def words(tests: Sequence[ShearTest], strengths: Sequence[Strength] | None, losses: Sequence[Loss]) -> str:
    """The fits as tables."""
    head = ("test", "normal stress (kPa)", "peak (kPa)", "slip at peak (mm)", "residual (kPa)", "D_95 (mm)", "elastic (kPa/mm)")
    rows = [
        (
            test.name,
            "-" if test.normal is None else f"{test.normal:.4g}",
            f"{test.peak:.4g}",
            f"{1e3 * test.slip_at_peak:.3g}",
            f"{test.residual:.4g}",
            f"{1e3 * test.D_95:.3g}",
            "-" if test.stiffness is None else f"{1e-3 * test.stiffness:.3g}",
        )
        for test in tests
    ]
    facts = [] if strengths is None else [(name, said(each)) for name, each in zip(("peak", "residual"), strengths, strict=True)]
    if strengths is None:
        facts = [("residual over peak", f"{tests[0].residual / tests[0].peak:.3g}; c and phi need the normal stress (--normal-stress)")]
    facts += [
        (
            each.shape,
            f"misfit {each.misfit:.2f} kPa; strength falls from {1e3 * each.slip_at_peak:.3g} mm on, slip at residual "
            f"{1e3 * each.slip_at_residual:.3g} mm, D_95 {1e3 * each.D_95:.3g} mm{', the better' * (each is losses[0])}",
        )
        for each in losses
    ]
    return f"{table(head, rows)}\n{aligned(facts)}"


def said(strength: Strength) -> str:
    """A strength with its bounds."""
    return f"c {bounded(strength.cohesion)} kPa, phi {bounded(strength.friction_angle)} degrees"


def bounded(number: Bounded) -> str:
    """A number with its bounds."""
    if number.value == number.high:
        return f"{number.value:.3g} (held)"
    return f"{number.value:.3g}" + ("" if math.isnan(number.low) else f" ({number.low:.3g} to {number.high:.3g} at {100 * LEVEL:.0f} %)")


def written(made: dict[str, Any], strengths: Sequence[Strength] | None, losses: Sequence[Loss], width: float | None) -> str:
    """The keys as YAML to paste, with what they come from."""
    softening, best = made["coupling"]["softening"], losses[0]
    others = "".join(f", {each.shape} {each.misfit:.2f} kPa" for each in losses[1:])
    left = float(best.weight(np.array([best.slip_at_residual]))[0])
    about = {
        "coupling.S_R": "residual over peak strength",
        "coupling.softening.slip_at_peak": "m",
        "coupling.softening.slip_at_residual": f"m; {100.0 * left:.0f} % of the loss still to come" if left > 0.0 else "m",
        "coupling.softening.shape": f"misfit {best.misfit:.2f} kPa{others}",
        "coupling.softening.width": f"m, {WIDTH} of the slope's height; no test gives it, at least three spacings",
    }
    for name, number in zip(SOIL, [] if strengths is None else [each for fit in strengths for each in fit], strict=False):
        cut = "; at most that at the peak" * (made["soil"][name] < rounded(number.value))
        about[f"soil.{name}"] = f"{SOIL[name]}; the tests give {bounded(number)}{cut}"
    if width is not None:
        made = {**made, "coupling": {**made["coupling"], "softening": {**softening, "width": width}}}
    text = yaml.safe_dump(made, sort_keys=False).rstrip("\n").split("\n")
    names = iter(flat(made))
    lines = [line if line.endswith(":") else f"{line} # {about[next(names)]}" for line in text]
    if width is None:
        lines.append(f"    # width: as in your scene; {WIDTH} of the slope's height, which --height gives, and at least three spacings")
    return "\n".join(lines)


def record(
    tests: Sequence[ShearTest], strengths: Sequence[Strength] | None, losses: Sequence[Loss], made: dict[str, Any]
) -> dict[str, Any]:
    """The fits for machines: stresses in Pa, angles in degrees, slips in m; ``keys`` in the units of a scene."""
    fits = [
        each._asdict() | {"misfit": 1e3 * each.misfit, "D_95": each.D_95, "peaks": [1e3 * peak for peak in each.peaks]} for each in losses
    ]
    return {
        "tests": [
            {
                "name": test.name,
                "normal_stress": None if test.normal is None else 1e3 * test.normal,
                "peak": 1e3 * test.peak,
                "residual": 1e3 * test.residual,
                "slip_at_peak": test.slip_at_peak,
                "D_95": test.D_95,
                "stiffness": None if test.stiffness is None else 1e3 * test.stiffness,
            }
            for test in tests
        ],
        "strength": None
        if strengths is None
        else {
            name: {"cohesion": [1e3 * value for value in each.cohesion], "friction_angle": list(each.friction_angle)}
            for name, each in zip(("peak", "residual"), strengths, strict=True)
        },
        "fits": {each["shape"]: {name: value for name, value in each.items() if name != "shape"} for each in fits},
        "keys": made,
    }
