"""Runs of the landslide of the Eastern Iburi earthquake (``iburi.md``), beside a shallow flow of the same fluid.

``python docs/gallery/iburi.py`` makes the run of the scene as it is; names of ``CHANGES`` after it make those, and ``all`` every one.
"""

from __future__ import annotations

import sys

import numpy as np
import xarray as xr

import sph
from sph.measures.linked import largest_mass

FLUID = {"coupling": {"initial_state": "fluid"}, "gravity": {"ramp": 1.0, "duration": 1.0}, "motion": {"amplitude": 0.0}}
"""Nothing shakes and nothing fails, as in the inversion."""
PARABOLA = [[x, 0.286 * x + 7.36 * (1.0 - (2.0 * x / 80.0 - 1.0) ** 2)] for x in (5, 10, 20, 30, 40, 50, 60, 70, 75)]
LENS = {
    "geometry": {"points": [[-400, 0], [0, 0], *PARABOLA, [80, 22.9], [95, 22.9]], "crest_at": [80, 22.9]},
    "probes": {"A": [60.0, 20.0]},
}
"""A parabola in place of the slab, 7 m thick in its middle."""
LEVEL = FLUID | LENS | {"gravity": FLUID["gravity"] | {"inclination": 0.0}}
SHORT = {"duration": 80.0}
GROUND = {"region": {"points": [[0, 0], [80, 22.9], [80, 40], [0, 40]]}}
"""The cover is the soil that slides, and no deeper."""


def spacing(metres: float) -> dict:
    """Another spacing, with the cover 2.5 spacings into the hill."""
    foot, head = 8.7 * metres, 80.0 + 2.5 * metres
    region = {"points": [[0, 0], [foot, 0], [head, 22.9 / 80.0 * (head - foot)], [head, 40], [0, 40]]}
    return {"numerics": {"spacing": metres}, "layers": {"cover": {"region": region}}}


CHANGES = {
    "as in the file": {},
    "0.7 m": SHORT | spacing(0.7),
    "0.5 m": SHORT | spacing(0.5),
    "1200 kg/m3": SHORT | {"layers": {"cover": {"soil": {"density": 1200.0}}}},
    "1600 kg/m3": SHORT | {"layers": {"cover": {"soil": {"density": 1600.0}}}},
    "5 degrees below": SHORT | {"gravity": {"inclination": 5.0}},
    "800 Pa s": SHORT | {"layers": {"cover": {"soil": {"viscosity": 800.0}}}},
    "3000 Pa s": SHORT | {"layers": {"cover": {"soil": {"viscosity": 3000.0}}}},
    "hard": SHORT | {"motion": {"amplitude": "0.3g"}, "layers": {"cover": {"soil": {"cohesion": 55.0}}}},
    "strong ground, both": SHORT | {"geometry": {"base": -2.0}, "layers": {"cover": GROUND}},
    "strong ground, weaker": {"geometry": {"base": -2.0}, "layers": {"cover": GROUND}, "numerics": {"interfaces": "weaker"}},
    "fluid": SHORT | FLUID,
    "lens, fluid": SHORT | FLUID | LENS,
    "lens, fluid, level": SHORT | LEVEL,
    "lens, fluid, level, 0.5 m": SHORT | LEVEL | spacing(0.5),
}
"""Changes to the scene by name."""


def front(trajectory: xr.Dataset) -> tuple[np.ndarray, np.ndarray]:
    """Times of the frames (s) and how far the cover's main mass then reaches beyond the foot of the hill (m)."""
    scene = sph.scene_of(trajectory)
    soil = trajectory["kind"].values == 0
    cover = trajectory["layer"].values[soil] == 1
    reach = [
        scene.geometry.toe[0] - x[cover & largest_mass(x, y, 2.0 * scene.numerics.spacing)].min() + 0.5 * scene.numerics.spacing
        for x, y in zip(trajectory["x"].values[:, soil], trajectory["y"].values[:, soil], strict=True)
    ]
    return trajectory["time"].values, np.array(reach)


def numbers(time: np.ndarray, reach: np.ndarray) -> tuple[float, float, float]:
    """Run-out (m), largest speed of the front over 2 s (m/s), and time (s) from its first metre until it moves less than 0.5 m in 10 s."""
    speed = max((np.interp(time + 2.0, time, reach) - reach) / 2.0)
    going = time[(np.interp(time + 10.0, time, reach) - reach >= 0.5) & (time + 10.0 <= time[-1])]
    return reach[-1], speed, going[-1] + 10.0 - time[reach > reach[0] + 1.0][0] if going.size else 0.0


