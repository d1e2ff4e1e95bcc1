"""The dimensions of a study: keys of the scene by their dotted paths, of three by a short name, and values as written.

A value stays the string that it was written as, so that file names and labels are what the user wrote; it becomes a number, a word
or null once, in the scene and in the study's tables.
"""

from __future__ import annotations

import functools
import re
import types
import typing
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import PurePath
from typing import Annotated, Any, NamedTuple

from pydantic import BaseModel, BeforeValidator, Field

from sph.scene.configuration import Section
from sph.scene.names import nearest
from sph.scene.schema import Scene
from sph.scene.units import acceleration, beside_g
from sph.storage.trajectory import Variable


class ShortName(NamedTuple):
    """A scene key with a short name as dimension, as it is written."""

    key: str
    symbol: str  # in figures, on the page and in messages
    phrase: str  # in a sentence
    axis: Variable  # in a study's tables


def _short(name: str, key: str, symbol: str, phrase: str, unit: str, text: str) -> ShortName:
    return ShortName(key, symbol, phrase, Variable(name, (name,), "f8", unit, text))


SHORT_NAMES = {
    each.axis.name: each
    for each in (
        _short("S_R", "coupling.S_R", "S_R", "strength ratio S_R", "1", "strength ratio of the fluid state, Eqs. 14-15"),
        _short("gamma", "coupling.gamma", "γ", "rate of the loss of strength γ", "s-1", "rate of the loss of strength, Eq. 9"),
        _short("amplitude", "motion.amplitude", "amplitude", "amplitude of shaking", "m s-2", "amplitude of the ground acceleration"),
    )
}
"""The dimensions with short names, by these."""
AXES = tuple(each.axis for each in SHORT_NAMES.values())
"""The same in a study's tables."""
AMPLITUDE = "amplitude"
"""The dimension of the shaking."""
SAME_LEVEL = 1e-3
"""Relative difference of amplitudes that are one level of shaking, written in g or in m/s2."""
ALTERNATIVE, BASE = "alternative", "base"
"""Dimension of a study with alternatives, and its value for the scene as it is."""
AS_IT_IS = "as it is"
"""That value as it is read."""
SPACING = "numerics.spacing"
"""Dimension of a study that compares spacings itself."""
RECORD = "motion.file"
"""Dimension of the record, whose values have names."""
DIRECTION, DIRECTIONS = "motion.factor", (("1", "as recorded"), ("-1", "reversed"))
"""Dimension of a record's factor, and what its values are called where it is run in both directions."""
CASE = "case"
"""Dimension of a study that is a list of runs, and the column of their names."""
NUMBER = re.compile(r"[+-]?[0-9]+(\.[0-9]*)?([eE][+-]?[0-9]+)?")
NAME = "<name>"
"""Stands for a name of the user's choice in a key."""


def as_written(value: Any) -> Any:
    """A number that YAML has read becomes its shortest text, null the word; quoted values keep theirs, lists item by item."""
    if isinstance(value, list):
        return [as_written(item) for item in value]
    number = isinstance(value, (int, float)) and not isinstance(value, bool)
    return "null" if value is None else repr(value) if number else value


Value = Annotated[
    str,
    Field(max_length=100, pattern=r"^[A-Za-z0-9+-][A-Za-z0-9_./+-]*$"),
    BeforeValidator(as_written, json_schema_input_type=str | float | None),
]
Values = Annotated[tuple[Value, ...], Field(min_length=1)]


def is_number(label: str) -> bool:
    """Whether a value is written as a number."""
    return NUMBER.fullmatch(label) is not None


def value_of(label: str) -> float | str | None:
    """What a scene is given for a value as written: a number, nothing for null, else the word."""
    return None if label == "null" else float(label) if is_number(label) else label


