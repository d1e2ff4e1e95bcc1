"""JSON that any reader takes: no NaN, no infinity, of a bounded depth."""

from __future__ import annotations

import math
import re
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pytest

from sph.scene.strict_json import DEEPEST, parse_json, to_json

ROOT = Path(__file__).resolve().parents[2]


class Row(NamedTuple):
    name: str
    value: float


@pytest.mark.parametrize(
    ("data", "text"),
    [
        (math.nan, "null"),
        ({"a": [1.5, -math.inf, (math.inf, "NaN")]}, '{"a": [1.5, null, [null, "NaN"]]}'),
        (
            [Row("x", math.nan)._asdict(), np.float64(math.nan), np.float64(2.5), True, None, 3],
            '[{"name": "x", "value": null}, null, 2.5, true, null, 3]',
        ),
    ],
)
def test_what_is_not_finite_is_null(data: Any, text: str) -> None:
    assert to_json(data) == text
    assert to_json(parse_json(text)) == text


@pytest.mark.parametrize("text", ["NaN", "[1, -Infinity]", '{"a": 1e999}', "[" * 20_000 + "]" * 20_000, '{"a":' * 20_000, "{", ""])
def test_what_is_no_json_is_refused(text: str) -> None:
    with pytest.raises(ValueError, match=r".+"):
        parse_json(text)


def test_depth_is_that_of_lists_and_objects_alone() -> None:
    assert parse_json("[" * DEEPEST + '"[[\\\\"' + "]" * DEEPEST) and len(parse_json("[" + "[]," * 200 + r'"\"[[{"]')) == 201
    with pytest.raises(ValueError, match="nested too deeply: more than 100"):
        parse_json('{"a":' + "[" * DEEPEST + "]" * DEEPEST + "}")


def test_all_json_is_written_and_read_here() -> None:
    own = ("strict_json.py", "jit.py")  # jit's list of digests holds no numbers
    paths = [*(ROOT / "sph").rglob("*.py"), *(ROOT / "workflow" / "scripts").rglob("*.py")]
    called = re.compile(r"\bjson\.(dumps?|loads?)\(")
    assert len(paths) > 200 and not [path for path in paths if path.name not in own and called.search(path.read_text(encoding="utf-8"))]
