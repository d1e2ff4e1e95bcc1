"""The scene with strain-compatible stiffness: its own column against the sublayered one, by the library; and all that has to stay."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from sph.command.compatible import WITHIN, Written, bands_of, compatible, stiffened, write_compatible
from sph.command.site import GRAVITY, Part, Response, Site, Stratum, column, darendeli, place_of, respond, shaking
from sph.scene.configuration import merge
from sph.scene.natural_periods import Column, natural_frequencies, natural_frequency, strata_at
from sph.scene.schema import Scene, load_scene, make_scene
from sph.solver.particles import peak_strength, place_particles

site, propagation, output, motions = (pytest.importorskip(f"pystrata.{name}") for name in ("site", "propagation", "output", "motion"))
ROCK = {"density": 2400.0, "s_wave_speed": 900.0, "p_wave_speed": 1800.0}
DEEP: dict[str, Any] = {
    "name": "deep",
    "scheme": "paper",
    "duration": 6.0,
    "geometry": {"shape": "ground_line", "points": [[100, 50], [140, 50], [160, 60], [220, 60]], "base": 30},
    "soil": {"density": 1900.0, "poisson_ratio": 0.3, "shear_wave_speed": 218.0},
    "layers": {"lens": {"region": {"kind": "polygon", "points": [[100, 32], [130, 32], [130, 40], [100, 40]]}, "soil": {"cohesion": 99.0}}},
    "gravity": {"ramp": 0.5, "duration": 1.0},
    "walls": {"base": "absorbing", "sides": "absorbing", "layers": 4, "bedrock": ROCK},
    "motion": {"kind": "tapered_sine", "amplitude": 1.5, "frequency": 1.5, "start": 1.0, "ramp": 0.5, "decay_start": 4.0, "end": 5.0},
    "numerics": {"spacing": 1.0, "time_step": 1e-2},
}


def responded(data: dict[str, Any], plasticity: float = 0.0, at: float | None = None) -> tuple[Scene, Site, Written]:
    scene = make_scene(data)
    found = respond(scene, darendeli(plasticity, 1.0), at)
    return scene, found, compatible(data, scene, found)


@pytest.fixture(scope="module")
def deep() -> tuple[Scene, Site, Written]:
    return responded(DEEP)


class Rayleigh(site.Layer):  # type: ignore[misc,name-defined]
    """The library's layer, with Rayleigh damping: factors of the modulus and of the density for each frequency."""

    stiff = heavy = 1.0

    @property
    def comp_shear_mod(self) -> Any:
        return self.shear_mod * self.stiff

    @property
    def comp_shear_vel(self) -> Any:
        return np.sqrt(self.comp_shear_mod / self.density / self.heavy)


def by_the_library(scene: Scene, x: float) -> tuple[float, float]:
    """Peak acceleration of the surface (m/s2) and largest effective strain of a scene's column, of its moduli and its damping."""
    assert scene.damping is not None
    step = scene.numerics.time_step
    shaken = np.pad(shaking(scene) / GRAVITY, (0, shaking(scene).size))
    motion = motions.TimeSeriesMotion("", "", step, shaken)
    omega = np.maximum(motion.angular_freqs, 1e-9)
    layers = []
    for each in column(scene, x):
        count = int(np.ceil((each.bottom - each.top) / 0.5))
        for _ in range(count):
            layer = Rayleigh(site.SoilType("", each.weight, None, 0.0), (each.bottom - each.top) / count, each.speed)
            layer.stiff = 1.0 + 1j * omega * scene.damping.stiffness_coefficient
            layer.heavy = 1.0 - 1j * scene.damping.mass_coefficient / omega
            layers.append(layer)
    rock = scene.walls.bedrock
    below = site.Layer(site.SoilType("", 2e-2 * GRAVITY, None, 0.0), 0.0, 1e6)  # rigid, nearly
    if rock is not None:
        below = site.Layer(site.SoilType("", 1e-3 * rock.density * GRAVITY, None, 0.0), 0.0, rock.s_wave_speed)
    profile = site.Profile([*layers, below])
    profile.update_layers()
    calculator = propagation.LinearElasticCalculator()
    calculator(motion, profile, profile.location("outcrop" if rock else "within", index=-1))
    top = output.AccelerationTSOutput(output.OutputLocation("outcrop", index=0))
    top(calculator)
    places = (profile.location("within", depth=each.depth_mid) for each in layers)
    tops = [motion.calc_peak(calculator.calc_strain_tf(calculator.loc_input, place)) for place in places]
    return GRAVITY * float(np.abs(top.values).max()), 0.65 * float(max(tops))


