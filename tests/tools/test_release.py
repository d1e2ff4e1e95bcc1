"""What a release states of the paper's study is read from the study's files."""

from __future__ import annotations

from pathlib import Path

import pandas as pd
import pytest

import sph
from sph.experiments.paper.claims import CLAIMS
from sph.study.tables import VALUES, Layout, write_csv
from sph.study.verdicts import HOLDS, NOT_YET
from tools import release
from tools.release import (
    RESOLVED_STUDIES,
    agreement,
    compared_fidelities,
    measured_claims,
    read_measured,
    resolved_claims,
    write_time,
)

POINTS = [("0.10", "100", "6.0"), ("0.25", "100", "6.0"), ("0.50", "100", "6.0")]


def study(classes: list[str], displacements: list[float]) -> pd.DataFrame:
    """Table of three runs, zero or empty but for class and displacement."""
    rows = []
    for point, collapse_class, displacement in zip(POINTS, classes, displacements, strict=True):
        row = {value.name: "" if value.dtype == "str" else 0 for value in VALUES}
        row |= dict(zip(("S_R", "gamma", "amplitude"), point, strict=True))
        rows.append(row | {"collapse_class": collapse_class, "displacement_magnitude": displacement})
    return pd.DataFrame(rows)[Layout().names]


BASELINE = study(["collapse", "damaged", "stable"], [20.0, 2.0, 0.05])


def test_a_study_is_compared_run_by_run() -> None:
    other = study(["collapse", "collapse", "stable"], [22.0, 9.0, 0.10])
    found = agreement(other.iloc[::-1], BASELINE)
    assert found == {"runs": 3, "same_class": 2, "displacement_difference": pytest.approx(0.1)}, "another class and 5 cm do not count"
    with pytest.raises(ValueError, match="2 of the 3 runs"):
        agreement(other.iloc[:2], BASELINE)


def test_fidelities_are_read_from_their_studies(tmp_path: Path) -> None:
    for fidelity, displacement in (("paper", 20.0), ("draft", 15.0)):
        (tmp_path / fidelity).mkdir()
        write_csv(study(["collapse", "damaged", "stable"], [displacement, 2.0, 0.05]), tmp_path / fidelity / "study.csv")
    found = compared_fidelities(tmp_path).to_dict("records")
    assert found == [{"fidelity": "draft", "runs": 3, "same_class": 3, "displacement_difference": 0.25, "origin": sph.__version__}]
    (tmp_path / "draft" / "study.csv").unlink()
    with pytest.raises(ValueError, match="fidelity; run"):
        compared_fidelities(tmp_path)


def test_claims_of_the_scheme_of_ones_own_slopes_are_those_of_its_studies_at_every_fidelity(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match="--configfile config/studies/NAME.yaml"):
        resolved_claims(tmp_path)
    for name, fidelity in ((RESOLVED_STUDIES[1], "draft"), (RESOLVED_STUDIES[0], "standard"), (RESOLVED_STUDIES[0], "draft")):
        row = pd.DataFrame([(1, "s", "t", f"{name} at {fidelity}", HOLDS)], columns=["claim", "statement", "test", "measured", "verdict"])
        (tmp_path / name / fidelity).mkdir(parents=True)
        write_csv(row, tmp_path / name / fidelity / "claims.csv")
    found = resolved_claims(tmp_path)
    assert list(zip(found["study"], found["fidelity"], strict=True)) == [
        (RESOLVED_STUDIES[0], "draft"),
        (RESOLVED_STUDIES[0], "standard"),
        (RESOLVED_STUDIES[1], "draft"),
    ]
    assert list(found["measured"]) == [f"{name} at {fidelity}" for name, fidelity in zip(found["study"], found["fidelity"], strict=True)]


def test_the_claims_of_the_scheme_of_ones_own_slopes_are_shipped() -> None:
    table = read_measured("resolved_claims")
    for _, rows in table.groupby(["study", "fidelity"]):
        assert list(rows["claim"]) == [claim.number for claim in CLAIMS]
    assert set(table["study"]) <= set(RESOLVED_STUDIES)


def test_claims_are_those_of_the_study_and_of_the_search(tmp_path: Path) -> None:
    (tmp_path / "paper").mkdir()
    rows = [(claim.number, claim.statement, "test", f"number {claim.number}", NOT_YET if claim.number == 11 else HOLDS) for claim in CLAIMS]
    write_csv(pd.DataFrame(rows, columns=["claim", "statement", "test", "measured", "verdict"]), tmp_path / "paper" / "claims.csv")
    with pytest.raises(ValueError, match="run 'snakemake --cores 2 trigger'"):
        measured_claims(tmp_path)
    (tmp_path / "draft" / "trigger" / "rounds").mkdir(parents=True)
    decided = pd.DataFrame([(11, "the box", "s", "a search", "1.9 m/s²", HOLDS), (11, "slip", "s", "a search", "2.6 m/s²", "fails")])
    decided.columns = pd.Index(["claim", "case", "statement", "test", "measured", "verdict"])
    write_csv(decided, tmp_path / "paper" / "trigger" / "claim.csv")
    found = measured_claims(tmp_path)
    assert list(found.columns) == [row.name for row in release.CLAIMS] and set(found["verdict"]) == {HOLDS}
    assert found["measured"].tolist() == [*(f"number {n}" for n in range(1, 11)), "1.9 m/s², searched at fidelity `draft`", "number 12"]
    with pytest.raises(ValueError, match="claims.csv: .*snakemake --cores 2"):
        measured_claims(tmp_path / "elsewhere")


def test_the_shipped_claims_are_the_paper_s() -> None:
    shipped = read_measured("claims")
    assert [(row["claim"], row["statement"]) for row in shipped.to_dict("records")] == [(claim.number, claim.statement) for claim in CLAIMS]


def test_a_time_takes_the_place_of_an_earlier_one(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    write_csv(read_measured("times"), tmp_path / "times.csv")
    before = read_measured("times")
    monkeypatch.setattr(release, "MEASURED", tmp_path)
    write_time("study", 61.4, "from nothing", "some processor, 2 cores")
    after = read_measured("times").set_index("task")
    assert len(after) == len(before) and after.loc["study", "wall_time"] == 61.4 and after.loc["tests", "wall_time"] > 0
