"""What of the layers of a scene its particles do not resolve, found before a run: thin layers, and those that are not continuous."""

from __future__ import annotations

import itertools
from collections.abc import Iterable
from typing import Any, NamedTuple

import numpy as np

from sph.checks.after_run import BRAKED
from sph.checks.cover_rows import FACTOR_ERROR, HELD_BELOW, Cover, covers, enough_rows, rows_in_time, strata
from sph.checks.finding import Finding, finding
from sph.scene.geometry import Bodies
from sph.scene.schema import Scene
from sph.scene.soil import Soil
from sph.solver.particles import Particles, place_particles
from sph.solver.physics.interface import soil_numbers
from sph.solver.physics.seams import seam_sides
from sph.stability.extrapolation import UNASKED_RATIO, unasked_spacings
from sph.stability.safety import DEFAULT_RULE
from sph.stability.standing import dividing, slope_height

MIN_IN_LAYER = 4
"""Particles across a layer: a kernel of h = 1.3 spacings reaches 2.6 to either side, and mixes a thinner one with its neighbours."""
MAX_GAP = 0.25
"""Share of a layer's columns at its ends, where it thins out to nothing, that may be without a particle."""


class Layer(NamedTuple):
    """The soil particles of one material."""

    name: str
    soil: Soil
    particles: int
    thickness: float  # that three quarters of its columns exceed, particles


class Section(NamedTuple):
    """A layer in the columns of the lattice."""

    thickness: np.ndarray  # (columns,) vertically, as the scene has it, m; 0 where it is not
    particles: np.ndarray  # (columns,) number of its soil particles


class Needed(NamedTuple):
    """Rows of particles across a layer that needs a number of them."""

    name: str
    rows: float
    enough: int
    thickness: float  # m
    purpose: str = "needed"

    @property
    def spacing(self) -> float:
        """The largest with which it has enough, m."""
        return self.thickness / self.enough


def layers_of(scene: Scene, particles: Particles) -> list[Layer]:
    """The materials with their particles."""
    layers = []
    for number, (name, soil) in enumerate(zip(("soil", *scene.layers), scene.soils, strict=True)):
        counts = _in_columns(scene, particles, number)
        columns = counts[counts > 0]
        layers.append(Layer(name, soil, int(columns.sum()), float(np.percentile(columns, 25)) if columns.size else 0.0))
    return layers


def of_layers(scene: Scene, particles: Particles) -> list[Finding]:
    """A finding for each layer that is thin, an error instead for each that its particles do not make continuous, and for each weak soil
    on stronger ground what its rows of particles do to what sets it off and to its run-out."""
    others, cut = [], broken(scene, particles)
    left_out = {each.subject for each in cut}
    weak = [cover for cover in covers(scene) if cover.name not in left_out]
    left_out |= {cover.name for cover in weak}
    if scene.numerics.interfaces == "both" and not weak and len(set(soil_numbers(scene))) > 1:
        rows = min(layer.thickness for layer in layers_of(scene, particles))
        others.append(finding("weak-on-strong", "numerics.interfaces", rows=rows, both=True))
    for layer in layers_of(scene, particles):
        if layer.thickness < MIN_IN_LAYER and layer.name not in left_out:
            keys = ("numerics.spacing", *([f"layers.{layer.name}.region"] if layer.name in scene.layers else []))
            others.append(finding("thin-layer", *keys, subject=layer.name, value=layer.thickness, bound=MIN_IN_LAYER))
    return cut + [of_cover(cover, scene) for cover in weak] + others


def needed_rows(scene: Scene, particles: Particles) -> list[Needed]:
    """Rows in each weak soil on stronger ground whose need is known, and in each other layer that has too few."""
    weak = covers(scene)
    needs = [(cover, HELD_BELOW if cover.held else enough_rows(cover.law)) for cover in weak]
    found = [
        Needed(cover.name, cover.rows, enough, cover.thickness, "needed for its run-out alone" if cover.late else "needed")
        for cover, enough in needs
        if enough is not None
    ]
    others = [layer for layer in layers_of(scene, particles) if layer.name not in {cover.name for cover in weak}]
    dx = scene.numerics.spacing
    return found + [
        Needed(layer.name, layer.thickness, MIN_IN_LAYER, layer.thickness * dx) for layer in others if 0.0 < layer.thickness < MIN_IN_LAYER
    ]


def braked(scene: Scene) -> list[Finding]:
    """Those with which displacement and run-out of a run of the scene are lower bounds."""
    return [each for each in of_layers(scene, place_particles(scene)) if each.code in BRAKED]


def of_cover(cover: Cover, scene: Scene) -> Finding:
    """What the rows of particles in weak soil on stronger ground do to what sets it off and to its run-out: a note where they suffice."""
    name, numbers = cover.name, dict[str, Any]()
    if cover.held:
        numbers = {"value": cover.rows, "bound": HELD_BELOW, "thickness": cover.thickness}
        return finding("layer-held", "numerics.spacing", f"seams.{name}", subject=name, **numbers)
    numbers = {"value": cover.run_out, "ground": cover.ground, "rows": cover.rows, "thickness": cover.thickness, "factor": cover.factor}
    if cover.seamed:
        return finding("cover-on-seam", "seams", subject=name, **numbers)
    if not cover.short and cover.late:
        numbers |= {"value": cover.factor, "bound": 1.0 + FACTOR_ERROR, "in_time": rows_in_time()}
        return finding("cover-late", "numerics.spacing", f"seams.{name}", subject=name, between=cover.between, **numbers)
    if not cover.short:
        return finding("cover-rows", subject=name, between=cover.between, **numbers)
    if (enough := enough_rows(cover.law)) is not None:
        return finding(
            "weak-on-strong",
            "numerics.spacing",
            f"seams.{name}",
            subject=name,
            bound=1.0,
            enough=enough,
            in_time=rows_in_time(),
            **numbers,
        )
    both = scene.numerics.interfaces == "both"
    keys = ("numerics.interfaces",) if both else ("coupling.gamma", "coupling.softening.slip_at_residual")
    return finding("weak-on-strong", *keys, subject=name, bound=1.0, both=both, **numbers)


