"""What ``sph new`` writes: a commented scene and study of the user's own slope, from what an engineer knows of it."""

from __future__ import annotations

import math
import os
import shlex
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import yaml

import sph
from sph.checks.cover_rows import covers, enough_rows
from sph.checks.layers import MIN_IN_LAYER, broken, of_cover
from sph.checks.messages import sentence
from sph.checks.scene import HOLDS, PLACEHOLDER, room_ahead, to_side
from sph.command.known import (
    RESIDUAL,
    Known,
    read_depth,
    read_numbers,
    read_peak,
    read_plain,
    read_softening,
    refuse,
    refused,
    to_digits,
    too_high,
    with_density,
)
from sph.command.options import parse_treatment, parse_values
from sph.command.schema import schema_file
from sph.command.sections import BERM_SIDE, Berm, at_depth, berm, plain_slope
from sph.command.terminal import say
from sph.measures.places import beyond_toe
from sph.scene.configuration import validated
from sph.scene.ground_line import GroundLine
from sph.scene.ground_motion import read_record
from sph.scene.natural_periods import Column, natural_frequencies
from sph.scene.places import Point
from sph.scene.schema import load_scene
from sph.scene.scheme import SOFTENING
from sph.scene.survey import read_line
from sph.solver.particles import place_particles
from sph.storage.files import whole
from sph.study.cost import ON_REFERENCE, cost
from sph.study.dimensions import ALTERNATIVE, BASE, scene_keys
from sph.study.machine import duration
from sph.study.plan import load_study

SCENE, STUDY = "scene.yaml", "study.yaml"
LINES = {
    "ground": "ground, m; x = 0 is the toe",
    "rock": "top of the ground below the cover, m",
    "water": "water table, m",
    "drained": "water table of the alternative drained, m",
    "berm": "ground of the alternative berm, m",
    "berm_fill": "outline of its fill, m",
}
"""Files with a line each, by name, and what they say of themselves."""
ROWS = 20
"""Particles over the height of the slope at least."""
PART, PARTS = 3, 4
"""Share of these for a first look, and to compare with; whole rows at both make the height of the slope and the depth below its toe."""
MAX_COMPARED, MAX_RUN = 3600.0, 86400.0
"""Computing time (s) of a run up to which thin soil has the rows that it needs at the coarser spacing as well, and at most."""
COARSE = "coarse"
"""The fidelity of a first look."""
FROM_TESTS = ("density", "cohesion", "friction_angle", "residual_cohesion", "residual_friction_angle")
"""Those without which the soil is not the user's."""
FILL = {
    "density": 2000.0,
    "shear_wave_speed": 300.0,
    "cohesion": 5.0,
    "friction_angle": 40.0,
    "residual_cohesion": 0.0,
    "residual_friction_angle": 36.0,
}
"""That of a berm, compacted gravel."""
RATIOS, FACTORS = ("0.3", "0.5", "0.7"), (0.5, 1.0, 1.5)
"""S_R, and amplitude over the record's peak, that a study varies where neither was typed."""
WIDTH = 0.22
"""Over which failure begins, over the slope's height, and at most the thickness of a cover: three spacings even for a first look."""
DEPTH, BEHIND, AHEAD = 0.4, 3.0, 2.0
"""Soil below the lowest ground, level ground behind the crest of a plain slope and at least before its toe, over the slope's height."""
START, AFTER = 3.0, 5.0
"""Beginning of the record, after the gravity stage, s, and what is simulated after its end, in s over the root of the slope's height in m:
a point that slides from the crest of a slope of 15° to rest needs 4.8 with a friction angle of 12°, on 30° with 18° 2.3.  A run ends
sooner where all soil has come to rest."""
LOWERED, BERM = 0.3, 0.2
"""By how much the water line of a file is lowered once drained, and height of a berm, that are suggested, over the slope's height."""
REINFORCED = 5.0
"""Cohesion that roots or nails add, which is suggested, kPa."""
SPRING = 0.1
"""Frequency of the spring of the base, Hz: a tenth of that of most motions, to whose traction it then adds 0.5 %."""
MAX_TITLE = 100
"""Most characters of the ground file's name in the title."""

