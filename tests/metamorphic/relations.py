"""Relations between two answers: how a scene is said in other words or changed, and how its answer must follow.

A relation is a function that takes a ``Case`` and raises AssertionError where it does not hold; its docstring says what must follow.
Most ask for the same bits, or for the same to rounding (see ``answers``).

Weaker soil must **never move less**.  A coarse slope is cut into particles by its lattice, and that is the chance in its displacement; it
is bounded by the same two slopes on ``LATTICES``: weaker soil has moved less only if on every lattice it moved less than the stronger
on any.
"""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Iterator
from contextlib import suppress
from typing import Any, NamedTuple

import numpy as np
import yaml
from answers import (
    LOADS,
    Case,
    common,
    first_failure,
    in_units,
    mean_displacement,
    placed,
    placed_region,
    same_but,
    same_metrics,
    same_particles,
    same_state,
    same_to_rounding,
    same_until,
    same_values,
    size_of,
)
from comparison import same_bits, same_variables
from scenes import GRAVITY_STAGE, SERIES_INTERVAL, TIME_STEP, Data, top

from sph.command.repeat import given_scene
from sph.scene.configuration import dotted, merge
from sph.scene.gravity import GRAVITY
from sph.scene.ground_motion import motion_of
from sph.scene.loading import make_loading
from sph.scene.schema import Scene, load_scene, make_scene
from sph.solver.checkpoint import run_to_file
from sph.solver.particles import place_particles
from sph.solver.run import Result, Run, run
from sph.solver.state import ARMED
from sph.stability.newmark import sliding_block
from sph.storage import trajectory
from sph.study.plan import load_study

LATTICES = (1.0, 0.92, 0.96, 1.04, 1.08)
"""Spacings, over that of the scene, on which chance is looked for."""


class Relation(NamedTuple):
    """One relation."""

    name: str
    holds: Callable[[Case, np.random.Generator], None]
    fits: Callable[[Case], bool]
    """whether it says something of a scene"""

    def check(self, case: Case) -> None:
        """Raise AssertionError where it does not hold, and ValueError where the other scene is refused."""
        self.holds(case, case.generator(self.name))


RELATIONS: dict[str, Relation] = {}


def relation(fits: Callable[[Case], bool] = lambda case: True) -> Callable[[Any], Any]:
    """Register a function as a relation between scenes that it fits."""

    def register(holds: Callable[[Case, np.random.Generator], None]) -> Any:
        RELATIONS[holds.__name__] = Relation(holds.__name__, holds, fits)
        return holds

    return register


def is_a(*shapes: str) -> Callable[[Case], bool]:
    """Whether a scene has one of these shapes."""
    return lambda case: case.data["geometry"]["shape"] in shapes


def shaken(*kinds: str) -> Callable[[Case], bool]:
    """Whether a scene is shaken, by one of these motions if some are named."""
    return lambda case: case.data["motion"]["kind"] in kinds if kinds else case.data["motion"]["kind"] != "none"


def default_walls(case: Case) -> bool:
    """Whether a scene may have layers without needing another variant of the solver."""
    return "walls" not in case.data


# ------------------------------------------------------------ the same scene in other words


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
        written, kept = load_scene(path, dotted(each)), given_scene(stored, dotted(each))
        case.others[:] = [each]
        assert written.model_dump_json() == kept.model_dump_json(), f"with {each}: {_differing(written.model_dump(), kept.model_dump())}"
    same_bits(case.result, run(given_scene(stored, {})))
    same_metrics(case.result.trajectory, trajectory.read_run(stored))


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
    far = (512345.6, 4321.1) if chance.random() < 0.5 else np.round(chance.uniform(-6e5, 6e5, 2), 1).tolist()

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


# ------------------------------------------------------------ the same soil


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


# ------------------------------------------------------------ the same shaking


def _record_changed(case: Case, changes: Data) -> Result:
    """The run of a scene with another record, whose loads must be the same to rounding."""
    other = case.changed(changes)
    for name in ("ground", "vertical"):
        left, right = (getattr(make_loading(scene), name) for scene in (case.scene, make_scene(other)))
        assert np.abs(left - right).max() <= LOADS * max(np.abs(left).max(), 1.0), f"{name}: loads differ by {np.abs(left - right).max():g}"
    return case.run(other)