def broken(scene: Scene, particles: Particles) -> list[Finding]:
    """An error for each layer that is continuous in the scene and not in its particles, where weak soil has no slip surface."""
    dx = scene.numerics.spacing
    findings = []
    for name, section in sections(scene, particles).items():
        there, filled = section.thickness > 0.0, section.particles > 0
        if _is_continuous(section, dx):
            continue
        thickness = float(np.median(section.thickness[there])) if there.any() else 0.0
        columns, crossed = int(np.count_nonzero(there & filled)), int(np.count_nonzero(there))
        share = {"value": min(columns / crossed, thickness / dx), "bound": 1.0} if crossed else {}
        numbers = {"particles": int(section.particles.sum()), "columns": columns, "crossed": crossed, "thickness": thickness, "spacing": dx}
        keys = ("numerics.spacing", f"layers.{name}.region", f"seams.{name}")
        findings.append(finding("layer-broken", *keys, subject=name, **share, **numbers))
    return findings


def seam_rows(scene: Scene, particles: Particles) -> list[tuple[str, str]]:
    """Name of each seam and, in words, how long it is in the soil, how many rows of particles it is made of, and its logged thickness."""
    side, _, _ = seam_sides(scene, particles)
    told = []
    for number, (name, seam) in enumerate(scene.seams.items(), 1):
        length, on_it = scene.length_in_soil(seam), int(np.count_nonzero(np.abs(side[: particles.n_soil]) == number))
        rows = on_it * scene.numerics.spacing / length
        logged = (
            "no thickness given" if seam.thickness is None else f"thickness {seam.thickness:g} m as logged (not used in the computation)"
        )
        told.append((name, f"{length:.3g} m in the soil, {rows:.2g} rows of particles ({on_it:,}) slide along it; {logged}"))
    return told


def broken_at(scene: Scene, spacings: Iterable[float]) -> list[Finding]:
    """Layers that are continuous at the scene's spacing and broken at others (m), as searches of its stability take them; each once."""
    there = {each.subject for each in broken(scene, place_particles(scene))}
    by_layer: dict[str, Finding] = {}
    for spacing in spacings:
        other = scene.model_copy(update={"numerics": scene.numerics.model_copy(update={"spacing": spacing})})
        for each in broken(other, place_particles(other)):
            if each.subject not in there:
                by_layer.setdefault(each.subject, each)
    return list(by_layer.values())


def unbroken(scene: Scene, spacing: float) -> float:
    """The coarsest spacing (m), no coarser than this, that divides the slope's height and breaks no layer which is whole in the scene."""
    height = slope_height(scene)
    rows = itertools.count(round(height / dividing(spacing, height)))
    return next(finer for finer in (height / each for each in rows) if not broken_at(scene, [finer]))


def own_spacings(scene: Scene) -> tuple[float, float]:
    """Coarse and fine spacing (m) of a search beside the runs of a scene: twice their own and that, finer where that breaks a layer."""
    coarse, fine = unasked_spacings(scene, scene.numerics.spacing, DEFAULT_RULE)
    coarse = unbroken(scene, coarse)
    return coarse, unbroken(scene, min(fine, coarse / UNASKED_RATIO))


def _is_continuous(section: Section, spacing: float) -> bool:
    """Whether a layer is a spacing thick, mostly, and has a particle in all columns but at its ends, where it thins out.

    Of a thinner one the place of the lattice decides whether it is a row of particles, dots or nothing.
    """
    there = section.thickness > 0.0
    thick, gap = section.thickness > spacing * (1.0 - 1e-9), there & (section.particles == 0)
    if not section.particles.any() or 2 * np.count_nonzero(thick) < np.count_nonzero(there):
        return False
    parts = np.split(np.arange(there.size), np.flatnonzero(np.diff(there)) + 1)  # of the section, and of what lies between
    return not any(_is_cut(thick[part], gap[part]) for part in parts) and bool(gap.sum() <= MAX_GAP * there.sum())


def _is_cut(thick: np.ndarray, gap: np.ndarray) -> bool:
    """Whether there is a column without a particle between two in which a layer is thick."""
    between = np.maximum.accumulate(thick) & np.maximum.accumulate(thick[::-1])[::-1]
    return bool((gap & between).any())


def sections(scene: Scene, particles: Particles) -> dict[str, Section]:
    """The layers in the columns of the lattice, by name, the later one where two overlap; none of bodies, which have no section."""
    if isinstance(scene.geometry, Bodies) or not scene.layers:
        return {}
    _, part, number = strata(scene)
    return {
        name: Section(np.where(number == index, part, 0.0).sum(axis=0), _in_columns(scene, particles, index))
        for index, name in enumerate(scene.layers, 1)
    }


def _in_columns(scene: Scene, particles: Particles, number: int) -> np.ndarray:
    """Soil particles (columns,) of a material in the columns of the lattice."""
    x = particles.x[: particles.n_soil][particles.layer[: particles.n_soil] == number]
    columns = np.round(x / scene.numerics.spacing - 0.5).astype(int)
    return np.bincount(columns, minlength=scene.lattice[0])