SCENE_TEXT = """\
{scene_schema}# Your own slope, written by `sph new`. Check it, and look at it:  sph check {study_word} --plot scene.png
# What you did not type is ASSUMED, and named by the study. Replace what you know better; docs/reference/scene-keys.md describes every key.
name: {name}
title: {title} # shown in every figure{placeholder}
duration: {duration:g} # s, until {after:.3g} s after the longest record, for the debris to come to rest
early_stop: {{}} # a run ends sooner where all soil has come to rest
geometry:
  shape: ground_line
  file: {ground}
  base: {base:.8g} # m, elevation of the model's base; deeper than any slip surface, whole rows of particles below the toe
  downhill: {downhill}{ends}
# Waves leave through base and sides; put the sides on level ground beyond the debris. The motion is the outcrop motion of the bedrock,
# which is here as the lowest soil: change both. For the motion of a stiffer rock describe that, in kg/m3 and m/s:
#   bedrock: {{density: 2300, s_wave_speed: 800, p_wave_speed: 1500, spring_frequency: {spring:g}}}
# Without spring_frequency (Hz) the ground sinks for good below debris: docs/model/walls.md
walls:
  base: absorbing
  sides: absorbing
  bedrock: {bedrock} # ASSUMED
soil: # density with its water; strength at the peak and, as residual, of failed soil; youngs_modulus (kPa) in place of shear_wave_speed
{soil}
  dilation_angle: 0.0 # degree, at most the friction angle; 0: no dilation, as in loose soil and clay  ASSUMED
  viscosity: 2.0 # Pa s, of debris above its yield stress; has little effect
  # K0: {jaky:.2f} # horizontal over vertical effective stress at rest, 1 - sin(phi) in soil that has never borne more (Jaky 1944).
  # Left out: nu / (1 - nu) = {rest:.2f}. It decides how near failure soil is: try both
{layers}{water}coupling:
  S_R: {ratio}
  # From a shear test (docs/how-to/shear-tests.md), m: slip at the end of the peak and where the residual strength is reached
  # width: of the soil that yields before a slip surface forms, at least three spacings
  softening: {softening}
# Damping ratio at two frequencies: the natural one of the ground with its layers ("column frequency" of sph info, to be looked at again
# when the soil and the layers are final), and five times that; damping also slows blocks that have not failed
damping: {{ratio: 0.03, frequencies: [{low:g}, {high:g}]}} # ASSUMED
motion: {{kind: record, {file}, start: {start:g}, baseline: {{degree: 1}}}} # as recorded, {peak:.3g} m/s2; the study scales it
numerics:
  spacing: {spacing:g} # m, {rows} whole rows over the height of the slope{in_cover}
{kernel}probes: {{A: crest_edge}} # to follow a building behind the crest: keep A, and add house: [x, elevation]
"""
KERNEL_TEXT = """\
  smoothing_ratio: {ratio:g} # keeps wet ground that fails on its lattice, which the default of 1.3 does not: docs/model/choices.md
"""
LAYERS_TEXT = """\
# layers: # other soils, by depth, elevation or polygon; give only the keys that differ
#   clay: {region: {kind: depth, top: 6.0, bottom: 9.0}, soil: {cohesion: 12.0, friction_angle: 19.0}, S_R: 0.6}
"""
COVER_TEXT = """\
layers: # the soil above is the cover; other layers by depth, elevation or polygon, with only the keys that differ
  ground: # below the cover, whose thickness ({cover:g} m, vertically) decides the spacing
    region: {{kind: below, file: rock.csv}}
    soil: {soil} # ASSUMED, but what was typed with --below
"""
WATER_TEXT = """\
water: # carried: silt and clay that move faster than their water drains; by_place: sand and gravel, which drain as they move
  {{pressure: carried, file: {file}}} # ASSUMED carried
"""
STUDY_TEXT = """\
{study_schema}# How far, when, how deep, and does a measure help?
#   snakemake --cores 2 --configfile {study_word}      (or --config fidelity=coarse for a first look)
study: {name}
scene: {scene}
fidelity: own
second_fidelity: {second}
design: {design} # amplitude that the page answers first, one of these; null: the largest
grid: # every combination is run
{grid}
fidelities:
  coarse: {{numerics: {{spacing: {coarse:g}}}}} # for a first look{at_coarse}
  own: {{}} # the scene as it is
# What of the scene nobody typed. The page names it; take out what you have replaced:
assumed:
{assumed}
# What must the debris not reach, or the ground not move at? By x as in {ground}, or "15 beyond the toe":
{places}
# What would help? Every run is made for the scene as it is and for each of these; take away "# " to add one. Files are as seen from here,
# the folder where you run the study:
{alternatives}
"""
COMPARED = (
    "coarse # every run is repeated with coarser particles, which adds 0.4 of the time: the page shows the effect; null: no; a first look "
    "at it\n# repeats at most three of its runs with those of own, which decide in what shaking the slope fails"
)
NOT_COMPARED = "null # coarser particles would not resolve the thin soil; add a fidelity with finer ones to see what they change"


