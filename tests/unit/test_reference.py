"""Declarations, shipped scenes and the documentation of keys agree."""

from __future__ import annotations

from pathlib import Path

import pytest

from sph.analysis.study import Study
from sph.analysis.trade import Trade
from sph.command.reference import TABLES, key_rows
from sph.configuration import Section
from sph.scene import Scene, load_scene

ROOT = Path(__file__).resolve().parents[2]
HOMES = {
    "scene": "config",
    "study": "config",
    "trade_keys": "config",
    "validation_keys": "config",
    "limits_keys": "config",
    "extremes_keys": "config",
    "sensitivity_keys": "config",
    "trigger_keys": "config",
    "failure_rule": "config",
    "trajectory": "results",
    "metrics": "results",
    "trade_variables": "results",
    "convergence": "results",
    "validation_variables": "results",
    "limits_variables": "results",
    "extremes_variables": "results",
    "sample_variables": "results",
    "morris_variables": "results",
    "tornado_variables": "results",
    "sobol_variables": "results",
    "cross_validation_variables": "results",
    "confirmation_variables": "results",
    "trigger_variables": "results",
    "points_variables": "results",
    "confirm_variables": "results",
    "cells_variables": "results",
    "shares_variables": "results",
}
MEASURED = ("presets", "trade", "validation", "limits", "extremes", "time_steps")


def test_every_table_has_a_home() -> None:
    assert set(TABLES) == {*HOMES, *MEASURED}


@pytest.mark.parametrize("table", HOMES)
def test_the_documentation_holds_the_generated_tables(table: str) -> None:
    text = (ROOT / HOMES[table] / "README.md").read_text(encoding="utf-8")
    assert TABLES[table]() in text, f"{HOMES[table]}/README.md is out of step: put the output of 'sph reference {table}' into it"


@pytest.mark.parametrize("table", MEASURED)
def test_the_readme_holds_what_was_measured_for_this_release(table: str) -> None:
    text = (ROOT / "README.md").read_text(encoding="utf-8")
    block = text.partition(f"<!-- sph reference {table} -->\n")[2].partition("\n<!-- end -->")[0]
    assert block == TABLES[table](), f"README.md is out of step: put the output of 'sph reference {table}' between its marks"


@pytest.mark.parametrize(("model", "keys"), [(Scene, 25), (Study, 25), (Trade, 15)])
def test_every_key_says_what_it_is(model: type[Section], keys: int) -> None:
    rows = list(key_rows(model))
    assert len(rows) > keys
    assert all(unit and source and text for _, unit, _, _, source, text in rows)
    assert len({row[0] for row in rows}) == len(rows)


@pytest.mark.parametrize("path", sorted((ROOT / "config" / "scenes").glob("**/*.yaml")), ids=lambda p: p.stem)
def test_shipped_scenes_are_valid(path: Path) -> None:
    assert load_scene(path).name == path.stem
