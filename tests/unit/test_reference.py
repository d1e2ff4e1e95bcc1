"""Declarations, shipped scenes and the documentation of keys agree."""

from __future__ import annotations

from pathlib import Path

import pytest

from sph.command.reference import scene_rows, scene_table
from sph.scene import load_scene

ROOT = Path(__file__).resolve().parents[2]


def test_the_documentation_holds_the_generated_table() -> None:
    text = (ROOT / "config" / "README.md").read_text(encoding="utf-8")
    assert scene_table() in text, "config/README.md is out of step with sph.scene: put the output of 'sph keys' into it"


def test_every_key_says_what_it_is() -> None:
    rows = list(scene_rows())
    assert len(rows) > 60
    assert all(unit and source and text for _, unit, _, _, source, text in rows)
    assert len({row[0] for row in rows}) == len(rows)


@pytest.mark.parametrize("path", sorted((ROOT / "config" / "scenes").glob("**/*.yaml")), ids=lambda p: p.stem)
def test_shipped_scenes_are_valid(path: Path) -> None:
    assert load_scene(path).name == path.stem
