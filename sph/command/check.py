"""A scene before it is run (``sph check``): its summary and findings."""

from __future__ import annotations

import functools
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import sph
from sph.checks.equilibrium import (
    equilibrium_numbers,
    factor_below_1,
    found_equilibrium,
    probes_off_slide,
    slip_at_base,
    within_cover,
    without_surface,
)
from sph.checks.finding import Finding, called, finding
from sph.checks.layers import Layer, layers_of, needed_rows, seam_rows
from sph.checks.liquefaction import of_liquefaction
from sph.checks.messages import factor_words, line, record, yield_words
from sph.checks.motion import frequency_rows, other_direction, peak_accelerations
from sph.checks.scene import choices, findings, highest_frequency, in_wave, strengths, uncertain_rows, water_rows
from sph.checks.stability import stability, standing
from sph.command.given import earlier_run, is_study, read_given
from sph.command.outputs import check_picture
from sph.command.study import find_study
from sph.command.terminal import aligned, say, table
from sph.command.watch import Shown, svg, watch
from sph.measures.metrics import MetricSettings
from sph.measures.places import PlaceAt, check_places
from sph.output.run import Run
from sph.scene.configuration import dotted, found_file, merge, read_yaml, validated
from sph.scene.geometry import SLOPES
from sph.scene.schema import Scene
from sph.scene.strict_json import to_json
from sph.solver.particles import Particles, locate_probes, place_particles
from sph.stability.safety import DEFAULT_RULE
from sph.stability.slip_search import LimitEquilibrium
from sph.stability.standing import static_scene
from sph.study.cost import ON_REFERENCE, cost, search_cost
from sph.study.dimensions import Dimension, scene_key, value_of
from sph.study.machine import duration
from sph.study.plan import Plan

if TYPE_CHECKING:
    from matplotlib.figure import Figure


LIBRARY = Path(sph.__file__).parents[1]
"""Where the scenes of the repository are."""
Told = dict[str, dict[str, list[Finding]]]
"""Findings by section of a study, and by the name of a fidelity, an alternative or a motion in it."""
AT = " at fidelity {}"
"""Where an alternative is not at the scene's own spacing."""
MAX_MOTIONS = 20
"""Most motions of a study that are told."""


class Check(NamedTuple):
    """A scene's particles and findings."""

    scene: Scene
    particles: Particles
    probes: dict[str, int]
    layers: list[Layer]
    equilibrium: LimitEquilibrium | None
    limits: dict[str, Any]
    """by it"""
    findings: list[Finding]


