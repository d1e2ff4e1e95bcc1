"""Critical amplitudes: what is searched, what is refused, and brackets from hand-made points."""

from __future__ import annotations

import math
from collections import defaultdict
from pathlib import Path
from typing import Any

import pandas as pd
import pytest
import yaml
from overprint import overprints

from sph.experiments.paper.claims import decide_trigger
from sph.experiments.registry import load_study
from sph.experiments.trigger.critical import (
    AT_LOWEST,
    BRACKETED,
    BRAKED,
    NEVER,
    UNDECIDED,
    block_estimates,
    bracket,
    bracket_ends,
    coarser_cases,
    confirm_columns,
    confirm_table,
    critical_columns,
    critical_table,
    read_critical,
)
from sph.experiments.trigger.design import Searched, TriggerPlan, load_trigger
from sph.experiments.trigger.figures import MAPPED, figure_class_map, figure_critical, figure_map, figure_shares
from sph.experiments.trigger.maps import cell_columns, class_shares, map_cells, read_shares, share_columns
from sph.experiments.trigger.points import MEASURED, measured_points, names, no_points, point_columns, read_points, wanted_points
from sph.measures.metrics import CLASSES, MetricSettings, class_displacement
from sph.scene.configuration import dotted, merge, read_yaml
from sph.scene.loading import motion_of
from sph.scene.schema import make_scene
from sph.stability.newmark import sliding_block
from sph.study.baseline import baseline_metrics, newmark_factor
from sph.study.dimensions import Dimension
from sph.study.tables import read_csv, write_csv

ROOT = Path(__file__).resolve().parents[2]
STUDY: dict[str, Any] = yaml.safe_load((ROOT / "config" / "config.yaml").read_text(encoding="utf-8"))
TRIGGER: dict[str, Any] = {
    "fidelity": "draft",
    "cases": {"as it is": {}, "slip: sides": {"walls": {"sides": "free_slip", "layers": 4}}},
    "intensity": {"lowest": 0.0, "highest": 8.0, "cells": 2},
    "tolerance": 0.5,
    "classes": ["collapse", "damaged"],
    "at": {"S_R": ["0.1", "0.3"], "gamma": ["100"]},
    "confirm": {"at": {"S_R": ["0.10"]}},
    "maps": {
        "cases": ["as it is"],
        "over": {
            "S_R": {"lowest": 0.1, "highest": 0.5, "cells": 1},
            "gamma": {"lowest": 1, "highest": 100, "cells": 1, "scale": "logarithmic"},
        },
        "levels": 2,
    },
}


SEARCHED = Searched(
    (Dimension("S_R", "-", "strength ratio", False), Dimension("gamma", "1/s", "rate", False), Dimension("amplitude", "m/s2", "", False)),
    "amplitude",
)


def planned(folder: Path, changes: dict[str, Any] | None = None) -> TriggerPlan:
    (folder / "trigger.yaml").write_text(yaml.safe_dump(merge(TRIGGER, changes or {}), sort_keys=False))
    return load_trigger("trigger.yaml", load_study(STUDY, [folder, ROOT]), [folder])


def line(*classes: str, case: str = "as it is", S_R: str = "0.10", gamma: str = "100", moving: int = 0) -> pd.DataFrame:
    """Points at amplitudes 0, 1, 2, ... of one S_R and gamma."""
    rows = [
        {"case": case, "S_R": S_R, "gamma": gamma, "amplitude": str(at), "round": 0}
        | dict.fromkeys(MEASURED, 1.0)
        | {"collapse_class": name, "status": "diverged" if name == "undetermined" else "complete", "still_moving": moving, "findings": ""}
        for at, name in enumerate(classes)
    ]
    return pd.DataFrame(rows, columns=names(point_columns(SEARCHED.all)))


# ---------------------------------------------------------------- what is searched


def test_the_shipped_searches_are_valid() -> None:
    trigger = load_trigger("config/trigger.yaml", load_study(STUDY, [ROOT]), [ROOT])
    assert trigger.folder == "results/paper/draft" and {at[0] for at in trigger.shaken} == set(trigger.searched)
    assert len(trigger.searched) == 2
    assert {"0.10", "0.25", "0.50"} <= set(trigger.trigger.at["S_R"]) and "100" in trigger.trigger.at["gamma"], "what claim 11 needs"


def test_figures_state_the_spacing_of_the_cases_they_show() -> None:
    study = read_yaml(ROOT / "config" / "studies" / "slope_on_rock.yaml")
    trigger = load_trigger("config/studies/slope_on_rock/trigger.yaml", load_study(study, [ROOT]), [ROOT])
    assert "spacing 2.5 to 1 m" in trigger.note() and trigger.note("maps").startswith("fidelity standard, case 1.25 m · ")


def test_a_case_that_changes_nothing_shares_the_studys_stages(tmp_path: Path) -> None:
    trigger = planned(tmp_path)
    assert trigger.searched == {"as it is": "results/paper/draft", "slip: sides": "results/paper/draft/trigger/slip-sides"}
    study = load_study(STUDY | {"fidelity": "draft"}, [ROOT])
    own, slip = (trigger.plans[folder] for folder in trigger.searched.values())
    assert own.scene() == study.scene() and own.scene(amplitude="4.0") == study.scene(amplitude="4.0")
    assert slip.built().walls.sides == "free_slip" and slip.built().numerics == own.built().numerics


