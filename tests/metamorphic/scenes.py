"""Small scenes made from a number: every number gives one scene, the same every time.

Slopes, surveyed lines and bodies of fifty to two hundred particles, walls included, 2 or 2.5 m apart with h = 1.3 spacings, are brought
under gravity in a second and shaken for one or two.  Half of them have corners and layer bounds where particles lie, or half-way between.
Terms of physics are chosen so that all scenes together need three variants of the compiled solver: the default one, one with layers and
one with free-slip sides.
"""

from __future__ import annotations

from typing import Any

import numpy as np

Data = dict[str, Any]

GRAVITY_STAGE = 1.0
"""Length of the gravity stage, s."""
TIME_STEP, SERIES_INTERVAL = 5e-3, 0.025
"""s."""
ORIGINS = ((0.0, 0.0), (120.0, 434.0), (-37.5, -12.25))
"""Where surveys have the lower left or right corner of the box, m."""


def make_data(number: int) -> Data:
    """The scene of a number, as a mapping that ``sph.make_scene`` takes."""
    draw = Draw(number)
    shape = draw.one_of("slope", "survey", "survey", "mound")
    geometry = {"slope": _slope, "survey": _survey, "mound": _mound}[shape](draw)
    shaking = _motion(draw, record=shape == "mound")
    data: Data = {
        "scheme": "paper",
        "name": f"scene-{number}",
        "duration": draw.one_of(3.0, 3.5),
        "geometry": geometry,
        "soil": _soil(draw),
        "coupling": {"S_R": draw.between(0.0, 1.0), "gamma": draw.one_of(0.5, 5.0, 50.0)},
        "motion": shaking,
        "gravity": {"ramp": 0.5, "duration": GRAVITY_STAGE},
        "numerics": {"spacing": draw.spacing, "smoothing_ratio": 1.3, "time_step": TIME_STEP},
        "outputs": {"frame_interval": draw.one_of(0.25, 0.5), "series_interval": SERIES_INTERVAL},
        "probes": {"A": top(geometry)},
    }
    variant = draw.one_of("default", "layers", "layers", "free-slip")
    if variant == "layers":
        data["layers"] = {name: _layer(draw, geometry) for name in ("fill", "clay", "rock")[: draw.whole(1, 3)]}
    elif variant == "free-slip":
        data["walls"] = {"sides": "free_slip"}
    return data


class Draw:
    """Numbers drawn for one scene, as a user writes them."""

    def __init__(self, number: int) -> None:
        self.generator = np.random.default_rng(number)
        self.spacing = self.one_of(2.0, 2.5)
        self.on_lattice = self.one_of(True, False)

    def one_of(self, *values: Any) -> Any:
        """One of the values."""
        return values[self.generator.integers(len(values))]

    def whole(self, low: int, high: int) -> int:
        """A whole number, both ends included."""
        return int(self.generator.integers(low, high + 1))

    def between(self, low: float, high: float) -> float:
        """A number with three digits behind the point."""
        return round(float(self.generator.uniform(low, high)), 3)

    def length(self, low: float, high: float) -> float:
        """A length (m): of scenes on the lattice a multiple of half a spacing, where particles lie and where they end."""
        half = 0.5 * self.spacing
        return round(self.between(low, high) / half) * half if self.on_lattice else self.between(low, high)


def top(geometry: Data) -> Any:
    """Where a scene's probe is: at the crest edge, of bodies at the middle of the top."""
    if geometry["shape"] != "bodies":
        return "crest_edge"
    (_, _), (_, _), (right, height), (left, _) = geometry["bodies"][0]["points"]
    return [0.5 * (left + right), height]


def _slope(draw: Draw) -> Data:
    return {
        "shape": "slope",
        "slope_angle": draw.one_of(45.0, 45.0, 90.0, draw.between(25.0, 80.0)),
        "slope_height": draw.length(6.0, 13.0),
        "base_depth": draw.length(3.0, 6.0),
        "apron_length": draw.length(6.0, 16.0),
        "crest_length": draw.length(6.0, 14.0),
    }


def _survey(draw: Draw) -> Data:
    """A ground line with a berm or without, in the coordinates of its survey."""
    corners = [(0.0, draw.length(3.0, 6.0))]
    for run, rise in ((draw.length(6.0, 16.0), 0.0), *_faces(draw), (draw.length(6.0, 14.0), 0.0)):
        corners.append((corners[-1][0] + run, corners[-1][1] + rise))
    (x0, z0), right = draw.one_of(*ORIGINS), draw.one_of(True, False)
    line = [[x0 - x if right else x0 + x, z0 + y] for x, y in corners]
    return {"shape": "ground_line", "points": line, "base": z0, "downhill": "right" if right else "left"}


def _faces(draw: Draw) -> list[tuple[float, float]]:
    """Run and rise of the parts of a slope's face."""
    gradient = draw.one_of(0.5, 1.0, 1.0, draw.between(0.3, 2.0))
    rises = [draw.length(3.0, 6.0) for _ in range(draw.whole(1, 2))]
    faces = [(rise / gradient, rise) for rise in rises]
    return faces if len(faces) == 1 else [faces[0], (draw.length(2.0, 4.0), 0.0), faces[1]]


