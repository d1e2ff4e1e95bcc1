"""JSON that any reader takes: no NaN, no infinity, of a bounded depth."""

from __future__ import annotations

import ast
import math
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pytest

from sph.scene.strict_json import parse_json, to_json

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


@pytest.mark.parametrize(
    "path", sorted([*(ROOT / "sph").rglob("*.py"), *(ROOT / "workflow" / "scripts").rglob("*.py")]), ids=lambda p: p.name
)
def test_all_json_is_written_and_read_here(path: Path) -> None:
    if path.name in ("strict_json.py", "jit.py"):  # jit's list of digests holds no numbers
        return
    tree = ast.parse(path.read_text(encoding="utf-8"))
    calls = [ast.unparse(node.func) for node in ast.walk(tree) if isinstance(node, ast.Call)]
    assert not {"json.dumps", "json.dump", "json.loads", "json.load"}.intersection(calls)