def test_numbers_are_written_as_the_study_writes_them(tmp_path: Path) -> None:
    first, second, *_ = planned(tmp_path).lattices("trigger")
    assert first.labels((0.0,)) == ("0.10", "100", "0") and first.labels((1.0,)) == ("0.10", "100", "4.0")
    assert first.labels((0.125,))[2] == "0.5" and second.labels((0.0,))[0] == "0.3"
    (mapped,) = planned(tmp_path).lattices("maps")
    assert mapped.labels((0.0, 0.5, 1.0)) == ("0.10", "10", "4.0") and mapped.labels((0.5, 0.25, 0.0))[:2] == ("0.3", "3.16228")


def own_search(folder: Path, study: dict[str, Any], search: dict[str, Any]) -> TriggerPlan:
    """A search on the shipped layered slope."""
    own = read_yaml(ROOT / "config" / "studies" / "gentle_layered.yaml")
    (folder / "mine.yaml").write_text(yaml.safe_dump(search, sort_keys=False))
    return load_trigger("mine.yaml", load_study({**own, **study}, [ROOT]), [folder])


OWN: dict[str, Any] = {
    "cases": {"as it is": {}},
    "intensity": {"dimension": "amplitude", "lowest": 0.0, "highest": 4.0, "cells": 2},
    "tolerance": 0.5,
    "at": {"layers.clay.soil.cohesion": ["5", "20"], "walls.sides": ["free_slip", "fixed"]},
}


def test_any_dimensions_are_searched(tmp_path: Path) -> None:
    plan = own_search(tmp_path, {}, OWN)
    assert plan.names == ("amplitude", "layers.clay.soil.cohesion", "walls.sides") and len(plan.lattices("trigger")) == 4
    assert plan.searched == {"as it is": "results/gentle_layered/own/trigger/as-it-is"}, "the study has other dimensions"
    line = plan.lattices("trigger")[1]
    assert line.labels((0.5,)) == ("1", "5", "fixed")
    own = plan.plans[plan.searched["as it is"]]
    point = dict(zip(plan.names, ("1", "5", "free_slip"), strict=True))
    (run,) = plan.runs_at([("as it is", point)])
    scene = make_scene(run.scene)
    assert run.file == f"{own.folder}/runs/amplitude-1_layers.clay.soil.cohesion-5_walls.sides-free_slip.nc"
    assert (scene.motion.amplitude, scene.layers["clay"].soil.cohesion, scene.walls.sides) == (1.0, 5.0, "free_slip")
    shared = own.runs_at({run.id: point})
    assert [stage.id for stage in shared.gravities] == ["gravity_layers.clay.soil.cohesion-5_walls.sides-free_slip"]
    assert [(stage.parent, stage.point["amplitude"]) for stage in shared.pre_failures] == [(shared.gravities[0].file, "1")]
    files = {at: search.file.removeprefix(f"{own.folder}/stages/") for at, search in plan.searches.items()}
    assert files["as it is", "5", "fixed"] == "yield_acceleration_layers.clay.soil.cohesion-5_walls.sides-fixed.nc" and len(files) == 4
    units = {found.name: found.unit for found in plan.dimensions.all}
    assert units["layers.clay.soil.cohesion"] == "kPa" and plan.dimensions.intensity.name == "amplitude"


def test_no_slope_is_searched_twice(tmp_path: Path) -> None:
    """One with the study's own keys before the shaking is the study's, others are shared by the cases that have them."""
    records = {"as it is": {}, "weak": {"coupling": {"S_R": 0.1}}, "late": {"motion": {"start": 5.0}}}
    walls = {name: merge(keys, {"walls": {"sides": "free_slip"}}) for name, keys in records.items()}
    cases = records | {f"{name}, smooth": keys for name, keys in walls.items()}
    search = {**OWN, "cases": cases, "at": {}}
    branches = {"grid": {"amplitude": ["3.0"], "layers.clay.S_R": ["0.25", "0.60"]}, "second_fidelity": None}
    plan = own_search(tmp_path, branches, search)
    assert {plan.searches[case,].file for case in records} == {"results/gentle_layered/own/stages/yield_acceleration.nc"}
    assert {plan.searches[f"{case}, smooth",].file for case in records} == {
        f"{plan.searched['as it is, smooth']}/stages/yield_acceleration.nc"
    }
    assert own_search(tmp_path, branches | {"searches": "quick"}, search).searches == {}