@relation(shaken("record"))
def record_resampled_finer(case: Case, chance: np.random.Generator) -> None:
    """A record with samples put between its own, on the straight line: the same to rounding."""
    data = case.data["motion"]["data"]
    times = [m for m in (2, 4, 5) if data["interval"] / m > TIME_STEP * (1 - 1e-6)]
    m, n = int(chance.choice(times)), len(data["x"])
    at = np.arange((n - 1) * m + 1) / m
    finer = {name: np.interp(at, np.arange(n), data[name]).tolist() for name in ("x", "y") if name in data}
    result = _record_changed(case, {"motion.data": {"interval": data["interval"] / m, **finer}})
    same_to_rounding(case.result, result, case.scene)


@relation(shaken("record"))
def record_with_rest_after_it(case: Case, chance: np.random.Generator) -> None:
    """A record that goes on standing still: the same values (a zero may have another sign) at the frames and samples that both have."""
    data = case.data["motion"]["data"]
    zeros = [0.0] * int(chance.integers(1, 60))
    longer = {name: data[name] + zeros for name in ("x", "y") if name in data}
    result = _record_changed(case, {"motion.data": {"interval": data["interval"], **longer}})
    same_values(*common(case.result.trajectory, result.trajectory))
    same_values(case.result.restart, result.restart)


@relation(lambda case: shaken("record")(case) and case.scene.motion.start > GRAVITY_STAGE)
def record_with_rest_before_it(case: Case, chance: np.random.Generator) -> None:
    """A record that stands still at first and begins earlier by as much: the same to rounding."""
    motion = case.data["motion"]
    interval = motion["data"]["interval"]
    zeros = int(chance.integers(1, int((motion["start"] - GRAVITY_STAGE) / interval + 1e-9) + 1))
    earlier = {name: [0.0] * zeros + motion["data"][name] for name in ("x", "y") if name in motion["data"]}
    changes = {"motion.data": {"interval": interval, **earlier}, "motion.start": motion["start"] - zeros * interval}
    same_to_rounding(case.result, _record_changed(case, changes), case.scene)


@relation(shaken("tapered_sine", "velocity_pulse"))
def formula_as_a_record(case: Case, chance: np.random.Generator) -> None:
    """A motion by formula sampled at the time steps is the same record, with or without a vertical component of nothing: to rounding."""
    motion = case.scene.motion
    time = motion.start + TIME_STEP * np.arange(round((motion.end - motion.start) / TIME_STEP) + 1)
    data: Data = {"interval": TIME_STEP, "x": motion.acceleration(time).tolist()}
    record: Data = {"kind": "record", "start": motion.start, "data": data}
    if chance.random() < 0.5:
        record |= {"data": data | {"y": [0.0] * time.size}, "vertical": {}}
    result = _record_changed(case, {"motion": record})
    same_to_rounding(case.result, result, case.scene)


@relation()
def no_shaking(case: Case, chance: np.random.Generator) -> None:
    """No motion, a sine, a pulse and a wavelet of amplitude 0, a record of zeros: the same values, where both have frames."""
    none = case.run({**case.data, "motion": {"kind": "none"}})
    still: Data = chance.choice(
        [
            {"kind": "tapered_sine", "amplitude": 0.0, "start": 1.0, "ramp": 0.25, "decay_start": 1.5, "end": 2.0},
            {"kind": "velocity_pulse", "amplitude": 0.0, "frequency": 2.0, "start": 1.0},
            {"kind": "ricker", "amplitude": 0.0, "frequency": 4.0, "peak": 2.0},
            {"kind": "constant", "amplitude": 0.0, "start": 1.0, "ramp": 0.5},
            {"kind": "record", "start": 1.0, "vertical": {}, "data": {"interval": 0.02, "x": [0.0] * 9, "y": [0.0] * 9}},
        ]
    )
    result = case.run({**case.data, "motion": still})
    same_values(*common(none.trajectory, result.trajectory))
    assert none.status == result.status


