"""What a user types of a slope for ``sph new``: read from its options, and refused by option before anything is drawn."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import NamedTuple

from pydantic import TypeAdapter, ValidationError

from sph.checks.scene import PLACEHOLDER_SOIL
from sph.command.options import parse_acceleration, parse_numbers, parse_values
from sph.scene.configuration import validated
from sph.scene.ground_motion import read_record
from sph.scene.ground_motion.units import Unit
from sph.scene.names import check_known
from sph.scene.soil import Softening
from sph.scene.units import GRAVITY
from sph.study.dimensions import Value

SOIL = ("density", "shear_wave_speed", "poisson_ratio", "cohesion", "friction_angle", "residual_cohesion", "residual_friction_angle")
"""Keys of a soil in the order in which they are written."""
UNIT_WEIGHT = "unit_weight"
"""What is typed in place of the density, kN/m3."""
AS_SOIL = "as unit_weight=19,cohesion=6,friction_angle=32,residual_cohesion=0,residual_friction_angle=20"
EXAMPLES = {
    "--soil": AS_SOIL,
    "--below": AS_SOIL,
    "--softening": "as slip_at_peak=0.003,slip_at_residual=0.07,shape=exponential, slips in m as sph fit-shear prints them",
    "--alternative": "as drained=4,berm=3,reinforced=10: the depth of the lowered water table, or by how much its line is lowered, and the "
    "height of the berm, m; the cohesion that roots or nails add, kPa",
}
"""What options with names and numbers are to look like."""
PLACEHOLDERS = {"shear_wave_speed" if name == "s_wave_speed" else name: value for name, value in PLACEHOLDER_SOIL.items()}
RESIDUAL = "residual_"
"""Beginning of the keys that a layer has only where the soil has them."""
ROCK = {
    "density": 2200.0,
    "shear_wave_speed": 450.0,
    "cohesion": 200.0,
    "friction_angle": 38.0,
    "residual_cohesion": 50.0,
    "residual_friction_angle": 34.0,
}
"""The ground below a cover where nothing else is typed, weathered rock, in the units of the scene's keys."""
GENTLEST, STEEPEST = 5.0, 80.0
"""Angles of a plain slope, degree."""


class Known(NamedTuple):
    """What the user knows of a slope."""

    ground: Path | tuple[float, float]  # file of a survey, or height (m) and angle (degree) of a plain slope
    records: Sequence[Path]
    component: str | None = None  # of records that hold several
    unit: Unit | None = None  # of records that state none
    peaks: Sequence[str] = ()  # accelerations to which the records are scaled, as a study has them
    cover: float | None = None  # thickness of weak soil on stronger ground, m
    soil: Mapping[str, float] = {}  # by ``SOIL``, with ``UNIT_WEIGHT`` for the density
    below: Mapping[str, float] = {}  # the same of the ground below the cover
    water: float | Path | None = None  # depth below the ground, m, or the file of a line
    places: Mapping[str, float | str] = {}  # x, m, or a distance beyond the toe
    alternatives: Mapping[str, float] = {}
    """drained: depth of the water, m, or by how much a line is lowered; berm: its height, m; reinforced: cohesion, kPa"""
    softening: Mapping[str, float | str] = {}  # loss of strength with slip, by the keys of a scene
    design: str = ""  # that one of the peaks which the page answers first

    @property
    def own_soil(self) -> dict[str, float]:
        """The keys of the soil that were typed, in the units of the scene."""
        return with_density(self.soil)

    @property
    def lowest_soil(self) -> dict[str, float]:
        """The keys of the ground below the cover, or of the soil where it has none."""
        return self.whole_soil if self.cover is None else ROCK | with_density(self.below)

    @property
    def whole_soil(self) -> dict[str, float]:
        """The keys of the soil, placeholders for those that were not typed among them."""
        known = PLACEHOLDERS | self.own_soil
        return {key: known[key] for key in SOIL if key in known}

    @property
    def has_residual(self) -> bool:
        """Whether the residual strength was typed."""
        return any(key.startswith(RESIDUAL) for key in self.soil)

    def of_layer(self, soil: Mapping[str, float]) -> dict[str, float]:
        """The keys of a layer's soil: without residual strengths, which S_R would not vary, where the scene's soil has none."""
        return {key: value for key, value in soil.items() if self.has_residual or not key.startswith(RESIDUAL)}


def with_density(soil: Mapping[str, float]) -> dict[str, float]:
    """The keys of a soil as a scene has them, with its density in the place of a unit weight."""
    density = {"density": to_digits(1e3 * soil[UNIT_WEIGHT] / GRAVITY, 4)} if UNIT_WEIGHT in soil else {}
    return density | {key: value for key, value in soil.items() if key != UNIT_WEIGHT}


def read_peak(text: str) -> str:
    """A peak acceleration with its unit, as a study has it: in g where it was typed so, else in m/s2."""
    value = parse_acceleration(text, "--scale-to")
    return text.replace(" ", "") if text.endswith("g") else f"{value:.4g}m/s2"


def read_plain(text: str) -> tuple[float, float]:
    """Height (m) and angle (degree) of a plain slope."""
    plain = parse_numbers(text, "--slope") or ()
    if len(plain) != 2:
        raise ValueError(f"--slope {text!r}: write a height (m) and an angle (degree), as 28,32")
    return plain[0], plain[1]


