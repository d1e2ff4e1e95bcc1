"""Declaring, reading and checking configuration: scenes and studies.

A section is a frozen pydantic model.  Every key is declared once, with its sentence, unit, source,
default and range (``key``); the tables in ``docs/reference`` are generated from these declarations.
"""

from __future__ import annotations

import os
import re
import stat
import typing
from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Annotated, Any, ClassVar, TypeVar

import yaml
from pydantic import AfterValidator, BaseModel, ConfigDict, Field, GetJsonSchemaHandler, ValidationError, model_validator

from sph.scene.names import nearest


class Section(BaseModel):
    """A frozen part of a scene; unknown keys and non-finite numbers are errors."""

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)


def key(text: str, unit: str = "-", source: str = "ours", **constraints: Any) -> Any:
    """Declare one key: sentence, unit, source (paper section or 'ours'), default and range."""
    return Field(description=text, json_schema_extra={"unit": unit, "source": source}, **constraints)


def without_unnamed(section: Section, stored: dict[str, Any], names: Sequence[str]) -> dict[str, Any]:
    """What is stored of a section without those of these keys that are null and that nobody named."""
    return {name: value for name, value in stored.items() if value is not None or name not in names or name in section.model_fields_set}


CONTENT_KEYS = ("points", "data")
"""Keys whose values may stand in a file instead, named by the key ``file`` beside them."""


class FileSection(Section):
    """A section whose content may stand in a file of the user's.

    The file is read when the section is built and its content kept in the keys ``content`` names, so that a scene
    stored with its results repeats without it; ``file`` stays as a record of where the content came from.
    """

    content: ClassVar[tuple[str, ...]]  # of CONTENT_KEYS

    file: str | None = key(
        "file with the content, relative to the scene's file or else to the working folder", default=None, min_length=1, max_length=1000
    )

    @classmethod
    def read_content(cls, path: Path, keys: Mapping[str, Any]) -> dict[str, Any]:
        """The keys of ``content`` in a file; ``keys`` are those given beside it, not checked yet.  ValueError says what is wrong where."""
        raise NotImplementedError

    @classmethod
    def __get_pydantic_json_schema__(cls, core_schema: Any, handler: GetJsonSchemaHandler) -> dict[str, Any]:
        """The content need not be given where a file is."""
        schema = handler(core_schema)
        own = handler.resolve_ref_schema(schema)
        own["required"] = [name for name in own.get("required", ()) if name not in cls.content]
        return schema

    @model_validator(mode="before")
    @classmethod
    def _filled_in(cls, keys: Any) -> Any:
        if (
            not isinstance(keys, Mapping)
            or not isinstance(keys.get("file"), str)
            or any(keys.get(name) is not None for name in cls.content)
        ):
            return keys
        try:
            check_file(keys["file"])
            return {**keys, **cls.read_content(Path(keys["file"]), keys)}
        except (OSError, ValueError) as error:
            reason = error.strerror or error if isinstance(error, OSError) else error
            raise ValueError(f"file: {one_line(keys['file'])}: {reason}") from error


def check_file(name: str) -> None:
    """ValueError for what is no file with content: nothing, a folder, a device or a pipe."""
    try:
        mode = os.stat(name).st_mode
    except (OSError, ValueError) as error:
        raise ValueError(f"there is no such file, seen from {Path.cwd()}") from error
    if not stat.S_ISREG(mode):
        raise ValueError(f"is {'a folder' if stat.S_ISDIR(mode) else 'a device or a pipe'}; name a file")


VARIANT_KEYS = ("shape", "law", "kind")
"""Keys that choose between the variants of a section."""
RESERVED = ("file", *CONTENT_KEYS, *VARIANT_KEYS)
"""Keys that mean the same in every section that has them, so that nothing may have their names."""


def _free(name: str) -> str:
    if name in RESERVED:
        raise ValueError(f"{', '.join(RESERVED)} are keys of other sections; choose another name")
    return name