@relation(shaken("record"))
def record_in_units(case: Case, chance: np.random.Generator) -> None:
    """A record's file in g, gal, cm/s2 or m/s2, by its header or by ``unit``, as CSV or PEER, with time in s or ms: the same samples.

    A unit, wherever a header names it, is understood or refused.
    """
    g_values = [round(value / GRAVITY, 5) for value in case.data["motion"]["data"]["x"]]
    interval = case.data["motion"]["data"]["interval"]
    sizes = {"g": GRAVITY, "gal": 0.01, "cm/s2": 0.01, "m/s2": 1.0}
    columns = {unit: [value * GRAVITY / size for value in g_values] for unit, size in sizes.items()}
    headers = {
        "t, a": "unit",
        "time (s), ax ({})": "",
        "time [s],acc [{}]": "",
        "time,acc_{}": "",
        "time,ACC ({}) NS": "",
        "time, acc {}": "",
    }
    files: list[tuple[str, str, Data]] = []
    for unit, values in columns.items():
        for header, by_key in headers.items():
            rows = "\n".join(f"{interval * k!r},{value!r}" for k, value in enumerate(values))
            files.append((f"{header.format(unit)}\n{rows}", ".csv", {"unit": unit} if by_key else {}))
    milliseconds = "\n".join(f"{1e3 * interval * k!r},{value!r}" for k, value in enumerate(columns["m/s2"]))
    files += [(f"{header}\n{milliseconds}", ".csv", {}) for header in ("time (ms), a (m/s2)", "time_ms,a", "t [msec],a")]
    peer = "\n".join(" ".join(f"{value:.5E}" for value in g_values[k : k + 5]) for k in range(0, len(g_values), 5))
    files.append(
        (f"PEER\nsomewhere\nACCELERATION TIME SERIES IN UNITS OF G\nNPTS= {len(g_values)}, DT= {interval} SEC\n{peer}\n", ".AT2", {})
    )
    wanted = None
    for number, (text, ending, keys) in enumerate(files):
        path = case.folder / f"record{number}{ending}"
        path.write_text(text)
        case.others[:] = [text[:200]]
        first = text.splitlines()[0]
        try:
            scene = make_scene({**case.data, "motion": {"kind": "record", "file": str(path), "start": 1.0, **keys}})
        except ValueError as error:
            assert any(unit in first for unit in ("_", ") NS", "acc ", "ms")) and "line 1" in str(error), f"{first!r}: {error}"
            continue
        wanted = wanted or scene.motion.data
        assert scene.motion.data.x == wanted.x and np.isclose(scene.motion.data.interval, wanted.interval, rtol=1e-8), (
            f"{first!r} {keys}: read as {max(map(abs, scene.motion.data.x)):g} m/s2 every {scene.motion.data.interval:g} s"
        )


@relation(shaken())
def sliding_block_follows(case: Case, chance: np.random.Generator) -> None:
    """Newmark's block on the scene's motion: twice the motion and yield acceleration give twice the displacement, turned round the same
    upslope (bits); a finer sampling changes rounding only; a lower yield acceleration never slides it less."""
    motion = motion_of(case.scene)
    time, a, yields = motion.time, motion.acceleration, sorted(chance.uniform(0.02, 0.9, 3) * max(motion.peak, 0.01))
    slides = [sliding_block(time, a, float(value)).permanent for value in yields]
    assert slides == sorted(slides, reverse=True), f"yield accelerations {yields} slide it by {slides}"
    both = sliding_block(time, a, yields[0], yields[1])
    assert sliding_block(time, 4.0 * a, 4.0 * yields[0], 4.0 * yields[1]).permanent == 4.0 * both.permanent
    assert sliding_block(time, -a, yields[1], yields[0]).permanent == -both.permanent
    finer = np.interp(np.arange(2 * time.size - 1) / 2, np.arange(time.size), time)
    again = sliding_block(finer, np.interp(finer, time, a), yields[0], yields[1]).permanent
    assert np.isclose(again, both.permanent, rtol=1e-9, atol=1e-12), (again, both.permanent)


# ------------------------------------------------------------ the same run in other pieces


@relation()
def run_in_stages(case: Case, chance: np.random.Generator) -> None:
    """To the end of the gravity stage, on to the first failure and on to the end, through files: the bits of a run without a stop."""
    gravity, trunk = case.folder / "gravity.nc", case.folder / "trunk.nc"
    run_to_file(case.scene, gravity, "gravity")
    paused = run_to_file(case.scene, trunk, "first_failure", gravity)
    same_bits(case.result, run(case.scene, restart=trunk) if paused.status == "paused" else paused)