class Dimension(NamedTuple):
    """What a study varies."""

    name: str  # in the configuration, in file names and in tables
    unit: str  # of the scene's key
    text: str  # its meaning
    words: bool  # some value is no number
    names: tuple[tuple[str, str], ...] = ()  # values that are called otherwise than they are written, as a record's file
    plainly: bool = False  # called in words where its name has a symbol

    def shown(self, value: str) -> str:
        """A value as it is read: an acceleration in g as well, a record by its name."""
        return dict(self.names).get(value) or beside_g(value, self.unit)

    @property
    def named(self) -> bool:
        """Whether values stand beside each other, each by its name."""
        return self.words or bool(self.names)

    @property
    def symbol(self) -> str:
        """Name for figures and pages."""
        if self.names == DIRECTIONS:
            return "direction"
        if self.plainly:
            return functools.reduce(lambda words, each: words.replace(*each), PLAIN.items(), readable(self.name))
        return readable(self.name)

    @property
    def phrase(self) -> str:
        """The same in a sentence."""
        return SHORT_NAMES[self.name].phrase if self.name in SHORT_NAMES and not self.plainly else self.symbol

    @property
    def label(self) -> str:
        """Symbol and unit."""
        return f"{self.symbol} ({self.shown_unit})" if self.shown_unit else self.symbol

    @property
    def shown_unit(self) -> str:
        """Unit as it is printed; nothing for a number without one."""
        return shown_unit(self.unit)

    def said(self, value: str) -> str:
        """Symbol, value and unit; an acceleration in g as well."""
        if self.name == ALTERNATIVE:
            return self.shown(value)
        if value in dict(self.names):
            return f"{self.symbol} {self.shown(value)}"
        number, *of_gravity = beside_g(value, self.unit).split(" ", 1)
        return " ".join(word for word in (self.symbol, number, self.shown_unit, *of_gravity) if word)

    def equation(self, value: float | str) -> str:
        """The same as an equation, a number in its shortest form: ``S_R = 0.1``."""
        number = value if isinstance(value, str) else f"{value:g}"
        if number in dict(self.names):
            return self.said(number)
        return f"{self.symbol} = {number} {self.shown_unit}".rstrip()

    def variable(self, listed: bool) -> Variable:
        """The coordinate of a study's table: a dimension of its own, or one along the cases of a list."""
        kind, unit = ("str" if self.words else "f8"), "1" if self.unit == "-" else self.unit
        known = SHORT_NAMES.get(self.name)
        axis = known.axis if known else Variable(self.name, (self.name,), "f8", unit, f"{scene_key(self.name)}: {self.text}")
        return axis._replace(dims=(CASE,) if listed else axis.dims, dtype=kind)


PRINTED = {"-": "", "1": "", "1/s": "s⁻¹"}
"""Units that are printed otherwise than with raised digits."""


def short_names(files: Sequence[str]) -> dict[str, str]:
    """Files by as little of their paths as tells them apart: the name without its ending, with it, and folders before that."""

    def tails(file: str) -> list[str]:
        path = PurePath(file)
        return [str(PurePath(*of.parts[-last:])) for last in range(1, len(path.parts) + 1) for of in (path.with_suffix(""), path)]

    taken = Counter(tail for file in files for tail in {*tails(file)})
    return {file: next((tail for tail in tails(file) if taken[tail] == 1), file) for file in files}


def shown_unit(unit: str) -> str:
    """A unit as it is printed; nothing for a number without one."""
    return PRINTED[unit] if unit in PRINTED else re.sub(r"(?<=[a-z])[23]", lambda power: "²³"[int(power[0]) - 2], unit)


WORDS = {
    **{name: each.symbol for name, each in SHORT_NAMES.items()},
    "youngs_modulus": "Young's modulus",
    "poisson_ratio": "Poisson's ratio",
    "stochastic": "synthetic motion",
    "motion.file": "record",
    "softening.slip_at_peak": "slip at the peak",
    "softening.slip_at_residual": "slip at the residual strength",
}
"""Parts of keys, and ends of two parts, that are not read as they are written."""
SYMBOLS = {"S_R": "residual strength ratio", "γ": "rate of the loss of strength"}
"""Symbols, and what they are called in words."""
PLAIN = {**SYMBOLS, "amplitude": "amplitude of shaking"}
"""What readers are told who do not know the symbols."""
UNNAMED = ("soil", "coupling", "numerics", "geometry", "region", "uncertain", "variables")
"""Sections that the name of a key does without."""


