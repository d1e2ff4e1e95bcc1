"""The matrix of a study: which run stands in which cell, and what the cell says."""

from __future__ import annotations

import itertools

import pandas as pd
import pytest
from matplotlib.colors import to_rgb
from synthetic import study_row

from sph.measures.metrics import CLASSES
from sph.page.matrix import DIVERGED, MAX_CELLS, MAY_FAIL, UNSHAKEN, Cell, matrix
from sph.page.second_spacing import with_second_class
from sph.study.dimensions import Dimension, short_names

DIMENSIONS = [Dimension("S_R", "-", "", False), Dimension("gamma", "1/s", "", False), Dimension("amplitude", "m/s2", "", False)]


def a_study(*values: tuple[str, ...]) -> pd.DataFrame:
    """A grid in which A moves by 100 S_R + gamma + amplitude, named by its values; all collapse."""
    rows = [
        study_row(*point, displacement_magnitude=100 * float(point[0]) + float(point[1]) + float(point[2]), runout=3.0)
        | {"collapse_class": "collapse"}
        for point in itertools.product(*values)
    ]
    return pd.DataFrame(rows, index=["-".join(point) for point in itertools.product(*values)])


def test_every_run_has_its_cell_wherever_it_stands_in_the_table() -> None:
    table = a_study(("0.1", "0.5"), ("1", "10"), ("2.0", "4.0", "6.0")).sample(frac=1.0, random_state=1)
    table = table.sort_values(["S_R", "gamma", "amplitude"], ascending=[True, False, True])
    found = matrix(table, DIMENSIONS, "A", list(table.index))
    assert found is not None and found.columns == "amplitude (m/s²)"
    assert len(found.panels) == 2 and {len(panel.rows) for panel in found.panels} == {2}
    seen = []
    for panel in found.panels:
        assert list(panel.head) == ["2.0 (0.204 g)", "4.0 (0.408 g)", "6.0 (0.612 g)"]
        for label, cells in panel.rows:
            for amplitude, cell in zip(("2.0", "4.0", "6.0"), cells, strict=True):
                S_R, gamma, of = cell.name.split("-")
                assert of == amplitude and f"{100 * float(S_R) + float(gamma) + float(amplitude):.1f}" == f"{float(cell.words):.1f}"
                assert (S_R in label or S_R in panel.title) and (gamma in label or gamma in panel.title)
                seen.append(cell.name)
    assert sorted(seen) == sorted(table.index)


def test_a_run_that_the_spacing_decides_has_an_asterisk() -> None:
    table = a_study(("0.1", "0.5"), ("1",), ("2.0", "4.0"))
    again = pd.DataFrame({"run": [table.index[0], table.index[1]], "second_class": ["stable", "damaged"]})
    found = matrix(with_second_class(table, again, []), DIMENSIONS, "A", [])
    assert found is not None and "with * where the spacing decides whether it stands" in found.caption
    marked = [cell.name for panel in found.panels for _, cells in panel.rows for cell in cells if cell.words.endswith("*")]
    assert marked == [table.index[0]]
    assert "*" not in (matrix(table, DIMENSIONS, "A", []) or found).caption


def test_records_are_called_by_their_names() -> None:
    table = a_study(("0.1", "0.5"), ("1",), ("2.0",))
    table["motion.file"] = ["kjm_000.csv", "elc_180.csv"]
    record = Dimension("motion.file", "-", "", True, (("kjm_000.csv", "Kobe 1995, KJMA"),))
    found = matrix(table, [record], "A", list(table.index))
    assert found is not None and list(found.panels[0].head) == ["Kobe 1995, KJMA", "elc_180.csv"]
    assert record.said("kjm_000.csv") == "record Kobe 1995, KJMA" and record.said("elc_180.csv") == "record elc_180.csv"


