"""JSON as its standard has it, which knows neither NaN nor infinity."""

from __future__ import annotations

import json
import math
import re
from collections.abc import Mapping
from itertools import accumulate
from typing import Any

DEEPEST = 100
"""Levels of lists and objects within each other.  From where on Python's own parser gives up depends on its version, if it does."""
_BRACKET = re.compile(r'"[^"\\]*(?:\\.[^"\\]*)*"|[\[\]{}]', re.DOTALL)  # strings as well, since they may hold some
_STEP = {"[": 1, "{": 1, "]": -1, "}": -1}


def to_json(data: Any, **layout: Any) -> str:
    """Plain data as JSON, null for what is not finite; ``layout`` as of ``json.dumps``."""
    return json.dumps(finite(data), allow_nan=False, **layout)


def finite(data: Any) -> Any:
    """Plain data with None for every number that is not finite."""
    if isinstance(data, Mapping):
        return {name: finite(value) for name, value in data.items()}
    if isinstance(data, (list, tuple)):
        return [finite(value) for value in data]
    return None if isinstance(data, float) and not math.isfinite(data) else data


def parse_json(text: str) -> Any:
    """Plain data in a JSON text; ValueError where it is malformed, too deep, or holds a number that is not finite."""
    if text.count("[") + text.count("{") > DEEPEST and _depth(text) > DEEPEST:
        raise ValueError(f"its JSON is nested too deeply: more than {DEEPEST} lists and objects within each other")
    return json.loads(text, parse_constant=_number, parse_float=_number)


def _depth(text: str) -> int:
    return max(accumulate(_STEP.get(found[0], 0) for found in _BRACKET.finditer(text)), default=0)


def _number(text: str) -> float:
    value = float(text)
    if not math.isfinite(value):
        raise ValueError(f"{text} is no number in JSON; write null where there is none")
    return value