def readable(name: str) -> str:
    """Name of a key of a scene, or of a dimension, as it is read: ``cohesion of clay`` for ``layers.clay.soil.cohesion``."""
    *sections, last = name.split(".")
    if sections and f"{sections[-1]}.{last}" in WORDS:
        last = f"{sections.pop()}.{last}"
    word = WORDS.get(last, last.replace("_", " "))
    owners = [section for section in sections if section not in UNNAMED]
    if not owners:
        return word
    return f"{word} of {'' if owners[0] == 'layers' else 'the '}{WORDS.get(owners[-1], owners[-1].replace('_', ' '))}"


def scene_key(name: str) -> str:
    """The dotted scene key of a dimension."""
    return SHORT_NAMES[name].key if name in SHORT_NAMES else name


def title_of(dimensions: Iterable[Dimension], point: Mapping[str, str]) -> str:
    """A point in words: every dimension with value and unit."""
    return ", ".join(d.said(point[d.name]) for d in dimensions)


def in_order(names: Iterable[str]) -> list[str]:
    """Dimensions in the order of file names and tables: those with short names first, then as written."""
    names = list(names)
    return [name for name in SHORT_NAMES if name in names] + [name for name in names if name not in SHORT_NAMES]


def point_name(point: Mapping[str, str]) -> str:
    """Name of a point in file names; ~, which no value holds, stands for the slash of a file in a folder."""
    return "_".join(f"{name}-{point[name].replace('/', '~')}" for name in in_order(point))


def check_names(where: str, names: Iterable[str]) -> None:
    """ValueError for a dimension that is not a key of a scene, with the nearest one, and for two that set one key."""
    keys: dict[str, str] = {}
    for name in names:
        key = scene_key(name)
        if name == ALTERNATIVE:
            continue
        check_key(f"{where}.{name}", key)
        if key in keys:
            raise ValueError(f"{where}: {keys[key]} and {name} set the same key")
        keys[key] = name


def check_key(where: str, key: str) -> None:
    """ValueError, which begins with ``where``, for a dotted key that no scene has, with the nearest one."""
    if not any(_matches(key, known) for known in scene_keys()):
        raise ValueError(f"{where}: there is no such key in a scene{nearest(key, [*SHORT_NAMES, *scene_keys()])}")


def value_at(scene: Scene, key: str, where: str) -> tuple[Any, str]:
    """What a scene has at a dotted key, of a layer too, and its unit; ValueError, which begins with ``where``, names what there is."""
    check_key(f"{where}: {key}", key)
    at: Any = scene
    unit, path = "-", list[str]()
    for part in key.split("."):
        known = at if isinstance(at, Mapping) else type(at).model_fields if isinstance(at, Section) else {}
        if part not in known:
            there = f"it has {', '.join(known)}" if known else f"write {'.'.join(path)} in the scene, or in overrides"
            raise ValueError(f"{where}: {key}: {'.'.join(path)} of the scene has no {part}; {there}")
        extra: Any = getattr(known[part], "json_schema_extra", None) or {}
        unit, at = extra.get("unit", "-"), at[part] if isinstance(at, Mapping) else getattr(at, part)
        path.append(part)
    return at, unit


def number_at(scene: Scene, key: str, where: str) -> tuple[float, str]:
    """The number that a scene has at a dotted key, and its unit; ValueError likewise where it is none."""
    value, unit = value_at(scene, key, where)
    if not isinstance(value, (int, float)):
        there = "null" if value is None else repr(value) if isinstance(value, str) else "no number"
        raise ValueError(f"{where}: {key}: is {there} in the scene, and must be a number there; write one in the scene, or in overrides")
    return float(value), unit


