"""A scene, its answer, and how another answer is compared with it.

Two measures are written down before the runs:

* **The same bits**, wherever the program computes with the same numbers in the same order.
* **The same to rounding** (``same_to_rounding``), where sums are made in another order or numbers pass through other units: places
  within ``ROUNDING`` spacings at the end of the run.  Runs of a few seconds are no chaos: changing gravity by a part in 1e9 moved no
  particle of 40 such scenes by more than 2e-7 m, and by a part in 1e6 by 2e-5 m, while rounding is a part in 1e16, which gradients in
  single precision raise to 1e-8 m.
"""

from __future__ import annotations

import functools
import math
import sys
import zlib
from collections.abc import Callable, Mapping
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import xarray as xr

ROOT = Path(__file__).resolve().parents[2]
sys.path[:0] = [str(ROOT), str(ROOT / "tests")]

from comparison import same_bits, same_variables  # noqa: E402
from scenes import TIME_STEP, Data, make_data  # noqa: E402

from sph.measures.metrics import METRICS, measure  # noqa: E402
from sph.scene.configuration import Section, dotted, merge  # noqa: E402
from sph.scene.schema import Scene, make_scene  # noqa: E402
from sph.solver.particles import place_particles  # noqa: E402
from sph.solver.run import Result, run  # noqa: E402

ROUNDING = 1e-5
"""Largest distance of two particles that are the same to rounding, over the spacing."""
LOADS = 1e-12
"""Largest relative difference of two loads that are the same to rounding."""
COSTS = {"wall_time", "particle_steps_per_second"}
"""Metrics that tell how long a run took."""


class Case:
    """A scene, what has been computed of it, and what a relation draws by chance."""

    def __init__(self, number: int, folder: Path) -> None:
        self.data, self.folder = make_data(number), folder
        self.number = number
        self.scene = make_scene(self.data)
        self.others: list[Any] = []

    @functools.cached_property
    def result(self) -> Result:
        """The run of the scene as it is; all relations share it."""
        return run(self.scene)

    def generator(self, name: str) -> np.random.Generator:
        """Chance of one relation: the same whichever others are tried."""
        return np.random.default_rng([self.number, zlib.crc32(name.encode())])

    def changed(self, changes: Mapping[str, Any]) -> Data:
        """The scene with dotted keys laid over it."""
        return merge(self.data, dotted(changes))

    def run(self, data: Data, **how: Any) -> Result:
        """The run of another scene, which is kept for the report of a failure."""
        self.others.append(data)
        return run(make_scene(data), **how)


def same_metrics(one: xr.Dataset, other: xr.Dataset, but: frozenset[str] | set[str] = frozenset()) -> None:
    """Assert that two runs have the same numbers: equal, or to rounding where places of the survey enter."""
    left, right = measure(one), measure(other)
    for name in {metric.name for metric in METRICS} - COSTS - but:
        if isinstance(left[name], float):
            assert np.isclose(left[name], right[name], rtol=1e-9, atol=1e-9, equal_nan=True), (name, left[name], right[name])
        else:
            assert left[name] == right[name], (name, left[name], right[name])


def same_but(one: Result, other: Result, *names: str) -> None:
    """Assert that two runs have the same bits but for some variables of the trajectory."""
    left, right = (with_trajectory(each, each.trajectory.drop_vars(names)) for each in (one, other))
    same_bits(left, right)


def with_trajectory(result: Result, trajectory: xr.Dataset) -> Any:
    """A result with a part of its trajectory."""
    return SimpleNamespace(trajectory=trajectory, restart=result.restart, status=result.status)


def same_values(one: xr.Dataset, other: xr.Dataset) -> None:
    """Assert that two datasets hold the same values: 0 and -0 are one."""
    for name in one.data_vars:
        assert np.array_equal(one[name].values, other[name].values, equal_nan=one[name].dtype.kind == "f"), name


def common(one: xr.Dataset, other: xr.Dataset, before: float = math.inf) -> tuple[xr.Dataset, xr.Dataset]:
    """Two trajectories at the frames and samples that both have before a time (s), without what depends on how many frames there were."""
    for dim, name in (("frame", "time"), ("sample", "sample_time")):
        left, right = (np.round(ds[name].values / TIME_STEP) for ds in (one, other))
        times = np.intersect1d(left, right)
        times = times[times < before / TIME_STEP - 0.5]
        one, other = one.isel({dim: np.isin(left, times)}), other.isel({dim: np.isin(right, times)})
    return one.drop_vars("time_step_limit"), other.drop_vars("time_step_limit")


def same_until(one: xr.Dataset, other: xr.Dataset, time: float) -> None:
    """Assert that two trajectories have the same bits before a time (s), and at the start."""
    left, right = (ds.drop_vars("t_f") for ds in common(one, other, time))
    assert left.sizes["sample"] > 1
    same_variables(left, right)


def same_state(one: Result, other: Result) -> None:
    """Assert that two runs end in the same bits, but for the shape of the stiffest mode, which is measured at frames."""
    same_variables(*(result.restart.drop_vars(["mode_x", "mode_y"]) for result in (one, other)))
    assert one.status == other.status and one.restart.attrs["step"] == other.restart.attrs["step"]