def shallow(
    viscosity: float = 1500.0, density: float = 1400.0, floor: float = 2.0, lens: bool = False, end: float = 240.0
) -> tuple[np.ndarray, np.ndarray]:
    """Times (s) and front (m beyond the foot) of a depth-averaged Bingham flow along one line, with columns that move with the fluid.

    The shear at the base is that of steady plane flow with the depth and mean speed of the column (as in Hungr 1995, Can. Geotech. J. 32,
    610-623): u = (h τ_b / 6 η) (2 - 3 a + a³) with a = τ_y / τ_b.  ``floor`` is the slope below the foot (degrees); the hill is 16 degrees
    steeper.
    """
    yield_stress, thickness, length, dt = 1500.0, 7.0, 80.0, 0.01
    s, u = np.linspace(-length, 0.0, 61), np.zeros(61)
    middle = 0.5 * (s[1:] + s[:-1])
    area = np.diff(s) * thickness * (1.0 - (2.0 * middle / length + 1.0) ** 2 if lens else np.ones(60))
    reach = []
    for _ in range(round(end / dt)):
        h = area / np.diff(s)
        depth = 0.5 * np.concatenate([h[:1], h[1:] + h[:-1], h[-1:]])
        rise = 2.0 * np.concatenate([h[:1] / np.diff(s)[:1], np.diff(h) / (s[2:] - s[:-2]), -h[-1:] / np.diff(s)[-1:]])
        angle = np.radians(np.where(s < 0.0, floor + 16.0, floor))
        u = u + dt * 9.81 * (np.sin(angle) - np.cos(angle) * rise)
        viscous = 3.0 * viscosity * dt / (density * depth**2)  # its part of the shear at the base is taken at the end of the step
        root = np.sqrt(1.0 + 2.0 * viscosity * np.abs(u) / (depth * yield_stress))
        share = 2.0 * root * np.cos(np.arccos(-(root**-3)) / 3.0 - 2.0 * np.pi / 3.0)  # a, of the cubic equation
        rest = np.maximum(dt * yield_stress / (np.maximum(share, 1e-9) * density * depth) - viscous * np.abs(u), 0.0)
        u = np.sign(u) * np.maximum(np.abs(u) - rest, 0.0) / (1.0 + viscous)
        s = s + dt * u
        reach.append(s[-1])
    return dt * np.arange(1, len(reach) + 1), np.array(reach)


def main(names: list[str]) -> None:
    """Print run-out, speed and duration of the runs and of the shallow flows, and draw the front."""
    import matplotlib.pyplot as plt

    figure, ax = plt.subplots(figsize=(7.5, 3.8), layout="constrained")
    ax.axhspan(75.0, 125.0, color="0.9", label="published run-out, with its tolerance")
    fronts = {f"shallow flow, {'lens' if lens else 'slab'}, {floor:g}°": shallow(floor=floor, lens=lens) for lens, floor in SHALLOW}
    for name in CHANGES if names == ["all"] else names or ["as in the file"]:
        fronts[name] = front(sph.run(sph.load_scene("docs/gallery/iburi.yaml", CHANGES[name])).trajectory)
    print("| flow | run-out (m) | speed of the front (m/s) | duration (s) |\n| --- | --- | --- | --- |")
    for name, (time, reach) in fronts.items():
        print("| " + " | ".join([name, *(f"{value:.4g}" for value in numbers(time, reach))]) + " |")
        ax.plot(time, reach, label=name)
    ax.set(xlabel="time (s)", ylabel="front beyond the foot of the hill (m)", xlim=(0.0, 100.0), ylim=(0.0, None))
    figure.legend(loc="outside right upper", fontsize="small")
    figure.savefig("fronts.png", dpi=150)
    speed = numbers(*fronts["shallow flow, slab, 2°"])[1]
    assert abs(speed / 12.5 - 1.0) < 0.02, speed
    if "as in the file" in fronts:
        speed = numbers(*fronts["as in the file"])[1]
        assert abs(speed / 14.3 - 1.0) < 0.05, speed


SHALLOW = ((False, 2.0), (True, 2.0), (True, 0.0))
"""Whether the shallow flow begins as a lens, and the slope below the foot (degrees)."""
if __name__ == "__main__":
    main(sys.argv[1:])
