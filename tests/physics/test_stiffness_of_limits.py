"""Limits of stability do not depend on Young's modulus: soft soil that bends has not failed."""

from __future__ import annotations

import copy
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml
from calling import call

from sph.scene.configuration import merge
from sph.scene.gravity import GRAVITY
from sph.scene.schema import Scene, make_scene
from sph.stability.search import Trial
from sph.stability.standing import ELASTIC_SHARE, FailureRule, stand, static_scene, stiffness

RULE = FailureRule()
STIFF = 3e6
"""Young's modulus of stiff soil, kPa; the others are soft ones, down to a thousandth."""
SLOPE: dict[str, Any] = {
    "scheme": "paper",
    "name": "slope",
    "duration": 3.0,
    "geometry": {
        "shape": "slope",
        "slope_angle": 26.565,
        "slope_height": 10.0,
        "base_depth": 5.0,
        "apron_length": 15.0,
        "crest_length": 20.0,
    },
    "walls": {"sides": "free_slip"},
    "soil": {"density": 2038.7, "youngs_modulus": STIFF, "poisson_ratio": 0.3, "cohesion": 10.0, "friction_angle": 20.0},
    "gravity": {"ramp": 1.0, "duration": 2.0},
    "numerics": {"spacing": 1.0, "smoothing_ratio": 1.3},
}
"""The 2:1 slope of 10 m on 5 m of the same soil."""
LAYERED: dict[str, Any] = {
    "layers": {
        "fill": {
            "region": {"kind": "elevation", "bottom": 11.0},
            "soil": {"cohesion": 6.0, "friction_angle": 25.0, "youngs_modulus": STIFF},
        },
        "clay": {
            "region": {"kind": "elevation", "top": 5.0},
            "soil": {"cohesion": 20.0, "friction_angle": 10.0, "poisson_ratio": 0.4, "youngs_modulus": STIFF},
        },
    }
}
WET: dict[str, Any] = {"water": {"pressure": "by_place", "level": 9.0}}
GROUND: dict[str, Any] = {
    "geometry": {
        "shape": "ground_line",
        "points": [[0.0, 105.0], [15.0, 105.0], [25.0, 110.0], [27.0, 110.0], [36.0, 115.0], [56.0, 115.0]],
        "base": 100.0,
    }
}
VARIABLE: dict[str, Any] = {
    "uncertain": {
        "seed": 3,
        "variables": {
            "c": {
                "of": "soil.cohesion",
                "kind": "lognormal",
                "mean": 10.0,
                "cov": 0.3,
                "field": {"horizontal_length": 10.0, "vertical_length": 2.0},
            },
            "E": {"of": "soil.youngs_modulus", "kind": "lognormal", "mean": STIFF, "cov": 0.5},
        },
    }
}
GEOSTATIC: dict[str, Any] = {"gravity": {"ramp": 0.0, "initial_stress": "geostatic"}}
SLOPES = {
    "homogeneous": {},
    "layered": LAYERED,
    "wet": WET,
    "layered and wet": LAYERED | WET,
    "geostatic": GEOSTATIC,
    "a ground line": GROUND,
}


def scene(changes: dict[str, Any], softer: float = 1.0, **other: float) -> Scene:
    """A slope with all Young's moduli divided, or those of some soils."""
    data = copy.deepcopy(merge(SLOPE, changes))
    for part in ("soil", *data.get("layers", ())):
        soil = data["soil"] if part == "soil" else data["layers"][part]["soil"]
        soil["youngs_modulus"] /= softer * other.get(part, 1.0)
    for variable in data.get("uncertain", {}).get("variables", {}).values():
        if variable["of"] == "soil.youngs_modulus":
            variable["mean"] /= softer
            del data["soil"]["youngs_modulus"]
    return make_scene(data)


