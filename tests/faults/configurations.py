"""Configurations made from the schema: values that a key allows, its edges, and everything that it does not.

The strategies walk the pydantic models, so that a new key is fuzzed from the day it is declared.
"""

from __future__ import annotations

import copy
import datetime
import functools
import math
import types
from collections.abc import Iterator, Mapping
from typing import Annotated, Any, Literal, Union, get_args, get_origin

from hypothesis import strategies as st
from pydantic import BaseModel
from pydantic.fields import FieldInfo

from sph.scene.laboratory import INSTEAD_OF
from sph.scene.schema import Scene

Path = tuple[str | int, ...]
Strategy = st.SearchStrategy[Any]

HARD_NUMBERS: list[Any] = [
    *(0, -0.0, 1, -1, 5e-324, 1e-320, 1e-300, 1e-9, 1e9, 1e300, 1.7976931348623157e308, 10**30, 10**400),
    *(math.nan, math.inf, -math.inf, "1e400", "nan", "-inf", "1_0", "0x10", "1e-4", " 3 ", "٣", "1,5"),
]
HARD_TEXTS = [
    *("", " ", "..", "../x", "/etc/passwd", "a\0b", "a\nb", "\x1b[31m", "x" * 5000, "é", "\ud800", "\u202e"),
    *("CON", "$\\frac$", "{x}", "{{", "%s", "~", "*"),
]
HARD_VALUES: list[Any] = [None, True, False, [], {}, [[]], [None], {"a": {"b": [1]}}, {"kind": "none"}, b"\xff", {1.0, 2.0}]
DAYS = [datetime.date(2001, 1, 1), datetime.datetime(2001, 1, 1)]
NAMES = ("kind", "shape", "law", "<<", "__class__", "model_config", "name", "1", "é", "a.b", "")
KEYWORDS = ("ge", "gt", "le", "lt", "min_length", "max_length", "pattern")

junk: Strategy = st.recursive(
    st.one_of(
        st.sampled_from(HARD_NUMBERS),
        st.sampled_from(HARD_TEXTS),
        st.sampled_from(HARD_VALUES).map(copy.deepcopy),
        st.sampled_from(DAYS),
        st.floats(),
        st.integers(),
        st.text(max_size=20),
    ),
    lambda inner: st.one_of(st.lists(inner, max_size=4), st.dictionaries(st.sampled_from(NAMES), inner, max_size=3)),
    max_leaves=6,
)
"""What nobody should write."""


def allowed(annotation: Any, *metadata: Any) -> Strategy:
    """Values that a type with its constraints allows, edges among them."""
    limits, origin, parts = _limits(metadata), get_origin(annotation), get_args(annotation)
    if origin is Annotated:
        return allowed(parts[0], *metadata, *parts[1:])
    if origin in (Union, types.UnionType):
        return st.one_of([allowed(part, *metadata) for part in parts])
    if origin is Literal:
        return st.sampled_from(parts)
    if origin is tuple and parts[-1] is Ellipsis:
        return st.lists(allowed(parts[0]), min_size=limits.get("min_length", 0), max_size=5)
    if origin is tuple:
        return st.tuples(*map(allowed, parts)).map(list)
    if origin is dict and parts[1] is Any:
        return settings(Scene)
    if origin is dict:
        return st.dictionaries(allowed(parts[0]), allowed(parts[1]), min_size=limits.get("min_length", 0), max_size=3)
    if annotation is float:
        return _floats(limits)
    if annotation is int:
        return st.integers(limits.get("ge"), limits.get("le"))
    if annotation is str and "pattern" in limits:
        return st.from_regex(limits["pattern"], fullmatch=True)
    if annotation is str:
        return st.text(min_size=limits.get("min_length", 0), max_size=20)
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        return section(annotation)
    return st.none() if annotation in (None, type(None)) else junk


@functools.cache
def section(model: type[BaseModel]) -> Strategy:
    """A section with values that each of its keys allows by itself."""
    fields = {name: _of(field) for name, field in model.model_fields.items()}
    required = {name for name, field in model.model_fields.items() if field.is_required()}
    return st.fixed_dictionaries(
        {name: fields[name] for name in fields if name in required},
        optional={name: fields[name] for name in fields if name not in required},
    )


@functools.cache
def keys(model: type[BaseModel]) -> list[tuple[Path, Strategy]]:
    """Every key that a model declares, with the values it allows."""
    found: list[tuple[Path, Strategy]] = []
    for name, field in model.model_fields.items():
        found.append(((name,), _of(field)))
        found += [((name, *path), values) for inner in _sections(field.annotation) for path, values in keys(inner)]
    return found