CASES: dict[str, tuple[dict[str, Any], float, float | None]] = {
    "sand to 30 m": ({}, 0.0, None),
    "on a rigid base": ({"walls": {"base": "no_slip", "sides": "free_slip", "bedrock": None}, "motion": {"amplitude": 0.6}}, 0.0, None),
    "on the same soil": ({"walls": {"bedrock": None}}, 0.0, None),
    "before the toe": ({"motion": {"amplitude": 2.5}}, 0.0, 135.0),
    "clay on sand": (
        {
            "layers": {"clay": {"region": {"kind": "elevation", "bottom": 48.0}, "soil": {"shear_wave_speed": 130.0, "density": 1700.0}}},
            "motion": {"amplitude": 0.7},
        },
        15.0,
        None,
    ),
}


@pytest.mark.parametrize("case", [name if name == "clay on sand" else pytest.param(name, marks=pytest.mark.long) for name in CASES])
def test_the_written_scene_is_shaken_as_the_sublayered_column(case: str, tmp_path: Path) -> None:
    """First mode, peak acceleration of the surface and largest strain of the file that is written, by the library, within 5 %."""
    changes, plasticity, at = CASES[case]
    _, found, made = responded(merge(DEEP, changes), plasticity, at)
    write_compatible(tmp_path / "made.yaml", made, found)
    scene = load_scene(tmp_path / "made.yaml")
    parts = [(each.stratum, part) for each in found.layers for part in each.parts]
    sublayers = [(part.bottom - part.top, of.speed * part.reduction**0.5, 1e3 * of.weight / GRAVITY) for of, part in parts]
    wanted = (float(natural_frequencies(Column(*np.array(sublayers).T))[0]), found.peak, max(each.worst.strain for each in found.layers))
    assert wanted == pytest.approx(made.wanted, rel=1e-6)
    got = (natural_frequency(scene, place_of(scene, at)), *by_the_library(scene, found.x))
    assert got == pytest.approx(made.achieved, rel=0.01), "the command's own figures"
    assert got == pytest.approx(wanted, rel=WITHIN) and made.within
    reductions = [part.reduction for each in found.layers for part in each.parts]
    assert max(reductions) > 1.5 * min(reductions), "one modulus would not do"


def test_one_mean_modulus_is_another_column(deep: tuple[Scene, Site, Written]) -> None:
    """What was written before bands: the arithmetic mean makes the first mode a quarter too high."""
    scene, found, made = deep
    mean = float(np.mean([part.reduction for each in found.layers for part in each.parts]))
    assert scene.soil.s_wave_speed * mean**0.5 / 120.0 > 1.2 * made.wanted.frequency


def test_layers_that_the_column_does_not_meet_keep_their_stiffness_and_are_named(deep: tuple[Scene, Site, Written]) -> None:
    scene, _, made = deep
    assert made.untouched == ["lens"] and made.scene.layers["lens"].soil.s_wave_speed == pytest.approx(218.0)
    assert made.scene.layers["lens"].soil == scene.layers["lens"].soil
    assert DEEP["soil"]["shear_wave_speed"] == 218.0, "the scene that was given stays"
    assert made.split == {"soil": [name for name in made.scene.layers if name.startswith("soil_")]} and made.split["soil"]


def sublayered(scene: Scene, reductions: np.ndarray) -> Site:
    """A response with given moduli, from the top, in parts of half a metre."""
    layers, used = [], 0
    for each in column(scene):
        count = int(np.ceil((each.bottom - each.top) / 0.5))
        ends = np.linspace(each.top, each.bottom, count + 1).tolist()
        values = np.resize(reductions, used + count)[used:]
        layers.append(Response(Stratum(*each), [Part(a, b, 1e-3, float(r), 0.05) for a, b, r in zip(ends, ends[1:], values, strict=False)]))
        used += count
    return Site(160.0, layers, 2.0, 3.0, 1.5)


