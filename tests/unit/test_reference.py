"""Declarations, shipped scenes and the documentation of keys agree."""

from __future__ import annotations

from pathlib import Path

import pytest

from sph.analysis.study import Study
from sph.command.reference import TABLES, key_rows
from sph.scene import Scene, load_scene

ROOT = Path(__file__).resolve().parents[2]
HOMES = {"scene": "config", "study": "config", "trajectory": "results", "metrics": "results"}


@pytest.mark.parametrize("table", TABLES)
def test_the_documentation_holds_the_generated_tables(table: str) -> None:
    text = (ROOT / HOMES[table] / "README.md").read_text(encoding="utf-8")
    assert TABLES[table]() in text, f"{HOMES[table]}/README.md is out of step: put the output of 'sph reference {table}' into it"


@pytest.mark.parametrize("model", [Scene, Study])
def test_every_key_says_what_it_is(model: type[Scene] | type[Study]) -> None:
    rows = list(key_rows(model))
    assert len(rows) > 25
    assert all(unit and source and text for _, unit, _, _, source, text in rows)
    assert len({row[0] for row in rows}) == len(rows)


@pytest.mark.parametrize("path", sorted((ROOT / "config" / "scenes").glob("**/*.yaml")), ids=lambda p: p.stem)
def test_shipped_scenes_are_valid(path: Path) -> None:
    assert load_scene(path).name == path.stem
