"""The same scene in other words, and the same soil in other layers or bodies."""

from __future__ import annotations

import json
from typing import Any

import numpy as np
import yaml
from answers import (
    Case,
    in_units,
    placed,
    placed_region,
    same_but,
    same_metrics,
    same_particles,
    same_to_rounding,
    size_of,
)
from comparison import same_bits, same_variables
from relation import default_walls, is_a, relation
from scenes import Data, top

from sph.command.given import read_given
from sph.scene.configuration import dotted
from sph.scene.schema import Scene, load_scene, make_scene
from sph.solver.particles import place_particles
from sph.solver.run import run
from sph.storage import trajectory


@relation()
def keys_in_another_order(case: Case, chance: np.random.Generator) -> None:
    """The order of keys in a file, how numbers are spelled, and the scene's name and title say nothing: the same bits.

    Only the order of layers counts, since of two that overlap the later one does.
    """

    def shuffled(value: Any, keep: bool = False) -> Any:
        if isinstance(value, dict):
            names = list(value) if keep else chance.permutation(list(value)).tolist()
            return {name: shuffled(value[name], name == "layers") for name in names}
        if isinstance(value, float) and value == int(value) and chance.random() < 0.5:
            return int(value)
        return [shuffled(item) for item in value] if isinstance(value, list) else value

    path = case.folder / "shuffled.yaml"
    path.write_text(yaml.safe_dump(shuffled(case.data) | {"name": "other", "title": "Another"}, sort_keys=False))
    scene = load_scene(path)
    same_bits(case.result, run(scene))


@relation()
def defaults_written_out(case: Case, chance: np.random.Generator) -> None:
    """Every default written out, and every key that has its default left out: the same scene, the same bits."""
    whole, short = case.folder / "whole.yaml", case.folder / "short.yaml"
    whole.write_text(yaml.safe_dump(case.scene.model_dump(mode="json"), sort_keys=False))
    short.write_text(yaml.safe_dump(_without_defaults(case.scene), sort_keys=False))
    for path in (whole, short):
        assert load_scene(path).model_dump_json() == case.scene.model_dump_json(), path.read_text()
    same_bits(case.result, run(load_scene(short)))


def _without_defaults(scene: Scene) -> Data:
    """The scene without the keys that have their default; which variant a section is must be said, and a layer's defaults are the
    scene's own soil."""
    data = scene.model_dump(mode="json", exclude_defaults=True) | {"geometry": scene.geometry.model_dump(mode="json")}
    for name, layer in data.get("layers", {}).items():
        layer["soil"] = scene.layers[name].soil.model_dump()
    return data


@relation()
def scene_in_its_trajectory(case: Case, chance: np.random.Generator) -> None:
    """A scene stored in its trajectory is the scene in its file, as it is and with any key set over it: the same scene, the same bits."""
    path, stored = case.folder / "scene.yaml", case.folder / "run.nc"
    path.write_text(yaml.safe_dump(case.data, sort_keys=False))
    trajectory.write(stored, case.result.trajectory, case.result.restart)
    settings: list[Data] = [
        {},
        {"soil.cohesion": 11.5},
        {"soil.density": 1850.0, "soil.friction_angle": 12.5},
        {"coupling.S_R": 0.45, "coupling.gamma": 3.0},
        {"numerics.spacing": 1.25 * case.scene.numerics.spacing},
        {"motion": {"kind": "ricker", "amplitude": 2.0, "frequency": 4.0, "peak": 1.5}},
        {"probes.B": "toe"},
        {"outputs.frame_interval": 0.1},
    ]
    settings += [{f"layers.{name}.soil.cohesion": 7.5} for name in case.scene.layers]
    for each in settings:
        written, kept = load_scene(path, dotted(each)), read_given(stored, dotted(each))[0]
        case.others[:] = [each]
        assert written.model_dump_json() == kept.model_dump_json(), f"with {each}: {_differing(written.model_dump(), kept.model_dump())}"
    same_bits(case.result, run(read_given(stored, {})[0]))
    same_metrics(case.result.trajectory, trajectory.read_run(stored).dataset())


