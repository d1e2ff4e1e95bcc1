"""A scene before it is run (``sph check``): its summary and findings."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import sph
from sph.checks.equilibrium import equilibrium_numbers, factor_below_1, found_equilibrium, slip_at_base, without_surface
from sph.checks.finding import Finding, called
from sph.checks.layers import Layer, layers_of, needed_rows, seam_rows
from sph.checks.liquefaction import of_liquefaction
from sph.checks.messages import factor_words, line, record, yield_words
from sph.checks.motion import frequency_rows, peak_accelerations
from sph.checks.scene import choices, findings, highest_frequency, in_wave, strengths, uncertain_rows, water_rows
from sph.checks.stability import stability
from sph.command.given import earlier_run, is_study, read_given
from sph.command.outputs import check_picture
from sph.command.study import find_study
from sph.command.terminal import aligned, say, table
from sph.command.watch import Shown, svg, watch
from sph.measures.metrics import MetricSettings
from sph.measures.places import PlaceAt, check_places
from sph.output.run import Run
from sph.scene.configuration import found_file, merge, read_yaml, validated
from sph.scene.geometry import SLOPES
from sph.scene.schema import Scene
from sph.scene.strict_json import to_json
from sph.solver.particles import Particles, locate_probes, place_particles
from sph.stability.slip_search import LimitEquilibrium
from sph.study.cost import ON_REFERENCE, cost
from sph.study.machine import duration

if TYPE_CHECKING:
    from matplotlib.figure import Figure


LIBRARY = Path(sph.__file__).parents[1]
"""Where the scenes of the repository are."""
Variants = dict[str, dict[str, list[Finding]]]
"""Findings by section of a study, and by the name of a fidelity or an alternative in it."""


class Check(NamedTuple):
    """A scene's particles and findings."""

    scene: Scene
    particles: Particles
    probes: dict[str, int]
    layers: list[Layer]
    equilibrium: LimitEquilibrium | None
    findings: list[Finding]


def answer(
    given: Path | None,
    changes: Mapping[str, Any],
    plot: Path | None,
    study: Path | None,
    static: bool,
    magnitude: float | None,
    as_json: bool,
    watching: bool = False,
) -> str | None:
    """The summary and the findings of the scene in a file, with changes, and of the fidelities and alternatives of a study; its picture,
    with the places of the study, where asked for.  A study alone names its scene.

    With a magnitude also whether such an earthquake liquefies or softens its layers.  None where section and findings were shown in the
    browser, and again whenever a file was saved, until the command was interrupted.
    """
    path, study = scene_and_study(given, study)
    if watching:
        others_asked = (("--plot", plot), ("--stability", static), ("--magnitude", magnitude), ("--json", as_json))
        asked = [name for name, value in others_asked if value]
        if asked:
            raise ValueError(f"--watch: shows section and findings in the browser; leave out {' and '.join(asked)}")
        watch(path, partial(shown, path, changes, study), say)
        return None
    earlier = earlier_run(path)
    scene, inputs = read_given(path, changes, earlier)
    if plot is not None:
        check_picture(plot, [*inputs, *([] if study is None else [study])], "--plot")
    places = {} if study is None else places_of(study, scene)
    checked = check(scene)
    if plot is not None:
        from sph.figures.style import save

        save(draw(checked, places, None if earlier is None or changes else Run(earlier, scene)), plot)
    others = in_variants(path, changes, study, checked.findings)
    liquefied = [] if magnitude is None else of_liquefaction(scene, checked.particles, magnitude)
    facts, layers, told = rows(checked), layer_rows(checked), (stability(scene) if static else []) + liquefied + checked.findings
    if as_json:
        named = [dict(zip(LAYER_COLUMNS, row, strict=True)) for row in layers]
        variants = {section: {name: [record(each) for each in of] for name, of in by_name.items()} for section, by_name in others.items()}
        findings = [record(each) for each in told]
        return to_json({"rows": dict(facts), "layers": named, "findings": findings, **variants}, indent=1)
    return "\n".join([aligned(facts), table(LAYER_COLUMNS, layers), *told_lines(told), *other_lines(others)])