@pytest.mark.parametrize(
    ("files", "names"),
    [
        (("quakes/kjm_000.csv", "quakes/elc_180.csv"), ("kjm_000", "elc_180")),
        (("near/a.csv", "far/a.csv", "far/b.csv"), ("near/a", "far/a", "b")),
        (("x/a.EW", "x/a.NS"), ("a.EW", "a.NS")),
        (("a.csv", "x/a.csv"), ("a.csv", "x/a")),
        (("a.csv",), ("a",)),
    ],
)
def test_records_without_names_are_called_by_as_little_as_tells_them_apart(files: tuple[str, ...], names: tuple[str, ...]) -> None:
    assert tuple(short_names(files).values()) == names


def test_what_a_cell_says_of_its_run() -> None:
    table = a_study(("0.1",), ("1",), ("1.0", "2.0", "3.0", "4.0", "5.0"))
    table["status"] = ["complete", "failed_unshaken", "diverged", "complete", "complete"]
    table["diverged"] = [0, 0, 1, 0, 0]
    table["reached_side"] = ["", "", "", "front", ""]
    table["collapse_class"] = ["stable", *["collapse"] * 4]
    found = matrix(table, DIMENSIONS, "crest", list(table.index[:4]))
    assert found is not None and found.caption == "Displacement of crest (m) in each run"
    ((_, cells),) = found.panels[0].rows
    assert [(cell.words, cell.kind, cell.shown) for cell in cells] == [
        ("12.0", "stable", True), ("13.0", UNSHAKEN, True), ("×", DIVERGED, True), ("≥ 15.0", "collapse", True), ("16.0", "collapse", False)
    ]  # fmt: skip
    assert cells[3].said == "collapse; run-out ≥ 3.00 m" and isinstance(cells[0], Cell)
    assert list(found.colours) == ["stable", "collapse", UNSHAKEN, DIVERGED], "the key has the classes that there are"


def test_a_run_that_stands_for_lack_of_rows_has_not_the_colour_of_one_that_stands() -> None:
    table = a_study(("0.1",), ("1",), ("1.0", "2.0", "3.0")).assign(collapse_class=["stable", "stable", "collapse"])
    table["findings"] = ["cover-late", "", "cover-late"]
    found = matrix(table, DIMENSIONS, "A", [], design=2.0005)
    assert found is not None and list(found.colours) == ["stable", MAY_FAIL, "collapse"]
    ((_, cells),) = found.panels[0].rows
    assert [cell.kind for cell in cells] == [MAY_FAIL, "stable", "collapse"] and "gradient" in found.colours[MAY_FAIL][0]
    assert list(found.panels[0].head) == ["1.0 (0.102 g)", "2.0 (0.204 g), design", "3.0 (0.306 g)"]


def test_no_matrix_of_a_list_nor_of_a_large_study() -> None:
    table = a_study(("0.1", "0.5"), ("1",), ("2.0", "4.0"))
    assert matrix(table[:3], DIMENSIONS, "A", []) is None
    many = a_study(tuple(f"{0.1 * n:.1f}" for n in range(1, 10)), ("1",), tuple(map(str, range(1, 10))))
    assert len(many) > MAX_CELLS and matrix(many, DIMENSIONS, "A", []) is None


@pytest.mark.parametrize("kind", [*CLASSES, UNSHAKEN, DIVERGED])
def test_text_on_every_colour_can_be_read(kind: str) -> None:
    """A contrast of 4.5 at least (WCAG 2.1, 1.4.3)."""
    table = a_study(("0.1",), ("1",), ("1.0",)).assign(collapse_class=kind if kind in CLASSES else "stable")
    if kind not in CLASSES:
        table = table.assign(status="failed_unshaken") if kind == UNSHAKEN else table.assign(diverged=1)
    found = matrix(table, DIMENSIONS, "A", [])
    assert found is not None

    def luminance(colour: str) -> float:
        linear = [part / 12.92 if part <= 0.04045 else ((part + 0.055) / 1.055) ** 2.4 for part in to_rgb(colour)]
        return sum(weight * part for weight, part in zip((0.2126, 0.7152, 0.0722), linear, strict=True))

    low, high = sorted(map(luminance, found.colours[kind]))
    assert (high + 0.05) / (low + 0.05) >= 4.5