def test_a_search_over_any_dimensions_ends_in_tables_and_figures(tmp_path: Path) -> None:
    maps = {"maps": {"over": {"layers.clay.soil.cohesion": {"lowest": 5.0, "highest": 20.0, "cells": 2}}}}
    plan = own_search(tmp_path, {}, {**OWN, "at": {"layers.clay.soil.cohesion": ["5", "20"]}, **maps})
    searched = plan.dimensions

    def found(amplitude: float, cohesion: float) -> str:
        return "collapse" if amplitude > 1.0 + 0.1 * cohesion else "stable"

    points = searched_points(plan, "trigger", found)
    shaken = {at: scene.build() for at, scene in plan.shaken.items()}
    estimates = block_estimates(shaken, {}, ["collapse"], MetricSettings(), searched, 4.0)
    assert list(estimates) == [("as it is", "5"), ("as it is", "20")]
    assert math.isnan(estimates["as it is", "5"]["collapse"]["newmark_intensity"])
    table = critical_table(points, ["collapse"], estimates, searched)
    assert table["layers.clay.soil.cohesion"].tolist() == ["5", "20"] and table["outcome"].tolist() == [BRACKETED] * 2
    for row, limit in zip(table.to_dict("records"), (1.5, 3.0), strict=True):
        assert row["lower"] <= limit < row["upper"] <= row["lower"] + 0.5
    write_csv(table, tmp_path / "table.csv")
    pd.testing.assert_frame_equal(read_critical(tmp_path / "table.csv"), table)
    figure = figure_critical(table, searched)
    (ax,) = figure.axes
    assert "kPa" in ax.get_xlabel() and "m/s²" in ax.get_ylabel() and [scale.get_ylabel() for scale in ax.child_axes] == ["(g)"]
    assert not overprints(figure)
    mapped = searched_points(plan, "maps", found)
    cells = map_cells(plan.lattices("maps"), mapped, ["collapse"], plan.levels("maps"), searched)
    shares = class_shares(cells, searched)
    assert cells.groupby("amplitude_lower")["share"].sum().max() <= 1.0 + 1e-9
    assert not overprints(figure_class_map(mapped, searched)) and not overprints(figure_map(mapped, searched, MAPPED["runout"]))
    assert len(figure_class_map(mapped, searched).axes) == 1 and len(figure_shares(shares, searched).axes) == 3


def test_a_search_needs_no_other_dimension(tmp_path: Path) -> None:
    plan = own_search(tmp_path, {}, {**OWN, "at": {}})
    assert plan.names == ("amplitude",) and list(plan.searches) == [("as it is",)]
    assert [line.labels((0.5,)) for line in plan.lattices("trigger")] == [("1",)]
    points = searched_points(plan, "trigger", lambda amplitude: "collapse" if amplitude > 1.2 else "stable")
    estimates = {("as it is",): {"collapse": {"yield_acceleration": 2.0, "newmark_intensity": 3.0}}}
    table = critical_table(points, ["collapse"], estimates, plan.dimensions)
    assert table[["lower", "upper"]].to_numpy().tolist() == [[1.0, 1.5]]
    assert len(figure_critical(table, plan.dimensions).axes) == 1


def test_cases_at_a_single_strength_ratio_stand_side_by_side(tmp_path: Path) -> None:
    plan = planned(tmp_path, {"at": {"S_R": ["0.25"], "gamma": ["100"]}, "confirm": None, "maps": None})
    points = searched_points(plan, "trigger", lambda S_R, gamma, amplitude: "collapse" if amplitude > 3.0 else "stable")
    statics = {
        "collapse": {"yield_acceleration": 2.0, "newmark_intensity": 3.0},
        "damaged": {"yield_acceleration": 2.0, "newmark_intensity": 3.0},
    }
    table = critical_table(points, ["collapse"], dict.fromkeys(plan.shaken, statics), plan.dimensions)
    figure = figure_critical(table, plan.dimensions)
    (ax,) = figure.axes
    assert [label.get_text() for label in ax.get_xticklabels()] == list(TRIGGER["cases"])
    words = [text.get_text() for text in figure.legends[0].get_texts()]
    assert words[0] == "$S_R$ = 0.25, γ = 100 s⁻¹"
    several = planned(tmp_path, {})
    points = searched_points(several, "trigger", lambda S_R, gamma, amplitude: "collapse" if amplitude > 3.0 else "stable")
    table = critical_table(points, ["collapse"], dict.fromkeys(several.shaken, statics), several.dimensions)
    assert figure_critical(table, several.dimensions).axes[0].get_xlabel() == "strength ratio $S_R$"


def test_accelerations_have_units(tmp_path: Path) -> None:
    plan = planned(tmp_path, {"intensity": {"highest": "0.8g"}, "tolerance": "50 gal"})
    assert plan.trigger.intensity.highest == pytest.approx(7.848) and plan.trigger.tolerance == pytest.approx(0.5)


@pytest.mark.parametrize(("tolerance", "levels"), [(4.0, 0), (3.9, 1), (1.0, 2), (0.25, 4), (100.0, 0)])
def test_the_number_of_rounds_follows_from_the_tolerance(tmp_path: Path, tolerance: float, levels: int) -> None:
    assert planned(tmp_path, {"tolerance": tolerance}).levels("trigger") == levels