class Written(NamedTuple):
    """What was written, and what nobody typed."""

    scene: Path
    study: Path
    assumed: Mapping[str, str]  # by keys


class Rows(NamedTuple):
    """Rows of particles over the height of the slope."""

    own: int  # a multiple of ``PARTS``
    compared: bool = True  # whether the runs are repeated with the coarser ones

    @property
    def coarse(self) -> int:
        """Of the first look."""
        return self.own * PART // PARTS


def new(
    ground: Path | None,
    slope: str | None,
    records: Sequence[Path],
    scale_to: list[str] | None,
    design: str | None,
    component: str | None,
    unit: str | None,
    cover: float | None,
    soil: list[str] | None,
    below: list[str] | None,
    water: str | None,
    place: list[str] | None,
    alternative: list[str] | None,
    softening: list[str] | None,
    folder: Path,
) -> str:
    """Write what is asked for on the command line; the files, what was assumed, and what to do next.  ValueError names the option."""
    wrong = [] if (ground is None) != (slope is None) else ["GROUND: give the file of a ground line, or --slope HEIGHT,ANGLE, and not both"]

    def read(parse: Callable[..., Any], *given: Any) -> Any:
        """What was typed; None where it is refused, which is told with all else that is."""
        try:
            return parse(*given)
        except ValueError as error:
            wrong.append(str(error))
            return None

    known = Known(
        ground or (read(read_plain, slope) if slope is not None else None) or Path(),
        records,
        component,
        (read(parse_treatment, unit, None, None) or {}).get("unit"),
        [read(read_peak, peak) for text in (*(scale_to or ()), *([design] if design else ())) for peak in text.split(",")],
        cover,
        read(read_numbers, soil, "--soil") or {},
        read(read_numbers, below, "--below") or {},
        None if water is None else read_depth(water),
        read(parse_values, place, "--place") or {},
        read(read_numbers, alternative, "--alternative") or {},
        read(read_softening, softening) or {},
        (read(read_peak, design) if design else None) or "",
    )
    if wrong:
        refuse([*wrong, *refused(known)])
    scene, study, assumed = write_new(known, folder)
    say(*(cover_words(scene) if cover is not None else ()))
    next_ = f"next: sph check {shlex.quote(str(study))} --plot scene.png"
    return "\n".join([f"{scene}, {study}", *(f"assumed: {key}: {each}" for key, each in assumed.items()), next_])


def write_new(known: Known, folder: Path) -> Written:
    """Write ``SCENE`` and ``STUDY``, named after it, and the ``LINES`` that they name into a folder, which is made.

    A cover has the rows of particles that its run-out needs, a berm those that hold it together, a plain slope the ground before its toe
    that its debris may need.

    ValueError for what cannot be used, where one of the files exists, and for a path that a line of text cannot hold; nothing is left
    behind then.
    """
    files = [folder / name for name in (SCENE, STUDY, *(f"{name}.csv" for name in LINES))]
    given = [path for path in (known.ground, known.water, *known.records) if isinstance(path, Path)]
    for path in files:
        if path.exists() and (path.name in (SCENE, STUDY) or path not in given):
            raise ValueError(f"--out {folder}: {path} is there already; name another folder")
    for path in (*given, folder.absolute()):
        if not str(path).isprintable():
            raise ValueError(f"{str(path)!r}: holds a character that cannot be printed, which a scene file cannot hold; rename it")
    refuse(refused(known))
    new, made = [path for path in files if not path.exists()], [path for path in (folder, *folder.parents) if not path.exists()]
    try:
        folder.mkdir(parents=True, exist_ok=True)
        return _written(known, folder)
    except BaseException:
        for path in new:
            path.unlink(missing_ok=True)
        for path in made:
            with suppress(OSError):  # it was not made, or another program has put something there
                path.rmdir()
        raise