OwnName = Annotated[str, Field(pattern=r"^[A-Za-z][A-Za-z0-9_]{0,31}$"), AfterValidator(_free)]
"""Name of a layer, a probe or an uncertain variable."""


MAX_FILE = 2_000_000
"""Largest YAML file, bytes."""
DEEPEST = 30
"""Deepest nesting of sections and lists."""
DECIMAL = {"int": re.compile(r"[+-]?(0|[1-9][0-9]*)"), "float": re.compile(r"[^_:]*")}
"""How the numbers are written that every reader takes for the same: not 030, 1:30, 0x1F and 1_000, which are 24, 90, 31 and 1000 in YAML
1.1, and words or other numbers elsewhere."""
MAX_LINES, MAX_LINE = 30, 600
"""Most lines of a refusal, and their longest, characters."""

Model = TypeVar("Model", bound=Section)


def read_yaml(path: Path | str) -> dict[str, Any]:
    """Mapping in a YAML file; raises ValueError naming the file when it is none."""
    try:
        with Path(path).open("rb") as file:
            text = file.read(MAX_FILE + 1)
        if len(text) > MAX_FILE:
            raise ValueError(f"it is larger than {MAX_FILE:,} bytes")
        data = parse_yaml(text.decode("utf-8"))
    except (OSError, ValueError) as error:
        raise ValueError(f"{path}: cannot be read as YAML: {error}") from error
    if not isinstance(data, dict):
        raise ValueError(f"{path}: must hold a mapping of keys, found {type(data).__name__}")
    return data


def check_files(paths: Iterable[Path | str]) -> None:
    """ValueError for a YAML file that ``read_yaml`` refuses, though others read it: 030 as 24, and of two equal keys the last."""
    for path in paths:
        read_yaml(path)


def parse_yaml(text: str) -> Any:
    """Plain data in a YAML text; raises ValueError where it is malformed or too deep, has a key twice or a number that is not decimal."""
    try:
        loader = yaml.SafeLoader(text)
        node = loader.get_single_node()
        if node is None:
            return None
        _check(node)
        return loader.construct_document(node)
    except RecursionError as error:
        raise ValueError(f"it is nested deeper than {DEEPEST} levels") from error
    except Exception as error:  # PyYAML passes on whatever a value provokes: KeyError for '!!bool x', AttributeError for '!!timestamp x'
        raise ValueError(str(error) or type(error).__name__) from error


def _check(node: yaml.Node, path: tuple[Any, ...] = ()) -> None:
    """Refuse keys that are there twice, numbers that are not decimal, and what is too deep, such as an alias of a section in itself.

    ``path`` are the names and places of the node and of those that it stands in.
    """
    if len(path) >= DEEPEST:
        raise ValueError(f"it is nested deeper than {DEEPEST} levels")
    if isinstance(node, yaml.MappingNode):
        _check_once([name.value for name, _ in node.value if isinstance(name, yaml.ScalarNode)], node.start_mark.line + 1)
        for name, value in node.value:
            _check(name, (*path, name.value))
            _check(value, (*path, name.value))
    elif isinstance(node, yaml.SequenceNode):
        for index, item in enumerate(node.value):
            _check(item, (*path, index))
    else:
        _check_decimal(node, path)


