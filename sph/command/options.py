"""The arguments and options that commands of ``sph`` share, and how their texts are read.

What is imported to read a text is imported then: ``sph --help`` waits for nothing.
"""

from __future__ import annotations

import re
import typing
from pathlib import Path
from typing import Annotated, Any

import typer

MIN_ACCELERATION = 1e-6
"""Smallest yield acceleration, m/s2; a block slides the farther the smaller it is."""
EXAMPLES = {"--set": "coupling.S_R=0.10", "--rule": "displacement=0.02"}

SceneFile = Annotated[Path, typer.Argument(metavar="SCENE", help="scene file (YAML), or a trajectory (netCDF), which contains its scene")]
CheckedFile = Annotated[
    Path | None,
    typer.Argument(metavar="[SCENE]", help="scene file (YAML), a trajectory (netCDF), or a study (YAML), which names its scene"),
]
Settings = Annotated[
    list[str] | None,
    typer.Option(
        "--set",
        metavar="KEY=VALUE",
        help="change one key, e.g. coupling.S_R=0.10; a section in braces takes the place of the whole old one; may be repeated",
    ),
]
Trajectory = Annotated[Path, typer.Argument(metavar="FILE", help="trajectory file (netCDF)")]
STUDY = "configuration of a study (YAML), as for snakemake --configfile"
Study = Annotated[Path, typer.Argument(metavar="STUDY", help=f"{STUDY}; one without a scene overrides keys of config/config.yaml")]
Progressing = Annotated[
    Path | None,
    typer.Argument(metavar="[STUDY]", help=f"{STUDY}, or its results, results/<study>/<fidelity>; by default config/config.yaml"),
]
WithPlaces = Annotated[Path | None, typer.Option("--configfile", help="configuration of a study whose places (metrics.places) to draw")]
Configfile = Annotated[Path | None, typer.Option(help="the study's configuration, as for snakemake --configfile")]
AsJson = Annotated[bool, typer.Option("--json", help="machine-readable, in SI units")]
Picture = Annotated[Path | None, typer.Option("--plot", metavar="PICTURE", help="picture to write (.png, .pdf, .svg)")]
Tolerance = Annotated[float, typer.Option(max=1, help="relative width of the bracket at which the search ends")]
Rule = Annotated[
    list[str] | None,
    typer.Option("--rule", metavar="KEY=VALUE", help="change the failure rule: displacement, area, observation, ramp; may be repeated"),
]
Trials = Annotated[Path | None, typer.Option(help="table of the trials to write (CSV)")]
Spacings = Annotated[
    str | None,
    typer.Option(
        metavar="COARSE,FINE",
        help="two spacings (m) to extrapolate from; by default the scene's own and about twice that, both dividing the slope's height",
    ),
]
Single = Annotated[bool, typer.Option("--single", help="search only at the scene's own spacing, without extrapolation")]
Unit = Annotated[
    str | None,
    typer.Option("--unit", help="unit of a record whose file does not state it: m/s2, cm/s2, gal or g; m/s or cm/s of velocities"),
]
Component = Annotated[
    str | None,
    typer.Option(
        "--component", metavar="NAME", help="horizontal component of a record that holds several: its name, e.g. N-S, or its number"
    ),
]
Baseline = Annotated[
    int | None,
    typer.Option(
        "--baseline", metavar="DEGREE", help="remove drift, like motion.baseline of a scene: degree 0 an offset, 1 a straight line"
    ),
]
BandPass = Annotated[
    str | None,
    typer.Option(
        "--band-pass", metavar="LOW,HIGH", help="band-pass filter, like motion.band_pass of a scene: corner frequencies in Hz, e.g. 0.1,25"
    ),
]


def parse_settings(settings: list[str] | None, option: str = "--set") -> dict[str, Any]:
    """``["coupling.S_R=0.1"]`` as nested overrides; ValueError for anything that is not KEY=VALUE."""
    from sph.scene.configuration import DEEPEST, dotted, parse_yaml

    pairs = {}
    for setting in settings or []:
        name, equals, text = setting.partition("=")
        if not equals or not all(name.split(".")) or name.count(".") > DEEPEST:
            raise ValueError(f"{option} {setting!r}: write KEY=VALUE, e.g. {EXAMPLES[option]}")
        if name in pairs:
            raise ValueError(f"{option} {setting!r}: {name} is set twice; write it once")
        try:
            pairs[name] = parse_yaml(text)
        except ValueError as error:
            raise ValueError(f"{option} {setting!r}: the value is not readable: {error}") from error
    try:
        return dotted(pairs)
    except ValueError as error:
        raise ValueError(f"{option} {error}") from error