class Variants(NamedTuple):
    """What a study runs of a scene besides it as it is."""

    fidelities: dict[str, Check]
    """that it runs and that change the scene, by name"""
    alternatives: dict[str, Check]
    """at the first fidelity that it runs, by name"""
    at: str
    """that fidelity in words, where it changes the scene"""
    again: dict[str, dict[str, Scene]]
    """alternatives at its second fidelity, by the names of both"""


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
    with the places and alternatives of the study, where asked for.  A study alone names its scene, and the motions that shake it.

    With a magnitude also whether such an earthquake liquefies or softens its layers.  None where section and findings were shown in the
    browser, and again whenever a file was saved, until the command was interrupted.
    """
    path, study, plan = scene_and_study(given, study)
    if watching:
        others_asked = (("--plot", plot), ("--stability", static), ("--magnitude", magnitude), ("--json", as_json))
        asked = [name for name, value in others_asked if value]
        if asked:
            raise ValueError(f"--watch: shows section and findings in the browser; leave out {' and '.join(asked)}")
        watch(path, functools.partial(shown, path, changes, study), say)
        return None
    earlier = earlier_run(path)
    shaken = {} if plan is None else {name: [merge(keys, changes) for keys in each] for name, each in motions_of(plan).items()}
    if shaken:
        changes = next(iter(shaken.values()))[-1]
    scene, inputs = read_given(path, changes, earlier)
    if plot is not None:
        check_picture(plot, [*inputs, *([] if study is None else [study])], "--plot")
    if study is not None:
        places_of(study, scene)  # refused where they cannot be, drawn or not
    checked = check(scene)
    variants = in_variants(path, changes, study, plan)
    if plot is not None:
        from sph.figures.style import save

        run = None if earlier is None or changes else Run(earlier, scene)
        save(draw([checked, *variants.alternatives.values()], study, run, ["", *variants.alternatives]), plot)
    motions = {name: [read_given(path, keys)[0] for keys in each] for name, each in shaken.items()} or {"": [scene]}
    others = further(variants, checked.findings, static)
    if shaken:
        others["motions"] = in_motions(motions, checked)
    liquefied = [] if magnitude is None else of_liquefaction(scene, checked.particles, magnitude)
    facts, layers = rows(checked, motions), layer_rows(checked)
    told = (stability(scene) if static else []) + liquefied + checked.findings
    if as_json:
        named = [dict(zip(LAYER_COLUMNS, row, strict=True)) for row in layers]
        by_section = {section: {name: [record(each) for each in of] for name, of in by_name.items()} for section, by_name in others.items()}
        findings = [record(each) for each in told]
        return to_json({"rows": dict(facts), "layers": named, "findings": findings, **by_section}, indent=1)
    offered = [] if static else offered_tests(scene)
    return "\n".join([aligned(facts), table(LAYER_COLUMNS, layers), *told_lines(told), *other_lines(others), *offered])


def scene_and_study(given: Path | None, study: Path | None) -> tuple[Path, Path | None, Plan | None]:
    """The file of a scene, that of the study, if there is one, and the study where it names the scene; ValueError where neither is given,
    and where no scene is found."""
    if given is not None and study is None and is_study(given):
        given, study = None, given
    if given is not None:
        return given, study, None
    if study is None:
        raise ValueError("SCENE: is missing; give a scene, or a study, which names its scene")
    catalogue = find_study(study)
    return found_file([catalogue.base, LIBRARY], catalogue.plan.study.scene, f"{study}: scene"), study, catalogue.plan


def motions_of(plan: Plan) -> dict[str, list[dict[str, Any]]]:
    """The scene keys of the motions of a study's runs, by all in which these differ but the amplitude: with the least and the largest."""
    shaking = [each for each in plan.dimensions if scene_key(each.name).startswith("motion.")]
    found: dict[str, dict[float, dict[str, Any]]] = {}
    for point in plan.study.runs.values():
        levels = [float(point[each.name]) for each in shaking if scene_key(each.name) == "motion.amplitude" and point[each.name] != "null"]
        name = ", ".join(each.said(point[each.name]) for each in shaking if scene_key(each.name) != "motion.amplitude")
        keys = dotted({scene_key(each.name): _written(each, point[each.name]) for each in shaking})
        found.setdefault(name, {})[levels[0] if levels else 0.0] = keys
    return {name: [each[level] for level in sorted({min(each), max(each)})] for name, each in list(found.items())[:MAX_MOTIONS]}


def _written(dimension: Dimension, value: str) -> Any:
    """A value of a study's dimension as a scene's key, an acceleration with its unit: without one it might be meant in g."""
    return f"{value} m/s2" if dimension.unit == "m/s2" and value != "null" else value_of(value)


def in_motions(motions: Mapping[str, Sequence[Scene]], checked: Check) -> dict[str, list[Finding]]:
    """Errors and warnings of the motions of a study, each at its largest amplitude, besides those of the scene that is ``checked``."""
    strongest = {name: scenes[-1] for name, scenes in motions.items()}
    critical = checked.limits.get("critical", 0.0)
    turned = other_direction(strongest, critical)
    told = {
        name: [*([turned[name]] if name in turned else []), *new_findings(findings(scene, checked.particles), checked.findings)]
        for name, scene in strongest.items()
    }
    return {name or "motion": each for name, each in told.items() if name or each}


