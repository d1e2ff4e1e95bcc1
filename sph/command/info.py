"""Summary of a scene before it is run: sizes, wave speeds, limits, terms, expected cost."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from sph.checks.layers import seam_rows
from sph.checks.messages import sentence
from sph.checks.motion import frequency_rows, peak_accelerations
from sph.checks.scene import choices, findings, strengths, uncertain_rows, water_rows
from sph.command.given import read_given
from sph.command.terminal import aligned
from sph.experiments.variants.advice import expected_sentence
from sph.scene.schema import Scene
from sph.solver.cuda.ensemble import describe_card
from sph.solver.particles import BASE, SIDE, SOIL, TOP, locate_probes, place_particles
from sph.solver.terms import KEYS, wanted_terms
from sph.solver.time_step import limits
from sph.study.cost import ON_REFERENCE, cost, needs


def info(path: Path, changes: Mapping[str, Any]) -> str:
    """The summary of the scene in a file, with changes."""
    return aligned(describe(read_given(path, changes)[0]))


def describe(scene: Scene) -> list[tuple[str, str]]:
    """Pairs of label and text."""
    particles = place_particles(scene)
    numerics, soil = scene.numerics, scene.soil
    count = {kind: int(np.count_nonzero(particles.kind == kind)) for kind in (SOIL, BASE, SIDE, TOP)}
    lid = f", {count[TOP]:,} lid" if count[TOP] else ""
    expected, asked = cost(scene), needs(scene)
    smallest = min(limit.seconds for limit in limits(scene))
    step = numerics.time_step if numerics.adaptive_step is None else min(numerics.time_step, numerics.adaptive_step.courant * smallest)
    steps = round(scene.duration / step)
    n = particles.x.size
    rows = [
        ("scene", f"{scene.name}: {scene.title}"),
        ("scheme", scene.scheme),
        *((f"strength of {name}", text) for name, text in strengths(scene)),
        *choices(scene),
        ("particles", f"{n:,} ({count[SOIL]:,} soil, {count[BASE]:,} base, {count[SIDE]:,} side walls{lid})"),
        (
            "kernel",
            f"{numerics.kernel}, h = {numerics.smoothing_length:g} m, "
            f"{expected.neighbours:.0f} neighbours in {2 * numerics.smoothing_length:g} m",
        ),
        *(
            (
                f"layer {name}",
                f"{np.count_nonzero((particles.layer == number) & (particles.kind == SOIL)):,} particles, {its.soil.density:g} kg/m3, "
                f"V_s = {its.soil.s_wave_speed:.1f} m/s",
            )
            for number, (name, its) in enumerate(scene.layers.items(), 1)
        ),
        *((f"seam {name}", text) for name, text in seam_rows(scene, particles)),
        *uncertain_rows(scene, particles),
        *water_rows(scene),
        ("moduli", f"G = {soil.shear_modulus_si / 1e6:.1f} MPa, K = {soil.bulk_modulus_si / 1e6:.1f} MPa"),
        ("wave speeds", f"V_s = {soil.s_wave_speed:.1f} m/s, V_p = {soil.p_wave_speed:.1f} m/s"),
        *frequency_rows(scene),
        ("time step", f"{step:.3g} s, {steps:,} steps" + ("" if numerics.adaptive_step is None else ", adapts to the limit")),
    ]
    for limit in limits(scene):
        state = "ok" if step < limit.seconds else "EXCEEDED"
        rows.append((f"limit: {limit.name}", f"{limit.seconds:.2e} s ({limit.reason}): {state}, factor {limit.seconds / step:.1f}"))
    rows.append(
        ("limit: debris", "measured at every frame of a run, since particles that have left the lattice are stiffer (time_step_limit)")
    )
    on = wanted_terms(scene)
    rows.append(("active terms", "; ".join(f"{name} [{KEYS[name]}]" for name in on if on[name]) or "none"))
    rows.append(("not compiled", ", ".join(name for name in on if not on[name]) or "none"))
    if scene.walls.kinds.base.absorbs:
        depth = scene.walls.layers * numerics.spacing
        below = "the same soil" if scene.walls.bedrock is None else f"bedrock, V_s = {scene.walls.bedrock.s_wave_speed:g} m/s"
        rows.append(
            (
                "half-space",
                f"{below}, from {depth:g} m below the soil, which is so much deeper to waves; the motion is its outcrop motion",
            )
        )
    rows.append(("PGA", peak_accelerations(scene)))
    for name, index in locate_probes(scene, particles).items():
        x, y = scene.geometry.in_survey(float(particles.x[index]), float(particles.y[index]))
        rows.append((f"probe {name}", f"particle {index} at ({x:.10g}, {y:.10g}) m"))
    rows += [(finding.severity, f"{sentence(finding)} [{finding.code}]") for finding in findings(scene, particles)]
    rows.append(("expected error", expected_sentence(scene)))
    rows += [
        ("estimated cost", f"{expected.seconds:.3g} s {ON_REFERENCE} ({n * expected.steps / 1e6:.0f} M particle-steps), if the soil fails"),
        ("memory and disk", f"{expected.memory:.0f} MiB while it runs, {expected.disk:.1f} MiB for its trajectory"),
        ("cluster request", f"{asked.mem_mb} MB, {asked.runtime} min"),
        ("graphics card", describe_card()),
    ]
    return rows