class _Section(NamedTuple):
    """The ground with what lies on it and below it."""

    line: GroundLine
    file: Path  # of the ground
    lowered: float | None  # depth of the water of the alternative, or by how much its line is lowered, m
    berm_height: float  # m
    berm: Berm | None

    @property
    def height(self) -> float:
        """Of the slope, m."""
        return self.line.slope_height

    @property
    def after(self) -> float:
        """What is simulated after the end of the shaking, s."""
        return AFTER * math.sqrt(self.height)


def _written(known: Known, folder: Path) -> Written:
    scene, study = folder / SCENE, folder / STUDY
    section, rows = _section(known, folder), Rows(ROWS)
    motions = [read_record(record, known.unit, known.component) for record in known.records]
    longest, peak = max(float(motion.time[-1]) for motion in motions), motions[0].peak

    def write(section: _Section, rows: Rows) -> dict[str, str]:
        facts, assumed = _facts(known, section, _of_rows(rows, section.line, known), folder)
        facts |= {
            "assumed": "\n".join(f"  {key}: {quoted(each)}" for key, each in assumed.items()),
            "grid": "\n".join(f"  {each}" for each in _grid(known, peak)),
            "duration": math.ceil(START + longest + section.after),
            "peak": peak,
        }
        for path, text in ((scene, SCENE_TEXT), (study, STUDY_TEXT)):
            with whole(path) as temporary:
                temporary.write_text(text.format(**facts), encoding="utf-8")
        return assumed

    if not isinstance(known.ground, Path):
        write(section, rows)
        weakest = load_scene(scene, {} if known.has_residual else {"coupling": {"S_R": float(RATIOS[0])}})
        section = _section(known, folder, room_ahead(weakest))
    if known.cover is not None:
        write(section, rows)
        needed = math.ceil(section.height * (enough_rows() or ROWS) / known.cover * (1.0 - 1e-9))
        rows = _enough(f"--cover {known.cover:g}", needed, cost(load_scene(scene)).seconds)
    while True:
        assumed = write(section, rows)
        plan = load_study(study, check=False)
        first = next(iter(plan.study.runs.values()))
        for name in (BASE, *plan.study.alternatives):
            plan.built(**(first | {ALTERNATIVE: name} if plan.study.alternatives else first))
        if "berm" not in known.alternatives:
            break
        filled = plan.at(COARSE).built(**(first | {ALTERNATIVE: "berm"}))
        if not broken(filled, place_particles(filled)):
            break
        finer = rows._replace(own=rows.own + PARTS)
        if (seconds := cost(load_scene(scene)).seconds * (finer.own / rows.own) ** 3) > MAX_RUN:
            raise ValueError(_too_thin(f"--alternative berm={known.alternatives['berm']:g}", seconds, "give a higher one"))
        rows = finer
    return Written(scene, study, assumed)


