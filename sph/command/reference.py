"""The table of scene keys, generated from their declarations in ``sph.scene``."""

from __future__ import annotations

import types
import typing
from collections.abc import Iterator
from typing import Any

from pydantic import BaseModel
from pydantic.fields import FieldInfo

from sph.scene import Scene


def scene_rows(model: type[BaseModel] = Scene, prefix: str = "") -> Iterator[tuple[str, str, str, str, str, str]]:
    """Rows (key, unit, default, allowed, source, meaning), sections first, then what they hold."""
    for name, field in model.model_fields.items():
        extra = typing.cast(dict[str, Any], field.json_schema_extra or {})
        path = prefix + name
        yield path, extra["unit"], _default(field), _allowed(field), extra["source"], field.description or ""
        for section in _sections(field.annotation):
            variant = len(_sections(field.annotation)) > 1
            yield from scene_rows(section, f"{path} ({_tag(section)})." if variant else f"{path}.")


def scene_table() -> str:
    """Markdown table of ``scene_rows``."""
    head = ("key", "unit", "default", "allowed", "source", "meaning")
    lines = ["| " + " | ".join(head) + " |", "|" + " --- |" * len(head)]
    for key_, *cells in scene_rows():
        lines.append("| `" + key_ + "` | " + " | ".join(cell.replace("|", "\\|") for cell in cells) + " |")
    return "\n".join(lines)


def _sections(annotation: Any) -> list[type[BaseModel]]:
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        return [annotation]
    origin = typing.get_origin(annotation)
    if origin in (typing.Union, types.UnionType, typing.Annotated):
        return [section for part in typing.get_args(annotation) for section in _sections(part)]
    return []


def _tag(section: type[BaseModel]) -> str:
    for field in section.model_fields.values():
        if typing.get_origin(field.annotation) is typing.Literal:
            return str(typing.get_args(field.annotation)[0])
    return section.__name__


def _default(field: FieldInfo) -> str:
    if field.is_required():
        return "required"
    default = field.default
    if isinstance(default, BaseModel):
        return "see below"
    return "null" if default is None else repr(default).replace("'", '"')


def _allowed(field: FieldInfo) -> str:
    bounds = []
    for item in field.metadata:
        for sign, attribute in ((">", "gt"), (">=", "ge"), ("<", "lt"), ("<=", "le")):
            if getattr(item, attribute, None) is not None:
                bounds.append(f"{sign} {getattr(item, attribute):g}")
        if getattr(item, "pattern", None):
            bounds.append("letters, digits, _ . -")
    choices = _choices(field.annotation)
    if choices:
        bounds.append(", ".join(choices))
    if type(None) in typing.get_args(field.annotation):
        bounds.append("null")
    return ", ".join(bounds) or "-"


def _choices(annotation: Any) -> list[str]:
    if typing.get_origin(annotation) is typing.Literal:
        return [str(choice) for choice in typing.get_args(annotation)]
    return []