def same_to_rounding(one: Result, other: Result, scene: Scene, order: Any = slice(None), mirror: float | None = None) -> None:
    """Assert that two runs end alike and with every particle within ``ROUNDING`` spacings of its like.

    ``order`` is that of the other's particles; ``mirror`` (m) is the width of the box that the other's left and right are changed in.
    """
    x = other.restart["x"].values[order]
    distance = np.hypot(one.restart["x"] - (x if mirror is None else mirror - x), one.restart["y"] - other.restart["y"].values[order])
    assert one.status == other.status, (one.status, other.status)
    assert distance.max() <= ROUNDING * scene.numerics.spacing, f"a particle lies {float(distance.max()):.3g} m away from its like"
    first, second = (first_failure(result) for result in (one, other))
    assert first == second or abs(first - second) <= 1.5 * TIME_STEP, (first, second)


def same_particles(one: Scene, other: Scene) -> None:
    """Assert that two scenes place the same particles in the same layers, without running them."""
    for name, left, right in zip(place_particles(one)._fields, place_particles(one), place_particles(other), strict=True):
        assert np.shape(left) == np.shape(right), f"{name}: {np.size(left)} and {np.size(right)} particles"
        assert np.array_equal(left, right), f"{name}: other values of {np.count_nonzero(left != right)} of {np.size(left)} particles"


def first_failure(result: Result) -> float:
    """Time of the first failure, s; infinite without one."""
    return float(np.nanmin(np.append(result.trajectory["t_f"].values, math.inf)))


def mean_displacement(result: Result) -> float:
    """Mean length of the soil's displacement since the very start, m: a slope that does not stand has moved before it is shaken."""
    soil = result.trajectory["kind"].values == 0
    return float(np.hypot(*(result.trajectory[f"displacement_{axis}"].values[-1, soil].astype(float) for axis in "xy")).mean())


# ------------------------------------------------------------ places and units


def placed(data: Data, place: Callable[[float, float], tuple[float, float]], turned: bool) -> Data:
    """A scene with all places of its survey elsewhere; ``turned`` if left and right have changed."""
    geometry = dict(data["geometry"])
    geometry["points"] = [list(place(*point)) for point in geometry["points"]]
    geometry["base"] = place(0.0, geometry["base"])[1]
    if turned:
        geometry["downhill"] = {"left": "right", "right": "left"}[geometry["downhill"]]
    layers = {name: {**layer, "region": placed_region(layer["region"], place)} for name, layer in data.get("layers", {}).items()}
    probes = {name: probe if isinstance(probe, str) else list(place(*probe)) for name, probe in data["probes"].items()}
    return {**data, "geometry": geometry, "probes": probes, **({"layers": layers} if layers else {})}


def placed_region(region: Data, place: Callable[[float, float], tuple[float, float]]) -> Data:
    """The region of a layer elsewhere."""
    if region["kind"] == "polygon":
        return {**region, "points": [list(place(*point)) for point in region["points"]]}
    if region["kind"] == "elevation":
        return {name: value if name == "kind" or value is None else place(0.0, value)[1] for name, value in region.items()}
    return region


UNITS = {
    "-": (0, 0, 0),
    "%": (0, 0, 0),
    "degree": (0, 0, 0),
    "m": (1, 0, 0),
    "s": (0, 1, 0),
    "Hz": (0, -1, 0),
    "1/s": (0, -1, 0),
    "m/s": (1, -1, 0),
    "m/s2": (1, -2, 0),
    "kg/m3": (-3, 0, 1),
    "kPa": (-1, -2, 1),
    "kPa/m": (-2, -2, 1),
    "Pa s": (-1, -1, 1),
    "1": (0, 0, 0),
    "m s-1": (1, -1, 0),
    "m s-2": (1, -2, 0),
    "kg m-3": (-3, 0, 1),
    "kg m-1": (-1, 0, 1),
    "Pa": (-1, -2, 1),
    "J m-1": (1, -2, 1),
}
"""Powers of length, time and mass in the units of keys and of variables."""


def size_of(unit: str, sizes: tuple[float, float, float]) -> float:
    """What a number in a unit is multiplied by when length, time and mass are."""
    return math.prod(size**power for size, power in zip(sizes, UNITS[unit], strict=True))


def in_units(section: Section, sizes: tuple[float, float, float]) -> Data:
    """A section with every number multiplied as its unit says."""
    changed = {}
    for name, field in type(section).model_fields.items():
        extra = field.json_schema_extra
        assert isinstance(extra, dict)
        changed[name] = _in_units(getattr(section, name), size_of(str(extra["unit"]) if name != "probes" else "m", sizes), sizes)
    return changed


def _in_units(value: Any, size: float, sizes: tuple[float, float, float]) -> Any:
    if isinstance(value, Section):
        return in_units(value, sizes)
    if isinstance(value, dict):
        return {name: _in_units(item, size, sizes) for name, item in value.items()}
    if isinstance(value, tuple):
        return [_in_units(item, size, sizes) for item in value]
    return value * size if isinstance(value, float) else value