def _section(known: Known, folder: Path, ahead: float = 0.0) -> _Section:
    """The ground, and the lines below and above it, which are written; a plain slope has at least this much ground before its toe, m."""
    if isinstance(known.ground, Path):
        file, points = known.ground, _read(known.ground)
    else:
        height, angle = known.ground
        beyond = [beyond_toe(at, _ground(plain_slope(height, angle, height, height), folder, 0.0)) for at in known.places.values()]
        ahead = max(ahead, AHEAD * height, *(each + height for each in beyond), 0.0)
        file, points = folder / "ground.csv", plain_slope(height, angle, BEHIND * height, 5.0 * math.ceil(ahead / 5.0))
    line, cover, wet, asked = _ground(points, file, known.cover or 0.0), known.cover, known.water, known.alternatives
    height = line.slope_height
    refuse(too_high(known, height))
    lowered, high = asked.get("drained"), asked.get("berm", BERM * height)
    if lowered is None and wet is not None:
        lowered = max(cover or 0.0, 2.0 * wet, wet + 1.0) if isinstance(wet, float) else LOWERED * height
    filled = None
    try:
        filled = berm(line, high)
        for name, at in known.places.items():
            if -filled.back < beyond_toe(at, line) < filled.foot:
                raise ValueError(f"would cover {name}, with its foot {filled.foot:.3g} m beyond the toe; give a lower one, or leave it out")
    except ValueError as error:
        filled = None
        if "berm" in asked:
            raise ValueError(f"--alternative berm={high:g}: {error}") from error
    lines = {
        "ground": None if isinstance(known.ground, Path) else points,
        "rock": None if cover is None else at_depth(points, cover),
        "water": at_depth(points, wet) if isinstance(wet, float) else None,
        "drained": None if lowered is None else at_depth(_read(wet) if isinstance(wet, Path) else points, lowered),
        "berm": filled and filled.ground,
        "berm_fill": filled and filled.fill,
    }
    for name, drawn in lines.items():
        if drawn:
            _write_line(folder / f"{name}.csv", drawn)
    return _Section(line, file, lowered, high, filled)


def _grid(known: Known, peak: float) -> Iterator[str]:
    """Lines of what the study varies."""
    if known.peaks:
        peaks = ", ".join(map(quoted, dict.fromkeys(known.peaks)))
        yield f'amplitude: [{peaks}] # peak acceleration to which every record is scaled; add others, as "0.5g"'
    elif len(known.records) == 1:
        values = ", ".join(f'"{factor * peak:.3g}"' for factor in FACTORS)
        yield f'amplitude: [{values}] # m/s2: half of the record\'s peak, the peak, and 1.5 times that; add your design peak, e.g. "0.4g"'
    if len(known.records) > 1:
        yield f"motion.file: [{', '.join(quoted(str(record)) for record in known.records)}] # as seen from here"
    yield 'motion.factor: ["1", "-1"] # each record as recorded and reversed, since either may bring the slope down; one halves the runs'
    if not known.has_residual:
        yield f"S_R: [{', '.join(map(quoted, RATIOS))}] # ASSUMED; for one layer write layers.NAME.S_R, or give residual strengths instead"


def _softening(known: Known, section: _Section) -> dict[str, float | str]:
    """Loss of strength with slip as a scene has it."""
    slips: Mapping[str, float | str] = known.softening or {"slip_at_peak": 1.0e-3, "slip_at_residual": 0.1}
    width = min(WIDTH * section.height, known.cover or math.inf)  # above the ground there is nothing to average over
    return {**slips, "width": known.softening.get("width", to_digits(width, 2))}


