"""JSON Schema of the files that a user writes, by which editors complete keys and mark mistakes (``sph schema``, ``config/schemas``)."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from pydantic import BaseModel

from sph.experiments.registry import EXPERIMENTS, STUDY
from sph.scene.schema import Scene
from sph.scene.strict_json import to_json

MODELS: dict[str, type[BaseModel]] = {
    "scene": Scene,
    "study": STUDY,
    **{name: each.keys for name, each in EXPERIMENTS.items() if each.keys},
}
"""What the files hold, by the name of the schema; that of an experiment is the name of its file."""


def json_schema(name: str) -> dict[str, Any]:
    """The schema of a file; that of a study asks for no key, since a study may override keys of another."""
    schema = {"$schema": "https://json-schema.org/draft/2020-12/schema"} | MODELS[name].model_json_schema()
    if name == "study":
        schema.pop("required", None)
    return schema


def schema_text(name: str) -> str:
    """The schema as JSON."""
    return to_json(json_schema(name)) + "\n"


def schema_file(name: str) -> Path:
    """Where the repository keeps it for editors, seen from its folder."""
    return Path("config", "schemas", f"{name}.json")