REGIONS: dict[str, dict[str, Any]] = {
    "depth": {"kind": "depth", "top": 3.0, "bottom": 17.0},
    "elevation": {"kind": "elevation", "bottom": 43.0, "top": 57.0},
    "polygon": {"kind": "polygon", "points": [[120, 40], [220, 43], [220, 57], [150, 55], [120, 50]]},
}


@settings(max_examples=8, deadline=None)
@given(
    st.lists(st.floats(0.05, 1.0), min_size=3, max_size=30), st.sampled_from([*REGIONS]), st.sampled_from([1.1, 1.5, 4.0]), st.booleans()
)
def test_bands_change_the_stiffness_alone(values: list[float], region: str, largest: float, grows: bool) -> None:
    """Of any profile of moduli: strength, density and lattice of every particle stay, and in the column each band has its modulus."""
    clay: dict[str, Any] = {"undrained_strength": {"at_top": 30.0, "gradient": 2.0} | ({} if region == "depth" else {"datum": 57.0})}
    layer = {"region": REGIONS[region], "soil": (clay if grows else {"cohesion": 20.0}) | {"density": 1700.0}, "S_R": 0.4}
    data = merge(DEEP, {"layers": {"clay": layer}, "numerics": {"spacing": 2.0}})
    scene = make_scene(data)
    found = sublayered(scene, np.array(values))
    bands = bands_of(scene, found, largest)
    for inside in bands.values():
        assert all(band.bottom - band.top >= scene.numerics.spacing * (1.0 - 1e-9) for band in inside)
    stiff, *_ = stiffened(data, scene, found, largest)
    new = make_scene(stiff)
    before, after = place_particles(scene), place_particles(new)
    np.testing.assert_array_equal(before.mass, after.mass)
    np.testing.assert_allclose(peak_strength(scene, before), peak_strength(new, after), rtol=1e-7)
    ratios = np.array([0.4 if name.startswith("clay") else scene.coupling.S_R for name in ("soil", *new.layers)])
    assert (ratios[after.layer] == np.array([scene.coupling.S_R, scene.coupling.S_R, 0.4])[before.layer]).all()
    for number, depth, modulus in ((n, 0.5 * (b.top + b.bottom), b.modulus) for n, own in bands.items() for b in own):
        here = next(each for each in strata_at(new, place_of(new)) if each.bottom >= depth)
        if next(each for each in strata_at(scene, place_of(scene)) if each.bottom >= depth).number == number:
            assert new.soils[here.number].youngs_modulus == modulus


GROWING = {"undrained_strength": {"at_top": 30.0, "gradient": 2.0}, "friction_angle": None, "cohesion": None}
DRAWN = {"of": "layers.clay.soil.cohesion", "kind": "normal", "mean": 99.0, "sd": 1.0}
BELOW = {"clay": {"region": {"kind": "elevation", "bottom": 40.0, "top": 57.0}, "soil": GROWING}}


def test_strength_that_grows_from_the_ground_stays_without_layers() -> None:
    data = merge({**DEEP, "layers": {}}, {"soil": GROWING})
    scene = make_scene(data)
    made = make_scene(stiffened(data, scene, sublayered(scene, np.geomspace(1.0, 0.1, 60)), 1.5)[0])
    assert len(made.layers) > 3
    np.testing.assert_allclose(*(peak_strength(each, place_particles(each)) for each in (scene, made)), rtol=1e-7)


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"soil": GROWING}, "soil: sph site --out divides soil into layers.*give the growth a datum"),
        ({"layers": BELOW}, "layers.clay.soil: sph site --out divides clay.*give the growth a datum"),
        (
            {
                "layers": {"clay": {"region": REGIONS["depth"]}},
                "uncertain": {"seed": 1, "variables": {"c": DRAWN | {"of": "layers.clay.soil.cohesion"}}},
            },
            "divides clay into layers.*layers.clay.soil.cohesion would not be drawn",
        ),
    ],
)
def test_bands_in_which_the_soil_would_not_be_what_it_was_are_refused(changes: dict[str, Any], words: str) -> None:
    data = merge(DEEP, changes)
    scene = make_scene(data)
    with pytest.raises(ValueError, match=words):
        stiffened(data, scene, sublayered(scene, np.geomspace(1.0, 0.1, 60)), 1.5)
