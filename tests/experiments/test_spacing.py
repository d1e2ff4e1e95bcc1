"""What a second spacing changes, on numbers that are known."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import pandas as pd
import pytest
import yaml

from sph.experiments.registry import load_study
from sph.experiments.variants.design import load_spacing
from sph.experiments.variants.second_spacing import (
    CONVERGED,
    DECIDING,
    NOT_CONVERGED,
    UNKNOWN,
    compared,
    deciding_runs,
    read_spacing,
    spacing_columns,
)
from sph.jobs.catalogue import Catalogue
from sph.measures.metrics import UNDETERMINED
from sph.page.second_spacing import answer_spacing, drifts
from sph.study.dimensions import BASE
from sph.study.plan import Plan
from sph.study.tables import Layout, study_rows, text_column, write_csv

ROOT = Path(__file__).resolve().parents[2]
FINE, COARSE = 1.0, 1.5
LAYOUT = Layout(axes=(*Layout().axes, text_column("alternative", "")))


def run(displacement: float, runout: float = 0.0, name: str = "collapse") -> dict[str, Any]:
    return {"collapse_class": name, "displacement_magnitude": displacement, "runout": runout, "road_passed": runout - 8.0}


@pytest.mark.parametrize(
    ("quantity", "own", "second", "extrapolated", "verdict"),
    [
        ("displacement_magnitude", run(10.0), run(9.1), 11.8, CONVERGED),
        ("displacement_magnitude", run(10.0), run(8.9), 12.2, NOT_CONVERGED),
        ("displacement_magnitude", run(0.03), run(0.07), 0.0, CONVERGED),  # neither is what counts as motion
        ("displacement_magnitude", run(5.0), run(5.0, name="damaged"), math.nan, NOT_CONVERGED),
        ("runout", run(0.0, 2.0), run(0.0, 1.3), 3.4, CONVERGED),  # half of the coarser spacing
        ("runout", run(0.0, 2.0), run(0.0, 1.2), 3.6, NOT_CONVERGED),
        ("road_passed", run(0.0, 2.0), run(0.0, 3.5), -9.0, NOT_CONVERGED),  # the run-out changes by more than a tenth
        ("road_passed", run(0.0, 8.5), run(0.0, 7.7), 2.1, CONVERGED),  # it is near the road, and the run-out changes by less
        ("runout", run(0.0, 2.0), run(math.nan, math.nan, UNDETERMINED), math.nan, UNKNOWN),
    ],
)
def test_two_spacings_compared(quantity: str, own: Any, second: Any, extrapolated: float, verdict: str) -> None:
    """On the line through 1.5 and 1 m the value at 0 is that at 1 m and twice its change."""
    found = compared(own, second, quantity, (FINE, COARSE), 0.05)
    assert found[:4] == pytest.approx((FINE, own[quantity], COARSE, second[quantity]), nan_ok=True)
    assert found[4] == pytest.approx(extrapolated, nan_ok=True) and found[6] == verdict
    turned = compared(second, own, quantity, (COARSE, FINE), 0.05)
    assert turned[4:] == pytest.approx(found[4:], nan_ok=True), "whichever of the two is the study's own"


def study(**changes: Any) -> Plan:
    config = yaml.safe_load((ROOT / "config" / "studies" / "gentle_layered.yaml").read_text(encoding="utf-8"))
    return load_study(config | changes, [ROOT])


def test_every_run_of_the_study_is_made_at_the_second_fidelity() -> None:
    plan = study()
    found = load_spacing("", plan)
    assert found.spacings == (1.0, 2.0) and list(found.second.study.runs) == list(plan.study.runs)
    files = {row.file for row in plan.jobs}
    assert {row.file for row in found.second.shared.runs.values()} <= files <= Catalogue(plan, [ROOT]).own.keys()
    assert {file.split("/")[2] for file in files} == {"own", "coarse"}


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"second_fidelity": None}, "names none besides fidelity 'own'"),
        ({"fidelity": "coarse", "fidelities": {"coarse": {"numerics": {"spacing": 2.0}}}}, "names none besides fidelity 'coarse'"),
        ({"second_fidelity": "same", "fidelities": {"own": {}, "same": {}}}, "'same' has the spacing of 'own', 1 m"),
    ],
)
def test_nothing_to_compare_is_refused(changes: dict[str, Any], words: str) -> None:
    plan = study(**changes)
    with pytest.raises(ValueError, match="second_fidelity: ") as raised:
        load_spacing("", plan)
    assert words in str(raised.value)


def test_a_study_over_the_spacing_has_no_second_one() -> None:
    with pytest.raises(ValueError, match="second_fidelity: 'coarse' .*numerics.spacing is a dimension"):
        study(grid={"numerics.spacing": ["1.0", "2.0"]})


def test_an_unknown_second_fidelity_is_refused() -> None:
    with pytest.raises(ValueError, match="second_fidelity: 'finest' is not one of"):
        study(second_fidelity="finest")


def test_at_the_second_fidelity_itself_the_runs_that_decide_are_made_finer(tmp_path: Path) -> None:
    plan = study(fidelity="coarse")
    found = load_spacing("", plan)
    assert found.spacings == (2.0, 1.0) and plan.draft is None
    assert {row.file.split("/")[2] for row in plan.jobs} == {"coarse"}, "which they are is not known yet"
    catalogue = Catalogue(plan, [ROOT], tmp_path)
    assert catalogue.started == []
    name = next(iter(plan.study.runs))
    path = tmp_path / plan.folder / DECIDING
    path.parent.mkdir(parents=True)
    write_csv(pd.DataFrame({"run": [name]}), path)
    files = [row.file for row in catalogue.started]
    assert files[-1] == found.second.shared.runs[name].file and {file.split("/")[2] for file in files} == {"own"}
    assert {*files} <= catalogue.own.keys(), "the workflow knows how to make them"
    assert all(row.target == "fidelity own" for row in catalogue.started)


@pytest.mark.parametrize(
    ("classes", "moved", "expected"),
    [
        (["stable", "stable", "minor", "collapse", "damaged", "collapse"], [0.01, 0.02, 5.0, 4.0, 1.0, 7.0], ["2a", "3b", "1b"]),
        (["collapse"] * 6, range(6), ["1b", "2b"]),
        (["stable"] * 6, range(6), ["3b"]),
        ([UNDETERMINED, *["stable"] * 4, "collapse"], range(6), ["3b", "2b"]),
        ([UNDETERMINED] * 6, range(6), []),
    ],
)
def test_the_runs_that_decide_are_those_at_the_ends_of_the_bracket(tmp_path: Path, classes: Any, moved: Any, expected: list[str]) -> None:
    """Of each level the one that moves farthest; of the scene as it is."""
    names = ["1a", "1b", "2a", "2b", "3a", "3b"]
    rows = [
        dict.fromkeys(LAYOUT.names, 0)
        | {"gamma": str(number), "amplitude": name[0], "alternative": BASE, "status": "complete"}
        | {"collapse_class": found, "displacement_magnitude": far, "diverged": int(found == UNDETERMINED)}
        for number, (name, found, far) in enumerate(zip(names, classes, moved, strict=True))
    ]
    other = rows[-1] | {"alternative": "berm", "collapse_class": "collapse", "displacement_magnitude": 99.0}
    path = tmp_path / "study.csv"
    write_csv(study_rows([*rows, other], LAYOUT), path)
    assert deciding_runs(str(path), [*names, "berm"], LAYOUT)["run"].tolist() == expected


def test_the_first_screen_says_what_is_not_converged(tmp_path: Path) -> None:
    runs = {"weak": (run(15.3), run(9.9)), "strong": (run(0.01, name="stable"), run(0.01, name="stable"))}
    rows = [
        (name, *(each["collapse_class"] for each in both), quantity, *compared(*both, quantity, (1.27, 1.9), 0.05))
        for name, both in runs.items()
        for quantity in ("displacement_magnitude", "runout")
    ]
    table, file = pd.DataFrame(rows, columns=[column.name for column in spacing_columns()]), tmp_path / "spacing.csv"
    write_csv(table, file)
    pd.testing.assert_frame_equal(read_spacing(file), table)
    (fact,) = answer_spacing(table, 2)
    assert fact[1:] == (
        "agrees within 10 %, or differs by less than counts as motion, in 1 of 2 runs",
        "all runs with particles of 1.27 m and 1.9 m",
    )
    assert answer_spacing(table, 2, "3 rows")[0][2].endswith("; it does not show what more rows would change: 3 rows")
    assert drifts(table, "B", {}) == [
        "Not converged: displacement of B in 1 of 2 runs. With particles of 1.27 m and of 1.9 m: at weak B moves 15.3 m and 9.90 m "
        "(extrapolated to spacing 0: 26.2 m)."
    ]
    assert answer_spacing(table, 6)[0][2].startswith("the runs that decide in what shaking it fails, with particles of")
    past = [("weak", "collapse", "collapse", "road_passed", *compared(run(9.0, 10.0), run(9.0, 7.5), "road_passed", (1.27, 1.9), 0.05))]
    assert drifts(pd.DataFrame(past, columns=table.columns), "A", {"weak": "S_R 0.1"}) == [
        "Not converged: whether debris reaches road depends on the spacing at S_R 0.1."
    ]
    both = [(*past[0][:3], f"{place}_passed", *past[0][4:]) for place in ("road", "house")]
    assert drifts(pd.DataFrame(both, columns=table.columns), "A", {}) == [
        "Not converged: whether debris reaches road or house depends on the spacing at weak."
    ]
    assert drifts(pd.DataFrame([*rows, *past], columns=table.columns), "B", {})[0].endswith("26.2 m), it reaches road or not.")
    short = run(9.0, 4.0), run(2.0, 3.0, "damaged")  # of two classes, and both short of the road
    past = [(name, "", "", "road_passed", *compared(own, second, "road_passed", (1.27, 1.9), 0.05)) for name, own, second in (
        ("short", *short), ("diverged", run(9.0, 4.0), run(math.nan, math.nan, UNDETERMINED)))]  # fmt: skip
    assert drifts(pd.DataFrame(past, columns=table.columns), "A", {}) == [], "the spacing does not decide whether the road is reached"
    assert answer_spacing(None, 2) == drifts(None, "A", {}) == answer_spacing(table[:0], 2) == []