@relation()
def run_killed_and_given_again(case: Case, chance: np.random.Generator) -> None:
    """A run that stops after any sample but its last and goes on from its checkpoint: the bits of a run without a stop."""
    left = int(chance.integers(1, case.result.trajectory.sizes["sample"] - 1))
    path = case.folder / "checkpoint.nc"

    def keep(result: Callable[[], Result]) -> None:
        nonlocal left
        left -= 1
        if left == 0:
            trajectory.write(path, *result()[:2])
            raise KeyboardInterrupt

    with suppress(KeyboardInterrupt):
        Run(case.scene).go(checkpoint=keep)
    again = Run(case.scene)
    again.resume(path)
    same_bits(case.result, again.go())


@relation()
def restart_of_another_scene(case: Case, chance: np.random.Generator) -> None:
    """A scene that goes on from the gravity stage of another is refused, or has the bits of a run without a stop."""
    layers = case.data.get("layers", {})
    both = {name: {"region": {"kind": "elevation", "top": 1e4}, "soil": {"cohesion": c}} for name, c in (("a", 10.0), ("b", 90.0))}
    pairs = [
        (case.data, case.changed({"soil.cohesion": case.data["soil"]["cohesion"] + 5.0})),
        (case.data, case.changed({"coupling.S_R": 0.33, "coupling.gamma": 7.0, "coupling.fluid_tension_limit": 3.0})),
        (case.data, case.changed({"motion": {"kind": "ricker", "amplitude": 4.0, "frequency": 4.0, "peak": 1.5}, "duration": 4.0})),
        (case.data, case.changed({"gravity.damping": 10.0})),
        (case.data, {**case.data, "probes": {"B": "toe", **case.data["probes"]}}),
        (case.data, {**case.data, "layers": dict(reversed(layers.items()))}),
    ]
    if default_walls(case):
        pairs.append(({**case.data, "layers": both}, {**case.data, "layers": dict(reversed(both.items()))}))
    first, second = pairs[int(chance.integers(len(pairs)))]
    path = case.folder / "gravity_of_another.nc"
    run_to_file(make_scene(first), path, "gravity")
    case.others[:] = [first, second]
    try:
        result = run(make_scene(second), restart=path)
    except ValueError as error:
        assert "cannot go on from this run" in str(error), error
        return
    same_bits(run(make_scene(second)), result)


@relation()
def two_threads(case: Case, chance: np.random.Generator) -> None:
    """One thread or two, each with rows of particles of its own (a finer lattice than the other relations have): the same bits."""
    finer = case.changed({"numerics.spacing": 0.5 * case.scene.numerics.spacing, "numerics.time_step": 0.5 * TIME_STEP, "duration": 1.5})
    same_bits(case.run(finer), case.run(finer, threads=2))


@relation()
def other_frames(case: Case, chance: np.random.Generator) -> None:
    """Frames at another interval, which need not divide the gravity stage, the shaking or the duration: the same bits of the state and of
    what both store, and the same metrics."""
    result = case.run(case.changed({"outputs.frame_interval": SERIES_INTERVAL * int(chance.integers(1, 150))}))
    same_state(case.result, result)
    same_variables(*common(case.result.trajectory, result.trajectory))
    same_metrics(case.result.trajectory, result.trajectory, {"time_step_ratio"})


@relation()
def other_samples(case: Case, chance: np.random.Generator) -> None:
    """Samples at another interval: the same bits of the state, and of frames and samples that both have."""
    interval = float(chance.choice([TIME_STEP, 0.05, 0.125, 0.25]))
    result = case.run(case.changed({"outputs.series_interval": interval, "outputs.frame_interval": 2.0 * interval}))
    same_state(case.result, result)
    same_variables(*common(case.result.trajectory, result.trajectory))


@relation()
def longer_run(case: Case, chance: np.random.Generator) -> None:
    """A run that goes on for longer: the same bits up to the end of the shorter one."""
    result = case.run(case.changed({"duration": case.scene.duration + 0.5 * float(chance.integers(1, 3))}))
    same_until(case.result.trajectory, result.trajectory, case.scene.duration + TIME_STEP)


@relation()
def early_stop(case: Case, chance: np.random.Generator) -> None:
    """A run that ends once the soil is at rest: the bits of the run that goes on, up to there."""
    result = case.run(case.changed({"early_stop": {"speed": 0.1, "window": 0.25, "solid_weight": 0.9}}))
    end = float(result.trajectory["sample_time"][-1])
    same_until(case.result.trajectory, result.trajectory, end + TIME_STEP)
    assert end < case.scene.duration or result.status == case.result.status