def test_the_widest_cell_of_equal_ratios_decides(tmp_path: Path) -> None:
    ratios = {"lowest": 2.0, "highest": 8.0, "cells": 2, "scale": "logarithmic"}
    assert [planned(tmp_path, {"intensity": ratios, "tolerance": tolerance}).levels("trigger") for tolerance in (4.0, 2.4, 2.3)] == [
        0,
        1,
        2,
    ]


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"classes": ["collapse", {"runout": "road"}]}, ["classes: runout", "'road' is not"]),
        ({"classes": [{"runout": 0}]}, ["classes.0", "'runout: 0'", "a length above 0 in m"]),
        ({"classes": [{"speed": 1}]}, ["classes.0", "'speed: 1'", "displacement: a length"]),
        ({"intensity": {"lowest": 7.9}, "tolerance": 1e-5}, ["tolerance: 1e-05 must be at least 0.0019"]),
        ({"classes": ["collapsed"]}, ["classes.0", "'collapsed'", "minor, damaged, collapse"]),
        ({"classes": ["stable"]}, ["classes.0", "stable"]),
        ({"tolerance": 0.0}, ["tolerance", "greater than 0"]),
        ({"tolerance": 1e-5}, ["tolerance", "1e-05", "0.00098"]),
        ({"intensity": {"lowest": 8.0}}, ["intensity", "lowest (8) must be less than highest (8)"]),
        ({"intensity": {"highest": 101.0}}, ["motion.amplitude", "101", "case 'as it is'"]),
        ({"cases": {"wet": {"soil": {"water": 1.0}}}}, ["trigger.yaml", "case 'wet'", "soil.water", "no such key"]),
        ({"cases": {"wet": {"coupling": {"S_R": 0.2}}}}, ["cases.wet", "coupling.S_R", "searched"]),
        ({"cases": {"as-it-is": {}}}, ["cases", "same file name"]),
        ({"cases": {"thin": {"walls": {"sides": "free_slip", "layers": 1}}}}, ["case 'thin'", "walls.layers"]),
        ({"cases": {"mud": {"coupling": {"initial_state": "fluid"}}}}, ["case 'mud'", "coupling.initial_state", "gravity stage"]),
        ({"fidelity": "best"}, ["fidelity", "best", "draft"]),
        ({"confirm": {"fidelity": "best"}}, ["confirm.fidelity", "best"]),
        ({"confirm": {"at": {"S_R": ["0.2"]}}}, ["confirm.at.S_R", "0.2", "0.1, 0.3"]),
        ({"confirm": {"at": {"soil.cohesion": ["20"]}}}, ["confirm.at", "soil.cohesion", "S_R, gamma"]),
        ({"confirm": {"collapse_class": "minor"}}, ["confirm.collapse_class", "minor", "collapse, damaged"]),
        ({"maps": {"cases": ["odd"]}}, ["maps.cases", "odd", "as it is"]),
        ({"maps": {"over": {"gamma": {"lowest": 0.0}}}}, ["maps.over.gamma", "logarithmic"]),
        ({"maps": {"over": {"S_R": {"highest": 1.5}}}}, ["coupling.S_R", "1.5"]),
        ({"intensity": {"cells": 64}, "tolerance": 3.1e-5}, ["intensity", "too small for labels of six digits"]),
        ({"at": {"soil.cohesion": ["100"]}}, ["maps.over", "S_R, gamma", "dimensions of at (S_R, gamma, soil.cohesion)"]),
        ({"at": {"amplitude": ["1"]}}, ["at.amplitude", "is the intensity that is searched"]),
        ({"at": {"S_R": ["0.1", "0.10"]}}, ["at.S_R", "the same value twice"]),
        ({"at": {"soil.glue": ["1"]}}, ["at.soil.glue", "no such key in a scene"]),
        ({"intensity": {"dimension": "motion.frequency"}}, ["intensity.dimension", "motion.frequency", "amplitude, motion.factor"]),
        ({"maps": {"over": {"S_R": {"cells": 64}, "gamma": {"cells": 64}}}}, ["maps", "12,675 points, at most 10,000"]),
        ({"speed": 1}, ["speed", "no such key"]),
    ],
)
def test_refusals_name_key_and_value(tmp_path: Path, changes: dict[str, Any], words: list[str]) -> None:
    with pytest.raises(ValueError) as raised:
        planned(tmp_path, changes)
    assert all(word in str(raised.value) for word in words), str(raised.value)


def test_what_is_not_configured_is_refused_when_asked_for(tmp_path: Path) -> None:
    trigger = planned(tmp_path, {"maps": None, "confirm": None})
    for name in ("maps", "confirm"):
        with pytest.raises(ValueError, match=f"{name}: null"):
            getattr(trigger, name)


# ---------------------------------------------------------------- rounds


def searched_points(plan: TriggerPlan, search: str, found: Any) -> pd.DataFrame:
    """Points of a search whose class is a function of its dimensions."""
    points = no_points()
    for number in range(plan.levels(search) + 1):
        wanted = wanted_points(plan.lattices(search), points, plan.classes(search), number)
        assert not wanted.duplicated().any()
        metrics = [
            dict.fromkeys(MEASURED, 0.5)
            | {"status": "complete", "still_moving": 0, "findings": "", "collapse_class": found(*map(float, point[1:-1]))}
            for point in wanted.itertuples(index=False, name=None)
        ]
        points = measured_points(points, wanted, metrics)
    return points