def scene_and_study(given: Path | None, study: Path | None) -> tuple[Path, Path | None]:
    """The file of a scene and that of the study, if there is one; ValueError where neither is given, and where no scene is found."""
    if given is not None and study is None and is_study(given):
        given, study = None, given
    if given is not None:
        return given, study
    if study is None:
        raise ValueError("SCENE: is missing; give a scene, or a study, which names its scene")
    catalogue = find_study(study)
    return found_file([catalogue.base, LIBRARY], catalogue.plan.study.scene, f"{study}: scene"), study


def in_variants(path: Path, changes: Mapping[str, Any], study: Path | None, known: Sequence[Finding]) -> Variants:
    """Errors and warnings of the fidelities that a study runs, and of its alternatives, besides what is ``known`` of the scene as it is;
    ValueError for one that is refused."""
    written = {} if study is None else read_yaml(study)
    others: Variants = {}
    for section in ("fidelities", "alternatives"):
        keys = written.get(section) or {}
        if not isinstance(keys, Mapping) or not all(isinstance(each, Mapping) for each in keys.values()):
            raise ValueError(f"{study}: {section}: must be a section with a section of scene keys for each")
        run = keys if section == "alternatives" else (written.get("fidelity"), written.get("second_fidelity"))
        others[section] = {}
        for name in (name for name in keys if name in run and keys[name]):
            try:
                of = check(read_given(path, merge(changes, keys[name]))[0]).findings
            except ValueError as error:
                raise ValueError(f"{study}: {section}.{name}: {error}") from error
            others[section][name] = [each for each in of if each.counts and each not in known]
    return others


def other_lines(others: Variants) -> list[str]:
    """A line for each finding in a fidelity and in an alternative, and for one without more."""
    named = {f"fidelity {name}": told for name, told in others["fidelities"].items()} | others["alternatives"]
    return [f"{name}: {said}" for name, told in named.items() for said in (list(map(line, told)) or ["no further warnings"])]


def told_lines(told: Sequence[Finding]) -> list[str]:
    """A line for each finding, and where none counts that there is none."""
    return [*map(line, told), *["no warnings"] * (not any(each.counts for each in told))]


def shown(path: Path, changes: Mapping[str, Any], study: Path | None) -> Shown:
    """Section, findings and summary of the scene in a file for the browser."""
    scene, inputs = read_given(path, changes)
    checked = check(scene)
    figure = draw(checked, {} if study is None else places_of(study, scene))
    others = in_variants(path, changes, study, checked.findings)
    text = "\n".join([*told_lines(checked.findings), *other_lines(others), "", aligned(rows(checked))])
    return Shown(svg(lambda file: figure.savefig(file, format="svg")), text, [*inputs, *([] if study is None else [str(study)])])


def check(scene: Scene) -> Check:
    """Place the particles and look at the scene; ValueError for a probe away from the soil."""
    particles = place_particles(scene)
    equilibrium = found_equilibrium(scene)
    told = sorted(
        [
            *findings(scene, particles),
            *called(factor_below_1(scene, equilibrium), scene.soil.name),
            *slip_at_base(scene, equilibrium),
            *without_surface(scene, equilibrium),
        ],
        key=lambda each: each.rank,
    )
    return Check(scene, particles, locate_probes(scene, particles), layers_of(scene, particles), equilibrium, told)


