"""The cost-accuracy study: what is accepted, what is run, the table, and what it answers."""

from __future__ import annotations

import functools
import math
import shlex
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest
import yaml
from calling import call
from matplotlib.figure import Figure
from small_scenes import study_plan
from synthetic import PAPER, synthetic, translation
from synthetic_cost_accuracy import CONFIG, FIDELITIES, SCENE, made_frame, made_runs, runs_of

from sph.command.advise import options
from sph.command.options import parse_settings
from sph.experiments.variants import advice
from sph.experiments.variants.advice import advise, expected_error, expected_sentence, resolutions, shipped_table
from sph.experiments.variants.convergence import convergence_table
from sph.experiments.variants.design import Row, is_mean, load_variants, scheme
from sph.experiments.variants.figures import figure_convergence, figure_tradeoff
from sph.experiments.variants.schema import CostAccuracy
from sph.experiments.variants.table import COLUMNS, against, cost_accuracy_table, measured_run, non_dominated, read_cost_accuracy, summary
from sph.experiments.variants.table import COST_ACCURACY as VARIABLES
from sph.measures.metrics import MetricSettings
from sph.scene.configuration import dotted, merge, read_scene
from sph.scene.schema import Scene, load_scene, make_scene
from sph.study.machine import machine_class
from sph.study.tables import flat_dataset, write_csv
from tools.reference import TABLES, markdown

ROOT = Path(__file__).resolve().parents[2]
load = functools.partial(load_variants, "cost-accuracy", CostAccuracy)