def _facts(known: Known, section: _Section, of_rows: Mapping[str, Any], folder: Path) -> tuple[dict[str, Any], dict[str, str]]:
    """What the texts of scene and study have in braces, but for the records; and what of it decides the answer and was not typed, by its
    keys, what decides most first."""
    line, soil, own, water = section.line, known.whole_soil, known.own_soil, known.water
    units = {key: scene_keys()[f"soil.{key}"].replace("-", "") for key in soil}
    softening, rest = _softening(known, section), soil["poisson_ratio"] / (1.0 - soil["poisson_ratio"])
    jaky = 1.0 - math.sin(math.radians(soil["friction_angle"]))
    missing = [f"{key}: {value:g} {units[key]}".strip() for key, value in soil.items() if key not in own]
    width = f"in a zone {softening['width']:g} m wide"
    assumed = {SOFTENING: f"strength is lost from 1 mm to 100 mm of slip, {width}"}
    if known.softening:
        assumed = {} if "width" in known.softening else {f"{SOFTENING}.width": f"strength is lost {width}"}
    ratio, layers, carried = "1.0 # not felt: all soils have residual strengths", LAYERS_TEXT, ""
    if not known.has_residual:
        ratio = "0.5 # residual over peak strength, from a shear box or ring shear test  ASSUMED"
        assumed["coupling.S_R"] = f"residual strength: {', '.join(RATIOS)} of the peak"
    if missing:
        assumed["soil"] = ", ".join(missing)
    if water is None:
        assumed["water"] = "no water"
    else:
        carried = WATER_TEXT.format(file=quoted(os.path.relpath(water, folder) if isinstance(water, Path) else "water.csv"))
        follows = "" if isinstance(water, Path) else "; the water table follows the ground"
        assumed["water.pressure"] = f"moving soil keeps its pore pressure, as silt and clay{follows}"
    if known.cover is not None:
        layers = COVER_TEXT.format(cover=known.cover, soil=_flow(known.of_layer(known.lowest_soil)))
        typed = with_density(known.below)
        rock = _flow(known.of_layer({key: value for key, value in known.lowest_soil.items() if key not in typed}))[1:-1]
        below = f"below the cover {'' if typed else 'weathered rock: '}{rock}; " if rock else ""
        assumed["layers.ground"] = f"{below}the cover is as thick everywhere, before the toe, too"
    if not known.peaks:
        times = f", times {', '.join(f'{each:g}' for each in FACTORS)}" if len(known.records) == 1 else ""
        assumed["motion.amplitude"] = f"peak acceleration as recorded{times}"
    if "berm" in known.alternatives and section.berm is not None:
        high = [section.berm_height / of_rows[name] for name in ("spacing", "coarse")]
        few = f"; with fewer than {MIN_IN_LAYER} its effect is uncertain: take a finer spacing" if high[-1] < MIN_IN_LAYER else ""
        assumed["alternatives.berm"] = (
            f"of compacted gravel: {_flow(known.of_layer(FILL))[1:-1]}; its side 1 in {BERM_SIDE:g}; {high[0]:.2g} rows of particles high, "
            f"{high[1]:.2g} at the fidelity coarse, its ends thinner{few}"
        )
    if "reinforced" in known.alternatives:
        assumed["alternatives.reinforced"] = "roots or nails add as much cohesion to soil that has failed, and reach as deep as the slide"
    assumed["walls.bedrock"] = "each record is the outcrop motion of bedrock like the lowest soil"
    assumed["motion.factor"] = "each record is run in both directions"
    assumed["soil.K0"] = f"{rest:.2f} by Poisson's ratio, where 1 - sin(phi) is {jaky:.2f}"
    assumed["damping"] = f"3 % at {of_rows['low']:g} and {of_rows['high']:g} Hz"
    assumed["soil.dilation_angle"] = "no dilation"
    if isinstance(known.ground, Path):
        title = f"Slope {section.height:.3g} m high, {known.ground.name[:MAX_TITLE]}"
    else:
        title = "Slope {:g} m high, {:g} degree".format(*known.ground)
        assumed["geometry"] = f"level ground, {BEHIND * section.height:.4g} m behind the crest and {line.toe[0]:.4g} m before the toe"
    replaced = all(key in own for key in FROM_TESTS)
    record = {"file": os.path.relpath(known.records[0], folder), "component": known.component, "unit": known.unit}
    places = ", ".join(f"{name}: {at if isinstance(at, str) else f'{at:.10g}'}" for name, at in known.places.items())
    facts = {
        "scene_schema": _schema_line("scene", folder),
        "study_schema": _schema_line("study", folder),
        "study_word": shlex.quote(str(folder / STUDY)),
        "scene": quoted(str(folder / SCENE)),
        "name": quoted(_name(folder.resolve())),
        "title": quoted(title if replaced else f"{title} {PLACEHOLDER}"),
        "placeholder": "" if replaced else "; remove the words in brackets when the soil is yours",
        "after": section.after,
        "ground": quoted(os.path.relpath(section.file, folder)),
        "bedrock": _flow(_bedrock(known.whole_soil | known.lowest_soil)),
        "spring": SPRING,
        "downhill": line.downhill,
        "ends": "".join(f"\n  # {sentence(each)}" for each in to_side(line)),
        "soil": "\n".join(f"  {key}: {value:.10g} # {units[key]}{'' if key in own else '  ASSUMED'}" for key, value in soil.items()),
        "rest": rest,
        "jaky": jaky,
        "layers": layers,
        "water": carried,
        "kernel": KERNEL_TEXT.format(ratio=HOLDS) if carried else "",
        "ratio": ratio,
        "softening": f"{_flow(softening)}{' # ASSUMED' * (not known.softening)}",
        "start": START,
        "file": ", ".join(f"{key}: {quoted(value)}" for key, value in record.items() if value),
        "design": quoted(known.design) if known.design else "null",
        "places": f"metrics: {{places: {{{places}}}}}" if places else "# metrics: {places: {house: 15 beyond the toe}}",
        "alternatives": "\n".join(_alternatives(known, section, folder)),
    }
    return {**facts, **of_rows}, assumed