@relation()
def more_probes(case: Case, chance: np.random.Generator) -> None:
    """Probes added before and after the others: the same bits of all else, and of the probes that were there."""
    other = {**case.data, "probes": {"Z": "toe", **case.data["probes"], "B": case.data["probes"]["A"]}}
    result = case.run(other)
    kept = result._replace(trajectory=result.trajectory.isel(probe=[1]))
    same_bits(case.result, kept)
    again = result.trajectory.isel(probe=[2])
    same_variables(case.result.trajectory.drop_vars("probe"), again.drop_vars("probe"))
    same_metrics(case.result.trajectory, result.trajectory)


@relation()
def step_that_need_not_adapt(case: Case, chance: np.random.Generator) -> None:
    """An adaptive time step where the step is below its limit throughout: the bits of a fixed one."""
    ds = case.result.trajectory
    largest = float((ds["time_step"] / ds["time_step_limit"]).max())
    if largest < 0.98:
        same_bits(case.result, case.run(case.changed({"numerics.adaptive_step": {"courant": 0.99}})))


@relation()
def wider_neighbour_lists(case: Case, chance: np.random.Generator) -> None:
    """Neighbour lists with a wider margin: the same to rounding, since rows are summed in another order."""
    result = case.run(case.changed({"numerics.neighbour_skin": float(chance.uniform(0.35, 1.0))}))
    same_to_rounding(case.result, result, case.scene)


@relation()
def what_acts_later(case: Case, chance: np.random.Generator) -> None:
    """S_R and gamma have no effect before the first failure, the motion none before the end of the gravity stage: the same bits."""
    changes = {"coupling.S_R": float(chance.uniform()), "coupling.gamma": float(chance.uniform(0.0, 100.0))}
    result = case.run(case.changed(changes))
    assert first_failure(result) == first_failure(case.result)
    same_until(case.result.trajectory, result.trajectory, first_failure(case.result))
    still = case.run(case.changed({"motion": {"kind": "none"}}))
    same_until(case.result.trajectory, still.trajectory, GRAVITY_STAGE)


@relation(shaken("tapered_sine", "velocity_pulse"))
def study_against_single_runs(case: Case, chance: np.random.Generator) -> None:
    """The runs of a study go on from shared stages: each has the bits of the scene run alone, whatever the order of the grid's values."""
    path = case.folder / "study_scene.yaml"
    path.write_text(yaml.safe_dump(case.data, sort_keys=False))
    own = str(case.data["motion"]["amplitude"])
    ratios, amplitudes = ["0.10", "0.9"], [own, "8.5" if float(own) != 8.5 else "6.5"]
    study = {"study": "s", "scene": path.name, "fidelity": "draft", "fidelities": {"draft": {}}}
    plans = [
        load_study({**study, "grid": {"S_R": s, "soil.cohesion": ["5", "40"], "amplitude": a}}, [case.folder])
        for s, a in ((ratios, amplitudes), (ratios[::-1], amplitudes[::-1]))
    ]
    assert sorted(plans[0].study.runs) == sorted(plans[1].study.runs)
    name = str(chance.choice(sorted(plans[0].study.runs)))
    scenes = [make_scene(plan.run_scene(name)) for plan in plans]
    case.others[:] = [name]
    assert scenes[0].model_dump_json() == scenes[1].model_dump_json()
    stages = plans[0].stages(name)
    gravity, trunk = case.folder / "study_gravity.nc", case.folder / "study_trunk.nc"
    run_to_file(make_scene(plans[0].stage(stages.gravity)), gravity, "gravity")
    run_to_file(make_scene(plans[0].stage(stages.trunk)), trunk, "first_failure", gravity)
    same_bits(run(scenes[0]), run(scenes[0], restart=trunk))


# ------------------------------------------------------------ weaker soil, stronger shaking