def _mound(draw: Draw) -> Data:
    """A body with a face to either side, in a box that ends where its lattice does."""
    width, height = 12 * draw.spacing + 2 * draw.spacing * draw.whole(0, 2), draw.between(6.0, 12.0)
    left, right = draw.between(1.5, 6.0), width - draw.between(1.5, 6.0)
    points = [[left, 0.0], [right, 0.0], [right - draw.between(0.5, 5.0), height], [left + draw.between(0.5, 5.0), height]]
    return {"shape": "bodies", "width": width, "height": 16.0, "bodies": [{"kind": "polygon", "points": points}]}


def _soil(draw: Draw) -> Data:
    return {
        "density": draw.between(1600.0, 2200.0),
        "youngs_modulus": draw.one_of(2e4, 5e4, 1e5, 2e5),
        "poisson_ratio": draw.between(0.2, 0.4),
        "cohesion": draw.one_of(0.0, draw.between(1.0, 20.0), draw.between(10.0, 60.0), draw.between(30.0, 150.0)),
        "friction_angle": draw.one_of(0.0, draw.between(5.0, 45.0), draw.between(15.0, 45.0)),
    }


def _layer(draw: Draw, geometry: Data) -> Data:
    """A layer with some properties of its own, anywhere in the soil."""
    own = {"density": (1600.0, 2400.0), "cohesion": (0.0, 80.0), "friction_angle": (5.0, 45.0), "youngs_modulus": (2e4, 2e5)}
    soil = {name: draw.between(*own[name]) for name in draw.generator.permutation(list(own))[: draw.whole(1, 3)].tolist()}
    ratios = draw.one_of({}, {}, {"S_R": draw.between(0.0, 1.0), "gamma": 2.0})
    return {"region": draw.one_of(_depth, _elevation, _lens)(draw, geometry), "soil": soil, **ratios}


def _depth(draw: Draw, geometry: Data) -> Data:
    top = draw.length(0.0, 4.0)
    return {"kind": "depth", "top": top, "bottom": draw.one_of(None, top + draw.length(2.0, 5.0))}


def _elevation(draw: Draw, geometry: Data) -> Data:
    bottom = geometry.get("base", 0.0) + draw.length(0.0, 6.0)
    return {"kind": "elevation", "bottom": draw.one_of(None, bottom), "top": bottom + draw.length(2.0, 6.0)}


def _lens(draw: Draw, geometry: Data) -> Data:
    """A quadrangle about the middle of the scene."""
    xs = [x for x, _ in geometry.get("points", ())] or [0.0, 30.0]
    x, z = 0.5 * (min(xs) + max(xs)), geometry.get("base", 0.0)
    low, high = z + draw.length(0.0, 3.0), z + draw.length(5.0, 9.0)
    return {
        "kind": "polygon",
        "points": [
            [x - draw.length(4.0, 12.0), low],
            [x + draw.length(4.0, 12.0), low],
            [x + draw.length(1.0, 8.0), high],
            [x - draw.length(1.0, 8.0), high],
        ],
    }


def _motion(draw: Draw, record: bool) -> Data:
    """A sine, a pulse, a record with or without a vertical component, or no shaking."""
    start = GRAVITY_STAGE + draw.one_of(0.0, 0.25)
    amplitude = draw.between(0.5, 9.0)
    kind = "record" if record else draw.one_of("tapered_sine", "tapered_sine", "velocity_pulse", "record", "record", "none")
    if kind == "tapered_sine":
        times = {"start": start, "ramp": 0.25, "decay_start": start + 0.75, "end": start + 1.25}
        return {"kind": kind, "amplitude": amplitude, "frequency": draw.one_of(1.0, 2.0, 3.3), **times}
    if kind == "velocity_pulse":
        return {"kind": kind, "amplitude": amplitude, "frequency": draw.one_of(1.5, 2.5), "start": start}
    if kind == "none":
        return {"kind": kind}
    both = draw.one_of(True, False)
    samples = {"interval": draw.one_of(0.02, 0.04), "x": _samples(draw), **({"y": _samples(draw)} if both else {})}
    scale = draw.one_of({"amplitude": max(amplitude, 1.0)}, {"factor": draw.one_of(1.0, -2.0)})  # a smaller one may be meant in g
    return {"kind": kind, "start": start, "data": samples, **scale, **({"vertical": {"factor": 0.5}} if both else {})}


def _samples(draw: Draw) -> list[float]:
    """Thirty samples (m/s2) with two digits behind the point, of a motion that begins and ends with nothing."""
    at = np.linspace(0.0, 1.0, 30)
    wave = sum(draw.between(-1.5, 1.5) * np.sin(2.0 * np.pi * (k * at + draw.between(0.0, 1.0))) for k in (1, 2, 3, 5))
    return [round(value, 2) for value in (wave * np.sin(np.pi * at)).tolist()]
