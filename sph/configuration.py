"""Declaring, reading and checking configuration: scenes and studies.

A section is a frozen pydantic model.  Every key is declared once, with its sentence, unit, source,
default and range (``key``); the tables in ``config/README.md`` are generated from these declarations.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, TypeVar

import yaml
from pydantic import BaseModel, ConfigDict, Field, ValidationError


class Section(BaseModel):
    """A frozen part of a scene; unknown keys and non-finite numbers are errors."""

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)


def key(text: str, unit: str = "-", source: str = "ours", **constraints: Any) -> Any:
    """Declare one key: sentence, unit, source (paper section or 'ours'), default and range."""
    return Field(description=text, json_schema_extra={"unit": unit, "source": source}, **constraints)


VARIANT_KEYS = ("shape", "law", "kind")
"""Keys that choose between the variants of a section."""

Model = TypeVar("Model", bound=Section)


def read_yaml(path: Path | str) -> dict[str, Any]:
    """Mapping in a YAML file; raises ValueError naming the file when it is none."""
    path = Path(path)
    try:
        data = yaml.safe_load(path.read_text(encoding="utf-8"))
    except (OSError, UnicodeDecodeError, yaml.YAMLError) as error:
        raise ValueError(f"{path}: cannot be read as YAML: {error}") from error
    if not isinstance(data, dict):
        raise ValueError(f"{path}: must hold a mapping of keys, found {type(data).__name__}")
    return data


def found_file(folders: Sequence[Path], name: str, where: str) -> Path:
    """First of ``folders`` / ``name`` that exists; ValueError begins with ``where``."""
    for folder in folders:
        if (folder / name).is_file():
            return folder / name
    raise ValueError(f"{where}: no file {name!r} in {', '.join(str(folder.resolve()) for folder in folders)}")


def merge(base: Mapping[str, Any], overrides: Mapping[str, Any]) -> dict[str, Any]:
    """``base`` with ``overrides`` laid over it, section by section; lists and scalars are replaced.

    So is a section of which the override chooses another variant: its keys mean nothing to the new one.
    """
    merged = dict(base)
    for name, value in overrides.items():
        old = merged.get(name)
        if isinstance(old, Mapping) and isinstance(value, Mapping) and not _other_variant(old, value):
            value = merge(old, value)
        merged[name] = value
    return merged


def _other_variant(old: Mapping[str, Any], new: Mapping[str, Any]) -> bool:
    return any(tag in old and tag in new and old[tag] != new[tag] for tag in VARIANT_KEYS)


def dotted(settings: Mapping[str, Any]) -> dict[str, Any]:
    """``{"coupling.S_R": 0.1}`` as ``{"coupling": {"S_R": 0.1}}``."""
    nested: dict[str, Any] = {}
    for path, value in settings.items():
        for part in reversed(path.split(".")):
            value = {part: value}
        nested = merge(nested, value)
    return nested


def validated(model: type[Model], data: Mapping[str, Any], origin: str) -> Model:
    """A section built from a mapping; raises ValueError with one line per bad key.

    YAML reads yes, no, on and off as truth values, which would pass for the numbers 1 and 0; no key takes one.
    """
    truths = [f"{origin}: {path}: yes, no, on, off, true and false are not values of any key" for path in _truth_values(data)]
    if truths:
        raise ValueError("\n".join(truths))
    try:
        return model.model_validate(data)
    except ValidationError as error:
        raise ValueError(explain(error, origin, data)) from error


def _truth_values(value: Any, path: str = "") -> Iterator[str]:
    items = value.items() if isinstance(value, Mapping) else enumerate(value) if isinstance(value, (list, tuple)) else ()
    if isinstance(value, bool):
        yield path
    for name, item in items:
        yield from _truth_values(item, f"{path}.{name}" if path else str(name))


def explain(error: ValidationError, origin: str, data: Mapping[str, Any]) -> str:
    """One line per bad key: origin, key as written, what is allowed and the value found."""
    lines = []
    for item in error.errors():
        if item["type"] == "too_short" and len(item["input"]) >= item["ctx"]["min_length"]:
            continue  # only because bad items, which have lines of their own, do not count
        where = ".".join(_path_as_written(item["loc"], data, item["type"] == "missing"))
        message = item["msg"].removeprefix("Value error, ")
        if item["type"] == "extra_forbidden":
            message = "there is no such key here"
        value = item["input"]
        shown = f" (found {value!r})" if where and not isinstance(value, (Mapping, BaseModel)) else ""
        lines.append(f"{origin}: {where + ': ' if where else ''}{message}{shown}")
    return "\n".join(lines)


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