def test_the_search_closes_in_on_two_classes_within_the_tolerance(tmp_path: Path) -> None:
    plan = planned(tmp_path)

    def found(S_R: float, gamma: float, amplitude: float) -> str:
        return "collapse" if amplitude > 10 * S_R + 1.1 else "damaged" if amplitude > 10 * S_R else "stable"

    points = searched_points(plan, "trigger", found)
    assert list(points["case"].unique()) == list(TRIGGER["cases"])
    for (_, S_R), own in points.groupby(["case", "S_R"]):
        assert len(own) < 17, "fewer than all points of the lattice"
        for name, limit in (("collapse", 10 * float(S_R) + 1.1), ("damaged", 10 * float(S_R))):
            at = bracket(own, name)
            assert at.outcome == BRACKETED and at.lower <= limit < at.upper and at.upper - at.lower <= 0.5
    write_csv(points, tmp_path / "points.csv")
    pd.testing.assert_frame_equal(read_points(tmp_path / "points.csv"), points, check_dtype=False)
    finer = planned(tmp_path, {"tolerance": 0.25})
    more = wanted_points(finer.lattices("trigger"), points, finer.classes("trigger"), 4)
    assert 0 < len(more) <= 8, "a finer tolerance asks for the new halves only"


def test_a_diverged_run_is_closed_in_on_from_both_sides(tmp_path: Path) -> None:
    plan = planned(tmp_path)
    points = searched_points(plan, "trigger", lambda S_R, gamma, a: "undetermined" if 3.2 < a < 4.3 else "collapse" if a > 4 else "stable")
    at = bracket(points[(points["case"] == "as it is") & (points["S_R"] == "0.10")], "collapse")
    assert (at.outcome, at.lower, at.upper, at.diverged_inside) == (BRACKETED, 3.0, 4.5, 2) and at.diverged == at.diverged_inside


# ---------------------------------------------------------------- brackets


@pytest.mark.parametrize(
    ("classes", "outcome", "lower", "upper", "changes", "inside"),
    [
        (("stable", "minor", "damaged", "collapse"), BRACKETED, 2.0, 3.0, 1, 0),
        (("collapse", "collapse"), AT_LOWEST, math.nan, 0.0, 0, 0),
        (("stable", "damaged"), NEVER, 1.0, math.nan, 0, 0),
        (("stable", "undetermined", "undetermined", "collapse"), BRACKETED, 0.0, 3.0, 1, 2),
        (("stable", "collapse", "damaged", "collapse"), BRACKETED, 0.0, 1.0, 3, 0),
        (("undetermined", "collapse"), AT_LOWEST, math.nan, 1.0, 0, 0),
        (("undetermined",), UNDECIDED, math.nan, math.nan, 0, 0),
    ],
)
def test_brackets(classes: tuple[str, ...], outcome: str, lower: float, upper: float, changes: int, inside: int) -> None:
    found = bracket(line(*classes), "collapse")
    assert (found.outcome, found.changes, found.diverged_inside) == (outcome, changes, inside)
    assert (found.lower, found.upper) == pytest.approx((lower, upper), nan_ok=True)
    assert found.critical_intensity == pytest.approx(0.5 * (lower + upper), nan_ok=True)
    assert found.resolution_error == pytest.approx(0.5 * (upper - lower), nan_ok=True)
    assert found.runs == len(classes) and found.diverged == classes.count("undetermined")


@pytest.mark.parametrize(
    ("runouts", "outcome", "upper", "braked"),
    [
        ((0.0, 4.0, 12.0, 20.0), BRAKED, 2.0, 2),
        ((0.0, 4.0), BRAKED, math.nan, 2),
        ((12.0, 4.0, 20.0), AT_LOWEST, 0.0, 1),
    ],
)
def test_a_bracket_does_not_end_at_braked_debris(runouts: tuple[float, ...], outcome: str, upper: float, braked: int) -> None:
    """With enough rows of particles it may reach the place at less shaking."""
    points = line(*["damaged"] * len(runouts)).assign(runout=runouts, findings="weak-on-strong")
    found = bracket(points, "runout: 10")
    assert (found.outcome, found.braked, found.diverged, found.diverged_inside) == (outcome, braked, 0, 0)
    assert math.isnan(found.lower) and found.upper == pytest.approx(upper, nan_ok=True)
    free = bracket(points.assign(findings="cover-rows"), "runout: 10")
    assert free.braked == 0 and free.outcome != BRAKED
    assert bracket(points, "damaged").braked == 0, "classes are as they were"


def test_a_class_that_is_left_again_and_a_run_that_still_moves_are_told() -> None:
    assert bracket(line("stable", "collapse", "minor", "collapse"), "collapse").changes == 3
    assert bracket(line("stable", "collapse", moving=1), "collapse").lower_still_moving == 1.0


