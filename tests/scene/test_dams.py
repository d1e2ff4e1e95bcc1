"""The San Fernando dams of the gallery: their numbers follow from the published ones, and the motion is like that of 1971 (V26)."""

from __future__ import annotations

import functools
from pathlib import Path

import numpy as np
import pytest

from sph.checks.liquefaction import of_liquefaction
from sph.checks.motion import mean_period
from sph.scene.ground_motion.measures import measure
from sph.scene.liquefaction import residual_ratio
from sph.scene.loading import motion_of
from sph.scene.schema import Scene, load_scene
from sph.solver.particles import place_particles

pytestmark = pytest.mark.uncompiled

GALLERY = Path(__file__).resolve().parents[2] / "docs" / "gallery"
DAMS = ("lower", "upper")
N_FOR_S_R = {
    "lower": {"shell_1": 12.9, "shell_2": 27.7, "shell_3": 23.6, "shell_4": 10.8, "shell_5": 16.9},
    "upper": {"upstream_shell_2": 14.8, "upstream_shell_3": 11.6, "downstream_shell_1": 14.7, "downstream_shell_2": 13.5},
}
"""Published (N1)60 for the residual strength, where it is not that for the rise of pore pressure."""
ROCK = {"peak_velocity": 0.766, "arias_intensity": 3.03}
"""Of the published outcrop motion, m/s; its mean period is 0.574 s."""


@functools.cache
def dam(name: str) -> Scene:
    return load_scene(GALLERY / f"{name}_san_fernando.yaml")


@pytest.mark.parametrize("name", DAMS)
def test_residual_strengths_are_those_of_the_published_blow_counts(name: str) -> None:
    written = {layer: made.soil.liquefied_strength_ratio for layer, made in dam(name).layers.items()}
    found = {layer: ratio for layer, ratio in written.items() if ratio is not None}
    assert found == {layer: round(residual_ratio(blows), 3) for layer, blows in N_FOR_S_R[name].items()}


def test_the_motion_is_as_strong_as_that_of_1971() -> None:
    assert dam("lower").motion == dam("upper").motion
    motion = motion_of(dam("lower"))
    found = measure(motion.acceleration, float(motion.time[1] - motion.time[0]))
    assert {name: getattr(found, name) for name in ROCK} == pytest.approx(ROCK, rel=0.05)
    assert mean_period(motion) == pytest.approx(0.574, rel=0.05)


@pytest.mark.parametrize(("name", "safe"), [("lower", {"shell_2"}), ("upper", set())])
def test_the_simplified_procedure_tells_which_zones_liquefy(name: str, safe: set[str]) -> None:
    scene = dam(name)
    told = of_liquefaction(scene, place_particles(scene), 6.6)
    sand = {found.subject: found.numbers["value"] for found in told if found.code == "liquefaction"}
    wet = {layer for layer, made in scene.layers.items() if made.soil.can_liquefy}
    assert set(sand) == wet and {layer for layer, value in sand.items() if value >= 1.0} == safe
    assert np.median(list(sand.values())) < 0.7
