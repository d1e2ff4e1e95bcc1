"""Strain-compatible stiffness of a column: against the closed form of two linear layers, and the library called by hand."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml
from calling import call

from sph.command.site import MAX_STRAIN, STRAINS, TOLERANCE, Stratum, column, darendeli, respond, rows
from sph.jobs.exit_codes import REFUSED
from sph.scene.configuration import merge
from sph.scene.schema import Scene, load_scene, make_scene
from sph.scene.units import GRAVITY

site, propagation, output, motions = (pytest.importorskip(f"pystrata.{name}") for name in ("site", "propagation", "output", "motion"))
DATA: dict[str, Any] = {
    "name": "clay_on_sand",
    "scheme": "paper",
    "duration": 6.0,
    "geometry": {"shape": "ground_line", "points": [[100, 50], [140, 50], [160, 60], [220, 60]], "base": 40},
    "soil": {"density": 2000.0, "poisson_ratio": 0.3, "shear_wave_speed": 400.0},
    "layers": {"clay": {"region": {"kind": "depth", "bottom": 8.0}, "soil": {"density": 1600.0, "shear_wave_speed": 150.0}}},
    "gravity": {"ramp": 0.5, "duration": 1.0},
    "motion": {"kind": "tapered_sine", "amplitude": 1.0, "frequency": 3.0, "start": 1.0, "ramp": 0.5, "decay_start": 4.0, "end": 5.0},
    "numerics": {"spacing": 1.0, "time_step": 5e-3},
}
CLOSED, LIBRARY = 0.005, 1e-6
"""Relative differences from the closed form, whose peak is one of samples, and from the same calculation."""


def scene(**changes: Any) -> Scene:
    return make_scene(merge(DATA, changes))


def linear(stratum: Stratum) -> Any:
    """Soil of 2 % damping at every strain."""
    return site.SoilType("linear", stratum.weight, None, 0.02)


def test_two_linear_layers_amplify_as_in_closed_form() -> None:
    """On a rigid base |u(top) / u(base)| = 1 / |cos a cos b - Z1/Z2 sin a sin b|, a and b being k h in both layers."""
    made = scene()
    shaken = made.motion.acceleration(np.arange(1.0, 5.0, 5e-3))
    shaken = np.pad(shaken, (0, 2**14 - shaken.size))
    omega = 2.0 * np.pi * np.fft.rfftfreq(shaken.size, 5e-3)
    complex_speed = np.array([150.0, 400.0]) * np.sqrt(1.0 + 2j * 0.02)
    a, b = (omega * depth / speed for depth, speed in zip((8.0, 12.0), complex_speed, strict=True))
    impedance = 1600.0 * complex_speed[0] / (2000.0 * complex_speed[1])
    surface = np.fft.irfft(np.fft.rfft(shaken) / (np.cos(a) * np.cos(b) - impedance * np.sin(a) * np.sin(b)))
    found = respond(made, linear, 200.0)
    assert found.peak == pytest.approx(np.abs(surface).max(), rel=CLOSED) and found.peak > 1.5, "amplified"
    assert found.peak_small == pytest.approx(found.peak, rel=1e-9) and found.peak_base == pytest.approx(1.0, rel=1e-3)
    assert [each.mean("damping") for each in found.layers] == pytest.approx([0.02, 0.02])
    assert {part.reduction for each in found.layers for part in each.parts} == {1.0}


@pytest.mark.parametrize("rock", [None, {"density": 2400.0, "s_wave_speed": 1500.0, "p_wave_speed": 3000.0}])
def test_bedrock_below_an_absorbing_base_gives_waves_back_as_in_closed_form(rock: dict[str, float] | None) -> None:
    """Under 20 m of soil of 2 % damping |u(top) / u(outcrop)| = 1 / |cos kh + i alpha sin kh| (Kramer 1996, Sec. 7.2.1), alpha the
    impedance of the soil over that of the rock; without rock the soil goes on, and but for its damping alpha is 1."""
    soil = {"region": {"bottom": 60.0}, "soil": {"density": 2000.0, "shear_wave_speed": 250.0}}
    made = scene(layers={"clay": soil}, walls={"base": "absorbing", "layers": 4, "bedrock": rock})
    shaken = made.motion.acceleration(np.arange(1.0, 5.0, 5e-3))
    shaken = np.pad(shaken, (0, 2**14 - shaken.size))
    speed = 250.0 * np.sqrt(1.0 + 2j * 0.02)
    kh = 2.0 * np.pi * np.fft.rfftfreq(shaken.size, 5e-3) * 20.0 / speed
    alpha = 2000.0 * speed / (2400.0 * 1500.0 if rock else 2000.0 * 250.0)
    surface = np.fft.irfft(np.fft.rfft(shaken) / (np.cos(kh) + 1j * alpha * np.sin(kh)))
    found = respond(made, linear, 200.0)
    assert found.peak == pytest.approx(np.abs(surface).max(), rel=CLOSED)
    assert (found.peak > 2.5) if rock else (found.peak < 1.1), "a rock gives back what soil that goes on lets out"


def test_curves_fall_up_to_the_largest_strain() -> None:
    """Darendeli (2001): G / Gmax = 1 / (1 + (strain / 0.0352 %)^0.919) at one atmosphere without plasticity; 0.01041 at 5 %."""
    soil = darendeli(0.0, 1.0)(Stratum(0, 0.0, 1.0, 200.0, 18.0, 101.325))
    strains = np.array([1e-4, 2e-4, 1e-3, 2e-3, 0.01, 0.02, 0.0316, 0.04, MAX_STRAIN])
    np.testing.assert_allclose(soil.mod_reduc(strains), 1.0 / (1.0 + (strains / 3.52e-4) ** 0.919), rtol=1e-3)
    assert soil.mod_reduc(MAX_STRAIN) == pytest.approx(0.01041, rel=1e-3)


def test_the_column_has_the_layers_of_its_place() -> None:
    assert [(each.number, round(each.top, 1), round(each.bottom, 1)) for each in column(scene())] == [(1, 0.0, 8.0), (0, 8.0, 20.0)]
    assert [(each.number, round(each.bottom, 1)) for each in column(scene(), 110.0)] == [(1, 8.0), (0, 10.0)], "before the toe"
    clay = column(scene())[0]
    assert clay.stress == pytest.approx(1.6 * GRAVITY * 4.0 * (1 + 2 * 0.3 / 0.7) / 3, rel=0.01), "mean stress in its middle, kPa"


@pytest.mark.long
@pytest.mark.parametrize("base", ["fixed", "absorbing"])
def test_moduli_are_those_of_the_library_called_by_hand(base: str) -> None:
    made = scene(layers={"clay": {"region": {"bottom": 60.0}}}, walls={"base": base, "layers": 4})
    found = respond(made, darendeli(20.0, 2.0), 200.0)
    (clay,) = found.layers
    soil = site.DarendeliSoilType(1.6 * GRAVITY, plas_index=20.0, ocr=2.0, stress_mean=clay.stratum.stress, strains=STRAINS)
    count = 34  # 20 m in fifths of a wave of 25 Hz at 75 m/s, 0.6 m
    layers = [site.Layer(soil, 20.0 / count, 150.0) for _ in range(count)]
    profile = site.Profile([*layers, site.Layer(site.SoilType("", 1.6 * GRAVITY, None, 0.0), 0.0, 150.0)])
    profile.update_layers()
    shaken = made.motion.acceleration(np.arange(1.0, 5.0, 5e-3)) / GRAVITY
    calculator = propagation.EquivalentLinearCalculator(tolerance=TOLERANCE, max_iterations=100)
    calculator(
        motions.TimeSeriesMotion("", "", 5e-3, np.pad(shaken, (0, shaken.size))),
        profile,
        profile.location("outcrop" if base == "absorbing" else "within", index=-1),
    )
    reductions = np.array([each.shear_mod_reduc for each in layers])
    assert clay.mean("reduction") == pytest.approx(np.mean(reductions**-0.5) ** -2, rel=LIBRARY)
    assert clay.mean("damping") == pytest.approx(np.mean([each.damping for each in layers]), rel=LIBRARY)
    assert clay.mean("strain") == pytest.approx(np.mean([np.max(each.strain) for each in layers]), rel=LIBRARY)
    assert clay.worst.strain == pytest.approx(max(np.max(each.strain) for each in layers), rel=LIBRARY)
    assert clay.worst.reduction == pytest.approx(reductions.min(), rel=LIBRARY), "the least modulus stands beside the largest strain"
    assert clay.worst.damping == pytest.approx(max(each.damping for each in layers), rel=LIBRARY)
    assert [row[5] for row in rows(made, found)] == [f"{100 * value:.3g}" for value in (clay.mean("strain"), clay.worst.strain)]
    top = output.AccelerationTSOutput(output.OutputLocation("outcrop", index=0))
    top(calculator)
    assert found.peak == pytest.approx(GRAVITY * np.abs(top.values).max(), rel=LIBRARY)
    assert clay.mean("reduction") < 0.9 and clay.mean("damping") > 0.02


def test_the_command_prints_a_table_and_writes_a_scene(tmp_path: Path) -> None:
    file, out = tmp_path / "slope.yaml", tmp_path / "compatible.yaml"
    file.write_text(yaml.safe_dump(DATA))
    shown = call("site", file, "--plasticity", "20", "--out", out)
    assert shown.exit_code == 0, shown.output
    assert "clay" in shown.stdout and "PGA at the surface" in shown.stdout
    assert load_scene(out).layers["clay"].soil.s_wave_speed < 150.0
    assert "the written scene against the sublayered column: first mode" in shown.stdout
    assert '"reduction"' in call("site", file, "--json").stdout


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (["--set", "motion.kind=none"], "a site response needs shaking"),
        (["--at", "500"], "--at 500: must lie in the model, from 100 to 220 m"),
        (["--set", "motion.amplitude=60"], f"beyond {100 * MAX_STRAIN:g} % equivalent-linear analysis is not valid"),
    ],
)
def test_what_the_method_cannot_answer_is_refused(tmp_path: Path, options: list[str], words: str) -> None:
    file = tmp_path / "slope.yaml"
    data = {**DATA, "motion": {"kind": "none"}} if "none" in options[-1] else DATA
    file.write_text(yaml.safe_dump(data))
    refused = call("site", file, *([] if "none" in options[-1] else options))
    assert refused.exit_code == REFUSED and words in refused.output.replace("\n", " ")