def _matches(key: str, known: str) -> bool:
    parts, wanted = key.split("."), known.split(".")
    return len(parts) == len(wanted) and all(part == other or other == NAME and part for part, other in zip(parts, wanted, strict=True))


def in_si(values: Any) -> Any:
    """Values of dimensions by name, where an acceleration is written with its unit (``0.4g``) the number in m/s2 instead."""
    if not isinstance(values, Mapping):
        return values
    return {name: _in_si(each) if scene_keys().get(scene_key(str(name))) == "m/s2" else each for name, each in values.items()}


def _in_si(value: Any) -> Any:
    if isinstance(value, Mapping):
        return {name: _in_si(each) if name == "bounds" else each for name, each in value.items()}
    if isinstance(value, (list, tuple)):
        return [_in_si(each) for each in value]
    return f"{acceleration(value):.12g}" if isinstance(value, str) and value != "null" and not is_number(value) else value


@functools.cache
def scene_keys() -> dict[str, str]:
    """Unit of every dotted key of a scene that can hold a number, a word or null, of all variants; ``NAME`` stands for a name."""
    return dict(_keys(Scene))


def _keys(model: type[BaseModel], prefix: str = "") -> Iterator[tuple[str, str]]:
    for name, field in model.model_fields.items():
        yield prefix + name, (field.json_schema_extra or {}).get("unit", "-")  # type: ignore[union-attr, misc]
        for section in sections(field.annotation):
            yield from _keys(section, f"{prefix}{name}.")
        if _mappings(field.annotation):
            yield f"{prefix}{name}.{NAME}", "-"
        for section in named_sections(field.annotation):
            yield from _keys(section, f"{prefix}{name}.{NAME}.")


def sections(annotation: Any) -> list[type[BaseModel]]:
    """The sections that a key's type allows."""
    return [part for part in _parts(annotation) if isinstance(part, type) and issubclass(part, BaseModel)]


def named_sections(annotation: Any) -> list[type[BaseModel]]:
    """Sections that a mapping holds under names of the user's choice."""
    return [section for mapping in _mappings(annotation) for section in sections(typing.get_args(mapping)[1])]


def _mappings(annotation: Any) -> list[Any]:
    return [part for part in _parts(annotation) if typing.get_origin(part) is dict]


def _parts(annotation: Any) -> list[Any]:
    """The types that a type allows, one by one."""
    if typing.get_origin(annotation) in (typing.Union, types.UnionType, typing.Annotated):
        return [part for inner in typing.get_args(annotation) for part in _parts(inner)]
    return [annotation]


def named(name: str) -> Dimension:
    """A dimension with a short name, of numbers, as its key is declared."""
    return Dimension(name, scene_keys()[scene_key(name)], SHORT_NAMES[name].axis.text, words=False)


def dimension(name: str, labels: Iterable[str], scene: Scene) -> Dimension:
    """A dimension with the unit and the meaning that the scene's key is declared with, from a scene in which it is set."""
    if name == ALTERNATIVE:
        return Dimension(name, "-", "variant of the scene, by its name in the study", True, ((BASE, AS_IT_IS),))
    at: Any = scene
    unit, text, labels = "-", "", list(labels)
    for part in scene_key(name).split("."):
        field = type(at).model_fields.get(part) if isinstance(at, Section) else None
        if field is not None:
            extra: Any = field.json_schema_extra or {}
            unit, text = extra.get("unit", "-"), field.description or ""
        at = at.get(part) if isinstance(at, Mapping) else getattr(at, part, None)
    turned = name == DIRECTION and {"-1"} <= {*labels} <= {*dict(DIRECTIONS)}
    return Dimension(name, unit, text, not all(map(is_number, labels)), DIRECTIONS if turned else ())