def _differing(one: Data, other: Data, path: str = "") -> list[str]:
    """Dotted names of what differs between two nested mappings."""
    names = [name for name in one.keys() | other.keys() if one.get(name) != other.get(name)]
    deeper = [name for name in names if isinstance(one.get(name), dict) and isinstance(other.get(name), dict)]
    found = [f"{path}{name}: {one.get(name)!r:.80} and {other.get(name)!r:.80}" for name in names if name not in deeper]
    return found + [line for name in deeper for line in _differing(one[name], other[name], f"{path}{name}.")]


@relation(is_a("ground_line"))
def survey_elsewhere(case: Case, chance: np.random.Generator) -> None:
    """A survey in large coordinates: the same particles and bits, and the same layers where their bounds run through particles; metrics to
    rounding."""
    far = (512345.6, 2321.1) if chance.random() < 0.5 else np.round(chance.uniform((-6e5, -300.0), (6e5, 2e3)), 1).tolist()

    def moved(data: Data) -> Data:
        return placed(data, lambda x, z: (x + far[0], z + far[1]), turned=False)

    through = {**case.data, "layers": _layers_through_particles(case.scene)}
    case.others[:] = [through, moved(through)]
    same_particles(make_scene(through), make_scene(moved(through)))
    same_particles(case.scene, make_scene(moved(case.data)))
    result = case.run(moved(case.data))
    same_bits(case.result, result)
    same_metrics(case.result.trajectory, result.trajectory)


def _layers_through_particles(scene: Scene) -> Data:
    """A layer by elevation, one by depth and one by polygon, with bounds on which particles lie."""
    dx, ground = scene.numerics.spacing, scene.geometry.surface[1][0]
    (left, low), (right, high) = (scene.geometry.in_survey(*place) for place in ((1.5 * dx, 0.5 * dx), (5.5 * dx, 2.5 * dx)))
    regions: list[Data] = [
        {"kind": "elevation", "bottom": low, "top": high},
        {"kind": "depth", "top": ground - 0.5 * dx},
        {"kind": "polygon", "points": [[left, low], [right, low], [right, high], [left, high]]},
    ]
    return {f"layer{number}": {"region": region} for number, region in enumerate(regions)}


@relation(is_a("ground_line"))
def survey_mirrored(case: Case, chance: np.random.Generator) -> None:
    """A survey seen from the other side, its points from either end: the box turns it round to the same particles, layers and bits."""
    other = placed(case.data, lambda x, z: (-x, z), turned=True)
    if chance.random() < 0.5:
        other["geometry"]["points"].reverse()
    same_particles(case.scene, make_scene(other))
    result = case.run(other)
    same_bits(case.result, result)
    same_metrics(case.result.trajectory, result.trajectory)


@relation(is_a("slope"))
def slope_as_a_line(case: Case, chance: np.random.Generator) -> None:
    """A slope drawn as the ground line of its corners: the same particles and bits; metrics to rounding."""
    other = {**case.data, "geometry": {"shape": "ground_line", "points": np.transpose(case.scene.geometry.surface).tolist(), "base": 0.0}}
    case.others.append(other)
    same_particles(case.scene, make_scene(other))
    result = case.run(other)
    same_bits(case.result, result)
    same_metrics(case.result.trajectory, result.trajectory)


@relation(is_a("ground_line"))
def line_cut_out_of_a_longer_one(case: Case, chance: np.random.Generator) -> None:
    """A survey that goes on to both sides, cut to the same window: the same particles and bits."""
    points = sorted(case.data["geometry"]["points"])
    (left, low), (right, high) = points[0], points[-1]
    line = [[left - 30.0, low], *points, [right + 30.0, high]]
    other = case.changed({"geometry.points": line, "geometry.window": [left, right]})
    same_particles(case.scene, make_scene(other))
    same_bits(case.result, case.run(other))


