"""The scene with the strain-compatible stiffness and damping of a column (``sph site --out``).

The modulus of a layer runs over a factor of ten where shaking is strong, and a mean of it is no layer's: each layer of the column is
divided into bands of nearly one modulus, as few as reproduce the first mode of the sublayered column, and the peak acceleration of its
surface and its largest strain.  A band has the modulus of the mean compliance, so that it is sheared as much as its sublayers.  The scene
has one Rayleigh damping for all: its lower frequency is the first mode, and ratio and upper frequency are fitted to the two peaks.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from itertools import count
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import scipy  # type: ignore[import-untyped]
import shapely
import yaml

from sph.command.outputs import check_writable
from sph.command.site import COLUMNS, Part, Site, darendeli, place_of, record, respond, rows, shaking
from sph.command.site import lines as response_lines
from sph.command.terminal import say, table
from sph.scene.configuration import merge, scene_files
from sph.scene.laboratory import SPEED, UNDRAINED
from sph.scene.layers import DepthRegion, ElevationRegion
from sph.scene.natural_periods import Column, impedance_below, natural_frequencies, natural_frequency, strata_at, transfer
from sph.scene.schema import RayleighDamping, Scene, make_scene, written_scene
from sph.scene.strict_json import to_json

WITHIN = 0.05
"""Largest relative difference of the scene that is written from the sublayered column: of its first mode, the peak acceleration of its
surface and its largest strain."""
RANGES = (1.5, 1.25, 1.1)
"""Largest over smallest modulus in a band, tried in this order until the scene is within."""
EFFECTIVE = 0.65
"""Effective over largest shear strain (Schnabel, Lysmer and Seed 1972)."""
RATIOS, SPANS = (1e-3, 0.5), (1.5, 50.0)
"""Bounds of the damping ratio, and of its upper frequency over the lower one."""
MAX_NAME = 28
"""Letters of a layer's name that those of its bands keep."""


class Band(NamedTuple):
    """Neighbouring sublayers of one of the scene's soils."""

    top: float  # depth below the ground, m
    bottom: float  # m
    modulus: float  # Young's, kPa
    parts: list[Part]


class Response(NamedTuple):
    """What is compared."""

    frequency: float  # of the first mode on a rigid base, Hz
    peak: float  # acceleration of the surface, m/s2
    strain: float  # largest effective shear strain


class Written(NamedTuple):
    """A scene that was made, and what it is compared with."""

    data: dict[str, Any]
    scene: Scene
    wanted: Response  # of the sublayered column
    achieved: Response  # of the column of the scene, with its damping
    untouched: list[str]  # the soil and layers that the column does not meet
    split: dict[str, list[str]]  # layers with the names of their bands

    @property
    def off(self) -> Response:
        """Relative differences."""
        return Response(*(own / wanted - 1.0 for own, wanted in zip(self.achieved, self.wanted, strict=True)))

    @property
    def within(self) -> bool:
        """Whether all of them are at most ``WITHIN``."""
        return max(map(abs, self.off)) <= WITHIN


def site(path: Path, changes: Mapping[str, Any], at: float | None, plasticity: float, ocr: float, out: Path | None, as_json: bool) -> str:
    """The response of a column of the scene in a file, and the scene with its stiffness and damping where asked for."""
    data = merge(written_scene(path), changes)
    scene = make_scene(data, str(path))
    if out is not None:
        check_writable(out, [path, *scene_files(data)])
    site_response = respond(scene, darendeli(plasticity, ocr), at)
    told = [table(COLUMNS, rows(scene, site_response)), *response_lines(site_response)]
    if out is not None:
        made = compatible(data, scene, site_response)
        write_compatible(out, made, site_response)
        if not made.within:
            say(f"{out}: differs by more than {100 * WITHIN:g} % from the sublayered column; choose a smaller numerics.spacing")
        told += [*lines(made), f"{out}: written; look at it with sph check {out}"]
    return to_json(record(site_response), indent=1) if as_json else "\n".join(told)


def compatible(data: Mapping[str, Any], scene: Scene, site_response: Site) -> Written:
    """The scene with the strain-compatible stiffness and damping of a column; ValueError for what cannot be divided into bands."""
    for largest in RANGES:
        stiff, untouched, split = stiffened(data, scene, site_response, largest)
        made = Written(*damped(stiff, scene, site_response), untouched, split)
        if made.within:
            break
    return made


