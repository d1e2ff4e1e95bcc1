"""Alternatives of a study: the runs and stages that they need, and the table beside the scene as it is."""

from __future__ import annotations

import math
import re
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest
import yaml
from small_scenes import SLOPE

from sph.checks.cover_rows import factor_with
from sph.checks.finding import finding
from sph.checks.messages import Severity
from sph.checks.scene import findings
from sph.experiments.registry import EXPERIMENTS, load_study
from sph.page.alternatives import Doubt, compared, doubts, holding, slices_of, verdict
from sph.page.facts import few_rows
from sph.page.tables import turned
from sph.scene.schema import make_scene
from sph.solver.particles import place_particles
from sph.study.dimensions import BASE, Dimension
from sph.study.plan import Plan
from sph.study.preflight import Row

ROOT = Path(__file__).parents[2]
PAGE = ROOT / "docs" / "how-to" / "studies.md"
ALTERNATIVES: dict[str, Any] = {
    "drained": {"water": None},
    "head_35": {"water": {"level": 20.0}},
    "buttress": {"layers": {"fill": {"region": {"kind": "below", "file": "fill.csv"}, "soil": {"cohesion": 300.0}}}},
    "weaker": {"coupling": {"S_R": 0.1}},
}
KEYS = {"study": "alternatives", "scene": "slope.yaml", "fidelity": "own", "fidelities": {"own": {}}, "alternatives": ALTERNATIVES}