def test_cases_that_differ_in_the_spacing_alone_are_extrapolated_from() -> None:
    slope = read_yaml(str(ROOT / "config" / "scenes" / "slope_on_rock.yaml"))
    cases = {"2.5 m": 2.5, "5/3 m": 5.0 / 3.0, "1.25 m": 1.25, "1 m": 1.0}
    scenes = {name: make_scene(merge(slope, {"numerics": {"spacing": spacing}})) for name, spacing in cases.items()}
    scenes["2 m, damped"] = make_scene(merge(slope, {"numerics": {"spacing": 2.0}, "damping": {"ratio": 0.05}}))
    found = coarser_cases(scenes)
    assert {case: name for case, (name, _) in found.items()} == {"5/3 m": "2.5 m", "1.25 m": "2.5 m", "1 m": "5/3 m"}
    assert [ratio for _, ratio in found.values()] == pytest.approx([1.5, 2.0, 5.0 / 3.0])
    at_once = {
        name: make_scene(merge(slope, dotted({"numerics.spacing": cases[name], "coupling.softening": None, "coupling.gamma": 1.0})))
        for name in cases
    }
    assert coarser_cases(at_once) == {}, "no level to extrapolate to"


@pytest.mark.parametrize(
    ("coarse", "fine", "value", "error"),
    [
        (("stable",) * 5 + ("collapse",), ("stable",) * 4 + ("collapse",), 2.5, 0.5 + 0.5 * (2.0 + 1.0)),  # 4.5 and 3.5: a step of -1
        (("stable",) * 4 + ("collapse",), ("stable",) * 5 + ("collapse",), 4.5, 1.0 + 0.5 * (2.0 + 1.0)),  # up: not taken, as by sph fos
        (("stable", "collapse"), ("stable", "stable"), math.nan, math.nan),
    ],
)
def test_a_level_is_extrapolated_to_no_spacing(coarse: tuple[str, ...], fine: tuple[str, ...], value: float, error: float) -> None:
    points = pd.concat([line(*coarse, case="coarse"), line(*fine, case="fine")], ignore_index=True)
    statics = {(case, "0.10", "100"): {"collapse": {"yield_acceleration": 2.0, "newmark_intensity": 3.0}} for case in ("coarse", "fine")}
    table = critical_table(points, ["collapse"], statics, SEARCHED, {"fine": ("coarse", 2.0)}).set_index("case")
    assert table["extrapolated_intensity"].tolist() == pytest.approx([math.nan, value], nan_ok=True)
    assert table["extrapolation_error"].tolist() == pytest.approx([math.nan, error], nan_ok=True)


ESTIMATES = defaultdict(lambda: {"collapse": {"yield_acceleration": 3.0, "newmark_intensity": 9.0}})


def papers(*lines: pd.DataFrame) -> pd.DataFrame:
    return critical_table(pd.concat(lines, ignore_index=True), ["collapse"], ESTIMATES, SEARCHED)


CLEAR = [line("stable", "damaged", "collapse", S_R=S_R) for S_R in ("0.10", "0.25", "0.50")]


@pytest.mark.parametrize(
    ("last", "verdict", "measured"),
    [
        (CLEAR[2], "holds", "S_R 0.50: 1.5 ± 0.5 m/s²"),
        (line("stable", "stable", S_R="0.50"), "fails", "not reached at the highest amplitude, 1 m/s²"),
        (line("collapse", "collapse", S_R="0.50"), "fails", "reached at the lowest amplitude, 0 m/s²"),
        (line("stable", "undetermined", "collapse", S_R="0.50"), "fails", "1 diverged inside"),
        (line("stable", "collapse", "stable", S_R="0.50"), "fails", "2 changes of class"),
        (line("stable", "collapse", S_R="0.40"), "not covered", "S_R 0.50: not searched"),
    ],
)
def test_claim_11_is_decided_by_the_brackets(last: pd.DataFrame, verdict: str, measured: str) -> None:
    claim = decide_trigger(papers(*CLEAR[:2], last)).iloc[0]
    assert claim["claim"] == 11 and claim["verdict"] == verdict and measured in claim["measured"]


def test_ends_are_confirmed_at_another_fidelity(tmp_path: Path) -> None:
    points = pd.concat([CLEAR[0], line("stable", "stable", S_R="0.25"), CLEAR[2]], ignore_index=True)
    table = critical_table(points, ["collapse"], ESTIMATES, SEARCHED)
    ends = bracket_ends(table, points, "collapse", ["as it is"], {"S_R": ["0.1", "0.25"], "gamma": ["100"]}, SEARCHED)
    assert list(zip(ends["S_R"], ends["end"], ends["amplitude"], strict=True)) == [
        ("0.10", "lower", "1"),
        ("0.10", "upper", "2"),
        ("0.25", "lower", "1"),
    ]
    other = {"status": "complete", "displacement_magnitude": 1.5, "runout": 0.5}
    found = confirm_table(ends, points, [other | {"collapse_class": name} for name in ("collapse", "collapse", "undetermined")], SEARCHED)
    assert found["verdict"].tolist() == ["fails", "holds", "undetermined"]
    assert found["displacement_magnitude_difference"].tolist() == [0.5] * 3 and found["runout_difference"].tolist() == [-0.5] * 3
    write_csv(found, tmp_path / "confirm.csv")
    pd.testing.assert_frame_equal(read_csv(tmp_path / "confirm.csv", confirm_columns(SEARCHED), "confirmed brackets"), found)