def bands_of(scene: Scene, site_response: Site, largest: float) -> dict[int, list[Band]]:
    """Bands of each of the scene's soils in the column, from the top, at least a spacing thick, with moduli within a factor ``largest``."""
    parts: dict[int, list[Part]] = {}
    for each in site_response.layers:
        parts.setdefault(each.stratum.number, []).extend(each.parts)
    return {
        number: [*_bands(inside, scene.soils[number].youngs_modulus, scene.numerics.spacing, largest)] for number, inside in parts.items()
    }


def _bands(parts: Sequence[Part], modulus: float, thinnest: float, largest: float) -> Iterator[Band]:
    first = 0
    for last in range(1, len(parts) + 1):
        inside, rest = parts[first:last], parts[last:]
        next_one = [each.reduction for each in parts[first : last + 1]]
        alike = max(next_one) <= largest * min(next_one)
        if not rest or not alike and min(_thickness(inside), _thickness(rest)) >= thinnest * (1.0 - 1e-9):
            compliance = sum((each.bottom - each.top) / each.reduction for each in inside)
            yield Band(inside[0].top, inside[-1].bottom, float(f"{modulus * _thickness(inside) / compliance:.6g}"), [*inside])
            first = last


def _thickness(parts: Sequence[Part]) -> float:
    return sum(each.bottom - each.top for each in parts)


def stiffened(
    data: Mapping[str, Any], scene: Scene, site_response: Site, largest: float
) -> tuple[dict[str, Any], list[str], dict[str, list[str]]]:
    """The scene's mapping with the modulus of each band, not damped yet; layers that the column does not meet keep theirs.  Also which
    these are, and layers that are split with the names of their bands."""
    bands, names = bands_of(scene, site_response, largest), list(scene.layers)
    ground = scene.geometry.in_survey(*place_of(scene, site_response.x))[1]
    written = data.get("layers") or {}
    untouched = [name for number, name in enumerate(["soil", *names]) if number not in bands]
    made, layers, split = merge({}, data), dict[str, Any](), dict[str, list[str]]()
    for number, name in enumerate(["", *names]):
        holder = data if number == 0 else written[name]
        own = bands.get(number, [])
        _check_split(scene, number, own)
        extra = _extra(scene, ground, holder, number, own, {*names, *layers})
        if number == 0:
            made["soil"] = _of_modulus(holder.get("soil") or {}, own[0].modulus) if own else holder.get("soil") or {}
        else:
            soil = holder.get("soil") or {}
            if own:
                soil = _of_modulus(soil, own[0].modulus)
            elif 0 in bands and not {SPEED, "youngs_modulus"} & {key for key, value in soil.items() if value is not None}:
                soil = {**soil, "youngs_modulus": scene.soils[number].youngs_modulus}
            layers[name] = {**holder, "soil": soil}
        layers |= extra
        if extra:
            split[name or "soil"] = list(extra)
    made |= {"layers": layers} if layers else {}
    if scene.walls.kinds.base.absorbs and scene.walls.bedrock is None:  # as the column was shaken: what goes on below is not strained
        lowest = scene.soils[site_response.layers[-1].stratum.number]
        rock = {"density": lowest.density, "s_wave_speed": lowest.s_wave_speed, "p_wave_speed": lowest.p_wave_speed}
        made = merge(made, {"walls": {"bedrock": {name: float(f"{value:.6g}") for name, value in rock.items()}}})
    return made, untouched, split


def _of_modulus(soil: Mapping[str, Any], modulus: float) -> dict[str, Any]:
    return {name: value for name, value in soil.items() if name != SPEED} | {"youngs_modulus": modulus}


