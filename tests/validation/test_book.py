"""The verification book: a page a case, with what was missed."""

from __future__ import annotations

import math
import os
import re
from pathlib import Path

import netCDF4
import pytest
from matplotlib.figure import Figure

from cases import CASES
from cases.book import Code, Cost, Page, code_of, costs_of, missed_rows, save_book
from cases.suite import SHIPPED_VALIDATION, read_validation
from sph.scene.schema import make_scene
from sph.study.verdicts import MISSES

CODE = Code("1.2.3", "0123456789abcdef", "2026-11-26")


def test_a_page_a_case_with_its_misses(tmp_path: Path) -> None:
    table = read_validation(SHIPPED_VALIDATION)
    picture = tmp_path / "picture.png"
    Figure(figsize=(3.0, 2.0)).savefig(picture)
    names = list(dict.fromkeys(table["case"]))[-3:]
    pages = []
    for name in names:
        scene = make_scene(next(iter(CASES[name].scenes().values())))
        pages.append(Page(name, CASES[name], table[table["case"] == name], [Cost("1 m", 10, 2.0)], CODE, scene))
    save_book(pages, [picture] * len(pages), tmp_path / "book.md", tmp_path / "book.pdf")
    text = (tmp_path / "book.md").read_text(encoding="utf-8")
    assert [line.split(":")[0] for line in text.splitlines() if line.startswith("## ")] == [f"## {name}" for name in names]
    assert text.count(f"**{MISSES}**") == int((table[table["case"].isin(names)]["verdict"] == MISSES).sum()) > 0
    assert text.count(f"Made by {CODE}.") == len(names) + 1, "on the first page and on each case's"
    opening, missed = text[: text.index("## ")], table[table["case"].isin(names) & (table["verdict"] == MISSES)]
    assert all(row in opening for row in missed["text"]) and opening.count("| V") == len(missed)
    assert text.count("1 m: 10 steps, 2 s") == len(names) and all(page.case.source in text for page in pages)
    assert (tmp_path / "book.pdf").read_bytes().count(b"/Type /Page ") == 1 + len(names)


def test_what_is_missed_most_comes_first() -> None:
    """By the error over the tolerance: three times, twice; a run that diverged before both, and what holds not at all."""
    table = read_validation(SHIPPED_VALIDATION).head(4).copy()
    table["text"], table["verdict"] = ["twice", "holds", "thrice", "diverged"], [MISSES, "holds", MISSES, MISSES]
    table["error"], table["tolerance"] = [0.2, 0.01, -0.3, math.nan], 0.1
    page = Page("V1", CASES["V1"], table, [], None, None)
    assert [row[1] for row in missed_rows([page])] == ["diverged", "thrice", "twice"]


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


def test_the_code_of_a_case_is_that_of_its_files(tmp_path: Path) -> None:
    """More than one solver are all named, and the day is that of the last file."""
    for name, solver in (("a", "1111"), ("b", "1111"), ("c", "2222")):
        with netCDF4.Dataset(tmp_path / f"{name}.nc", "w") as data:
            data.setncatts({"source": "sph 1.2.3", "solver_digest": solver})
        os.utime(tmp_path / f"{name}.nc", (0.0, 86_400.0 * (1 + ord(name) - ord("a"))))
    assert code_of([tmp_path / "b.nc", tmp_path / "a.nc"]) == Code("1.2.3", "1111", "1970-01-03")
    assert code_of([tmp_path / "a.nc", tmp_path / "c.nc"]).solver == "1111 and 2222"


def test_the_source_of_every_case_is_told() -> None:
    """What is published has a year; what is ours has none of its own, and every case says which of its numbers are ours."""
    for name, case in CASES.items():
        assert case.reference == "own" or re.search(r"(19|20)\d\d", case.source), name
        assert case.ours != "all", name
