"""Layers of a scene: what they take over, where they lie, and what is refused."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml

from sph.checks.equilibrium import equilibrium_numbers, found_equilibrium
from sph.scene.configuration import read_scene, scene_files
from sph.scene.schema import load_scene, make_scene, stored_scene
from sph.solver.particles import layer_index, place_particles

SLOPE: dict[str, Any] = {"scheme": "paper", "name": "s", "geometry": {"shape": "slope"}, "soil": {"density": 1800.0, "cohesion": 40.0}}


def layered(**layers: Any) -> Any:
    return make_scene(SLOPE | {"layers": layers})


def test_a_layer_takes_over_what_it_does_not_name() -> None:
    scene = layered(clay={"region": {"kind": "depth"}, "soil": {"friction_angle": 5.0}})
    clay = scene.layers["clay"].soil
    assert (clay.density, clay.cohesion, clay.friction_angle) == (1800.0, 40.0, 5.0)
    assert make_scene(scene.model_dump(mode="json")) == scene
    assert scene.soils == (scene.soil, clay)


def test_where_regions_lie() -> None:
    scene = layered(
        cover={"region": {"kind": "depth", "top": 0.0, "bottom": 3.0}},
        rock={"region": {"kind": "elevation", "top": 5.0}},
        lens={"region": {"kind": "polygon", "points": [[10, 2], [20, 2], [20, 8], [10, 8]]}},
    )
    # Under the apron, whose ground lies at 10 m; under the crest at 35 m; in the lens, which is later than the rock.
    x, y = np.array([40.0, 40.0, 40.0, 95.0, 95.0, 15.0, 15.0]), np.array([8.0, 6.0, 4.0, 33.0, 31.0, 4.0, 6.0])
    assert layer_index(scene, x, y).tolist() == [1, 0, 2, 1, 0, 3, 3]
    particles = place_particles(scene)
    base = particles.kind == 1
    assert set(particles.layer[base]) == {2}, "the base goes on as the soil above it"
    assert particles.mass == pytest.approx(1800.0)


REFUSED = [
    ({"region": {"kind": "depth", "top": 5.0, "bottom": 5.0}}, "layers.clay.region", "deeper than top"),
    ({"region": {"kind": "elevation", "top": 1.0, "bottom": 2.0}}, "layers.clay.region", "lower than top"),
    ({"region": {"kind": "depth", "top": -1.0}}, "layers.clay.region.top", "greater than or equal to 0"),
    ({"region": {"kind": "polygon", "points": [[0, 0], [1, 1]]}}, "layers.clay.region.points", "at least 3"),
    ({"region": {"kind": "depth"}, "soil": {"cohesoin": 3}}, "layers.clay.soil.cohesoin", "no such key"),
    ({"region": {"kind": "depth"}, "soil": {"poisson_ratio": 0.6}}, "layers.clay.soil.poisson_ratio", "0.499"),
    ({"region": {"kind": "depth"}, "S_R": 2.0}, "layers.clay.S_R", "less than or equal to 1"),
    ({"soil": {}}, "layers.clay.region", "required"),
    (3, "layers.clay", "valid dictionary"),
]


@pytest.mark.parametrize(("layer", "where", "what"), REFUSED)
def test_a_bad_layer_is_refused_by_its_key(layer: Any, where: str, what: str) -> None:
    with pytest.raises(ValueError, match=where) as error:
        layered(clay=layer)
    assert what in str(error.value)


def test_a_bad_name_is_refused() -> None:
    with pytest.raises(ValueError, match="layers"):
        layered(**{"soft clay": {"region": {"kind": "depth"}}})


def test_a_boundary_and_a_polygon_may_stand_in_files(tmp_path: Path) -> None:
    """Beside the scene; what lies below a boundary lies where a polygon under it does, and level beyond its ends."""
    (tmp_path / "rock.csv").write_text("x (m),level (m)\n60,4\n90,20\n")
    (tmp_path / "lens.geojson").write_text('{"type": "Polygon", "coordinates": [[[10, 2], [20, 2], [20, 8], [10, 8], [10, 2]]]}')
    layers = {
        "rock": {"region": {"kind": "below", "file": "rock.csv"}},
        "lens": {"region": {"kind": "polygon", "file": "lens.geojson"}},
    }
    path = tmp_path / "scene.yaml"
    path.write_text(yaml.safe_dump(SLOPE | {"layers": layers}, sort_keys=False))
    scene = load_scene(path)
    x, y = np.array([40.0, 40.0, 75.0, 75.0, 110.0, 110.0, 15.0]), np.array([3.5, 4.5, 11.0, 13.0, 19.0, 21.0, 4.0])
    assert layer_index(scene, x, y).tolist() == [1, 0, 1, 0, 1, 0, 2]
    below = [[-50, 4], [60, 4], [90, 20], [300, 20], [300, -9], [-50, -9]]
    lens = [[10, 2], [20, 2], [20, 8], [10, 8]]
    same = layered(rock={"region": {"kind": "polygon", "points": below}}, lens={"region": {"kind": "polygon", "points": lens}})
    found, wanted = (place_particles(each).layer for each in (scene, same))
    assert np.array_equal(found, wanted)
    assert scene_files(read_scene(path)) == sorted(str(tmp_path / name) for name in ("rock.csv", "lens.geojson"))
    assert stored_scene(scene.model_dump(mode="json")) == scene, "without the files"
    one, other = (found_equilibrium(each) for each in (scene, same))
    assert one is not None and other is not None and equilibrium_numbers(one) == equilibrium_numbers(other)