def read_numbers(texts: list[str] | None, option: str) -> dict[str, float]:
    try:
        values = parse_values(texts, option)
    except ValueError as error:
        raise ValueError(f"{error}: {EXAMPLES[option]}") from error
    for name, value in values.items():
        if isinstance(value, str) or not math.isfinite(value):
            raise ValueError(f"{option} {name}={value}: must be a number; {EXAMPLES[option]}")
    return {name: float(value) for name, value in values.items()}


def read_softening(texts: list[str] | None) -> dict[str, float | str]:
    """Loss of strength with slip, as a scene takes it; its width (m) may be left out."""
    option = "--softening"
    try:
        typed = parse_values(texts, option)
        if typed and not {"slip_at_peak", "slip_at_residual"} <= typed.keys():
            raise ValueError(f"{option}: give both slip_at_peak and slip_at_residual")
        if typed:
            validated(Softening, {"width": 1.0, **typed}, option)
    except ValueError as error:
        raise ValueError(f"{error}: {EXAMPLES[option]}") from error
    return typed


def read_depth(text: str) -> float | Path:
    try:
        return float(text)
    except ValueError:
        return Path(text)


def refuse(wrong: Iterable[str]) -> None:
    """ValueError with all that is wrong, a line each, if there is anything."""
    if told := "\n".join(wrong):
        raise ValueError(told)


def refused(known: Known) -> Iterator[str]:
    """What is refused before anything is drawn, by option."""
    if not known.records:
        yield "--record: is missing; give the file of a ground motion, or of several, each with --record"
    if not isinstance(known.ground, Path):
        height, angle = known.ground
        if 0.0 < height < math.inf and GENTLEST <= angle <= STEEPEST:
            yield from too_high(known, height)
        else:
            allowed = f"a height above 0 m and an angle from {GENTLEST:g} to {STEEPEST:g} degree"
            yield f"--slope {height:g},{angle:g}: must be {allowed}, as 28,32"
    for option, names, known_names in (
        ("--soil", known.soil, (UNIT_WEIGHT, *SOIL[1:])),
        ("--below", known.below, (UNIT_WEIGHT, *SOIL[1:])),
        ("--alternative", known.alternatives, ("drained", "berm", "reinforced")),
    ):
        try:
            check_known(option, names, known_names)
        except ValueError as error:
            yield str(error)
    strength = [key for key in known.below if key in ("cohesion", "friction_angle")]
    if strength and known.has_residual and not any(key.startswith(RESIDUAL) for key in known.below):
        yield f"--below {strength[0]}: give residual_cohesion and residual_friction_angle as well, as for --soil"
    if known.below and known.cover is None:
        yield "--below: is the soil below a cover; give its thickness with --cover"
    for option, soil in (("--soil", known.soil), ("--below", known.below)):
        residual = [key for key in soil if key.startswith(RESIDUAL)]
        if len(residual) == 1:
            yield (
                f"{option} {residual[0]}: give residual_cohesion (0 is usual) and residual_friction_angle, or neither: then S_R times the "
                "peak is varied"
            )
        elif residual and not known.has_residual:
            yield f"{option} {residual[0]}: give the residual strength of --soil as well, or of neither"
        if not 10.0 <= soil.get(UNIT_WEIGHT, 20.0) <= 30.0:
            yield f"{option} {UNIT_WEIGHT}={soil[UNIT_WEIGHT]:g}: must be from 10 to 30 kN/m3, with its water"
    lowered = known.alternatives.get("drained")
    wet = known.water if isinstance(known.water, float) else 0.0
    if not 0.0 <= wet < math.inf:
        yield f"--water {wet:g}: must be a depth below the ground, 0 m or more, or the file of a line"
    if lowered is not None and known.water is None:
        yield f"--alternative drained={lowered:g}: there is no water to drain; give --water"
    elif lowered is not None and not wet < lowered < math.inf:
        must = (
            f"above 0 m; it is by how much the line of {known.water} is lowered"
            if isinstance(known.water, Path)
            else f"deeper below the ground than --water, {wet:g} m; it is the depth of the lowered water table"
        )
        yield f"--alternative drained={lowered:g}: must be {must}"
    added = known.alternatives.get("reinforced", 1.0)
    if not 0.0 < added < math.inf:
        yield f"--alternative reinforced={added:g}: must be above 0 kPa; it is the cohesion that roots or nails add"
    for record in known.records:
        try:
            if len(known.records) > 1:
                TypeAdapter(Value).validate_python(str(record))
            read_record(record, known.unit, known.component)
        except ValidationError:
            yield (
                f"--record {record}: of several records, each must lie in this folder or below it and be given by its path from here, as "
                "quakes/kobe.csv, with no characters but letters, digits and . _ + - /; copy or rename it"
            )
        except (ValueError, OSError) as error:
            yield f"--record {error}"


def too_high(known: Known, height: float) -> Iterator[str]:
    """A cover and a berm that do not fit a slope of a height (m)."""
    for option, value, hint in (
        ("--cover ", known.cover, "leave it out without one"),
        ("--alternative berm=", known.alternatives.get("berm"), "it is the berm's height"),
    ):
        if value is not None and not 0.0 < value < height:
            yield f"{option}{value:g}: must be above 0 and less than the height of the slope, {height:.4g} m; {hint}"


def to_digits(value: float, digits: int) -> float:
    return float(f"{value:.{digits}g}")