def test_the_block_slips_by_the_displacement_at_the_amplitude_found() -> None:
    scene = make_scene(
        {
            "scheme": "paper",
            "name": "slope",
            "geometry": {"shape": "slope"},
            "motion": {"kind": "tapered_sine"},
            "numerics": {"time_step": 1e-2},
        }
    )
    assert class_displacement("collapse", scene, MetricSettings()) == pytest.approx(2.5)
    factor = newmark_factor(scene, 3.0, 2.5)
    motion = motion_of(scene).scaled(6.0 * factor)
    assert 6.0 * factor > 3.0 and sliding_block(motion.time, motion.acceleration, 3.0).permanent == pytest.approx(2.5, rel=1e-3)
    assert newmark_factor(scene, 0.0, 2.5) == 0.0 and math.isnan(newmark_factor(scene, math.nan, 2.5))
    with pytest.raises(ValueError, match="not shaken"):
        newmark_factor(make_scene({"scheme": "paper", "name": "slope", "geometry": {"shape": "slope"}}), 3.0, 2.5)


@pytest.mark.long
def test_each_motion_and_each_slope_has_a_block_of_its_own(tmp_path: Path) -> None:
    study = load_study(read_yaml(ROOT / "config" / "studies" / "gentle_motions.yaml"), [ROOT])
    plan = load_trigger("config/studies/gentle_motions/trigger.yaml", study, [ROOT])
    assert len({search.file for search in plan.searches.values()}) == 1 and len(plan.searches) == 12, "twelve motions shake one slope"
    scenes = {at: scene.build() for at, scene in list(plan.shaken.items())[:2]}
    found = block_estimates(
        scenes, dict.fromkeys(plan.searches, 2.0), ["collapse"], MetricSettings(), plan.dimensions, plan.trigger.intensity.highest
    )
    for at, scene in scenes.items():
        block = found[at]["collapse"]
        motion = motion_of(scene).scaled(block["newmark_intensity"])
        slip = sliding_block(motion.time, motion.acceleration, block["yield_acceleration"]).permanent
        assert slip == pytest.approx(class_displacement("collapse", scene, MetricSettings()), rel=1e-2)
    assert len({block["collapse"]["newmark_intensity"] for block in found.values()}) == 2, "motions of different seeds"
    many = {**OWN, "at": {"layers.clay.soil.cohesion": list(map(str, range(5, 16)))}}
    assert own_search(tmp_path, {}, many).searches == {}, "eleven slopes"
    ten = own_search(tmp_path, {}, merge(many, {"at": {"layers.clay.soil.cohesion": many["at"]["layers.clay.soil.cohesion"][:10]}}))
    assert len({search.file for search in ten.searches.values()}) == 10


@pytest.mark.parametrize(("amplitude", "slip"), [(2.9, 0.0), (3.1, math.inf), (-3.1, 0.0)])
def test_a_load_that_stays_moves_the_block_without_end_or_not_at_all(amplitude: float, slip: float) -> None:
    load = {"kind": "constant", "amplitude": amplitude, "start": 3.0, "ramp": 1.0}
    scene = make_scene({"scheme": "paper", "name": "slope", "geometry": {"shape": "slope"}, "motion": load})
    assert baseline_metrics(scene, 3.0) == {"yield_acceleration": 3.0, "newmark_displacement": slip}
    assert newmark_factor(scene, 3.0, 2.5) == pytest.approx(3.0 / amplitude)


def test_a_motion_that_never_drives_the_block_downslope_has_no_amplitude() -> None:
    scene = make_scene(
        {"scheme": "paper", "name": "slope", "geometry": {"shape": "slope"}, "motion": {"kind": "tapered_sine"}, "duration": 3.0}
    )
    assert newmark_factor(scene, 3.0, 2.5) == math.inf, "the run ends before the motion"


# ---------------------------------------------------------------- maps


def test_shares_bound_the_truth_and_close_in(tmp_path: Path) -> None:
    def found(S_R: float, gamma: float, amplitude: float) -> str:
        return "collapse" if amplitude > 12 * S_R + 1.5 - 0.5 * math.log10(gamma) else "stable"

    gaps = []
    for levels in (0, 1, 2, 3):
        plan = planned(tmp_path, {"maps": {"levels": levels}})
        points = searched_points(plan, "maps", found)
        cells = map_cells(plan.lattices("maps"), points, ["collapse"], levels, SEARCHED)
        assert cells.groupby("amplitude_lower")["share"].sum().max() <= 1.0 and (cells["points"] >= 8).all()
        shares = class_shares(cells, SEARCHED)
        own = shares[shares["collapse_class"] == "collapse"]
        for row in own.to_dict("records"):
            grid = [(0.1 + 0.4 * (i + 0.5) / 40, 10 ** (2 * (j + 0.5) / 40)) for i in range(40) for j in range(40)]
            middle = 0.5 * (row["amplitude_lower"] + row["amplitude_upper"])
            truth = sum(found(S_R, gamma, middle) == "collapse" for S_R, gamma in grid) / len(grid)
            assert row["share_lower"] - 1e-9 <= truth <= row["share_upper"] + 1e-9
        widths = own["amplitude_upper"] - own["amplitude_lower"]
        gaps.append(float(((own["share_upper"] - own["share_lower"]) * widths).sum()))
    assert gaps == sorted(gaps, reverse=True) and gaps[-1] < 0.25 * gaps[0]
    write_csv(cells, tmp_path / "cells.csv")
    write_csv(shares, tmp_path / "shares.csv")
    pd.testing.assert_frame_equal(read_csv(tmp_path / "cells.csv", cell_columns(SEARCHED), "cells"), cells, check_dtype=False)
    pd.testing.assert_frame_equal(read_shares(tmp_path / "shares.csv"), shares)