def _check_split(scene: Scene, number: int, bands: Sequence[Band]) -> None:
    """Refuse bands in which the soil would not be what it was."""
    if len(bands) < 2:
        return
    name, soil, layers = ("soil", *scene.layers)[number], scene.soils[number], list(scene.layers.values())
    path = "soil" if number == 0 else f"layers.{name}.soil"
    why = f"sph site --out divides {name} into layers of other stiffness, in which"
    kept = isinstance(layers[number - 1].region, DepthRegion) if number else not layers
    if soil.cohesion_growth is not None and soil.cohesion_growth.datum is None and not kept:
        raise ValueError(f"{scene.name}: {path}: {why} the strength would grow from their own top; give the growth a datum")
    for variable in scene.uncertain.variables.values() if scene.uncertain else ():
        own = variable.of.startswith("soil.") and (variable.field is not None or bool(soil.gradient))
        if variable.of.startswith(f"layers.{name}.") or number == 0 and own:
            raise ValueError(
                f"{scene.name}: uncertain: {why} {variable.of} would not be drawn; leave uncertain out here, and write it again"
            )


def _extra(scene: Scene, ground: float, holder: Mapping[str, Any], number: int, bands: Sequence[Band], taken: set[str]) -> dict[str, Any]:
    """Layers over a soil or layer, of all its bands but the first, which it keeps itself, with what else it writes."""
    name = list(scene.layers)[number - 1] if number else "soil"
    free = (made for n in count(2) if (made := f"{name[:MAX_NAME]}_{n}") not in taken)
    extra = dict[str, Any]()
    for band, below in zip(bands[1:], [*bands[2:], None], strict=False):  # of one band the latter is longer
        soil = _of_modulus(_grown(scene, number, band.top, holder.get("soil") or {} if number else {}), band.modulus)
        for region in _regions(scene, ground, number, band.top, below and below.top):
            extra[next(free)] = (dict(holder) if number else {}) | {"region": region, "soil": soil}
    return extra


def _grown(scene: Scene, number: int, top: float, soil: Mapping[str, Any]) -> Mapping[str, Any]:
    """What a band writes of its soil: where the strength grows from the top of the soil, that at the top of the band."""
    grows = scene.soils[number].cohesion_growth
    if grows is None or grows.datum is not None:
        return soil
    region = list(scene.layers.values())[number - 1].region if number else None
    there = scene.soils[number].at_depth(top - (region.top if isinstance(region, DepthRegion) else 0.0))
    strength = {
        "cohesion": there.cohesion,
        "friction_angle": there.friction_angle,
        "cohesion_growth": {"gradient": grows.gradient, "datum": None},
    }
    return {name: value for name, value in soil.items() if name != UNDRAINED} | strength


def _regions(scene: Scene, ground: float, number: int, top: float, bottom: float | None) -> list[dict[str, Any]]:
    """Regions of a band between two depths in the column (None: as deep as its soil), below an elevation of the ground, m."""
    region = list(scene.layers.values())[number - 1].region if number else DepthRegion(kind="depth")
    if isinstance(region, DepthRegion):
        return [{"kind": "depth", "top": _digits(top), "bottom": region.bottom if bottom is None else _digits(bottom)}]
    if isinstance(region, ElevationRegion):
        lower = region.bottom if bottom is None else _digits(ground - bottom)
        return [{"kind": "elevation", "top": _digits(ground - top), "bottom": lower}]
    whole = shapely.Polygon(region.outline)
    left, lowest, right, _ = whole.bounds
    strip = whole.intersection(shapely.box(left, lowest if bottom is None else ground - bottom, right, ground - top))
    pieces = [piece for piece in getattr(strip, "geoms", [strip]) if isinstance(piece, shapely.Polygon) and piece.area > 0.0]
    return [{"kind": "polygon", "points": [[_digits(x), _digits(y)] for x, y in piece.exterior.coords[:-1]]} for piece in pieces]


def _digits(value: float, digits: int = 10) -> float:
    return float(f"{value:.{digits}g}")