@pytest.fixture
def shipped(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The hand-made study in the place of the one measured for the release."""
    path = tmp_path / "measured" / "cost-accuracy.csv"
    write_csv(made_frame(), path)
    monkeypatch.setattr(advice, "SHIPPED", path)
    return path


@pytest.fixture
def absent(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A release without a measured table."""
    monkeypatch.setattr(advice, "SHIPPED", tmp_path / "absent.csv")


def scene(**settings: Any) -> Scene:
    return make_scene(merge(SCENE, dotted({name.replace("__", "."): value for name, value in settings.items()})))


def row_of(frame: pd.DataFrame, parameter: str, variant: str, case: str = "weak") -> Mapping[str, Any]:
    found = frame[(frame["parameter"] == parameter) & (frame["variant"] == variant) & (frame["case"] == case)]
    assert len(found) == 1
    return found.iloc[0].to_dict()


SLOPE_ON_ROCK = ROOT / "config" / "scenes" / "slope_on_rock.yaml"
HALF = {"geometry": {"slope_height": 12.5}, "coupling": {"softening": {"slip_at_residual": 0.025}}}
"""Half as high, with half the slip, so that the slip zone is as many heights long."""


def on_rock(changes: dict[str, Any]) -> Scene:
    return load_scene(SLOPE_ON_ROCK, changes)


class TestResolution:
    """The study of the scheme for one's own slopes."""

    def test_it_is_valid_and_its_slope_has_the_height_that_errors_are_looked_up_by(self) -> None:
        shipped = load("config/resolution.yaml", study_plan({"paper": {}}), [ROOT])
        assert {row.variant for row in shipped.rows if row.parameter == "fidelity"} == {"draft", "standard", "fine"}
        assert {row.case for row in shipped.rows if row.reference} == set(shipped.variants.cases)
        geometry = load_scene(SLOPE_ON_ROCK).geometry
        assert geometry.slope_height == advice.HEIGHT  # type: ignore[union-attr]

    @pytest.mark.parametrize(
        ("spacing", "variant"),
        [(0.5, "fidelity: standard"), (0.4, "fidelity: standard"), (0.3125, "fidelity: fine"), (0.8334, "spacing: 5/3 m"), (1.26, None)],
    )
    def test_a_slope_of_ones_own_is_looked_up_by_its_rows_of_particles(self, spacing: float, variant: str | None) -> None:
        # 12.5 m high: 0.5 m is as 1 m on the slope of the study, 25 m high.  Coarser than 2.5 m there nothing was measured.
        settings = {
            "geometry": {"slope_height": 12.5},
            "numerics": {"spacing": spacing},
            "coupling": {"softening": {"width": 5.0, "slip_at_residual": 0.025}},
        }
        settings["damping"] = {"ratio": 0.03}
        found = expected_error(on_rock(settings))
        assert (found and found.variant) == variant
        settings["layers"] = {"clay": {"region": {"kind": "elevation", "bottom": 15.0}, "soil": {"cohesion": 50.0}}}
        layered = on_rock(settings)
        assert expected_error(layered) is None and "it has layers" in expected_sentence(layered)
        del settings["layers"]
        for base in ("absorbing", "no_slip"):
            settings["walls"] = {"base": base, "sides": "absorbing"}
            assert expected_error(on_rock(settings)) == found, "the moving soil's"

    def test_a_slope_that_is_too_coarse_is_told_from_which_spacing_on_there_is_an_expectation(self) -> None:
        settings = {
            "geometry": {"slope_height": 12.5},
            "numerics": {"spacing": 1.26},
            "coupling": {"softening": {"slip_at_residual": 0.025}},
        }
        assert expected_sentence(on_rock(settings)).endswith("the coarsest spacing measured is 1.25 m on a slope of this height")

    def test_another_scheme_or_failure_at_once_has_no_expectation(self) -> None:
        for other in (
            {"walls": {"base": "fixed"}},
            {"coupling": {"softening": None, "gamma": 1.0}},
            {"numerics": {"smoothing_ratio": 1.2}},
        ):
            settings = merge(merge(HALF, {"numerics": {"spacing": 0.5}}), other)
            assert expected_error(on_rock(settings)) is None


class TestAdviceForAScene:
    def test_the_spacings_are_those_of_its_slope(self) -> None:
        own, taller = (on_rock(changes) for changes in ({}, {"geometry": {"slope_height": 30.0}, "numerics": {"spacing": 1.2}}))
        found, scaled = resolutions(own), resolutions(taller)
        assert [each.rows for each in found] == sorted({each.rows for each in found}) and found[0].rows == 10.0
        assert [each.spacing for each in scaled] == pytest.approx([1.2 * each.spacing for each in found])
        assert [each.errors for each in scaled] == [each.errors for each in found]
        table = shipped_table("resolved")
        assert table is not None
        at_one = next(each for each in found if each.spacing == 1.0)
        assert at_one.errors["displacement"] == max(
            variant.errors["displacement"] for variant in summary(table) if variant.name in ("spacing: 1 m", "fidelity: standard")
        )

    def test_the_command_names_the_coarsest_within_an_error(self) -> None:
        result = call("advise", SLOPE_ON_ROCK, "--error", "8%")
        assert result.exit_code == 0 and result.stdout.splitlines()[-1].endswith("--set numerics.spacing=0.625")
        runout = call("advise", SLOPE_ON_ROCK, "--error", "11.5%", "--quantity", "runout")
        assert runout.stdout.splitlines()[-1].endswith("--set numerics.spacing=1.25")
        nothing = call("advise", SLOPE_ON_ROCK, "--error", "0.1%")
        assert nothing.exit_code == 2 and "no measured spacing has" in nothing.stdout

    def test_no_error_is_known_of_the_other_law_of_interfaces(self, tmp_path: Path) -> None:
        scene = tmp_path / "scene.yaml"
        scene.write_text(yaml.safe_dump(merge(read_scene(SLOPE_ON_ROCK), {"numerics": {"interfaces": "both"}})), encoding="utf-8")
        why = "errors are measured with numerics.interfaces: weaker, and not with both; run it at a second spacing"
        result = call("advise", scene, "--error", "10%")
        assert result.exit_code == 2 and why in result.stderr
        assert f"not known, since {why}" in expected_sentence(load_scene(scene))

    def test_a_slope_unlike_the_measured_one_is_told_so(self) -> None:
        result = call("advise", ROOT / "config" / "scenes" / "gentle_layered.yaml", "--error", "10%")
        assert result.exit_code == 2 and "it has layers" in result.stderr and "second_fidelity" in result.stderr

    def test_another_reference_is_refused(self) -> None:
        result = call("advise", SLOPE_ON_ROCK, "--error", "10%", "--of", "paper")
        assert result.exit_code == 2 and "--of paper: has no effect with a scene" in result.stderr


class TestConfiguration:
    def test_the_shipped_study_is_valid_and_covers_the_fidelities(self) -> None:
        config = yaml.safe_load((ROOT / "config" / "config.yaml").read_text(encoding="utf-8"))
        shipped = load("config/cost-accuracy.yaml", study_plan(config["fidelities"]), [ROOT])
        assert {row.variant for row in shipped.rows if row.parameter == "fidelity"} == {"draft", "standard", "paper", "fine"}
        assert {row.case for row in shipped.rows if row.reference} == set(shipped.variants.cases)
        assert all(row.runs and set(row.runs) <= set(shipped.runs) for row in shipped.rows)
        contents = [
            make_scene(made.scene).model_dump_json(exclude={"name", "title"}) for name, made in shipped.runs.items() if name.endswith("_1")
        ]
        assert len(set(contents)) == len(contents), "equal scenes are run once"

    def test_the_settings_of_every_shipped_variant_survive_the_command_line(self) -> None:
        for row in load("config/cost-accuracy.yaml", study_plan(), [ROOT]).rows:
            assert parse_settings([word for word in shlex.split(options(row.settings)) if word != "--set"]) == row.settings

    def test_equal_scenes_share_their_runs_and_take_the_most_repeats(self) -> None:
        rows = {(row.parameter, row.variant, row.case): row.runs for row in made_runs().rows}
        assert rows["skin", "0.3", "weak"] == rows["spacing", "3 m", "weak"] == tuple(f"spacing/3-m/weak_{n}" for n in (1, 2, 3))
        assert rows["fidelity", "draft", "weak"] == rows["spacing", "5 m", "weak"]
        assert rows["skin", "0.6", "weak"] == ("skin/0.6/weak_1",)
        assert rows["spacing", "3 m", "strong"] == ("spacing/3-m/strong_1",), "only the timed case is repeated"
        assert rows["spacing", "1.5 m", "weak"] == ("spacing/1.5-m/weak_1",) and ("spacing", "1.5 m", "strong") not in rows

    def test_a_variant_lies_over_its_parameter_and_a_case_over_both(self) -> None:
        made = made_runs({"overrides": {"duration": 12.0}}).runs["skin/0.6/strong_1"].scene
        assert made["numerics"] == {"spacing": 3.0, "time_step": 1e-3, "smoothing_ratio": 1.3, "neighbour_skin": 0.6}
        assert made["coupling"] == {"S_R": 0.5} and made["duration"] == 12.0

    @pytest.mark.parametrize(
        ("overrides", "wanted"),
        [
            (
                {"parameters": {"spacing": {"variants": {"x": {"numerics": {"spacng": 1}}}}}},
                ("parameter 'spacing', variant 'x', case 'weak'", "numerics.spacng", "no such"),
            ),
            (
                {"parameters": {"spacing": {"variants": {"x": {"numerics": {"time_step": 0.01}}}}}},
                ("variant 'x'", "numerics.time_step", "limit"),
            ),
            ({"parameters": {"spacing": {"variants": {"x": {"numerics": {"spacing": 60.0}}}}}}, ("variant 'x'", "numerics.spacing", "60")),
            ({"parameters": {"spacing": {"variants": {"2 m": {}, "2/m": {}}}}}, ("same file name", "'2 m'", "'2/m'")),
            ({"parameters": {"spacing": {"exceptions": {"7 m": {}}}}}, ("parameters.spacing", "'7 m'", "5 m, 3 m")),
            ({"parameters": {"skin": {"cases": ["medium"]}}}, ("parameters.skin", "'medium'", "weak, strong")),
            ({"parameters": {"skin": {"cases": ["strong"]}}}, ("parameters.skin", "timed case 'weak'")),
            ({"parameters": {"fidelity": CONFIG["parameters"]["skin"]}}, ("'fidelity'", "another name")),
            ({"parameters": {"skin": {"repeats": 0}}}, ("parameters.skin.repeats", "0")),
            ({"reference": {"variant": "9 m"}}, ("reference", "'9 m'")),
            ({"reference": {"variant": "1.5 m"}}, ("reference", "'1.5 m'", "missing: strong")),
            ({"baseline": "best"}, ("baseline", "'best'", "draft, paper")),
            ({"timed_case": "medium"}, ("timed_case", "'medium'", "weak, strong")),
            ({"convergence": "depth"}, ("convergence", "'depth'", "spacing, skin")),
            ({"cases": {"weak": {"coupling": {"S_R": 2}}}}, ("case 'weak'", "coupling.S_R", "2")),
            ({"extra": 1}, ("study.yaml: extra", "no such key")),
        ],
    )
    def test_refusals_name_file_key_and_value(self, overrides: dict[str, Any], wanted: tuple[str, ...]) -> None:
        with pytest.raises(ValueError) as error:
            made_runs(overrides)
        for text in ("study.yaml", *wanted):
            assert text in str(error.value)

    def test_files_are_searched_for_and_named_when_absent(self, tmp_path: Path) -> None:
        (tmp_path / "study.yaml").write_text(yaml.safe_dump(CONFIG, sort_keys=False))
        with pytest.raises(ValueError, match=r"study.yaml: scene: no file 'slope.yaml'"):
            load("study.yaml", study_plan(FIDELITIES), [tmp_path])
        (tmp_path / "slope.yaml").write_text(yaml.safe_dump(SCENE, sort_keys=False))
        assert load("study.yaml", study_plan(FIDELITIES), [tmp_path / "elsewhere", tmp_path]).rows == made_runs().rows
        with pytest.raises(ValueError, match="no file 'absent.yaml'"):
            load("absent.yaml", study_plan(FIDELITIES), [tmp_path])


class TestScheme:
    def test_it_leaves_out_what_is_simulated(self) -> None:
        other = {"coupling__S_R": 0.3, "soil__cohesion": 10.0, "motion__amplitude": 1.0, "duration": 12.0, "outputs__frame_interval": 0.5}
        assert scheme(scene(**other)) == scheme(scene()) == {"numerics": {"spacing": 5.0, "time_step": 1e-3}}

    @pytest.mark.parametrize(
        "change",
        [
            {"numerics__smoothing_ratio": 1.3},
            {"numerics__artificial_viscosity": None},
            {"walls__layers": 4},
            {"damping": None},
            {"coupling__fluid_tension_limit": None},
            {"coupling__fluid": {"law": "capped_viscosity", "max_viscosity": 1e5}},
            {"gravity__ramp": 0.5},
        ],
    )
    def test_it_holds_how_it_is_simulated(self, change: dict[str, Any]) -> None:
        assert scheme(scene(**change)) != scheme(scene())

    def test_a_default_written_out_is_the_default(self) -> None:
        assert scheme(scene(numerics__kernel="cubic_spline", walls__layers=2, damping={"ratio": 0.02})) == scheme(scene())


class TestTable:
    def test_deviations_are_relative_to_reference_and_baseline_in_the_same_case(self) -> None:
        frame = made_frame()
        assert list(frame.columns) == COLUMNS
        coarse = row_of(frame, "spacing", "5 m", "strong")
        assert coarse["displacement_deviation"] == pytest.approx(1.2 / 1.0 - 1)
        assert coarse["runout_deviation"] == pytest.approx(2.2 / 2.0 - 1)
        assert coarse["displacement_deviation_from_baseline"] == pytest.approx(1.2 / 1.5 - 1)
        assert coarse["onset_after_start"] == 1.5
        reference = row_of(frame, "spacing", "2 m")
        assert reference["reference"] == 1 and reference["displacement_deviation"] == 0.0 and reference["class_as_reference"] == 1

    def test_costs_are_the_median_of_the_repeats(self) -> None:
        row = row_of(made_frame(), "spacing", "3 m")
        assert (row["repeats"], row["timed"]) == (3, 1)
        assert [row[name] for name in ("wall_time", "wall_time_min", "wall_time_max")] == pytest.approx([4.4, 4.0, 4.8])

    def test_repeats_that_differ_are_told(self) -> None:
        made = made_runs()
        runs = runs_of(made)
        runs["fidelity/draft/weak_2"]["displacement_magnitude"] = np.nextafter(12.0, 13.0)
        frame = cost_accuracy_table(made.rows, runs, "paper", "m")
        assert row_of(frame, "spacing", "5 m")["reproducible"] == 0.0
        assert row_of(frame, "spacing", "3 m")["reproducible"] == 1.0
        assert math.isnan(row_of(frame, "skin", "0.6")["reproducible"])

    def test_a_diverged_run_has_no_deviation_and_another_class(self) -> None:
        gone = {"status": "diverged", "collapse_class": "undetermined", "displacement_magnitude": math.nan, "runout": math.nan}
        frame = made_frame(**{"skin_0.6": gone})
        row = row_of(frame, "skin", "0.6")
        assert math.isnan(row["displacement_deviation"]) and row["class_as_reference"] == 0
        assert not next(variant for variant in summary(frame) if variant.name == "skin: 0.6").finished

    def test_nothing_moved_in_both_is_no_deviation(self) -> None:
        still = {"runout": 0.0}
        frame = made_frame(**{"spacing_2_m": still, "spacing_3_m": still})
        assert row_of(frame, "spacing", "3 m")["runout_deviation"] == 0.0
        assert row_of(frame, "spacing", "5 m")["runout_deviation"] == math.inf

    def test_files_hold_what_was_written(self, tmp_path: Path) -> None:
        frame = made_frame()
        write_csv(frame, tmp_path / "study.csv")
        pd.testing.assert_frame_equal(read_cost_accuracy(tmp_path / "study.csv"), frame, check_dtype=False)
        ds = flat_dataset(frame, VARIABLES, {"machine": "m"})
        assert ds.attrs["machine"] == "m" and list(ds.data_vars) == COLUMNS and ds["wall_time"].attrs["units"] == "s"
        (tmp_path / "empty.csv").write_text(",".join(COLUMNS) + "\n")
        with pytest.raises(ValueError, match=r"empty.csv.*without a row"):
            read_cost_accuracy(tmp_path / "empty.csv")
        (tmp_path / "other.csv").write_text("a\n1\n")
        with pytest.raises(ValueError, match="other.csv"):
            read_cost_accuracy(tmp_path / "other.csv")

    def test_a_trajectory_gives_what_a_row_needs(self) -> None:
        run = synthetic(translation(-3.0))
        run.attrs["particle_steps"] = 2404 * 30
        values = measured_run(run, MetricSettings())
        assert (values["particles"], values["steps"], values["spacing"]) == (2404, 30, 1.0)
        frame = cost_accuracy_table(
            [Row("fidelity", "paper", "only", "accuracy", {}, {}, True, True, False, "", 2, (("a", "b"),))],
            {"a": values, "b": values},
            "paper",
            "m",
        )
        assert frame.iloc[0]["displacement_magnitude"] == pytest.approx(3.0) and frame.iloc[0]["reproducible"] == 1.0

    def test_a_mean_over_lattices(self) -> None:
        """Results are averaged, times added, the worst error and the most frequent class taken; a run that another has made is shared."""
        variants = {"2 m": {"numerics": {"spacing": 2.0, "lattice_shift": [-0.25, 0.0, 0.25]}}}
        mean = {"about": "mean", "base": {"numerics": {"smoothing_ratio": 1.3}}, "repeats": 1, "variants": variants}
        made = made_runs({"parameters": {"mean": mean}})
        (row,) = (row for row in made.rows if (row.parameter, row.case) == ("mean", "weak"))
        assert row.lattices[1] == ("spacing/2-m/weak_1", "spacing/2-m/weak_2", "spacing/2-m/weak_3"), "without a shift it is the variant"
        assert [made.runs[name].scene["numerics"]["lattice_shift"] for name in row.runs if name.startswith("mean/")] == [-0.25, 0.25]
        assert row.scheme["numerics"]["lattice_shift"] == [-0.25, 0.0, 0.25] and is_mean(row.settings)
        first = runs_of(made_runs())[row.lattices[1][0]]
        values = {"displacement_magnitude": (9.0, 10.0, 14.0), "runout": (12.0, 11.0, 13.0), "onset_time": (4.0, 5.0, 6.0)}
        values |= {"energy_error": (1e-3, -4e-3, 2e-3), "wall_time": (1.0, 2.0, 4.0), "collapse_class": ("collapse", "damaged", "collapse")}
        runs = {name: first | {key: each[at] for key, each in values.items()} for at, names in enumerate(row.lattices) for name in names}
        (found,) = cost_accuracy_table([row._replace(parameter="fidelity", variant="paper", reference=True)], runs, "paper", "m").to_dict(
            "records"
        )
        assert (found["displacement_magnitude"], found["runout"]) == (11.0, 12.0)
        assert found["onset_after_start"] == 5.0 - first["shaking_start"]
        assert (found["energy_error"], found["wall_time"], found["collapse_class"]) == (-4e-3, 7.0, "collapse")
        assert found["steps"] == 3 * first["steps"] and math.isnan(found["reproducible"])

    @pytest.mark.parametrize(
        ("shifts", "wanted"),
        [([], r"numerics\.lattice_shift: \[\] must name a lattice"), ([0.0, "x"], "lattice_shift"), ([7.0], "lattice_shift")],
    )
    def test_lattices_that_are_none_are_refused(self, shifts: list[Any], wanted: str) -> None:
        mean = {"about": "mean", "variants": {"2 m": {"numerics": {"spacing": 2.0, "lattice_shift": shifts}}}}
        with pytest.raises(ValueError, match=f"study.yaml: parameter '?mean'?, variant '2 m'.*{wanted}"):
            made_runs({"parameters": {"mean": mean}})

    def test_the_machine_has_a_name(self) -> None:
        assert "cores" in machine_class()


class TestSummary:
    def test_the_largest_deviation_over_the_cases_counts(self) -> None:
        variants = {variant.name: variant for variant in summary(made_frame(**{"skin_0.6": {"collapse_class": "collapse"}}))}
        coarse = variants["spacing: 5 m"]
        assert coarse.errors == pytest.approx({"displacement": 0.2, "runout": 13 / 11 - 1}) and coarse.cost == pytest.approx(1.1)
        assert (variants["skin: 0.6"].classes_agree, variants["skin: 0.6"].cases) == (1, 2)
        assert not variants["spacing: 1.5 m"].every_case and variants["spacing: 2 m"].reference

    def test_the_front_holds_what_nothing_beats(self) -> None:
        cost, error = np.array([4.0, 1.0, 2.0, 3.0, 1.0]), np.array([0.1, 0.9, 0.5, 0.6, math.nan])
        assert non_dominated(cost, error).tolist() == [1, 2, 0]


class TestAdvice:
    def test_the_cheapest_within_the_error_is_named(self) -> None:
        frame = made_frame()
        for error, name in ((0.25, "fidelity: draft"), (0.1, "spacing: 3 m")):
            found = advise(frame, error)
            assert found.fits and found.variant.name == name

    def test_one_quantity_alone_may_allow_more(self) -> None:
        assert advise(made_frame(), 0.19, ("runout",)).variant.cost == pytest.approx(1.1)
        assert advise(made_frame(), 0.19, ("displacement",)).variant.cost == pytest.approx(4.4)

    def test_a_variant_of_another_class_is_no_answer(self) -> None:
        changed = made_frame(**{"fidelity_draft": {"collapse_class": "minor"}})
        assert advise(changed, 0.25).variant.name == "spacing: 3 m"

    def test_a_variant_that_changes_the_model_is_no_answer(self) -> None:
        frame = made_frame(made_runs({"parameters": {"spacing": {"changes": "model"}}}))
        found = advise(frame, 0.1)
        assert found.fits and found.variant.name == "skin: 0.3"
        assert set(frame[frame["parameter"] == "spacing"]["changes"]) == {"model"}

    def test_a_variant_above_its_time_step_limit_is_no_answer(self) -> None:
        exceeded = {"time_step_ratio": 1.01}
        assert advise(made_frame(fidelity_draft=exceeded, spacing_5_m=exceeded), 0.25).variant.name == "spacing: 3 m"

    def test_a_fidelity_can_be_the_measure(self) -> None:
        # A moves by 15 m at paper and by 12 m at draft; the run-outs are a metre more.
        frame = against(made_frame(), "paper")
        assert advise(frame, 0.25).variant.name == "fidelity: draft"
        draft = next(variant for variant in summary(frame) if variant.name == "fidelity: draft")
        assert draft.errors["displacement"] == pytest.approx(0.2) and draft.errors["runout"] == pytest.approx(1 - 13 / 16)
        with pytest.raises(ValueError, match="fidelity: 'best' .*draft, paper"):
            against(made_frame(), "best")

    def test_neither_the_reference_nor_a_variant_of_some_cases_is_an_answer(self) -> None:
        found = advise(made_frame(), 0.001)
        assert not found.fits and found.variant.name == "spacing: 3 m"

    @pytest.mark.parametrize(("error", "quantities"), [(-0.1, ("runout",)), (math.nan, ("runout",)), (0.1, ("speed",))])
    def test_bad_questions_are_refused(self, error: float, quantities: tuple[str, ...]) -> None:
        with pytest.raises(ValueError):
            advise(made_frame(), error, quantities)

    def test_the_command_prints_settings_that_give_it(self, shipped: Path) -> None:
        result = call("advise", "--error", "10%")
        assert result.exit_code == 0 and "spacing: 3 m, 4.4 s" in result.stdout and "test machine" in result.stdout
        line = next(line for line in result.stdout.splitlines() if "--set" in line)
        settings = [word for word in line.split() if "=" in word]
        assert parse_settings(settings) == {"numerics": {"smoothing_ratio": 1.3, "spacing": 3.0}}
        assert call("advise", "--error", "0.1", "--table", shipped).stdout == result.stdout

    def test_the_command_says_when_nothing_is_good_enough(self, shipped: Path) -> None:
        result = call("advise", "--error", "1%")
        assert result.exit_code == 2 and "no measured setting" in result.stdout and "spacing: 3 m" in result.stdout

    @pytest.mark.parametrize(
        ("arguments", "wanted"),
        [
            (("--error", "little"), "little"),
            (("--error", "10%", "--quantity", "speed"), "speed"),
            (("--error", "1", "--table", "no.csv"), "no.csv"),
        ],
    )
    def test_the_command_refuses_by_name(self, shipped: Path, arguments: tuple[str, ...], wanted: str) -> None:
        result = call("advise", *arguments)
        assert result.exit_code == 2 and wanted in result.stderr and "Traceback" not in result.stderr

    def test_without_a_table_the_command_says_so(self, absent: None) -> None:
        result = call("advise", "--error", "10%")
        assert result.exit_code == 2 and "snakemake --cores 2 cost-accuracy" in result.stderr


class TestExpectedError:
    def test_it_is_that_of_the_variant_with_the_same_scheme(self, shipped: Path) -> None:
        other_soil = scene(numerics__smoothing_ratio=1.3, numerics__spacing=3.0, soil__cohesion=100.0, coupling__S_R=0.4)
        found = expected_error(other_soil)
        assert found is not None and found.displacement == pytest.approx(0.09) and found.variant == "spacing: 3 m"
        assert "A's displacement within 9 %, run-out within 8.2 %" in expected_sentence(other_soil)
        row = advice.expected_metrics(other_soil)
        assert row["expected_displacement_error"] == pytest.approx(0.09) and row["expected_runout_error"] == pytest.approx(0.9 / 11)

    def test_other_numerics_are_not_measured(self, shipped: Path) -> None:
        other = scene(numerics__smoothing_ratio=1.4)
        assert expected_error(other) is None and "not measured with these numerics" in expected_sentence(other)
        assert all(math.isnan(value) for value in advice.expected_metrics(other).values())

    def test_a_variant_of_some_cases_gives_none(self, shipped: Path) -> None:
        assert expected_error(scene(numerics__smoothing_ratio=1.3, numerics__spacing=1.5)) is None

    def test_without_a_table_nothing_is_expected(self, absent: None) -> None:
        assert expected_error(scene()) is None and "not measured yet" in expected_sentence(scene())

    def test_info_prints_it(self, shipped: Path, tmp_path: Path) -> None:
        path = tmp_path / "slope.yaml"
        path.write_text(yaml.safe_dump(SCENE, sort_keys=False))
        shown = call("info", path, "--set", "numerics.smoothing_ratio=1.3").stdout
        assert "expected error" in shown and "A's displacement within 20 %" in shown and "fidelity: draft" in shown


class TestReference:
    def test_the_tables_of_the_readme_come_from_the_shipped_table(self, shipped: Path) -> None:
        variants = markdown(TABLES["cost-accuracy"]())
        assert "| `spacing: 3 m` | 10.0 M | 4.4 s | 9 % | 8.2 % | 2 of 2 |" in variants and "test machine, 2 cores" in variants
        assert "| `spacing: 2 m` | 10.0 M | 22 s | reference | reference | 2 of 2 |" in variants

    def test_without_a_table_they_say_so(self, absent: None) -> None:
        assert TABLES["cost-accuracy"]().rows == [] and markdown(TABLES["cost-accuracy"]()).startswith("Not measured yet")


class TestFigures:
    def test_every_variant_but_the_reference_has_a_point_and_fidelities_their_name(self) -> None:
        figure = figure_tradeoff(made_frame(**{"skin_0.6": {"collapse_class": "minor"}}))
        for ax in figure.axes:
            points = [line for line in ax.lines if line.get_marker() not in (None, "None")]
            assert len(points) == 6, "draft, paper, 5 m, 3 m and two skins; not the reference, not the variant of one case"
            assert [line.get_markerfacecolor() for line in points].count("white") == 1
            assert {text.get_text() for text in ax.texts} == {"draft", "paper"}
        front = next(line for line in figure.axes[0].lines if line.get_marker() in (None, "None"))
        assert front.get_xydata().tolist() == pytest.approx(np.array([[1.1, 0.2], [4.4, 0.09]]))

    def test_the_curves_of_convergence_are_those_of_the_table(self) -> None:
        frame = made_frame()
        figure = figure_convergence(convergence_table(frame, "spacing"), frame)
        assert isinstance(figure, Figure) and len(figure.axes) == 3
        curve = figure.axes[0].lines[0]
        assert np.asarray(curve.get_xydata()).tolist() == [[1.5, 9.7], [2.0, 10.0], [3.0, 10.9], [5.0, 12.0]]

    def test_nothing_to_draw_is_refused(self) -> None:
        frame = made_frame()
        with pytest.raises(ValueError, match="nothing to draw"):
            figure_tradeoff(frame[frame["reference"] == 1])
        with pytest.raises(ValueError, match="no row"):
            figure_convergence(convergence_table(frame, "walls"), frame)


def test_the_paper_scene_of_the_tests_has_the_papers_scheme() -> None:
    assert scheme(make_scene(PAPER)) == {}