@pytest.mark.parametrize("load", [0.0, 2.0])
@pytest.mark.parametrize("slope", [*SLOPES, "variable"])
def test_the_static_test_does_not_know_the_stiffness(slope: str, load: float) -> None:
    if slope == "variable":
        pytest.importorskip("gstools", reason="the extra 'uncertainty' installs it")
    changes = SLOPES.get(slope, VARIABLE)
    stiff = static_scene(scene(changes), RULE, load)
    for softer in (1e-2, 10.0, 100.0, 1e3):
        soft = static_scene(scene(changes, softer), RULE, load)
        assert soft.model_copy(update={"uncertain": stiff.uncertain}) == stiff
    moduli = [soil.shear_modulus_si for soil in stiff.soils]
    np.testing.assert_allclose(moduli, stiffness(stiff, RULE, load), rtol=1e-9)
    assert [soil.poisson_ratio for soil in stiff.soils] == [soil.poisson_ratio for soil in scene(changes).soils]


@pytest.mark.parametrize("softer", [{"soil": 1e3}, {"fill": 1e3}, {"clay": 1e3}, {"soil": 1e3, "clay": 10.0}])
def test_nor_how_the_layers_differ_in_it(softer: dict[str, float]) -> None:
    assert static_scene(scene(LAYERED, **softer), RULE, 1.0) == static_scene(scene(LAYERED), RULE, 1.0)


def test_runs_of_the_gravity_stage_keep_their_stiffness() -> None:
    soft = scene(LAYERED, 30.0, clay=10.0)
    kept = static_scene(soft, RULE, own_stiffness=True)
    assert [soil.youngs_modulus for soil in kept.soils] == [soil.youngs_modulus for soil in soft.soils]


@pytest.mark.long
def test_elastic_ground_moves_by_its_share_of_what_the_rule_allows() -> None:
    """Closed form: rho a H^2 / 2G at the top of a layer that does not yield, of soil that is soft in its file.

    H is the height above the fixed particles, half a spacing below the base.  Tolerance, stated before the first run: 10 %, for the load
    that comes within a second and for the kernel.  It was too small for the 10 rows of that run (24 % over the height above the base, 12 %
    over this one); these are 20.
    """
    height, spacing, load = 10.0, 0.5, 5.0
    layer = {
        "geometry": {"shape": "block", "width": 6.0, "height": height},
        "walls": {"base": "fixed", "sides": "periodic"},
        "soil": SLOPE["soil"] | {"youngs_modulus": 3e3, "cohesion": 1e4},
        "numerics": SLOPE["numerics"] | {"spacing": spacing},
    }
    trial = stand(static_scene(make_scene({**SLOPE, **layer}), RULE, load), RULE, load)
    allowed = ELASTIC_SHARE * RULE.displacement * height * load / (load + GRAVITY)
    assert trial.stands
    assert trial.largest_displacement == pytest.approx(allowed * (1.0 + 0.5 * spacing / height) ** 2, rel=0.1)


@pytest.mark.parametrize("name", ["fos", "yield-acceleration"])
@pytest.mark.parametrize("slope", ["homogeneous", "layered and wet"])
def test_the_commands_try_the_same_slopes_over_three_decades(
    name: str, slope: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    tried: dict[float, list[tuple[float, Scene]]] = {1.0: [], 1e3: []}
    for softer, trials in tried.items():

        def trial(static: Scene, rule: FailureRule, value: float, trials: list[tuple[float, Scene]] = trials) -> Trial:
            trials.append((value, static))
            return Trial(value, value < 1.3, 0.0, 0.0, "complete", 0.0)

        monkeypatch.setattr("sph.stability.safety.stand", trial)
        (tmp_path / "slope.yaml").write_text(yaml.safe_dump(scene(SLOPES[slope], softer).model_dump(mode="json")))
        result = call(name, tmp_path / "slope.yaml", "--single", "--tolerance", 0.02)
        assert result.exit_code == 0, result.output
    assert tried[1.0] == tried[1e3] and len(tried[1.0]) > 4