def rows(checked: Check) -> list[tuple[str, str]]:
    """Pairs of label and text: the slope, sizes and cost."""
    scene, particles = checked.scene, checked.particles
    n, soil, geometry = particles.x.size, particles.n_soil, scene.geometry
    expected = cost(scene)
    lines = [
        ("scene", f"{scene.name}: {scene.title}"),
        ("box", f"{geometry.width:.6g} x {geometry.height:.6g} m"),
        ("scheme", scene.scheme),
        *((f"strength of {name}", text) for name, text in strengths(scene)),
        *choices(scene),
    ]
    if isinstance(geometry, SLOPES):
        toe, crest = (geometry.in_survey(*place) for place in (geometry.toe, geometry.crest))
        steep = f"{geometry.slope_height:.4g} m high, 1 : {(geometry.crest[0] - geometry.toe[0]) / geometry.slope_height:.2g}"
        lines.append(("slope", f"toe ({toe[0]:.10g}, {toe[1]:.10g}) m, crest ({crest[0]:.10g}, {crest[1]:.10g}) m, {steep}"))
    lines += equilibrium_rows(checked.equilibrium)
    for name, particle in checked.probes.items():
        x, y = geometry.in_survey(float(particles.x[particle]), float(particles.y[particle]))
        lines.append((f"probe {name}", f"({x:.10g}, {y:.10g}) m"))
    lines += [(f"seam {name}", text) for name, text in seam_rows(scene, particles)]
    lines += [
        (
            f"rows in {each.name}",
            f"{each.rows:.2g} in {each.thickness:.3g} m; {each.enough} are needed, with a spacing of at most {each.spacing:.3g} m, "
            f"with which a run takes {duration(expected.seconds * (scene.numerics.spacing / each.spacing) ** 3)}",
        )
        for each in needed_rows(scene, particles)
    ]
    frequency = highest_frequency(scene)
    shaking = f"{scene.motion.kind}, 95 % of its energy below {frequency:.3g} Hz" if frequency else f"{scene.motion.kind}, no waves"
    return [
        *lines,
        ("particles", f"{n:,} ({soil:,} soil, {n - soil:,} of the box), spacing {scene.numerics.spacing:g} m"),
        ("kernel radius", f"{2 * scene.numerics.smoothing_length:.3g} m, {expected.neighbours:.0f} neighbours"),
        *uncertain_rows(scene, particles),
        *water_rows(scene),
        *frequency_rows(scene),
        ("motion", shaking),
        ("PGA", peak_accelerations(scene)),
        ("steps", f"{expected.steps:,} of {scene.duration / expected.steps:.3g} s to {scene.duration:g} s"),
        ("computing time", f"{expected.seconds:,.3g} s {ON_REFERENCE}, if the soil fails"),
        ("memory and disk", f"{expected.memory:,.0f} MiB while it runs, {expected.disk:,.1f} MiB for its trajectory"),
    ]


def equilibrium_rows(equilibrium: LimitEquilibrium | None) -> list[tuple[str, str]]:
    """Label and text of the limits by limit equilibrium; none for a scene without a slope."""
    if equilibrium is None:
        return []
    numbers = equilibrium_numbers(equilibrium)
    return [("factor of safety", factor_words(numbers)), ("yield acceleration", yield_words(numbers))]


LAYER_COLUMNS = ("layer", "particles", "across", "V_s (m/s)", "λ (m)", "λ/spacing", "λ/h")


def layer_rows(checked: Check) -> list[tuple[str, ...]]:
    """A row of ``LAYER_COLUMNS`` a material; λ: length of shear waves at the motion's highest significant frequency."""
    scene, frequency = checked.scene, highest_frequency(checked.scene)
    made: list[tuple[str, ...]] = []
    for layer, name in zip(checked.layers, (scene.soil.name or "soil", *scene.layers), strict=True):
        speed = layer.soil.s_wave_speed
        length = speed / frequency if frequency else 0.0
        waves = (f"{length:.3g}", f"{length / scene.numerics.spacing:.3g}", f"{in_wave(scene, layer.soil, frequency):.3g}")
        row = (name, f"{layer.particles:,}", f"{layer.thickness:g}", f"{speed:.0f}")
        made.append(row + (waves if frequency else ("-",) * 3))
    return made


def places_of(study: Path, scene: Scene) -> dict[str, PlaceAt]:
    """The places of a study's configuration that debris may reach; ValueError for one that is neither before its slope nor on it."""
    metrics = read_yaml(study).get("metrics") or {}
    if not isinstance(metrics, dict):
        raise ValueError(f"{study}: metrics: must be a section")
    places = validated(MetricSettings, {"places": metrics.get("places") or {}}, f"{study}: metrics").places
    check_places(places, scene, str(study))
    return places


def draw(checked: Check, places: Mapping[str, PlaceAt] | None = None, run: Run | None = None) -> Figure:
    """The scene as a figure, with its critical slip surfaces, the places of a study and the soil that fails in a run of it; the drawing
    library, which needs a folder to write in, is imported here only."""
    from sph.figures.scene import figure_scene

    return figure_scene(checked.scene, checked.particles, checked.probes, places, checked.equilibrium, run)