def damped(stiff: Mapping[str, Any], scene: Scene, site_response: Site) -> tuple[dict[str, Any], Scene, Response, Response]:
    """A stiffened scene with the damping that fits best, as mapping and built; what is wanted of it, and what it achieves."""
    origin = f"{scene.name}, strain-compatible"
    made = make_scene(merge(stiff, {"damping": {"ratio": 0.0, "frequencies": [1.0, 2.0]}}), origin)
    place, sublayers = place_of(scene, site_response.x), [(each.stratum, part) for each in site_response.layers for part in each.parts]
    thickness = np.array([part.bottom - part.top for _, part in sublayers])
    density = np.array([scene.soils[stratum.number].density for stratum, _ in sublayers])
    speed = np.array([stratum.speed * math.sqrt(part.reduction) for stratum, part in sublayers])
    frequency = float(natural_frequencies(Column(thickness, speed, density))[0])
    wanted = Response(frequency, site_response.peak, max(each.worst.strain for each in site_response.layers))

    first = float(f"{natural_frequency(made, place):.4g}")
    strata = strata_at(made, place)
    middles = [0.5 * (part.top + part.bottom) for _, part in sublayers]
    soils = [made.soils[next(each.number for each in strata if each.bottom >= middle)] for middle in middles]
    column = Column(thickness, np.array([soil.s_wave_speed for soil in soils]), density)
    below, shaken = impedance_below(made, column), shaking(scene)

    def response(damping: RayleighDamping) -> Response:
        return Response(natural_frequency(made, place), *linear(column, below, damping, shaken, scene.numerics.time_step))

    def of(logarithms: np.ndarray, digits: int = 17) -> RayleighDamping:
        ratio, span = (_digits(value, digits) for value in np.exp(logarithms))
        return RayleighDamping(ratio=ratio, frequencies=(first, _digits(first * span, digits)))

    def off(logarithms: np.ndarray) -> list[float]:
        got = response(of(logarithms))
        return [got.peak / wanted.peak - 1.0, got.strain / wanted.strain - 1.0]

    bounds = np.log(np.transpose([RATIOS, SPANS]))
    start = np.log([np.clip(np.average([part.damping for _, part in sublayers], weights=thickness), *RATIOS), 5.0])
    damping = of(scipy.optimize.least_squares(off, start, bounds=bounds, diff_step=1e-3, ftol=1e-6).x, 4)
    data = merge(stiff, {"damping": damping.model_dump(mode="json")})
    return data, make_scene(data, origin), wanted, response(damping)


def linear(column: Column, below: float, damping: RayleighDamping, shaken: np.ndarray, step: float) -> tuple[float, float]:
    """Peak acceleration of the surface (m/s2) and largest effective shear strain of a column with Rayleigh damping under a motion (n,).

    The motion, m/s2 in steps of ``step`` s, is that of an outcrop of the half-space of an impedance ``below``, or of a rigid base.
    """
    size = scipy.fft.next_fast_len(2 * shaken.size, real=True)
    frequency = np.fft.rfftfreq(size, step)[1:]
    omega = 2.0 * math.pi * frequency
    transferred = transfer(column, frequency, 1.0 + 1j * omega * damping.stiffness_coefficient, 1.0 - 1j * damping.mass_coefficient / omega)
    surface = np.fft.rfft(shaken, size)[1:] / transferred.outcrop(below)
    spectra = np.vstack([surface, -transferred.strain * surface / omega**2])
    peaks = np.abs(np.fft.irfft(np.pad(spectra, ((0, 0), (1, 0))), size)).max(axis=1)
    return float(peaks[0]), EFFECTIVE * float(peaks[1:].max())


def lines(made: Written) -> list[str]:
    """What the scene that is written is, in words."""
    kinds = ("first mode", "PGA at the surface", "largest strain")
    off = ", ".join(f"{kind} {100 * value:+.1f} %" for kind, value in zip(kinds, made.off, strict=True))
    damping = made.scene.damping
    assert damping is not None
    told = [f"the written scene against the sublayered column: {off}"]
    told.append(f"its Rayleigh damping: {damping.ratio:.3g} at {damping.frequencies[0]:.3g} and {damping.frequencies[1]:.3g} Hz")
    for name, bands in made.split.items():
        told.append(
            f"{name} is divided: {', '.join([name, *bands])}, from the top; a study that varies keys of {name} has to vary all of them"
        )
    if made.untouched:
        told.append(f"not below this place, with their stiffness at small strain: {', '.join(made.untouched)}")
    return told


def write_compatible(path: Path, made: Written, site_response: Site) -> None:
    """Write the scene of ``compatible``, without the comments of the file that it was."""
    text = yaml.safe_dump(made.data, sort_keys=False, allow_unicode=True, width=140)
    head = [f"Stiffness and damping strain-compatible at x = {site_response.x:.10g} m, by sph site.", *lines(made)]
    path.write_text("".join(f"# {line}\n" for line in head) + text, encoding="utf-8")