def weaker(data: Data, share: float, cohesion: float = 0.0) -> Data:
    """A scene with a share of the cohesion and of tan(phi) of every soil it names, and so much more ``cohesion`` (kPa)."""

    def soil(own: Data) -> Data:
        changed = dict(own)
        if "cohesion" in own:
            changed["cohesion"] = share * own["cohesion"] + cohesion
        if "friction_angle" in own:
            changed["friction_angle"] = math.degrees(math.atan(share * math.tan(math.radians(own["friction_angle"]))))
        return changed

    layers = {name: {**layer, "soil": soil(layer["soil"])} for name, layer in data.get("layers", {}).items()}
    return {**data, "soil": soil(data["soil"]), **({"layers": layers} if layers else {})}


def never_less(case: Case, strong: Data, weak: Data) -> None:
    """Assert that the weaker of two scenes moves no less than the stronger by more than chance, as ``LATTICES`` show it.

    One pair in order is enough: the two ranges then meet, or lie as they should.
    """

    def moved(data: Data) -> Iterator[float]:
        for size in LATTICES:
            result = case.run(merge(data, {"numerics": {"spacing": size * data["numerics"]["spacing"]}}))
            yield math.inf if result.status == "diverged" else mean_displacement(result)

    of_strong, of_weak = [], []
    for from_strong, from_weak in zip(moved(strong), moved(weak), strict=True):
        of_strong.append(from_strong)
        of_weak.append(from_weak)
        if max(of_weak) >= min(of_strong):
            return
    raise AssertionError(
        f"the weaker moves {min(of_weak):.4g} to {max(of_weak):.4g} m, the stronger {min(of_strong):.4g} to {max(of_strong):.4g} m"
    )


@relation()
def weaker_soil_never_moves_less(case: Case, chance: np.random.Generator) -> None:
    """Less cohesion and tan(phi), down to none, in every soil: the soil moves no less, gravity stage included, by more than chance."""
    low, high = sorted(chance.choice([1.0, 0.8, 0.6, 0.4, 0.2, 0.1, 0.05, 0.0], 2, replace=False).tolist())
    never_less(case, weaker(case.data, high), weaker(case.data, low))


@relation()
def weaker_remains_never_move_less(case: Case, chance: np.random.Generator) -> None:
    """A smaller S_R, of the coupling and of the layers: the soil moves no less by more than chance."""
    low, high = sorted(chance.uniform(0.0, 1.0, 2).tolist())
    layers = {name: {**layer, "S_R": None} for name, layer in case.data.get("layers", {}).items()}
    data = {**case.data, **({"layers": layers} if layers else {})}
    never_less(case, *(merge(data, {"coupling": {"S_R": ratio}}) for ratio in (high, low)))


@relation(shaken())
def stronger_shaking_never_fails_later(case: Case, chance: np.random.Generator) -> None:
    """The same motion with a larger amplitude: the first failure comes no later, by one time step at most.

    Soil is elastic before it first fails, so that its stress is that of gravity and a part in proportion to the shaking.  A yield surface
    is convex: if it is reached from inside with some shaking, it has been reached with more.  What is not linear, artificial viscosity
    among approaching particles and soil at yield beside the walls, is left a time step.
    """
    motion, factor = case.data["motion"], float(chance.choice([1.01, 1.2, 1.5, 2.0]))
    change = {"motion.amplitude": factor * motion["amplitude"]} if "amplitude" in motion else {"motion.factor": factor * motion["factor"]}
    result = case.run(case.changed(change))
    later = first_failure(result) - first_failure(case.result)
    assert math.isnan(later) or later <= 1.5 * TIME_STEP, (
        f"{factor:g} times the shaking: first failure at {first_failure(result):g} s, not {first_failure(case.result):g} s"
    )


@relation(shaken())
def weaker_soil_never_fails_later(case: Case, chance: np.random.Generator) -> None:
    """Less cohesion and tan(phi) in soil so firm that it stays elastic under gravity: the first failure comes no later, exactly.

    The two runs have the same bits until the weaker fails.
    """
    firm = weaker(case.data, 1.0, cohesion=80.0)
    pair = firm, weaker(firm, float(chance.choice([0.99, 0.9, 0.7])))
    stages = [case.run({**data, "duration": GRAVITY_STAGE, "motion": {"kind": "none"}}).restart for data in pair]
    if not stages[0].equals(stages[1]) or (stages[0]["phase"] != ARMED).any():
        return
    strong, weak = map(case.run, pair)
    assert first_failure(weak) <= first_failure(strong), (first_failure(weak), first_failure(strong))
    same_until(strong.trajectory, weak.trajectory, first_failure(weak))
