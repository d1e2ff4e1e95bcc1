"""The verification book: a page a case, with what was missed."""

from __future__ import annotations

from pathlib import Path

import netCDF4
import pytest
from matplotlib.figure import Figure
from small_scenes import study_plan

from sph.experiments.validation.book import Cost, Page, costs_of, save_book
from sph.experiments.validation.design import load_suite
from sph.experiments.validation.measure import read_validation
from sph.study.verdicts import MISSES

ROOT = Path(__file__).resolve().parents[2]
MEASURED = ROOT / "sph" / "experiments" / "validation" / "measured" / "validation.csv"


def test_a_page_a_case_with_its_misses(tmp_path: Path) -> None:
    suite, table = load_suite("config/validation.yaml", study_plan(), [ROOT]), read_validation(MEASURED)
    picture = tmp_path / "picture.png"
    Figure(figsize=(3.0, 2.0)).savefig(picture)
    names = list(dict.fromkeys(table["case"]))[-3:]
    pages = []
    for name in names:
        plan = suite.plan(name)
        pages.append(Page(name, plan["case"], table[table["case"] == name], [Cost("1 m", 10, 2.0)], plan["runs"][0][2].build()))
    save_book(pages, [picture] * len(pages), tmp_path / "book.md", tmp_path / "book.pdf")
    text = (tmp_path / "book.md").read_text(encoding="utf-8")
    assert [line.split(":")[0] for line in text.splitlines() if line.startswith("## ")] == [f"## {name}" for name in names]
    assert text.count(f"**{MISSES}**") == int((table[table["case"].isin(names)]["verdict"] == MISSES).sum()) > 0
    assert text.count("1 m: 10 steps, 2 s") == len(names) and all(page.case["source"] in text for page in pages)
    assert (tmp_path / "book.pdf").read_bytes().count(b"/Type /Page ") == len(names)


def test_steps_and_seconds_are_added_up_by_resolution(tmp_path: Path) -> None:
    """A search has no particles, and its steps are not known."""
    for name, particles in (("run", 4), ("again", 4), ("search", 0)):
        with netCDF4.Dataset(tmp_path / f"{name}.nc", "w") as data:
            if particles:
                data.createDimension("particle", particles)
                data.setncattr("particle_steps", 40.0)
            data.setncattr("wall_time_s", 1.5)
    found = costs_of(["1 m", "1 m", "2 m"], [tmp_path / f"{name}.nc" for name in ("run", "again", "search")])
    assert found == [Cost("1 m", 20, pytest.approx(3.0)), Cost("2 m", 0, 1.5)]