def in_variants(path: Path, changes: Mapping[str, Any], study: Path | None, plan: Plan | None = None) -> Variants:
    """The fidelities that a study runs, and its alternatives at them; ValueError for one that is refused.  Of a ``plan`` what it has, or
    else what is written."""
    written = plan.study.model_dump() if plan is not None else {} if study is None else read_yaml(study)
    for section in ("fidelities", "alternatives"):
        keys = written.get(section) or {}
        if not isinstance(keys, Mapping) or not all(isinstance(each, Mapping) for each in keys.values()):
            raise ValueError(f"{study}: {section}: must be a section with a section of scene keys for each")
    fidelities, alternatives = written.get("fidelities") or {}, written.get("alternatives") or {}

    def read(key: str, *over: Mapping[str, Any]) -> Scene:
        try:
            return read_given(path, functools.reduce(merge, over, changes))[0]
        except ValueError as error:
            raise ValueError(f"{study}: {key}: {error}") from error

    run = [str(name) for name in dict.fromkeys((written.get("fidelity"), written.get("second_fidelity"))) if name in fidelities]
    first = fidelities[run[0]] if run else {}
    return Variants(
        {name: check(read(f"fidelities.{name}", fidelities[name])) for name in run if fidelities[name]},
        {name: check(read(f"alternatives.{name}", first, keys)) for name, keys in alternatives.items() if keys},
        AT.format(run[0]) if first else "",
        {
            fidelity: {name: read(f"alternatives.{name}", fidelities[fidelity], keys) for name, keys in alternatives.items() if keys}
            for fidelity in run[1:]
        },
    )


def new_findings(told: Sequence[Finding], known: Sequence[Finding]) -> list[Finding]:
    """Errors and warnings besides those that are known."""
    return [each for each in told if each.counts and each not in known]


def further(variants: Variants, known: Sequence[Finding], static: bool = False) -> Told:
    """Errors and warnings of variants of a scene, besides what is ``known`` of the scene as it is.

    Of alternatives limit equilibrium and, if asked for, ``static`` tests, and at a second fidelity what is found neither at the first nor
    of the scene at that fidelity.
    """
    of_fidelity = {name: each.findings for name, each in variants.fidelities.items()}
    told = {
        "fidelities": {name: new_findings(each, known) for name, each in of_fidelity.items()},
        "alternatives": dict[str, list[Finding]](),
    }
    everywhere = [each for findings_there in of_fidelity.values() for each in findings_there]
    for name, each in variants.alternatives.items():
        found = new_findings(each.findings, [*known, *everywhere])
        if static:
            found = [*standing(each.scene), *found]
        if each.limits:
            found.insert(0, finding("limit-equilibrium", **each.limits))
        told["alternatives"][f"{name}{variants.at}"] = found
    for fidelity, scenes in variants.again.items():
        for name, scene in scenes.items():
            before = {_kind(each) for each in (*known, *everywhere, *variants.alternatives[name].findings)}
            found = [each for each in findings(scene, place_particles(scene)) if each.counts and _kind(each) not in before]
            told["alternatives"] |= {f"{name}{AT.format(fidelity)}": found} if found else {}
    return told


def _kind(of: Finding) -> tuple[str, str, str]:
    return of.code, of.subject, of.severity


def offered_tests(scene: Scene) -> list[str]:
    """The line that offers the tests of ``--stability``, with their computing time; none for a scene that cannot be tested."""
    try:
        seconds = 3.0 * cost(static_scene(scene, DEFAULT_RULE)).seconds + 2.0 * search_cost(scene).seconds
    except ValueError:
        return []
    return [f"whether the slope stands without shaking is not tested; --stability tests it, in about {duration(seconds)} {ON_REFERENCE}"]


def other_lines(others: Told) -> list[str]:
    """A line for each finding in a fidelity, an alternative and a motion, and for one without more than notes."""
    named = {f"fidelity {name}": told for name, told in others["fidelities"].items()} | others["alternatives"] | others.get("motions", {})
    none = ["no further warnings"]
    return [f"{name}: {said}" for name, of in named.items() for said in [*map(line, of), *none * (not any(each.counts for each in of))]]


def told_lines(told: Sequence[Finding]) -> list[str]:
    """A line for each finding, and where none counts that there is none."""
    return [*map(line, told), *["no warnings"] * (not any(each.counts for each in told))]


