"""The study's configuration: what is accepted, and what a refusal says."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
import yaml

from sph.analysis.study import Plan, load_study
from sph.configuration import merge

ROOT = Path(__file__).resolve().parents[2]
GOOD: dict[str, Any] = yaml.safe_load((ROOT / "config" / "config.yaml").read_text(encoding="utf-8"))


def plan(overrides: dict[str, Any]) -> Plan:
    return load_study(merge(GOOD, overrides), [ROOT])


def test_the_shipped_study_covers_the_papers_cases() -> None:
    points = plan({}).study.points
    assert {"0.10", "0.25", "0.35", "0.50"} <= set(points["S_R"])
    assert {float(g) for g in points["gamma"]} == {1.0, 100.0}
    assert len({float(a) for a in points["amplitude"]} - {6.0}) >= 2 and "6.0" in set(points["amplitude"])
    assert {"draft", "standard", "paper"} <= set(plan({}).study.fidelities)


def test_labels_stay_as_written_and_become_numbers_in_the_scene() -> None:
    chosen = plan({"grid": {"S_R": ["0.10", 0.25, "0.350", 0.5]}, "figures": {"strengths": [0.1]}})
    assert chosen.study.grid is not None and chosen.study.grid["S_R"] == ("0.10", "0.25", "0.350", "0.5")
    assert chosen.built(S_R="0.10", gamma="1", amplitude="4.0").coupling.S_R == 0.1
    assert [point["S_R"] for _, point in chosen.study.figure_runs(4)] == ["0.10"]


def test_stages_do_not_depend_on_what_they_are_shared_by() -> None:
    one, other = plan({"grid": {"S_R": ["0.10", "0.25", "0.35", "0.50"]}}), plan({"grid": {"S_R": ["0.10", "0.25", "0.35", "0.50", "0.7"]}})
    assert one.scene() == other.scene()
    assert one.scene(amplitude="4.0") == other.scene(amplitude="4.0") != one.scene(amplitude="6.0")


def test_a_fidelity_lays_its_keys_over_the_scene() -> None:
    assert plan({"fidelity": "draft"}).built().numerics.smoothing_ratio == 1.3
    assert plan({}).built().numerics.smoothing_ratio == 2.3


def test_figure_7_shows_the_strength_of_the_text_and_of_the_caption() -> None:
    runs = list(plan({}).study.figure_runs(7))
    assert [(point["S_R"], point["gamma"]) for _, point in runs] == [("0.25", "100"), ("0.25", "1"), ("0.35", "100"), ("0.35", "1")]


@pytest.mark.parametrize(
    ("overrides", "wanted"),
    [
        (
            {"fidelities": {"draft": {"coupling": {"initial_state": "fluid"}}}, "fidelity": "draft"},
            ("coupling.initial_state", "fluid", "solid"),
        ),
        ({"fidelity": "best"}, ("fidelity", "best", "draft, standard, paper, fine")),
        ({"grid": {"S_R": []}}, ("grid.S_R", "at least 1")),
        ({"grid": {"S_R": ["0.1", "0.10"]}}, ("grid", "S_R", "one value twice")),
        ({"grid": {"gamma": ["fast"]}}, ("gamma = fast", "coupling.gamma", "valid number")),
        ({"grid": {"gamma": ["-1"]}}, ("gamma = -1", "coupling.gamma", "greater than or equal to 0")),
        ({"grid": {"depth": ["1"]}}, ("grid.depth", "no such key in a scene")),
        ({"grid": {"S_R": ["0.10", "0.25", "0.35", "0.50", "1.5"]}}, ("S_R = 1.5", "coupling.S_R", "less than or equal to 1")),
        ({"grid": {"S_R": ["0.10"]}}, ("grid.S_R", "0.25", "figures")),
        ({"claims": {"amplitude": 5.0}}, ("grid.amplitude", "5.0")),
        ({"fidelities": {"fine": {"numerics": {"spacng": 0.5}}}}, ("fidelity fine", "numerics.spacng", "no such key")),
        ({"metrics": {"link_length": 0}}, ("metrics.link_length", "0")),
        ({"study": "../elsewhere"}, ("study", "../elsewhere")),
        ({"fidelities": {"../x": {}}}, ("fidelities", "../x")),
        ({"scene": "config/scenes/absent.yaml"}, ("scene", "absent.yaml")),
        ({"extra": 1}, ("extra", "no such key")),
    ],
)
def test_refusals_name_key_and_value(overrides: dict[str, Any], wanted: tuple[str, ...]) -> None:
    with pytest.raises(ValueError) as error:
        plan(overrides)
    for text in wanted:
        assert text in str(error.value)


def test_a_fidelity_is_checked_over_the_scene_and_not_over_the_chosen_fidelity() -> None:
    """An interval of 0.1 ms suits the scene's own time step and not that of the draft."""
    dense = {"fidelities": {"dense": {"outputs": {"series_interval": 1e-4}}}}
    assert plan(dense | {"fidelity": "draft"}).built().outputs.series_interval == 0.01
    assert plan(dense | {"fidelity": "dense"}).built().outputs.series_interval == 1e-4
