"""Layers that the particles do not make continuous, and those that they do."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml
from typer.testing import CliRunner

from sph.checks.finding import Finding
from sph.checks.layers import broken_at, seam_rows, sections
from sph.checks.messages import words
from sph.checks.scene import findings
from sph.command.cli import app
from sph.scene.configuration import dotted, merge
from sph.scene.schema import Scene, make_scene
from sph.solver.particles import place_particles
from sph.solver.physics.seams import seam_sides

SLOPE: dict[str, Any] = {
    "scheme": "paper",
    "name": "seams",
    "geometry": {"shape": "ground_line", "points": [[100, 440], [160, 440], [180, 460], [220, 460]], "base": 430},
    "numerics": {"spacing": 1.0, "smoothing_ratio": 1.3, "time_step": 5e-4},
}


def scene(region: dict[str, Any], **settings: Any) -> Scene:
    return make_scene(merge(SLOPE, {"layers": {"clay": {"region": region}}} | dotted(settings)))


def level(bottom: float, thickness: float) -> dict[str, Any]:
    return {"kind": "elevation", "bottom": bottom, "top": bottom + thickness}


def dipping(angle: float, thickness: float, base: float = 432.3) -> dict[str, Any]:
    """A seam of a thickness (m, normal to it) through the whole section, rising to the right."""
    rise, upright = 140.0 * math.tan(math.radians(angle)), thickness / math.cos(math.radians(angle))
    corners = [[90, base], [230, base + rise], [230, base + rise + upright], [90, base + upright]]
    return {"kind": "polygon", "points": corners}


def told(region: dict[str, Any], **settings: Any) -> list[Finding]:
    return [each for each in findings(scene(region, **settings)) if each.subject == "clay" and each.code in ("layer-broken", "thin-layer")]


@pytest.mark.parametrize(
    "region",
    [
        *(level(435.0 + 0.1 * tenths, 0.4) for tenths in range(10)),
        dipping(12.0, 0.4),
        dipping(12.0, 0.8),
        {"kind": "depth", "top": 3.0, "bottom": 3.4},
        dipping(12.0, 0.02),
    ],
)
def test_a_seam_thinner_than_the_spacing_is_broken_wherever_the_lattice_lies(region: dict[str, Any]) -> None:
    (one,) = told(region)
    assert (one.code, one.severity) == ("layer-broken", "error") and "clay" in words(one).what
    assert (
        all(key in words(one).key for key in ("layers.clay.region", "seams.clay", "numerics.spacing"))
        and "at a spacing of 1 m" in words(one).measured
    )


@pytest.mark.parametrize(
    "region",
    [
        level(435.0, 3.0),
        level(435.3, 3.0),
        level(441.0, 8.0),
        dipping(12.0, 3.0),
        {"kind": "depth", "top": 3.0, "bottom": 6.0},
        {"kind": "depth", "top": 0.0, "bottom": 3.0},
        {"kind": "elevation", "top": 433.0},
        # A lens that thins out to nothing at both ends, within 15 m of 60.
        {"kind": "polygon", "points": [[120, 435.2], [135, 432.1], [165, 433.3], [180, 435.2], [165, 438.3], [135, 437.4]]},
    ],
)
def test_layers_of_three_rows_are_continuous(region: dict[str, Any]) -> None:
    assert "layer-broken" not in {each.code for each in told(region)}


def test_a_layer_without_a_particle_is_told() -> None:
    (outside,) = told({"kind": "elevation", "top": 400.0})
    assert (
        outside.code == "layer-broken" and "no particle lies in" in words(outside).what and "outside the ground" in words(outside).measured
    )
    (between_rows,) = told(level(435.55, 0.4))
    assert words(between_rows).measured == "particles in 0 of the 120 columns that it crosses, 0.4 m thick at a spacing of 1 m"


def test_a_seam_that_pinches_out_in_its_middle_is_told() -> None:
    """Thick on both sides of a neck where it has no particle."""
    upper, lower = [[90, 438], [150, 438], [155, 435.3], [165, 435.3], [170, 438], [230, 438]], [[230, 435], [90, 435]]
    (one,) = told({"kind": "polygon", "points": upper + lower})
    assert one.code == "layer-broken" and words(one).measured.startswith("particles in 110 of the 120 columns")


def test_the_remedies_help() -> None:
    assert told(dipping(12.0, 0.8), **{"numerics.spacing": 0.2}) == []
    assert "layer-broken" not in {each.code for each in told(dipping(12.0, 1.5))}


@pytest.mark.parametrize("spacing", [2.0, 1.0, 0.5])
def test_a_seam_is_there_without_a_gap_at_any_spacing(spacing: float) -> None:
    """It dips under the slope; every column has its rows there, as many normal to the line as the kernel reaches."""
    rise = 60.0 * math.tan(math.radians(12.0))
    seam = {"points": [[160, 435.3], [220, 435.3 + rise]], "thickness": 0.4, "cohesion": 0.5, "friction_angle": 5.0}
    one = make_scene(merge(SLOPE, {"seams": {"clay": seam}, "numerics": {"spacing": spacing, "time_step": 1e-4}}))
    particles = place_particles(one)
    side, _, _ = seam_sides(one, particles)
    columns = np.round(particles.x[side != 0] / spacing - 0.5).astype(int)
    upright = np.bincount(columns, minlength=one.lattice[0])[round(65.0 / spacing) : round(115.0 / spacing)] * math.cos(math.radians(12.0))
    assert upright.min() > 4.0 and upright.max() < 6.5
    assert set(np.sign(side)) == {-1, 0, 1}
    ((name, told),) = seam_rows(one, particles)
    assert name == "clay" and "5." in told and "thickness 0.4 m as logged" in told
    assert "layer-broken" not in {each.code for each in findings(one)}


def test_a_section_has_the_area_of_its_region_but_for_later_layers() -> None:
    one = make_scene(merge(SLOPE, {"layers": {"clay": {"region": level(432.0, 4.0)}, "lens": {"region": level(433.25, 0.5)}}}))
    found = sections(one, place_particles(one))
    np.testing.assert_allclose(found["clay"].thickness, 3.5)
    np.testing.assert_allclose(found["lens"].thickness, 0.5)
    assert found["clay"].particles.tolist() == [3] * 120 and found["lens"].particles.tolist() == [1] * 120
    turned = {"geometry.points": [[320 - x, y] for x, y in SLOPE["geometry"]["points"]], "geometry.downhill": "right"}
    mirrored = {"kind": "polygon", "points": [[320 - x, y] for x, y in dipping(12.0, 3.0)["points"]]}
    for region, settings in ((dipping(12.0, 3.0), {}), (mirrored, turned)):
        one = scene(region, **settings)
        np.testing.assert_allclose(sections(one, place_particles(one))["clay"].thickness[:10], 3.0 / math.cos(math.radians(12.0)))


def test_a_layer_that_only_a_coarser_spacing_breaks_is_told_of_that() -> None:
    one = scene(level(435.0, 1.5))
    (found,) = broken_at(one, (2.0, 1.0))
    assert found.subject == "clay" and words(found).measured.endswith("at a spacing of 2 m")
    assert broken_at(scene(level(435.0, 0.4)), (2.0, 1.0)) == [], "that is told of the scene's own spacing"


def test_the_searches_say_what_the_check_says_before_they_begin(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The same errors and warnings in the same order, also of a seam that the search cannot see."""
    file, searched = tmp_path / "seam.yaml", list[str]()
    file.write_text(yaml.safe_dump(merge(SLOPE, {"layers": {"clay": {"region": level(435.55, 0.4)}}})))
    invoke = CliRunner().invoke
    checked = json.loads(invoke(app, ["check", str(file), "--json"]).stdout)["findings"]
    assert checked[0]["code"] == "layer-broken"

    def stop(*arguments: Any, **options: Any) -> None:
        searched.append("began")
        raise ValueError("no search in this test")

    monkeypatch.setattr("sph.command.stability.extrapolated", stop)
    for command in ("fos", "yield-acceleration"):
        told = invoke(app, [command, str(file), "--spacings", "2,1"])
        lines = [line for line in told.stderr.splitlines() if line.endswith("]")]
        assert [line.rpartition("[")[2][:-1] for line in lines] == [each["code"] for each in checked if each["severity"] != "note"]
        assert told.stderr.endswith("no search in this test\n")
    assert len(searched) == 2


def test_weak_soil_that_the_kernel_lets_strong_soil_brake_is_told() -> None:
    """And not where the soils have the same strength, nor with the law of the interface, which a scene of one's own has."""

    def is_told(soil: dict[str, float], interfaces: str) -> bool:
        layers = {"clay": {"region": level(435.0, 4.0), "soil": soil}}
        made = make_scene(merge(SLOPE, {"layers": layers, "numerics": {"interfaces": interfaces}}))
        return "weak-on-strong" in [each.code for each in findings(made)]

    assert is_told({"cohesion": 1.0}, "both")
    assert not is_told({"cohesion": 1.0}, "weaker")
    assert not is_told({"density": 1500.0}, "both")
