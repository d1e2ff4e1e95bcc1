"""Sides of the box that failed soil meets: by debris, and by the apron that debris pushes ahead."""

from __future__ import annotations

import numpy as np
import pytest
from synthetic import synthetic

from sph.measures.sides import reached_sides
from sph.scene.schema import Scene

MOVED, LINK = 0.5, 2.5


@pytest.mark.parametrize(
    ("slope", "apron", "failed", "met"),
    [
        (5.0, 0.6, True, True),  # beyond the threshold
        (5.0, 0.4, True, False),
        (1.0, 0.3, True, True),  # more than a tenth of what moved most
        (1.0, 0.09, True, False),
        (0.4, 0.09, True, False),  # never less than a fifth of the threshold
        (1.0, 0.3, False, False),
    ],
)
def test_failed_apron_soil_at_the_front_counts(slope: float, apron: float, failed: bool, met: bool) -> None:
    def field(scene: Scene, x: np.ndarray, y: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        return np.where(y > scene.geometry.toe[1], -slope, 0.0), np.where(x < scene.geometry.toe[0], apron, 0.0)

    made = synthetic(field)
    scene = made.scene
    apron_soil = made["x0"] < scene.geometry.toe[0]
    made["failed"][-1] = np.where(apron_soil, failed, made["y0"] > scene.geometry.toe[1])
    assert ("front" in reached_sides(made, MOVED, LINK)) == met