@relation(is_a("ground_line"))
def line_in_files(case: Case, chance: np.random.Generator) -> None:
    """A ground line in a CSV of any dialect, in GeoJSON and in WKT is that of the scene; a unit named is understood or refused."""
    points = case.data["geometry"]["points"]
    rows = [(f"{x!r}", f"{z!r}") for x, z in points]
    table = "\n".join(",".join(row) for row in rows)
    files = {
        "plain.csv": table,
        "named.csv": "x (m), elevation (m)\n" + table,
        "semicolons.csv": "x;z\n" + "\n".join(";".join(row) for row in rows).replace(".", ","),
        "blanks.txt": "# x z\n" + "\n".join("  ".join(row) for row in rows),
        "line.json": json.dumps({"type": "LineString", "coordinates": points}),
        "line.wkt": f"LINESTRING ({', '.join(' '.join(row) for row in rows)})",
    }
    in_feet = "\n".join(f"{x / 0.3048!r},{z / 0.3048!r}" for x, z in points)
    named = {
        f"feet{number}.csv": f"{header}\n{in_feet}" for number, header in enumerate(("x (ft), z (ft)", "x_ft,z_ft", "x [feet], z [feet]"))
    }
    rest = {name: value for name, value in case.data["geometry"].items() if name != "points"}
    for name, text in (files | named).items():
        path = case.folder / name
        path.write_text(text)
        case.others[:] = [text]
        try:
            other = make_scene({**case.data, "geometry": {**rest, "file": str(path)}})
        except ValueError as error:
            assert name in named and any(word in str(error) for word in ("ft", "feet")), f"{name}: {error}"
            continue
        found, wanted = np.array(other.geometry.points), np.array(case.scene.geometry.points)
        assert np.allclose(found, wanted, rtol=0, atol=1e-9), f"{name}: {text.splitlines()[0]!r} is read as {found[:2].tolist()} m"


@relation()
def system_of_units(case: Case, chance: np.random.Generator) -> None:
    """Length, time and mass multiplied by powers of two, every key as its unit says: every variable follows its unit, to the last bit.

    So no number with a dimension is hidden in the code.  The measured limit of the time step passes through a power and follows to
    rounding.
    """
    while True:
        sizes = tuple(2.0 ** chance.integers(-3, 4, 3))
        if 1e-3 < size_of("m/s2", sizes) <= 4 and 1e-2 < size_of("kg/m3", sizes) <= 16 and sizes != (1.0, 1.0, 1.0):
            break
    other = in_units(case.scene, sizes)
    result = case.run({name: value for name, value in other.items() if value is not None})
    followed, expected = result.trajectory.copy(), case.result.trajectory.copy()
    for row in trajectory.VARIABLES:
        values = case.result.trajectory[row.name].values
        if values.dtype.kind == "f":
            expected[row.name] = (row.dims, values * np.array(size_of(row.units, sizes), values.dtype))
    limits = [ds["time_step_limit"].values for ds in (expected, followed)]
    assert np.allclose(*limits, rtol=1e-9)
    same_variables(*(ds.drop_vars("time_step_limit") for ds in (expected, followed)))
    assert result.status == case.result.status


@relation(default_walls)
def soil_in_equal_layers(case: Case, chance: np.random.Generator) -> None:
    """Soil parted into layers of the scene's own soil, by depth, elevation or polygon, on rows of particles or between them, lies in one
    of them everywhere: the same bits, and to rounding for a scene that had no layers, whose compiled code is another."""
    origin, spacing = case.scene.geometry.origin, case.scene.numerics.spacing
    step = float(chance.choice([0.5 * spacing, chance.uniform(1.0, 3.0)]))
    bounds = [step * k for k in sorted(chance.choice(np.arange(1, 8), chance.integers(1, 4), replace=False).tolist())]
    kind = chance.choice(["depth", "elevation", "polygon"])
    if kind == "polygon":
        left, right = sorted(origin[0] + case.scene.geometry.direction * x for x in (-50.0, 200.0))
        ends = [left, *(origin[0] + case.scene.geometry.direction * 4.0 * bound for bound in bounds), right]
        ends.sort()
        low, high = origin[1] - 10.0, origin[1] + 100.0
        regions = [{"points": [[a, low], [b, low], [b, high], [a, high]]} for a, b in zip(ends, ends[1:], strict=False)]
    elif kind == "depth":
        regions = [{"top": a, "bottom": b} for a, b in zip([0.0, *bounds], [*bounds, None], strict=True)]
    else:
        levels = [None, *(origin[1] + bound for bound in bounds), None]
        regions = [{"bottom": a, "top": b} for a, b in zip(levels, levels[1:], strict=False)]
    parts = {f"part{number}": {"region": {"kind": str(kind), **region}} for number, region in enumerate(regions)}
    other = {**case.data, "layers": parts | case.data.get("layers", {})}
    case.others.append(other)
    particles = place_particles(make_scene(other))
    assert particles.layer[: particles.n_soil].min() > 0, "a particle lies in none of the parts"
    result = case.run(other)
    if case.scene.layers:
        same_but(case.result, result, "layer")
    else:
        same_to_rounding(case.result, result, case.scene)


