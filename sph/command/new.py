"""What ``sph new`` writes: a commented scene and study of the user's own slope, from its ground line and a record."""

from __future__ import annotations

import math
import os
import shlex
from collections.abc import Mapping
from contextlib import suppress
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import yaml

import sph
from sph.checks.cover_rows import covers, enough_rows
from sph.checks.layers import of_cover
from sph.checks.messages import sentence
from sph.checks.scene import PLACEHOLDER, PLACEHOLDER_SOIL, to_side
from sph.command.schema import schema_file
from sph.scene.configuration import validated
from sph.scene.ground_line import GroundLine
from sph.scene.ground_motion import read_record
from sph.scene.natural_periods import Column, natural_frequencies
from sph.scene.schema import load_scene
from sph.scene.survey import read_line
from sph.storage.files import whole
from sph.study.cost import ON_REFERENCE, cost
from sph.study.machine import duration

SCENE, STUDY = "scene.yaml", "study.yaml"
ROWS = 20
"""Particles over the height of the slope at least."""
PART, PARTS = 3, 4
"""Share of these for a first look, and to compare with; whole rows at both make the height of the slope and the depth below its toe."""
FINER = 1.5
"""Times as many, to see what finer ones change."""
MAX_COMPARED, MAX_RUN = 3600.0, 86400.0
"""Computing time (s) of a run up to which a cover has the rows that it needs at the coarser spacing as well, and at most."""
GROUND = {"density": 2200.0, "s_wave_speed": 450.0, "cohesion": 200.0, "friction_angle": 38.0}
"""The ground below a cover, to be replaced, in the units of the scene's keys."""
WIDTH = 0.22
"""Over which failure begins, over the slope's height: three spacings even for a first look."""
DEPTH = 0.4
"""Soil below the lowest ground, over the slope's height."""
START, AFTER = 3.0, 5.0
"""Beginning of the record, after the gravity stage, and what is simulated after its end, s."""
MAX_TITLE = 100
"""Most characters of the ground file's name in the title."""

SCENE_TEXT = """\
{scene_schema}# Your own slope.
# Written by `sph new` from {ground} and {record}. The soil is a PLACEHOLDER: replace every line marked REPLACE, then check:
#   sph check {scene_word} --plot scene.png
#   sph fos {scene_word}
#   sph run {scene_word}
# Every key is described in docs/reference/scene-keys.md.
name: {name}
title: {title} # shown in every figure; remove the words in brackets after the last REPLACE
duration: {duration:g} # s, until {after:g} s after the record
geometry:
  shape: ground_line
  file: {ground}
  base: {base:.8g} # m, elevation of the model's base; deeper than any slip surface, whole rows of particles below the toe
  downhill: {downhill}{ends}
# Waves leave through base and sides; put the sides on level ground beyond the debris. The motion is the outcrop motion of the material
# below the base. bedrock: null means that the lowest soil continues below; for a rock motion describe the rock, in kg/m3 and m/s:
#   bedrock: {{density: 2300, s_wave_speed: 800, p_wave_speed: 1500}}
# base: no_slip, sides: free_slip is a rigid box, which reflects the waves
walls: {{base: absorbing, sides: absorbing, bedrock: null}} #         REPLACE null if there is rock below
soil:
  density: {density:g} # kg/m3                                         REPLACE
  shear_wave_speed: {s_wave_speed:g} # m/s; or youngs_modulus in kPa          REPLACE
  poisson_ratio: {poisson_ratio:g} #                                           REPLACE
  cohesion: {cohesion:.1f} # kPa, at the peak                                REPLACE
  friction_angle: {friction_angle:.1f} # degree, at the peak                       REPLACE
  dilation_angle: 0.0 # degree, at most the friction angle; 0: no dilation, as in loose soil and clay
  viscosity: 2.0 # Pa s, of debris above its yield stress; has little effect
  # K0: 0.5 # horizontal over vertical effective stress at rest; left out: nu / (1 - nu) = {rest:.2f}. It decides how near failure soil is
{layers}
coupling:
  S_R: 0.5 # residual over peak strength, from a shear box or ring shear test  REPLACE
  # From the same test, m: displacement at the end of the peak and where the residual strength is reached (docs/model/softening.md)  REPLACE
  # width: of the soil that yields before a slip surface forms, at least three spacings
  softening: {{slip_at_peak: 1.0e-3, slip_at_residual: 0.1, width: {width:g}}}
# Damping ratio at two frequencies: the natural one of the ground with its layers ("column frequency" of sph info, to be looked at again
# when the soil and the layers are final), and five times that; damping also slows blocks that have not failed
damping: {{ratio: 0.03, frequencies: [{low:g}, {high:g}]}} #           REPLACE when the soil is known
motion: {{kind: record, {file}, start: {start:g}, baseline: {{degree: 1}}}} # as recorded, {peak:.3g} m/s2; amplitude: 3.0 scales it
numerics:
  spacing: {spacing:g} # m, {rows} whole rows over the height of the slope{in_cover}; try {finer:g} to see the effect of a finer spacing
"""
LAYERS_TEXT = """\
# layers: # other soils, by depth, elevation or polygon; give only the keys that differ
#   clay: {region: {kind: depth, top: 6.0, bottom: 9.0}, soil: {cohesion: 12.0, friction_angle: 19.0}, S_R: 0.6}"""
COVER_TEXT = """\
layers: # the soil above is the cover; other layers by depth, elevation or polygon, with only the keys that differ
  ground: # below the cover, whose thickness (m, vertically) decides the spacing
    region: {{kind: depth, top: {cover:g}}}
    soil: # REPLACE
      {{density: {density:g}, shear_wave_speed: {s_wave_speed:g}, cohesion: {cohesion:g}, friction_angle: {friction_angle:g}}}"""