@pytest.fixture
def study(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> dict[str, Any]:
    monkeypatch.chdir(tmp_path)
    Path("slope.yaml").write_text(yaml.safe_dump(SLOPE | {"water": {"pressure": "by_place", "level": 15.0}}))
    Path("fill.csv").write_text("x (m),level (m)\n0,8\n120,9\n")
    return KEYS | {"grid": {"amplitude": ["4.0", "8.0"]}}


def test_a_page_for_a_client_has_the_figures_of_the_full_one(study: dict[str, Any]) -> None:
    """Which are not drawn again for other words, unless a symbol stands in them."""
    full, client = (load_study(study | {"page": page}) for page in ("full", "client"))
    assert full.drawn_dimensions == client.drawn_dimensions and full.figure_titles("profiles") == client.figure_titles("profiles")
    assert full.dimensions != client.dimensions
    rates = study | {"grid": {"gamma": ["1", "100"]}}
    assert load_study(rates).drawn_dimensions[0].symbol == "γ"
    assert load_study(rates | {"page": "client"}).drawn_dimensions[0].symbol == "rate of the loss of strength"


def test_every_run_is_made_for_each_alternative(study: dict[str, Any]) -> None:
    """With their names; keys, files and water lines lie over the scene, and stages are shared where nothing differs before them."""
    plan = load_study(study)
    assert plan.study.names == ["amplitude", "alternative"]
    assert [*plan.study.runs][:5] == [f"amplitude-4.0_alternative-{name}" for name in ("base", *ALTERNATIVES)]
    assert len(plan.study.runs) == 10
    scenes = {name: plan.built(amplitude="8.0", alternative=name) for name in ("base", *ALTERNATIVES)}
    assert scenes["base"] == plan.built(amplitude="8.0") == make_scene(plan.scene(amplitude="8.0"))
    assert scenes["drained"].water is None and scenes["head_35"].water.level == 20.0
    assert scenes["buttress"].layers["fill"].region.points == ((0.0, 8.0), (120.0, 9.0))
    gravities = {stage.id for stage in plan.shared.gravities}
    assert gravities == {"gravity", *(f"gravity_alternative-{name}" for name in ("drained", "head_35", "buttress"))}
    assert len(plan.shared.pre_failures) == 8, "of two amplitudes; weaker soil after failure shares that of the scene as it is"
    assert len({search.file for search in plan.searches.values()}) == 4, "a search for each slope"
    assert [found.variable(False).dtype for found in plan.dimensions] == ["f8", "str"]


def test_the_example_of_the_documentation_can_be_run(monkeypatch: pytest.MonkeyPatch) -> None:
    """Its buttress stands in front of the old ground, and its layers have particles."""
    monkeypatch.chdir(ROOT)
    (example,) = (code for code in re.findall(r"```yaml\n(.*?)```", PAGE.read_text(encoding="utf-8"), re.DOTALL) if "alternatives:" in code)
    plan = load_study(yaml.safe_load(example))
    base, *others = (plan.built(amplitude="3.0", alternative=name) for name in ("base", *plan.study.alternatives))
    assert all(scene != base for scene in others)
    assert not [each for scene in (base, *others) for each in findings(scene) if each.severity == Severity.ERROR]
    (buttress,) = (scene for scene in others if "fill" in scene.layers)
    x = np.linspace(0.0, base.geometry.width, 500)
    added = buttress.geometry.ground(x) - base.geometry.ground(x)
    assert added.min() > -0.01 and added.max() > 3.0
    particles = place_particles(buttress)
    filled = np.count_nonzero(particles.layer[: particles.n_soil] == 1 + [*buttress.layers].index("fill"))
    assert filled == pytest.approx(np.trapezoid(added, x) / buttress.numerics.spacing**2, rel=0.2)


def test_a_list_of_runs_has_alternatives_too(study: dict[str, Any]) -> None:
    plan = load_study(
        {name: value for name, value in study.items() if name != "grid"} | {"cases": [{"amplitude": "4.0"}, {"amplitude": "8.0"}]}
    )
    assert len(plan.study.runs) == 10 and {point["alternative"] for point in plan.study.runs.values()} == {"base", *ALTERNATIVES}


def test_a_grid_may_choose_some(study: dict[str, Any]) -> None:
    plan: Plan = load_study(study | {"grid": {"amplitude": ["4.0"], "alternative": ["base", "drained"]}})
    assert [*plan.study.runs] == ["amplitude-4.0_alternative-base", "amplitude-4.0_alternative-drained"]
    over = plan.over({"amplitude": ["1.0", "2.0"]})
    assert [*over.study.runs] == ["amplitude-1.0", "amplitude-2.0"], "a search of the scene as it is"
    chosen = plan.over({"amplitude": ["1.0"], "alternative": ["drained"]})
    assert chosen.built(**next(iter(chosen.study.runs.values()))).water is None


def test_an_alternative_that_moves_the_toe_moves_no_place(study: dict[str, Any]) -> None:
    longer = {"geometry": {"apron_length": 57.0}}
    changed = study | {"alternatives": {"longer": longer}, "grid": {"amplitude": ["4.0"]}}
    with pytest.raises(ValueError, match="metrics.places.road: '3 beyond the toe'.*moves the toe; give its x, 52"):
        load_study(changed | {"metrics": {"places": {"road": "3 beyond the toe"}}})
    load_study(changed | {"metrics": {"places": {"road": 52.0}}})
    load_study(study | {"metrics": {"places": {"road": "3 beyond the toe"}}})


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"alternatives": {"base": {}}}, "alternatives.base: is the name of the scene as it is"),
        ({"alternatives": {"strong": {"motion": {"amplitude": 9.0}}}}, "motion.amplitude: is a dimension of the runs"),
        ({"alternatives": {"wet": {"watr": {}}}}, "alternative = wet.*no such key"),
        ({"alternatives": {"two words": {}}}, "alternatives.two words"),
        ({"grid": {"amplitude": ["4.0"], "alternative": ["dry"]}}, "alternative: 'dry' is not one of base, drained"),
    ],
)
def test_what_cannot_be_an_alternative_is_refused(study: dict[str, Any], changes: dict[str, Any], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        load_study(study | changes)


def table_of(**columns: list[Any]) -> pd.DataFrame:
    """Six runs: two amplitudes of the scene as it is, of a drained slope and of a buttress."""
    table = pd.DataFrame(
        {
            "amplitude": ["2.0", "4.0"] * 3,
            "alternative": ["base", "base", "drained", "drained", "buttress", "buttress"],
            "collapse_class": ["minor", "collapse", "stable", "minor", "stable", "stable"],
            "displacement_magnitude": [0.5, 10.0, 0.0, 4.0, 0.0, 0.1],
            "runout": [0.0, 12.0, 0.0, 3.0, 0.0, 0.0],
            "expected_runout_error": math.nan,
            "yield_acceleration": [1.0, 1.0, 2.0, 2.0, 3.0, 3.0],
            "house_passed": [-11.0, 1.0, 2.0, -8.0, -11.0, -11.0],  # past it with one run, as a film too thin to be debris
            "house_reached": [0.0, 1.0, 0.0, 0.0, 0.0, 0.0],
            "house_depth": 0.0,
            "house_peak_depth": [0.0, 1.5, 0.0, 0.1, 0.0, 0.0],
            "house_arrival": [math.nan, 9.5] + [math.nan] * 4,
            "shaking_start": 3.0,
            "at_rest": 1,
            "time_to_rest": 7.5,
            "diverged": 0,
            "status": "complete",
            "reached_side": "",
            "findings": "",
        }
    )
    return table.assign(**columns)


DIMENSIONS = [Dimension("amplitude", "m/s2", "", False), Dimension("alternative", "-", "", True)]


def test_the_table_sets_alternatives_beside_the_scene_as_it_is() -> None:
    (found,) = compared(table_of(), DIMENSIONS, "A")
    assert [row[:4] for row in found.rows] == [
        ("as it is", "collapse", "2 of 2", "2 m/s2 (0.204 g)"),
        ("drained", "minor", "1 of 2", "4 m/s2 (0.408 g)"),
        ("buttress", "stable", "0 of 2", "not up to 4 m/s2 (0.408 g)"),
    ]
    assert [row[5:] for row in found.rows] == [
        ("10.0", "12.0", "–", "–"),
        ("4.00", "3.00", "6.00 m (60 %)", "9.00 m (75 %)"),
        ("0.100", "0", "9.90 m (99 %)", "12.0 m (100 %)"),
    ]
    assert "amplitude 4.0 m/s²" in found.note
    (berm,) = compared(table_of(runout=[0.0, 12.0, 0.0, 3.0, 0.0, 0.0], house_passed=[-11.0, 1.0, 2.0, -8.0, -4.0, 0.0]), DIMENSIONS, "A")
    assert berm.rows[2][-1] == "12.0 m (100 %)", "nothing comes down"
    fails = ["stable", "collapse", "stable", "minor", "stable", "collapse"]
    (berm,) = compared(table_of(collapse_class=fails, house_passed=[-11.0, 1.0, 2.0, -8.0, -4.0, 0.0]), DIMENSIONS, "A")
    assert berm.rows[2][-1] == "1.00 m (8 %)", "its foot lies 11 m beyond the toe, where its debris is"
    past = {f"{place}_{name}": [0.0] * 6 for place in ("bench", "house") for name in ("reached", "depth", "peak_depth", "arrival")}
    past |= {"house_passed": [-11.0, 1.0, 2.0, -8.0, -4.0, 0.0], "bench_passed": [9.0, 30.0, 30.0, 10.0, 10.0, 33.0]}
    both = table_of(collapse_class=fails, **past)
    (berm,) = compared(both[sorted(both.columns)], DIMENSIONS, "A")
    assert berm.rows[2][-1] == "1.00 m (8 %)", "at the farthest place, whichever the study names first"
    assert "farther than" not in found.note
    (deeper,) = compared(table_of(displacement_magnitude=[0.5, 10.0, 0.6, 12.0, 0.51, 0.1]), DIMENSIONS, "A")
    assert "With drained A moves farther than as it is, by more than 10 %, in 2 of 2 runs." in deeper.note and "buttress" not in deeper.note
    (open_one,) = compared(table_of(displacement_magnitude=[0.5, 10.0, 0.6, 12.0, 0.51, 0.1], at_rest=[1, 0, 1, 1, 1, 1]), DIMENSIONS, "A")
    assert "With drained A moves farther than as it is, by more than 10 %, in 1 of 2 runs." in open_one.note, "the other may go on as far"
    keys = {"drained": {"water": {"file": "low.csv"}}, "buttress": {"soil": {"cohesion": 9.0}, "numerics": {"lattice_shift": [0.0, 0.5]}}}
    (named,) = compared(table_of(), DIMENSIONS, "A", keys=keys)
    assert "drained: `water.file` low.csv." in named.note
    assert "buttress: `soil.cohesion` 9.0 and `numerics.lattice_shift` 2 values." in named.note
    on_paper = turned(found)
    assert on_paper.head == ("alternative", "as it is", "drained", "buttress")
    assert on_paper.rows[-2] == ("displacement that it saves", "–", "6.00 m (60 %)", "9.90 m (99 %)")
    assert compared(table_of().drop(columns="alternative"), DIMENSIONS[:1], "A") == []


def test_each_alternative_has_its_own_factor_of_safety() -> None:
    runs = table_of().set_index(pd.Index([f"run-{number}" for number in range(6)]))
    base = finding("limit-equilibrium", bishop=1.44, spencer=1.26, critical=1.09)
    drained = finding("limit-equilibrium", bishop=1.65, spencer=1.51, critical=2.11)
    (found,) = compared(runs, DIMENSIONS, "A", slices_of(runs, [Row(drained, 2, "run-2"), Row(base, 2, "run-0")]))
    assert [row[-2:] for row in found.rows] == [("1.44, 1.26", "1.09 m/s2 (0.111 g)"), ("1.65, 1.51", "2.11 m/s2 (0.215 g)"), ("–", "–")]
    assert all(len(row) == len(found.head) for row in found.rows)
    cover = finding("cover-late", subject="cover", value=1.4, bound=1.1, ground="rock", rows=3.1, thickness=3.0)
    factor = finding("factor-of-safety", value=1.44, error=0.34, coarse=2.0, fine=1.5, step_taken=True)
    assert (
        few_rows([cover, factor])
        == f"; with 2 rows of particles in cover at most, which make it up to {factor_with(2.0) - 1.0:.0%} too high"
    )
    assert few_rows([cover]) == ""
    assert few_rows([cover, replace(factor, numbers=dict(factor.numbers, fine=0.1))]) == "", "thirty rows"


def test_what_is_saved_is_a_bound_where_one_goes_on() -> None:
    """Of runs that still move, reach an end of the box or are braked; of a run that diverged nothing is said."""
    for moving, wanted in (
        ([0, 1, 0, 0, 0, 0], "≥ 6.00 m (60 %)"),
        ([0, 0, 0, 1, 0, 0], "at most 6.00 m (60 %)"),
        ([0, 1, 0, 1, 0, 0], "unknown: in both soil still moves at the end (run it for some 7.5 s more)"),
    ):
        (found,) = compared(table_of(at_rest=[1 - each for each in moving]), DIMENSIONS, "A")
        assert found.rows[1][7] == wanted
    braked = "weak soil is held back (take a smaller spacing, for more rows of particles in it)"
    (found,) = compared(table_of(findings=["", "weak-on-strong"] + ["", "layer-held"] + [""] * 2), DIMENSIONS, "A")
    assert found.rows[1][7] == f"unknown: in both {braked}"
    (found,) = compared(table_of(findings=["", "weak-on-strong"] + [""] * 4, at_rest=[1, 1, 1, 0, 1, 1]), DIMENSIONS, "A")
    assert found.rows[1][7].startswith(f"unknown: as it is {braked}, and with it soil still moves")
    (found,) = compared(table_of(displacement_magnitude=[0.5, 10.0, 0.0, 12.0, 0.0, 0.1]), DIMENSIONS, "A")
    assert found.rows[1][7] == "none, 2.00 m (20 %) farther"
    (found,) = compared(table_of(diverged=[0, 0, 1, 1, 0, 1]), DIMENSIONS, "A")
    assert found.rows[1][1] == "diverged" and found.rows[2][5:8] == ("–", "–", "–")


def test_a_sentence_compares_the_alternatives_also_where_none_helps() -> None:
    def said(**columns: list[Any]) -> str:
        return verdict(table_of(**columns)[1::2])

    assert said() == "Buttress prevents the failure in these runs, drained does not; drained and buttress keep debris from house."
    fails: dict[str, list[Any]] = {"collapse_class": ["collapse"] * 6, "house_reached": [1.0] * 6}
    neither = "Neither drained nor buttress prevents the failure in these runs; neither drained nor buttress keeps debris from house."
    assert said(**fails) == neither
    assert said(findings=[""] * 5 + ["layer-held"]) == (
        "Drained does not prevent the failure in these runs; whether buttress prevents the failure in these runs is unknown; "
        "drained keeps debris from house; whether buttress keeps debris from house is unknown."
    )
    close = said(house_passed=[-12.0, 1.0, 2.0, -0.3, -12.0, -12.0])
    assert close.endswith("buttress keeps debris from house; whether drained keeps debris from house is unknown.")
    assert said(house_passed=[-12.0, 1.0, 2.0, -0.4, -12.0, -12.0]) == said(), "0.12 of a run-out of 3 m"
    assert said(collapse_class=["stable"] * 6, house_reached=[0.0] * 6) == "", "nothing to prevent"
    assert verdict(table_of().drop(columns="alternative")) == "" == said(diverged=[1, 1, 0, 0, 0, 0])
    doubt = Doubt(finding("thin-layer", "numerics.spacing", subject="buttress", value=1.0, bound=4.0), ["buttress"])
    assert verdict(table_of()[1::2], [doubt, doubt]).endswith("; buttress is in doubt, see the warnings.")


def test_alternatives_that_hold_the_slope_in_weaker_shaking_are_named() -> None:
    assert holding(table_of()) == "The slope fails as it is in weaker shaking too, where drained and buttress hold it at 2 m/s2 (0.204 g)."
    fails = ["minor", "collapse", "minor", "minor", "stable", "stable"]
    assert holding(table_of(collapse_class=fails)).endswith("where buttress holds it at 2 m/s2 (0.204 g).")
    assert holding(table_of(at_rest=[1, 1, 0, 1, 0, 1], moving_share=0.1)) == "", "it is not known whether they do"
    assert holding(table_of(collapse_class=["stable", "collapse"] * 3)) == "", "nothing to hold"
    assert holding(table_of()[1::2]) == holding(table_of().drop(columns="alternative")) == ""


def test_what_an_alternative_alone_is_warned_of_is_said_of_it() -> None:
    """That of the scene as it is, perhaps with other numbers, and of all, is said of the runs of the study."""
    table = table_of().rename(index=str)
    base, other = (str(table.index[table["alternative"] == name][0]) for name in (BASE, "buttress"))
    thin = finding("thin-layer", "numerics.spacing", subject="buttress", value=1.0, bound=4.0)
    few = finding("few-particles", "numerics.spacing", value=4.0, bound=20.0, height=10.0)
    assert doubts(table, [Row(thin, 2, other), Row(few, 6, other)]) == [Doubt(thin, ["buttress"])]
    assert doubts(table, [Row(thin, 2, other), Row(few, 2, other), Row(few, 2, base)]) == [Doubt(thin, ["buttress"])], "with other numbers"
    drained = str(table.index[table["alternative"] == "drained"][0])
    (both,) = doubts(table, [Row(few, 2, drained), Row(few, 2, other)])
    assert both.of == "drained and buttress, with the numbers of drained"
    assert doubts(table.drop(columns="alternative"), [Row(thin, 2, other)]) == []


def test_a_trigger_search_may_be_made_for_alternatives(study: dict[str, Any]) -> None:
    """Of those that it names; of the scene as it is where it names none."""
    span = {"dimension": "amplitude", "lowest": 1.0, "highest": 9.0, "cells": 2}
    search = {"cases": {"all": {}}, "classes": ["collapse"], "intensity": span, "tolerance": 1.0}
    levels = {}
    for at in ({}, {"alternative": ["base", "drained"]}):
        Path("trigger.yaml").write_text(yaml.safe_dump(search | {"at": at}))
        design = EXPERIMENTS["trigger"].load("trigger.yaml", load_study(study), [Path()], True)
        fixed = [lattice.fixed for lattice in design.lattices("trigger")]
        runs = design.runs_at([("all", {"amplitude": "3", **each}) for each in fixed])
        for each, run in zip(fixed, runs, strict=True):
            levels[each.get("alternative")] = None if run.built.water is None else run.built.water.level
    assert levels == {None: 15.0, "base": 15.0, "drained": None}