def _check_decimal(node: yaml.Node, path: tuple[Any, ...]) -> None:
    kind = node.tag.rpartition(":")[2]
    if kind != "timestamp" and (kind not in DECIMAL or DECIMAL[kind].fullmatch(node.value)):
        return
    where = one_line(".".join(str(part)[:MAX_LINE] for part in path), MAX_LINE // 3)
    fault = "a date" if kind == "timestamp" else "not one number to all readers of YAML; write decimal digits without a leading zero"
    raise ValueError(f"{where + ': ' if where else ''}{one_line(node.value, 60)} is {fault}; quote it where it is a text")


def _check_once(names: Sequence[str], line: int) -> None:
    if len(set(names)) < len(names):
        twice = next(name for number, name in enumerate(names) if name in names[:number])
        raise ValueError(f"the section at line {line} has the key {twice!r} twice")


def read_text(path: Path) -> str:
    """Text of a user's table: UTF-8, UTF-16 with its mark, or else Windows' western European; ValueError where it is too large or none."""
    with path.open("rb") as file:
        data = file.read(MAX_FILE + 1)
    if len(data) > MAX_FILE:
        raise ValueError(f"it is larger than {MAX_FILE:,} bytes")
    for encoding in ("utf-16",) if data.startswith((b"\xff\xfe", b"\xfe\xff")) else ("utf-8-sig", "cp1252"):
        try:
            text = data.decode(encoding)
        except UnicodeDecodeError:
            continue
        if "\0" not in text:
            return text
    raise ValueError("it is not a text file")


def read_scene(path: Path | str) -> dict[str, Any]:
    """Mapping in a scene's file; files that it names beside itself as seen from the working folder.  ValueError as ``read_yaml``."""
    scene: dict[str, Any] = _located(read_yaml(path), Path(path).parent)
    return scene


def _located(part: Any, folder: Path) -> Any:
    if isinstance(part, list):
        return [_located(item, folder) for item in part]
    if not isinstance(part, Mapping) or _holds_content(part):
        return part
    part = {name: _located(item, folder) for name, item in part.items()}
    file = part.get("file")
    if isinstance(file, str) and os.path.isfile(folder / file):
        place = Path(os.path.abspath(folder / file))
        part["file"] = (place.relative_to(Path.cwd()) if place.is_relative_to(Path.cwd()) else place).as_posix()
    return part


def _holds_content(section: Mapping[str, Any]) -> bool:
    return any(section.get(name) is not None for name in CONTENT_KEYS)


def scene_files(scene: Any) -> list[str]:
    """Files that the sections of a scene's mapping are read from, for the inputs of a workflow's rule; none where content is given."""
    if isinstance(scene, Mapping) and _holds_content(scene):
        return []
    items = scene.values() if isinstance(scene, Mapping) else scene if isinstance(scene, (list, tuple)) else ()
    own = [scene["file"]] if isinstance(scene, Mapping) and isinstance(scene.get("file"), str) else []
    return sorted({*own, *(file for item in items for file in scene_files(item))})


def without_files(scene: Any) -> Any:
    """A scene's mapping without the names of files, for comparing: it holds their content."""
    if isinstance(scene, Mapping):
        return {name: without_files(value) for name, value in scene.items() if name != "file" or isinstance(value, Mapping)}
    return [without_files(item) for item in scene] if isinstance(scene, (list, tuple)) else scene


ORDERED = ("layers", "probes")
"""Sections in which the order of names counts: of two layers that overlap the later one does, and series are stored in that of probes."""


def differences(one: Mapping[str, Any], other: Mapping[str, Any]) -> dict[str, tuple[Any, Any]]:
    """Dotted keys whose values differ in the mappings of two scenes, with both; None for a key that one lacks.  Names of files do not
    count: a scene holds their content.  The order of names does in the sections ``ORDERED``."""
    left, right = (
        flat(scene) | {name: list(scene[name]) for name in ORDERED if isinstance(scene.get(name), Mapping)}
        for scene in (without_files(one), without_files(other))
    )
    pairs = {name: (left.get(name), right.get(name)) for name in sorted(left.keys() | right.keys())}
    return {name: pair for name, pair in pairs.items() if pair[0] != pair[1]}


def flat(section: Mapping[str, Any], prefix: str = "") -> dict[str, Any]:
    """``{"coupling": {"S_R": 0.1}}`` as ``{"coupling.S_R": 0.1}``; an empty section has no key."""
    found: dict[str, Any] = {}
    for name, value in section.items():
        found |= flat(value, f"{prefix}{name}.") if isinstance(value, Mapping) else {prefix + name: value}
    return found


def in_order(data: Any) -> Any:
    """Plain data of a scene whose sections ``ORDERED`` are lists, since their order counts; that of other keys means nothing."""
    if isinstance(data, Mapping):
        named = {name: in_order(value) for name, value in data.items()}
        return {name: list(value.items()) if name in ORDERED and isinstance(value, Mapping) else value for name, value in named.items()}
    return [in_order(item) for item in data] if isinstance(data, (list, tuple)) else data


def found_file(folders: Sequence[Path], name: str, where: str) -> Path:
    """First of ``folders`` / ``name`` that exists; ValueError begins with ``where``."""
    for folder in folders:
        if os.path.isfile(folder / name):  # unlike Path.is_file, also for a name that is too long
            return folder / name
    raise ValueError(f"{where}: no file {name!r} in {', '.join(str(folder.resolve()) for folder in folders)}")


class Whole(dict[str, Any]):
    """A section that takes the place of what ``merge`` lays it over: the value of one key that was set to it."""


def merge(base: Mapping[str, Any], overrides: Mapping[str, Any]) -> dict[str, Any]:
    """``base`` with ``overrides`` laid over it, section by section; lists, scalars and a section that is ``Whole`` are replaced.

    So is a section of which the override chooses another variant: its keys mean nothing to the new one.  A file takes
    the place of content that stood beside it, and content that of a file.  What is ``Whole`` in ``base`` stays so.
    """
    merged = Whole(base) if isinstance(base, Whole) else dict(base)
    for name in CONTENT_KEYS if overrides.get("file") is not None else ("file",) if _holds_content(overrides) else ():
        merged.pop(name, None)
    for name, value in overrides.items():
        if isinstance(value, Mapping):
            old = merged.get(name)
            value = merge(old if isinstance(old, Mapping) and not _replaces(value, old) else {}, value)
        merged[name] = value
    return merged


def _replaces(new: Mapping[str, Any], old: Mapping[str, Any]) -> bool:
    return isinstance(new, Whole) or any(tag in old and tag in new and old[tag] != new[tag] for tag in VARIANT_KEYS)


def dotted(settings: Mapping[str, Any]) -> dict[str, Any]:
    """``{"coupling.S_R": 0.1}`` as ``{"coupling": {"S_R": 0.1}}``; a section set to a key is ``Whole``, but for keys in it that follow.

    ValueError where a section is set to a key of which some have been set before.
    """
    nested: dict[str, Any] = {}
    for number, (path, value) in enumerate(settings.items()):
        if any(before.startswith(f"{path}.") for before in [*settings][:number]):
            raise ValueError(f"{path}: replaces all that is set in it; write all its keys there, or {path} first")
        *sections, name = path.split(".")
        at = nested
        for section in sections:
            inner = at.get(section)
            at[section] = type(inner)(inner) if isinstance(inner, dict) else {}
            at = at[section]
        at[name] = Whole(value) if isinstance(value, Mapping) else value
    return nested


def validated(model: type[Model], data: Mapping[str, Any], origin: str) -> Model:
    """A section built from a mapping; raises ValueError with one line per bad key.

    YAML reads yes, no, on and off as truth values, which would pass for the numbers 1 and 0; no key takes one.
    """
    truths = [one_line(f"{origin}: {path}: yes, no, on, off, true and false are not values of any key") for path in _truth_values(data)]
    if truths:
        raise ValueError("\n".join(truths[:MAX_LINES]))
    try:
        return model.model_validate(data)
    except ValidationError as error:
        raise ValueError(explain(error, origin, data, model)) from error


def _truth_values(value: Any, path: str = "") -> Iterator[str]:
    items = value.items() if isinstance(value, Mapping) else enumerate(value) if isinstance(value, (list, tuple)) else ()
    if isinstance(value, bool):
        yield path
    for name, item in items:
        yield from _truth_values(item, f"{path}.{name}" if path else str(name))


def explain(error: ValidationError, origin: str, data: Mapping[str, Any], model: type[BaseModel]) -> str:
    """One line per bad key: origin, key as written, what is allowed and the value found; of a misspelt name the nearest one."""
    lines = []
    for item in error.errors(include_url=False):
        if item["type"] == "too_short" and len(item["input"]) >= item["ctx"]["min_length"]:
            continue  # only because bad items, which have lines of their own, do not count
        path = _path_as_written(item["loc"], data, item["type"] == "missing")
        message, value = item["msg"].removeprefix("Value error, "), item["input"]
        if item["type"] == "extra_forbidden":
            known = [name for section in _sections_at(model, item["loc"][:-1]) for name in section.model_fields]
            message = "there is no such key here" + nearest(path[-1], known)
        elif item["type"] in ("union_tag_not_found", "union_tag_invalid") and isinstance(value, Mapping):
            tag = item["ctx"]["discriminator"].strip("'")
            known = [name for section in _sections_at(model, item["loc"]) for name in _tags(section, tag)]
            chosen = value.get(tag)
            path, value = [*path, tag], {} if chosen is None else chosen
            message = f"must be one of {', '.join(known)}" + nearest(str(chosen), known)
        elif item["type"] == "literal_error" and isinstance(value, str):
            message += nearest(value, re.findall("'([^']*)'", item["ctx"]["expected"]))
        where = ".".join(path)
        found = "" if isinstance(value, (Mapping, BaseModel)) else f" (found {_shown(value)})"
        lines.append(one_line(f"{origin}: {where + ': ' if where else ''}{message}{found}"))
    return "\n".join(lines[:MAX_LINES] + [f"{origin}: and {len(lines) - MAX_LINES} more"] * (len(lines) > MAX_LINES))


def _sections_at(model: type[BaseModel], location: Sequence[int | str]) -> list[type[BaseModel]]:
    """The sections that may stand at a location of the validator, which names chosen variants; places and names of the user's
    choice lead nowhere."""
    found = [model]
    for part in location:
        chosen = [each for each in found if len(found) > 1 and any(part in _tags(each, tag) for tag in VARIANT_KEYS)]
        below = [
            each for section in found if part in section.model_fields for each in _sections(section.model_fields[str(part)].annotation)
        ]
        found = chosen or below or found
    return found


def _sections(annotation: Any) -> list[type[BaseModel]]:
    """The sections in a type, in lists, mappings and unions too."""
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        return [annotation]
    return [section for part in typing.get_args(annotation) for section in _sections(part)]


def _tags(section: type[BaseModel], tag: str) -> tuple[str, ...]:
    """What a variant writes for the key that chooses it."""
    return typing.get_args(section.model_fields[tag].annotation) if tag in section.model_fields else ()


def _shown(value: Any) -> str:
    try:
        return one_line(repr(value), MAX_LINE // 3)
    except ValueError:  # Python does not write integers of more than 4,300 digits
        return "a number of too many digits"


def one_line(text: str, longest: int = MAX_LINE) -> str:
    """Text that a terminal shows as it is: what is not printable escaped, and cut where it is too long."""
    text = text if len(text) <= longest else f"{text[:longest]} ..."
    return "".join(c if c.isprintable() else repr(c)[1:-1] for c in text)


def _path_as_written(location: tuple[int | str, ...], data: Any, missing: bool) -> list[str]:
    """Path of a key, of one that is ``missing`` if so, without the names of variants ('tapered_sine') that the validator puts into it.

    A variant may have the name of one of its keys ('bodies').
    """
    path = []
    variant_named = False
    for depth, part in enumerate(location):
        last = depth == len(location) - 1
        if isinstance(data, Mapping):
            known = part in data or missing and last
            if not known or not variant_named and any(data.get(tag) == part for tag in VARIANT_KEYS):
                variant_named = True
                continue
            data = data.get(part)
        elif isinstance(data, (list, tuple)) and isinstance(part, int):
            data = data[part] if part < len(data) else None
        else:
            continue
        path.append(str(part))
        variant_named = False
    return path


def whole_multiple(value: float, unit: float, name: str, unit_name: str, of: str = "s") -> None:
    """ValueError, by name, for a value that is no whole multiple of another; ``of`` is their unit."""
    ratio = value / unit
    if round(ratio) < 1 or abs(ratio - round(ratio)) > 1e-6 * ratio:
        raise ValueError(f"{name}: {value} {of} must be a whole multiple of {unit_name} ({unit} {of})")