STUDY_TEXT = """\
{study_schema}# How far does the slope move, depending on the shaking and on the residual strength of its soil?
#   snakemake --cores 2 --configfile {study_word}
study: {name}
scene: {scene}
fidelity: own
second_fidelity: {second}
grid:
  amplitude: [{amplitudes}] # m/s2: half of the record's peak, the peak, and 1.5 times that; add your design peak, e.g. "0.4g"
  # For soil and layers without an S_R of their own; for one layer write layers.NAME.S_R. Soil with both residual_cohesion and
  # residual_friction_angle does not feel S_R: vary those keys instead
  S_R: ["0.3", "0.5", "0.7"]
  # motion.file: [{record_here}, "another.csv"] # more records, as seen from the folder where you run the study
fidelities:
  coarse: {{numerics: {{spacing: {coarse:g}}}}} # for a first look{at_coarse}
  own: {{}} # the scene as it is
# What must the debris not reach, or the ground not move at? By the distance to the toe, or by x in the coordinates of the survey:
# metrics: {{places: {{house: 15 beyond the toe}}}}
# What would help? Each run is then made for the scene as it is and for each of these, here a lower water level, where the scene has one:
# alternatives: {{drained: {{water: {{file: drained.csv}}}}}}
"""
COMPARED = "coarse # repeats every run with coarser particles, which adds 0.4 of the time: the page then shows the effect; null: no"
NOT_COMPARED = "null # coarser particles would hold the cover; add a fidelity with finer ones to see what they change"


class Rows(NamedTuple):
    """Rows of particles over the height of the slope."""

    own: int  # a multiple of ``PARTS``
    compared: bool = True  # whether the runs are repeated with the coarser ones

    @property
    def coarse(self) -> int:
        """Of the first look."""
        return self.own * PART // PARTS