def test_a_diverged_point_leaves_its_cells_open(tmp_path: Path) -> None:
    plan = planned(tmp_path, {"maps": {"levels": 0}})
    points = searched_points(plan, "maps", lambda S_R, gamma, a: "undetermined" if (S_R, gamma, a) == (0.1, 1.0, 0.0) else "stable")
    shares = class_shares(map_cells(plan.lattices("maps"), points, ["collapse"], 0, SEARCHED), SEARCHED)
    assert shares.groupby("amplitude_lower")["share_upper"].max().tolist() == [1.0, 0.0] and (shares["share_lower"] == 0).all()


def test_figures(tmp_path: Path) -> None:
    plan = planned(tmp_path)
    points = searched_points(
        plan, "maps", lambda S_R, gamma, a: "undetermined" if a == 8 and S_R == 0.5 else "collapse" if a > 10 * S_R else "minor"
    )
    for figure in (figure_class_map(points, SEARCHED), figure_map(points, SEARCHED, MAPPED["runout"])):
        assert len([ax for ax in figure.axes if ax.images]) == 2
        assert "diverged" in {text.get_text() for text in figure.legends[0].get_texts()}
    moving = figure_map(points.assign(still_moving=(points["amplitude"] == "4.0").astype(int)), SEARCHED, MAPPED["runout"])
    assert "still moving: at least so far" in {text.get_text() for text in moving.legends[0].get_texts()}
    shares = class_shares(map_cells(plan.lattices("maps"), points, ["collapse"], 2, SEARCHED), SEARCHED)
    figure = figure_shares(shares, SEARCHED)
    assert len(figure.axes) == 3 and not overprints(figure)
    table = papers(*CLEAR, line("collapse", S_R="0.05"), line("stable", S_R="0.9"), line("stable", "collapse", case="slip: sides"))
    write_csv(table, tmp_path / "table.csv")
    pd.testing.assert_frame_equal(read_critical(tmp_path / "table.csv"), table)
    assert list(table.columns) == names(critical_columns(SEARCHED))
    figure = figure_critical(table, SEARCHED)
    axes = figure.axes
    assert len(axes) == 2 and {line.get_marker() for line in axes[0].lines} >= {"v", "^"}
    assert not overprints(figure)
    words = {text.get_text() for text in figure.legends[0].get_texts()}
    assert {"at or below the lowest tried", "above the highest tried"} <= words
    for draw, empty in ((figure_critical, table), (figure_class_map, points), (figure_shares, shares)):
        with pytest.raises(ValueError, match="no "):
            draw(empty.iloc[:0], SEARCHED)


def test_titles_of_maps_side_by_side_do_not_overprint() -> None:
    slip = "coupling.softening.slip_at_residual"
    labels = {"S_R": "strength ratio", slip: "slip at the residual strength", "amplitude": "amplitude"}
    searched = Searched(tuple(Dimension(name, "m", label, False) for name, label in labels.items()), "amplitude")
    points = pd.concat([line("stable", "collapse", S_R=S_R, gamma=at) for S_R in ("0.1", "0.5") for at in ("0.01", "0.05", "0.25")])
    assert not overprints(figure_class_map(points.rename(columns={"gamma": slip}), searched))


def test_a_wide_axis_of_shares_is_not_cut_and_seeds_are_not_joined() -> None:
    labels = {"S_R": "strength ratio", "gamma": "slip at the residual strength of the upper clay", "amplitude": "amplitude"}
    searched = Searched(tuple(Dimension(name, "m", label, False) for name, label in labels.items()), "amplitude")
    shares = pd.DataFrame(
        [("as it is", name, 0.0, 1.0, 0.2, 0.8) for name in CLASSES[1:]], columns=[each.name for each in share_columns(searched)]
    )
    figure = figure_shares(shares, searched)
    figure.draw_without_rendering()
    label = figure.axes[0].yaxis.label.get_window_extent()
    assert figure.bbox.y0 <= label.y0 and label.y1 <= figure.bbox.y1
    seed = "motion.stochastic.seed"
    seeds = Searched((Dimension("amplitude", "m/s2", "amplitude", False), Dimension(seed, "-", "seed", False)), "amplitude")
    points = pd.concat([line("stable", "collapse", gamma=each) for each in "123"]).rename(columns={"gamma": seed})
    unknown = {"collapse": {"yield_acceleration": math.nan, "newmark_intensity": math.nan}}
    table = critical_table(points, ["collapse"], {("as it is", each): unknown for each in "123"}, seeds)
    assert {each.get_linestyle() for each in figure_critical(table, seeds).axes[0].lines} == {"None"}