def settings(model: type[BaseModel]) -> Strategy:
    """One to three keys of a model with values they allow, nested."""
    pairs = st.sampled_from(keys(model)).flatmap(lambda pair: pair[1].map(lambda value: (pair[0], value)))
    return st.lists(pairs, min_size=1, max_size=3).map(_nested)


def changed(model: type[BaseModel], base: Mapping[str, Any], most: int = 3) -> Strategy:
    """A good configuration in which some keys hold other values that they allow, or junk, are missing, unknown or misspelt."""
    declared = keys(model)
    places = [path for path, _ in declared] + list(_written(base))
    good = st.sampled_from(declared).flatmap(lambda pair: pair[1].map(lambda value: (pair[0], value)))
    bad = st.tuples(st.sampled_from(places), st.one_of(junk, st.just(_Missing), st.just(_Unknown)))
    changes = st.lists(st.one_of(good, good, bad), min_size=1, max_size=most)
    return changes.map(lambda chosen: _apply(base, chosen))


class _Missing:
    """Stands for a key that is left out."""


class _Unknown:
    """Stands for a key that is misspelt."""


def _apply(base: Mapping[str, Any], changes: list[tuple[Path, Any]]) -> dict[str, Any]:
    data = copy.deepcopy(dict(base))
    for path, value in changes:
        at: Any = data
        for part, following in zip(path, path[1:], strict=False):
            if isinstance(at, dict) and (not isinstance(at.get(part), (dict, list)) and isinstance(following, str)):
                at[part] = {}
            if not (isinstance(at, dict) and part in at or isinstance(at, list) and isinstance(part, int) and part < len(at)):
                break
            at = at[part]
        else:
            _put(at, path[-1], value)
            if isinstance(at, dict) and value not in (None, _Missing, _Unknown):
                for other in INSTEAD_OF.get(path[-1], ()):  # who writes the one leaves out the other
                    at.pop(other, None)
    return data


def _put(at: Any, name: str | int, value: Any) -> None:
    if isinstance(at, list) and isinstance(name, int) and name < len(at) or isinstance(at, dict):
        if value is _Missing:
            at.pop(name) if isinstance(at, list) else at.pop(name, None)
        elif value is _Unknown:
            at[name if isinstance(at, list) else f"{name}_"] = 1
        else:
            at[name] = copy.deepcopy(value)


def _nested(pairs: list[tuple[Path, Any]]) -> dict[str, Any]:
    return _apply({}, pairs)


def _written(data: Any, path: Path = ()) -> Iterator[Path]:
    """Paths of everything that a configuration holds."""
    for name, value in data.items() if isinstance(data, Mapping) else enumerate(data) if isinstance(data, list) else ():
        yield (*path, name)
        yield from _written(value, (*path, name))


def _of(field: FieldInfo) -> Strategy:
    values = allowed(field.annotation, *field.metadata)
    return values if field.is_required() else st.one_of(values, st.just(_plain(field.default)))


def _plain(value: Any) -> Any:
    return value.model_dump() if isinstance(value, BaseModel) else value


def _floats(limits: Mapping[str, Any]) -> Strategy:
    low, high = limits.get("ge", limits.get("gt")), limits.get("le", limits.get("lt"))
    inside = st.floats(low, high, allow_nan=False, allow_infinity=False, exclude_min="gt" in limits, exclude_max="lt" in limits)
    edges = [limits[name] for name in ("ge", "le") if name in limits]
    edges += [math.nextafter(limits[name], math.inf if name == "gt" else -math.inf) for name in ("gt", "lt") if name in limits]
    common = [
        v for v in (0.0, 1e-4, 1e-3, 0.01, 0.1, 0.5, 1.0, 2.0, 10.0, 30.0, 100.0) if (low is None or low < v) and (high is None or v < high)
    ]
    return st.one_of(inside, *([st.sampled_from(edges)] if edges else []), *([st.sampled_from(common)] * 2 if common else []))


def _limits(metadata: tuple[Any, ...]) -> dict[str, Any]:
    found = {}
    for item in metadata:
        for part in item.metadata if isinstance(item, FieldInfo) else [item]:
            found |= {name: getattr(part, name) for name in KEYWORDS if getattr(part, name, None) is not None}
    return found


def _sections(annotation: Any) -> Iterator[type[BaseModel]]:
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        yield annotation
    elif get_origin(annotation) in (Union, types.UnionType, Annotated):
        for part in get_args(annotation):
            yield from _sections(part)