def write_new(ground: Path, record: Path, folder: Path, component: str | None = None, cover: float | None = None) -> tuple[Path, Path]:
    """Write ``SCENE`` and ``STUDY``, named after it, into a folder, which is made; their paths.

    ``component`` is the horizontal component of a record that holds several, as ``motion.component``; ``cover`` the thickness (m) of weak
    soil on stronger ground, which then has the rows of particles that its run-out needs.

    ValueError for a ground line, a record or a cover that cannot be used, where one of the files exists, and for a path that a line of
    text cannot hold; nothing is left behind then.
    """
    scene, study = folder / SCENE, folder / STUDY
    for path in (scene, study):
        if path.exists():
            raise ValueError(f"--out {folder}: {path} is there already; name another folder")
    for path in (ground, record, folder.absolute()):
        if not str(path).isprintable():
            raise ValueError(f"{str(path)!r}: holds a character that cannot be printed, which a scene file cannot hold; rename it")
    line, downhill = _ground(ground, cover or 0.0)
    motion = read_record(record, component=component)
    height = line.slope_height
    if cover is not None and not 0.0 < cover < height:
        raise ValueError(
            f"--cover {cover:g}: must be above 0 and less than the height of the slope, {height:.4g} m; leave it out without one"
        )
    name = _name(folder.resolve())
    facts: dict[str, Any] = PLACEHOLDER_SOIL | {
        "scene_schema": _schema_line("scene", folder),
        "study_schema": _schema_line("study", folder),
        "name": quoted(name),
        "title": quoted(f"Slope of {ground.name[:MAX_TITLE]} {PLACEHOLDER}"),
        "scene": quoted(str(scene)),
        "scene_word": shlex.quote(str(scene)),
        "study_word": shlex.quote(str(study)),
        "ground": quoted(os.path.relpath(ground, folder)),
        "record": quoted(os.path.relpath(record, folder)),
        "record_here": quoted(str(record)),
        "file": f"file: {quoted(os.path.relpath(record, folder))}" + (f", component: {quoted(component)}" if component else ""),
        "duration": math.ceil(START + float(motion.time[-1]) + AFTER),
        "downhill": downhill,
        "ends": "".join(f"\n  # {sentence(each)}" for each in to_side(line)),
        "rest": PLACEHOLDER_SOIL["poisson_ratio"] / (1.0 - PLACEHOLDER_SOIL["poisson_ratio"]),
        "width": _digits(WIDTH * height, 2),
        "start": START,
        "after": AFTER,
        "peak": motion.peak,
        "layers": COVER_TEXT.format(cover=cover, **GROUND) if cover else LAYERS_TEXT,
        "amplitudes": ", ".join(f'"{factor * motion.peak:.3g}"' for factor in (0.5, 1.0, 1.5)),
    }
    made = [path for path in (folder, *folder.parents) if not path.exists()]
    try:
        folder.mkdir(parents=True, exist_ok=True)
        rows = Rows(ROWS)
        _write(scene, SCENE_TEXT, facts | _of_rows(rows, line, cover))
        if cover is not None and (rows := _enough(height, cover, cost(load_scene(scene)).seconds)) != Rows(ROWS):
            _write(scene, SCENE_TEXT, facts | _of_rows(rows, line, cover))
        load_scene(scene)
        _write(study, STUDY_TEXT, facts | _of_rows(rows, line, cover))
    except BaseException:
        for path in (scene, study):
            path.unlink(missing_ok=True)
        for path in made:
            with suppress(OSError):  # it was not made, or another program has put something there
                path.rmdir()
        raise
    return scene, study


def _write(path: Path, text: str, facts: Mapping[str, Any]) -> None:
    with whole(path) as temporary:
        temporary.write_text(text.format(**facts), encoding="utf-8")


