"""Tables of every key and every variable, generated from their declarations.

``config/README.md`` holds the tables ``scene`` and ``study``, ``results/README.md`` the tables
``trajectory`` and ``metrics``; a test keeps them in step.
"""

from __future__ import annotations

import types
import typing
from collections.abc import Callable, Iterable, Iterator, Sequence
from typing import Any

from pydantic import BaseModel
from pydantic.fields import FieldInfo

from sph.analysis.metrics import METRICS
from sph.analysis.study import Study
from sph.scene import Scene
from sph.trajectory import VARIABLES, Variable


def key_rows(model: type[BaseModel], prefix: str = "") -> Iterator[tuple[str, str, str, str, str, str]]:
    """Rows (key, unit, default, allowed, source, meaning), sections first, then what they hold."""
    for name, field in model.model_fields.items():
        extra = typing.cast(dict[str, Any], field.json_schema_extra or {})
        path = prefix + name
        yield path, extra["unit"], _default(field), _allowed(field), extra["source"], field.description or ""
        sections = _sections(field.annotation)
        for section in sections:
            yield from key_rows(section, f"{path} ({_tag(section)})." if len(sections) > 1 else f"{path}.")


def variable_rows(variables: Iterable[Variable]) -> Iterator[tuple[str, str, str, str, str]]:
    """Rows (variable, dimensions, type, unit, meaning)."""
    for variable in variables:
        yield variable.name, ", ".join(variable.dims), variable.dtype, variable.units, variable.text


def markdown(head: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """Markdown table; the first column is set as code."""
    lines = ["| " + " | ".join(head) + " |", "|" + " --- |" * len(head)]
    lines += ["| `" + first + "` | " + " | ".join(cell.replace("|", "\\|") for cell in cells) + " |" for first, *cells in rows]
    return "\n".join(lines)


KEY_HEAD = ("key", "unit", "default", "allowed", "source", "meaning")
VARIABLE_HEAD = ("variable", "dimensions", "type", "unit", "meaning")
TABLES: dict[str, Callable[[], str]] = {
    "scene": lambda: markdown(KEY_HEAD, key_rows(Scene)),
    "study": lambda: markdown(KEY_HEAD, key_rows(Study)),
    "trajectory": lambda: markdown(VARIABLE_HEAD, variable_rows(VARIABLES)),
    "metrics": lambda: markdown(VARIABLE_HEAD, variable_rows(METRICS)),
}
"""The tables by name."""


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