def _alternatives(known: Known, section: _Section, folder: Path) -> Iterator[str]:
    """Lines of the alternatives; of those that were not asked for as comments."""

    def path(name: str) -> str:
        return quoted(str(folder / f"{name}.csv"))

    blocks = {
        "drained": []
        if section.lowered is None
        else [
            f"  drained: {{water: {{file: {path('drained')}}}}} # {section.lowered:.3g} m below the "
            f"{'given water table' if isinstance(known.water, Path) else 'ground'}"
        ]
    }
    if section.berm is not None:
        top, foot = section.berm.top, section.berm.foot
        blocks["berm"] = [
            f"  berm: # {section.berm_height:.3g} m high, {top:.3g} m wide at its top, its foot {foot:.3g} m beyond the toe",
            f"    geometry: {{file: {path('berm')}}}",
            "    layers:",
            f"      berm: {{region: {{kind: polygon, file: {path('berm_fill')}}}, soil: {_flow(known.of_layer(FILL))}}} # ASSUMED",
        ]
    added, soil = known.alternatives.get("reinforced", REINFORCED), known.whole_soil
    held = {key: soil[key] + added for key in ("cohesion", f"{RESIDUAL}cohesion") if key in soil}
    kept = "" if known.has_residual else ", of which failed soil keeps S_R"
    blocks["reinforced"] = [f"  reinforced: {{soil: {_flow(known.of_layer(held))}}} # {added:g} kPa more, as by roots or nails{kept}"]
    yield "alternatives:" if known.alternatives else "# alternatives:"
    for name, block in blocks.items():
        yield from (each if name in known.alternatives else f"# {each}" for each in block)


def _enough(option: str, needed: int, seconds: float) -> Rows:
    """Rows over the height of the slope where thin soil has those that are ``needed``, of a run that takes ``seconds`` with ``ROWS``: at
    the coarser spacing as well, unless a run then takes longer than ``MAX_COMPARED``.

    ValueError, which begins with the ``option``, where a run takes longer than ``MAX_RUN``.
    """

    def longest(rows: int) -> float:
        return seconds * (rows / ROWS) ** 3

    own = max(ROWS, PARTS * math.ceil(needed / PART))
    if longest(own) > MAX_COMPARED:
        own = max(ROWS, PARTS * math.ceil(needed / PARTS))
    if longest(own) > MAX_RUN:
        raise ValueError(
            _too_thin(option, longest(own), "a run on a seam along its base shows whether it stands (docs/model/interfaces.md)")
        )
    found = Rows(own)
    return found._replace(compared=found.coarse >= needed)


def _too_thin(option: str, longest: float, remedy: str) -> str:
    return (
        f"{option}: the rows of particles that so thin a soil needs make a run of {duration(longest)} {ON_REFERENCE}, at most "
        f"{duration(MAX_RUN)}; leave it out, or {remedy}"
    )


def _bedrock(soil: Mapping[str, float]) -> dict[str, float]:
    """Bedrock like a soil, with a spring that bears what is added on it."""
    speed, ratio = soil["shear_wave_speed"], soil["poisson_ratio"]
    faster = math.sqrt(2.0 * (1.0 - ratio) / (1.0 - 2.0 * ratio))
    return {
        "density": soil["density"],
        "s_wave_speed": speed,
        "p_wave_speed": to_digits(faster * speed, 4),
        "spring_frequency": SPRING,
    }