def shown(path: Path, changes: Mapping[str, Any], study: Path | None) -> Shown:
    """Section, findings and summary of the scene in a file for the browser."""
    scene, inputs = read_given(path, changes)
    checked = check(scene)
    variants = in_variants(path, changes, study)
    figure = draw([checked, *variants.alternatives.values()], study, names=["", *variants.alternatives])
    others = further(variants, checked.findings)
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
            *probes_off_slide(scene, equilibrium),
            *without_surface(scene, equilibrium),
        ],
        key=lambda each: each.rank,
    )
    limits = {} if equilibrium is None else equilibrium_numbers(equilibrium) | within_cover(scene, equilibrium)
    return Check(scene, particles, locate_probes(scene, particles), layers_of(scene, particles), equilibrium, limits, told)


def rows(checked: Check, motions: Mapping[str, Sequence[Scene]] | None = None) -> list[tuple[str, str]]:
    """Pairs of label and text: the slope, sizes, cost and the motion; or the ``motions`` of a study, each with the scenes of its least and
    its largest amplitude."""
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
    lines += equilibrium_rows(checked.limits)
    for name, particle in checked.probes.items():
        x, y = geometry.in_survey(float(particles.x[particle]), float(particles.y[particle]))
        lines.append((f"probe {name}", f"({x:.10g}, {y:.10g}) m"))
    lines += [(f"seam {name}", text) for name, text in seam_rows(scene, particles)]
    lines += [
        (
            f"rows in {each.name}",
            f"{each.rows:.2g} in {each.thickness:.3g} m; {each.enough} are {each.purpose}, with a spacing of at most {each.spacing:.3g} m, "
            f"with which a run takes {duration(expected.seconds * (scene.numerics.spacing / each.spacing) ** 3)}",
        )
        for each in needed_rows(scene, particles)
    ]
    return [
        *lines,
        ("particles", f"{n:,} ({soil:,} soil, {n - soil:,} of the box), spacing {scene.numerics.spacing:g} m"),
        ("kernel radius", f"{2 * scene.numerics.smoothing_length:.3g} m, {expected.neighbours:.0f} neighbours"),
        *uncertain_rows(scene, particles),
        *water_rows(scene),
        *frequency_rows(scene),
        *(row for name, scenes in (motions or {"": [scene]}).items() for row in motion_rows(scenes, f" of {name}" if name else "")),
        ("steps", f"{expected.steps:,} of {scene.duration / expected.steps:.3g} s to {scene.duration:g} s"),
        ("computing time", f"{expected.seconds:,.3g} s {ON_REFERENCE}, if the soil fails"),
        ("memory and disk", f"{expected.memory:,.0f} MiB while it runs, {expected.disk:,.1f} MiB for its trajectory"),
    ]


def motion_rows(scenes: Sequence[Scene], of: str) -> list[tuple[str, str]]:
    """Label, with what the motion is ``of``, and text of a motion at its least and its largest amplitude."""
    strongest = scenes[-1]
    frequency = highest_frequency(strongest)
    shaking = f"{strongest.motion.kind}, 95 % of its energy below {frequency:.3g} Hz" if frequency else f"{strongest.motion.kind}, no waves"
    return [(f"motion{of}", shaking), (f"PGA{of}", " to ".join(map(peak_accelerations, scenes)))]


def equilibrium_rows(numbers: Mapping[str, Any]) -> list[tuple[str, str]]:
    """Label and text of the limits by limit equilibrium; none for a scene without a slope."""
    return [("factor of safety", factor_words(numbers)), ("yield acceleration", yield_words(numbers))] if numbers else []


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


def draw(checked: Sequence[Check], study: Path | None = None, run: Run | None = None, names: Sequence[str] = ("",)) -> Figure:
    """Scenes as a figure, a section each by their ``names``, with their critical slip surfaces, the places of a study and the soil that
    fails in a run of the first; the drawing library, which needs a folder to write in, is imported here only."""
    from sph.figures.scene import Drawn, figure_scenes

    return figure_scenes(
        [
            Drawn(each.scene, each.particles, each.probes, {} if study is None else places_of(study, each.scene), each.equilibrium, name)
            for each, name in zip(checked, names, strict=True)
        ],
        run,
    )
