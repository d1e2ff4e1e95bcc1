"""Declarations, shipped scenes and the documentation of keys agree."""

from __future__ import annotations

import re
import runpy
from pathlib import Path

import pandas as pd
import pytest
from typer.testing import CliRunner

from cases.suite import VALIDATION
from sph.checks.messages import MESSAGES
from sph.command.cli import app
from sph.experiments.paper.design import AnyStudy
from sph.experiments.registry import EXPERIMENTS
from sph.experiments.variants.figures_robustness import REFUSED
from sph.experiments.variants.schema import TIME_STEP
from sph.scene.schema import Scene, load_scene
from sph.storage.trajectory import VARIABLES
from sph.study.tables import VALUES
from tools.reference import (
    MARKED,
    PRINTED,
    TABLES,
    Reference,
    Strong,
    commands_text,
    filled,
    key_rows,
    markdown,
    outcome_lines,
    step_lines,
    with_tables,
)

ROOT = Path(__file__).resolve().parents[2]
KEYS = [AnyStudy, *{each.keys: None for each in EXPERIMENTS.values() if each.keys}]
PAGES = [ROOT / "README.md", *sorted((ROOT / "docs").rglob("*.md"))]


def test_every_table_has_one_home() -> None:
    texts = [page.read_text(encoding="utf-8") for page in PAGES]
    kept = [found[2] for text in texts for found in MARKED.finditer(text)]
    printed = [name for text in texts for name in PRINTED.findall(text)]
    assert sorted(kept + printed) == sorted(TABLES)


def test_the_readme_holds_its_generated_tables_and_no_other_page_has_any() -> None:
    text, *others = (page.read_text(encoding="utf-8") for page in PAGES)
    assert filled(text) == text, "README.md is out of step: python -m tools.reference"
    assert not [each for each in others if MARKED.search(each)]


@pytest.mark.parametrize(
    ("page", "names"),
    [
        ("reference/scene-keys.md", [row[0] for row in key_rows(Scene)]),
        ("reference/study-keys.md", [row[0] for model in KEYS for row in key_rows(model)]),
        ("reference/findings.md", [*MESSAGES]),
        ("reference/metrics.md", [column.name for column in VALUES]),
        ("reference/files.md", [column.name for column in VARIABLES]),
        ("evidence/validation.md", [column.name for column in VALIDATION]),
    ],
)
def test_the_site_has_an_entry_for_each(page: str, names: list[str]) -> None:
    text = (ROOT / "docs" / page).read_text(encoding="utf-8")
    site = with_tables(text)
    assert names and not [name for name in names if f"\n| `{name}` | " not in site]
    assert not PRINTED.search(site)


@pytest.mark.parametrize("name", [name for name in TABLES if name.endswith(("_keys", "_variables"))])
def test_every_entry_says_what_it_means(name: str) -> None:
    rows = TABLES[name]().rows
    assert rows and all(row[-1] for row in rows)


def test_a_table_is_printed_by_its_name(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    monkeypatch.setattr("sys.argv", ["reference", "failure_rule"])
    runpy.run_path(str(ROOT / "tools" / "reference.py"), run_name="__main__")
    assert capsys.readouterr().out == with_tables("*Table: `python -m tools.reference failure_rule`*\n")
    with pytest.raises(ValueError, match="nonsense.*must be one of .*scene, study"):
        with_tables("*Table: `python -m tools.reference nonsense`*")


def test_marks_are_filled_and_unknown_ones_refused() -> None:
    marks = "a\n<!-- sph reference failure_rule -->\n{}<!-- end -->\nb\n"
    assert filled(marks.format("old\n")) == filled(marks.format("")) == marks.format(f"\n{markdown(TABLES['failure_rule']())}\n\n")
    with pytest.raises(ValueError, match="nonsense.*must be one of .*scene, study"):
        filled("<!-- sph reference nonsense -->\n<!-- end -->")


def test_what_markdown_would_read_otherwise_is_escaped() -> None:
    table = markdown(
        Reference(("key", "text"), [("a|b", "results/<study> of mu* and mu*, **bold**, x <= 1 | 2"), ("c", Strong("fails"))], "A note.")
    )
    assert table.splitlines()[3:] == ["| `c` | **fails** |", "", "A note."]
    assert table.splitlines()[2] == "| `a\\|b` | results/&lt;study> of mu\\* and mu\\*, **bold**, x <= 1 \\| 2 |"


def test_commands_are_those_of_the_command_line() -> None:
    sections = commands_text().split("\n## `sph ")
    assert len(sections) == len(app.registered_commands)
    run = next(section for section in sections if section.startswith("run`"))
    told = CliRunner().invoke(app, ["run", "--help"]).output
    options = re.findall(r"^\* `(--[\w-]+)(?= KEY=VALUE| SECONDS| <|`)", run, re.MULTILINE)
    assert {"--set", "--checkpoint", "--overwrite"} <= set(options) and all(option in told for option in options)


@pytest.mark.parametrize("path", sorted((ROOT / "config" / "scenes").glob("**/*.yaml")), ids=lambda p: p.stem)
def test_shipped_scenes_are_valid(path: Path) -> None:
    assert load_scene(path).name == path.stem


def test_a_step_at_which_the_slope_fails_under_gravity_alone_is_too_long() -> None:
    steps = [("0.5", "complete"), ("0.8", "failed_unshaken"), ("0.95", "complete"), ("1.2", "diverged")]
    rows = [(TIME_STEP, value, "h 1.3", status) for value, status in steps]
    rows += [("cohesion (kPa)", "0", "weak", "failed_unshaken"), ("sides", "none", "weak", "diverged"), ("K0", "9", "weak", REFUSED)]
    table = pd.DataFrame(rows, columns=["sweep", "value", "case", "status"])
    assert list(step_lines(table)) == [("h 1.3", "0.5", "0.8")]
    assert list(outcome_lines(table)) == [("parameters", "3", "1", "1", "0", "1"), ("time_steps", "4", "2", "1", "1", "0")]