def _enough(height: float, cover: float, seconds: float) -> Rows:
    """Rows that the run-out of a cover needs, of a run that takes ``seconds`` with ``ROWS``: at the coarser spacing as well, unless a run
    then takes longer than ``MAX_COMPARED``.

    ValueError for a cover with which a run takes longer than ``MAX_RUN``.
    """
    needed = math.ceil(height * (enough_rows() or ROWS) / cover * (1.0 - 1e-9))

    def longest(rows: int) -> float:
        return seconds * (rows / ROWS) ** 3

    own = max(ROWS, PARTS * math.ceil(needed / PART))
    if longest(own) > MAX_COMPARED:
        own = max(ROWS, PARTS * math.ceil(needed / PARTS))
    if longest(own) > MAX_RUN:
        raise ValueError(
            f"--cover {cover:g}: {enough_rows()} rows of particles in it, without which it is held, make a run of {duration(longest(own))} "
            f"{ON_REFERENCE}, at most {duration(MAX_RUN)}; leave it out, and make the base of so thin a cover a seam (docs/model/seams.md)"
        )
    found = Rows(own)
    return found._replace(compared=found.coarse >= needed)


def _of_rows(rows: Rows, line: GroundLine, cover: float | None) -> dict[str, Any]:
    """What a scene and a study say of the rows of particles over the height of the slope, and of the base, which is a row."""
    height, toe = line.slope_height, line.toe[1]
    step = height * PARTS / rows.own  # whole rows at both spacings
    depth = math.ceil(toe / step * (1.0 - 1e-9)) * step
    soils = [PLACEHOLDER_SOIL, GROUND] if cover else [PLACEHOLDER_SOIL]
    thickness = [cover, depth + height - cover] if cover else [depth + height]
    column = Column(*map(np.array, (thickness, *([soil[key] for soil in soils] for key in ("s_wave_speed", "density")))))
    frequency = _digits(float(natural_frequencies(column)[0]), 3)

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
        **{
            name: _digits(height / number, 6)
            for name, number in (("spacing", rows.own), ("finer", FINER * rows.own), ("coarse", rows.coarse))
        },
    }


def cover_words(path: Path) -> list[str]:
    """What the rows of particles in the covers of a scene do to its run-out, and what a run costs."""
    scene = load_scene(path)
    takes = f"A run takes {duration(cost(scene).seconds)} {ON_REFERENCE}"
    return [f"{sentence(of_cover(cover, scene))}. {takes}" for cover in covers(scene)]


def quoted(text: str) -> str:
    """A text as YAML that is read as it was, whatever it holds."""
    return yaml.safe_dump(text, default_style='"', allow_unicode=True, width=math.inf).rstrip("\n")


def _name(folder: Path) -> str:
    """Name of the scene and of the study in a folder: its own, of the letters that a name may have."""
    name = "".join(letter if letter.isascii() and (letter.isalnum() or letter in "_.-") else "_" for letter in folder.name)[:60]
    return name if name[:1].isalnum() else f"slope{name}"


def _schema_line(name: str, folder: Path) -> str:
    """The line by which editors find the schema of a file in a folder; none where the repository is not there."""
    schema = Path(sph.__file__).parents[1] / schema_file(name)
    return f"# yaml-language-server: $schema={os.path.relpath(schema, folder)}\n" if schema.is_file() else ""


def _ground(path: Path, cover: float) -> tuple[GroundLine, str]:
    """The ground with a base below it and as deep below a cover as that is thick, and the side to which its largest slope falls."""
    try:
        points = read_line(path)
    except ValueError as error:
        raise ValueError(f"{path}: {error}") from error
    lowest = min(y for _, y in points)
    found, refused = [], []
    for downhill in ("left", "right"):
        keys: dict[str, Any] = {"shape": "ground_line", "points": points, "base": lowest - 1.0, "downhill": downhill}
        try:
            line = validated(GroundLine, keys, str(path))
            base = lowest - max(DEPTH * line.slope_height, 2.0 * cover, 1.0)
            found.append((validated(GroundLine, keys | {"base": base}, str(path)), downhill))
        except ValueError as error:
            refused.append(str(error))
    if not found:
        raise ValueError(refused[0])
    return max(found, key=lambda each: each[0].slope_height)


def _digits(value: float, digits: int) -> float:
    return float(f"{value:.{digits}g}")
