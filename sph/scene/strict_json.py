"""JSON as its standard has it, which knows neither NaN nor infinity."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from typing import Any


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


def parse_json(text: str | bytes) -> Any:
    """Plain data in a JSON text; ValueError where it is malformed, too deep, or holds a number that is not finite."""
    try:
        return json.loads(text, parse_constant=_number, parse_float=_number)
    except RecursionError as error:
        raise ValueError("its JSON is nested too deeply") from error


def _number(text: str) -> float:
    value = float(text)
    if not math.isfinite(value):
        raise ValueError(f"{text} is no number in JSON; write null where there is none")
    return value