def _of_rows(rows: Rows, line: GroundLine, known: Known) -> dict[str, Any]:
    """What a scene and a study say of the rows of particles over the height of the slope, and of the base, which is a row."""
    height, toe, cover = line.slope_height, line.toe[1], known.cover
    step = height * PARTS / rows.own  # whole rows at both spacings
    depth = math.ceil(toe / step * (1.0 - 1e-9)) * step
    soils = [known.whole_soil, known.lowest_soil] if cover else [known.whole_soil]
    thickness = [cover, depth + height - cover] if cover else [depth + height]
    column = Column(*map(np.array, (thickness, *([each[key] for each in soils] for key in ("shear_wave_speed", "density")))))
    frequency = to_digits(float(natural_frequencies(column)[0]), 3)

    def in_cover(number: int) -> str:
        return "" if cover is None else f", {cover * number / height:.2g} rows in the cover"

    return {
        "base": round(line.base + toe - depth, 4),
        "low": frequency,
        "high": 5.0 * frequency,
        "rows": rows.own,
        "in_cover": in_cover(rows.own),
        "second": COMPARED if rows.compared else NOT_COMPARED,
        "at_coarse": (", and to compare with" if rows.compared else ": its run-outs are lower bounds") + in_cover(rows.coarse),
        **{name: to_digits(height / number, 6) for name, number in (("spacing", rows.own), ("coarse", rows.coarse))},
    }


def cover_words(path: Path) -> list[str]:
    """What the rows of particles in the covers of a scene do to its run-out, and what a run costs."""
    scene = load_scene(path)
    takes = f"A run takes {duration(cost(scene).seconds)} {ON_REFERENCE}"
    return [f"{sentence(of_cover(cover, scene))}. {takes}" for cover in covers(scene)]


def quoted(text: str) -> str:
    """A text as YAML that is read as it was, whatever it holds."""
    return yaml.safe_dump(text, default_style='"', allow_unicode=True, width=math.inf).rstrip("\n")


def _flow(keys: Mapping[str, float | str]) -> str:
    """Keys of a scene as YAML in a line."""
    return f"{{{', '.join(f'{key}: {value}' if isinstance(value, str) else f'{key}: {value:g}' for key, value in keys.items())}}}"


def _name(folder: Path) -> str:
    """Name of the scene and of the study in a folder: its own, of the letters that a name may have."""
    name = "".join(letter if letter.isascii() and (letter.isalnum() or letter in "_.-") else "_" for letter in folder.name)[:60]
    return name if name[:1].isalnum() else f"slope{name}"


def _schema_line(name: str, folder: Path) -> str:
    """The line by which editors find the schema of a file in a folder; none where the repository is not there."""
    schema = Path(sph.__file__).parents[1] / schema_file(name)
    return f"# yaml-language-server: $schema={os.path.relpath(schema, folder)}\n" if schema.is_file() else ""


def _read(path: Path) -> list[Point]:
    """The points of a ground line."""
    try:
        return read_line(path)
    except ValueError as error:
        raise ValueError(f"{path}: {error}") from error


def _ground(points: Sequence[Point], path: Path, cover: float) -> GroundLine:
    """The ground with a base below it and as deep below a cover as that is thick, and the side to which its largest slope falls."""
    lowest = min(y for _, y in points)
    found, refused = [], []
    for downhill in ("left", "right"):
        keys: dict[str, Any] = {"shape": "ground_line", "points": points, "base": lowest - 1.0, "downhill": downhill}
        try:
            line = validated(GroundLine, keys, str(path))
            base = lowest - max(DEPTH * line.slope_height, 2.0 * cover, 1.0)
            found.append(validated(GroundLine, keys | {"base": base}, str(path)))
        except ValueError as error:
            refused.append(str(error))
    if not found:
        raise ValueError(refused[0])
    return max(found, key=lambda each: each.slope_height)


def _write_line(path: Path, points: Sequence[Point]) -> None:
    """Write points as a table that scenes read."""
    with whole(path) as temporary:
        rows = (f"{x:.10g},{y:.10g}" for x, y in points)
        temporary.write_text("\n".join([f"# {LINES[path.stem]}", "x,elevation", *rows, ""]), encoding="utf-8")