@relation(default_walls)
def layer_without_soil(case: Case, chance: np.random.Generator) -> None:
    """A layer that holds no particle, before or after the others: the same bits, to rounding for a scene that had no layers."""
    far = {"region": {"kind": "elevation", "bottom": case.scene.geometry.origin[1] + 500.0}, "soil": {"cohesion": 0.0}}
    layers = case.data.get("layers", {})
    other = {**case.data, "layers": {"far": far, **layers} if chance.random() < 0.5 else {**layers, "far": far}}
    result = case.run(other)
    if layers:
        same_but(case.result, result, "layer")
    else:
        same_to_rounding(case.result, result, case.scene)


@relation(default_walls)
def layers_side_by_side_in_any_order(case: Case, chance: np.random.Generator) -> None:
    """Two layers that touch and do not overlap, written in either order: the same bits, whatever lies on their common bound."""
    spacing, base = case.scene.numerics.spacing, case.scene.geometry.origin[1]
    bound = base + float(chance.choice([spacing * (chance.integers(1, 4) + 0.5), chance.uniform(1.0, 6.0)]))
    below = {"region": {"kind": "elevation", "top": bound}, "soil": {"cohesion": 80.0, "density": 2300.0}}
    above = {"region": {"kind": "elevation", "bottom": bound}, "soil": {"friction_angle": 33.0}, "S_R": 0.3}
    one, other = ({**case.data, "layers": layers} for layers in ({"a": below, "b": above}, {"b": above, "a": below}))
    same_but(case.run(one), case.run(other), "layer")


@relation(is_a("bodies"))
def mirrored_bodies(case: Case, chance: np.random.Generator) -> None:
    """A box, its bodies, layers and the shaking mirrored: the mirrored answer to rounding, since neighbours are summed from the other side.

    This one passes through the solver; a survey is turned round before it.
    """
    width = case.data["geometry"]["width"]
    motion = case.data["motion"]

    def mirrored(x: float, y: float) -> tuple[float, float]:
        return width - x, y

    body = {"kind": "polygon", "points": [list(mirrored(*point)) for point in case.data["geometry"]["bodies"][0]["points"]]}
    layers = {name: {**layer, "region": placed_region(layer["region"], mirrored)} for name, layer in case.data.get("layers", {}).items()}
    other = case.changed({"geometry.bodies": [body], "motion.factor": -motion.get("factor", 1.0)})
    if "vertical" in motion:
        other["motion"]["vertical"] = {"factor": -motion["vertical"]["factor"]}
    other |= {"probes": {"A": list(mirrored(*top(case.data["geometry"])))}, **({"layers": layers} if layers else {})}
    result = case.run(other)
    spacing = case.scene.numerics.spacing
    first, second = place_particles(case.scene), place_particles(make_scene(other))
    own = np.round(2.0 / spacing * np.array([first.x, first.y]))
    its = np.round(2.0 / spacing * np.array([width - second.x, second.y]))
    assert own.shape == its.shape, f"{own.shape[1]} and {its.shape[1]} particles"
    order = np.empty(own.shape[1], int)
    order[np.lexsort(own)] = np.lexsort(its)
    assert np.array_equal(own, its[:, order])
    same_to_rounding(case.result, result, case.scene, order, mirror=width)
