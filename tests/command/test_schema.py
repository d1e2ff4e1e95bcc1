"""The schemas for editors: in step with the keys, what the shipped files fit, and what they would mark."""

from __future__ import annotations

import json
import os
from functools import cache
from pathlib import Path
from typing import Any

import pytest
import yaml
from calling import call
from jsonschema import Draft202012Validator
from small_scenes import SLOPE

from sph.command.schema import MODELS, json_schema, schema_file, schema_text
from sph.jobs.exit_codes import REFUSED

ROOT = Path(__file__).resolve().parents[2]
SHIPPED = sorted((ROOT / "config").rglob("*.yaml"))


@cache
def validator(name: str) -> Draft202012Validator:
    schema = json_schema(name)
    Draft202012Validator.check_schema(schema)
    return Draft202012Validator(schema)


def fits(name: str, data: Any) -> bool:
    return bool(validator(name).is_valid(data))


@pytest.mark.parametrize("name", MODELS)
def test_the_files_for_editors_are_in_step(name: str) -> None:
    assert (ROOT / schema_file(name)).read_text(encoding="utf-8") == schema_text(name), "python -m tools.reference"


@pytest.mark.parametrize("path", SHIPPED, ids=lambda path: str(path.relative_to(ROOT / "config")))
def test_every_shipped_file_names_its_schema_and_fits_it(path: Path) -> None:
    text = path.read_text(encoding="utf-8")
    name = "scene" if "scenes" in path.parts else path.stem if path.stem in MODELS else "study"
    first = text.splitlines()[0]
    assert first == f"# yaml-language-server: $schema={os.path.relpath(ROOT / schema_file(name), path.parent)}"
    assert fits(name, yaml.safe_load(text))


@pytest.mark.parametrize(
    ("name", "good", "bad"),
    [
        ("scene", SLOPE | {"motion": {"kind": "ricker", "amplitude": "0.4g", "frequency": 1, "peak": 5}}, SLOPE | {"geometri": {}}),
        ("scene", SLOPE | {"geometry": {"shape": "ground_line", "file": "a.csv", "base": 1}}, SLOPE | {"geometry": {"shape": "hill"}}),
        ("scene", SLOPE | {"soil": {"cohesion": 3}}, SLOPE | {"soil": {"cohesion": -3}}),
        ("study", {"fidelity": "draft"}, {"fidelty": "draft"}),
        ("study", {"grid": {"S_R": [0.1, "0.20"]}}, {"grid": {"S_R": 0.1}}),
        ("study", {"cases": "cases.csv"}, {"cases": 3}),
        ("study", {"sample": {"size": 4, "ranges": {"amplitude": ["0.1g", 6.0]}}}, {"sample": {"size": 4, "ranges": {"amplitude": 3}}}),
    ],
)
def test_mistakes_are_marked_and_what_is_read_is_not(name: str, good: dict[str, Any], bad: dict[str, Any]) -> None:
    assert fits(name, good) and not fits(name, bad)


def test_the_command_prints_a_schema() -> None:
    assert json.loads(call("schema", "study").stdout) == json_schema("study")
    refused = call("schema", "scen")
    assert refused.exit_code == REFUSED and "did you mean scene?" in refused.stderr