def parse_conditions(texts: list[str] | None) -> dict[str, str]:
    """``["S_R=0.10"]`` as {"S_R": "0.10"}; ValueError for anything that is not COLUMN=VALUE."""
    wrong = [text for text in texts or () if "=" not in text]
    if wrong:
        raise ValueError(f"{wrong[0]!r}: write COLUMN=VALUE, e.g. S_R=0.10")
    return dict(text.split("=", 1) for text in texts or ())


def parse_error(text: str) -> float:
    """``"10%"`` or ``"0.1"`` as 0.1; ValueError for anything else."""
    number, percent = text.strip().removesuffix("%"), text.strip().endswith("%")
    try:
        return float(number) / (100 if percent else 1)
    except ValueError as error:
        raise ValueError(f"--error {text!r}: write 10% or 0.1") from error


def parse_numbers(text: str | None, option: str) -> tuple[float, ...] | None:
    """``"2,1"`` as (2.0, 1.0); ValueError naming the option for anything else."""
    if text is None:
        return None
    try:
        return tuple(float(number) for number in text.split(","))
    except ValueError as error:
        raise ValueError(f"{option} {text!r}: write numbers with commas between them, e.g. 2,1") from error


def parse_values(texts: list[str] | None, option: str) -> dict[str, float | str]:
    """``["road=8,house=40"]`` as {"road": 8.0, "house": 40.0}, a value that is no number as its text; ValueError naming the option for
    anything that is not NAME=VALUE, and for a name that is there twice."""
    values: dict[str, float | str] = {}
    for pair in ",".join(texts or ()).split(",") if texts else ():
        name, equals, text = (part.strip() for part in pair.partition("="))
        if not (name and equals and text):
            raise ValueError(f"{option} {pair!r}: write NAME=VALUE, and several with commas between them")
        if name in values:
            raise ValueError(f"{option} {pair!r}: {name} is given twice; give it once")
        try:
            values[name] = float(text)
        except ValueError:
            values[name] = text
    return values


def parse_acceleration(text: str, option: str) -> float:
    """``"2.5 m/s2"`` or ``"0.25g"`` in m/s2; ValueError naming the option for anything else, a bare number among it, and unless positive
    and finite."""
    from sph.scene.ground_motion import MAX_ACCELERATION
    from sph.scene.units import acceleration

    bare = text.strip()
    if re.fullmatch(r"[-+]?(\d+\.?\d*|\.\d+)([eE][-+]?\d+)?", bare):
        raise ValueError(f"{option} {text!r}: has no unit; write {bare}g or {bare} m/s2, whichever is meant")
    try:
        value = float(acceleration(text))
    except ValueError as error:
        raise ValueError(f"{option} {text!r}: {error}") from error
    if not MIN_ACCELERATION <= value <= MAX_ACCELERATION:
        raise ValueError(f"{option} {text!r}: must be positive and finite, from {MIN_ACCELERATION:g} to {MAX_ACCELERATION:g} m/s2")
    return value


def parse_treatment(unit: str | None, baseline: int | None, band_pass: str | None, component: str | None = None) -> dict[str, Any]:
    """The options that treat a record as the keys of a scene's ``motion``, those that were given; ValueError names the option."""
    from sph.scene.ground_motion.units import Unit
    from sph.scene.names import check_known

    check_known("--unit", [unit], typing.get_args(Unit))
    treatment: dict[str, Any] = {} if unit is None else {"unit": unit}
    if component is not None:
        treatment["component"] = component
    if baseline is not None:
        treatment["baseline"] = {"degree": baseline}
    if band_pass is not None:
        try:
            low, high = (float(corner) if corner.strip() else None for corner in band_pass.split(","))
        except ValueError as error:
            raise ValueError(
                f"--band-pass {band_pass!r}: write two corner frequencies in Hz, as 0.1,25, or one of them with the comma, as 0.1, or ,25"
            ) from error
        treatment["band_pass"] = {"low": low, "high": high}
    return treatment
