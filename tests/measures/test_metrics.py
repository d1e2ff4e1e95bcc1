"""Metrics on hand-made trajectories whose answers are known."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from synthetic import step_ramp, synthetic, translation

from sph.measures.linked import largest_mass
from sph.measures.metrics import METRICS, MetricSettings, collapse_class, measure, outline_area
from sph.output.run import Run
from sph.scene.schema import Scene, make_scene
from sph.solver.particles import SOIL

SAMPLE = 0.05  # s


def copied(run: Run) -> Run:
    """Another run with the same numbers."""
    return Run(run.trajectory.copy(deep=True))


def with_final(run: Run, particle: int, x: float, y: float) -> Run:
    """The run with one particle somewhere else in the last frame."""
    changed = copied(run)
    changed["displacement_x"][-1, particle] += x - changed["x"][-1, particle]
    changed["displacement_y"][-1, particle] += y - changed["y"][-1, particle]
    changed["x"][-1, particle], changed["y"][-1, particle] = x, y
    return changed


def nan_metrics(values: dict[str, float | int | str]) -> set[str]:
    return {name for name, value in values.items() if isinstance(value, float) and math.isnan(value)}


def test_measure_gives_exactly_the_rows_of_the_table_in_order(slid: Run) -> None:
    values = measure(slid)
    assert list(values) == [metric.name for metric in METRICS]
    types = {"f8": float, "i1": int, "str": str}
    assert {name: type(value) for name, value in values.items()} == {metric.name: types[metric.dtype] for metric in METRICS}


class TestProbe:
    def test_a_rigid_slide_of_3_m_is_reported_as_such(self, slid: Run) -> None:
        values = measure(slid)
        assert values["displacement_horizontal"] == pytest.approx(-3.0)
        assert values["displacement_vertical"] == 0.0
        assert values["displacement_magnitude"] == pytest.approx(3.0)
        assert values["probe_peak_speed"] == pytest.approx(0.75)
        assert values["peak_speed"] == pytest.approx(0.75)

    def test_displacement_starts_at_the_end_of_the_gravity_stage(self) -> None:
        settling = synthetic(translation(0.0, -1.0), step_ramp(0.0, 3.0))
        values = measure(settling)
        assert values["displacement_magnitude"] == pytest.approx(0.0, abs=1e-12)
        assert values["area_moved_10cm"] == 0.0
        assert values["collapse_class"] == "stable"

    def test_peak_keeps_its_sign_and_differs_from_the_permanent_value(self) -> None:
        def there_and_back(time: np.ndarray) -> np.ndarray:
            return np.interp(time, [4.0, 6.0, 8.0], [0.0, 1.5, 1.0])

        values = measure(synthetic(translation(-2.0, -1.0), there_and_back))
        assert (values["displacement_vertical"], values["peak_displacement_vertical"]) == pytest.approx((-1.0, -1.5))
        assert (values["displacement_horizontal"], values["peak_displacement_horizontal"]) == pytest.approx((-2.0, -3.0))
        assert values["peak_displacement_magnitude"] == pytest.approx(1.5 * math.hypot(2.0, 1.0))

    def test_value_at_the_end_of_shaking(self) -> None:
        values = measure(synthetic(translation(-3.0, -4.0), step_ramp(8.0, 12.0)))
        assert values["displacement_horizontal_end_of_shaking"] == pytest.approx(-1.5)
        assert values["displacement_vertical_end_of_shaking"] == pytest.approx(-2.0)
        assert values["displacement_magnitude_end_of_shaking"] == pytest.approx(2.5)

    def test_no_value_at_the_end_of_shaking_where_the_run_is_shorter_or_not_shaken(self) -> None:
        short = measure(synthetic(translation(-3.0), overrides={"duration": 9.0}))
        assert math.isnan(float(short["displacement_magnitude_end_of_shaking"])) and short["shaking_end"] == 10.0
        still = measure(synthetic(translation(-3.0), overrides={"motion": {"kind": "none"}}))
        assert math.isnan(float(still["displacement_magnitude_end_of_shaking"])) and math.isnan(float(still["shaking_start"]))
        assert still["displacement_magnitude"] == pytest.approx(3.0)

    def test_onset_and_arrest_on_a_ramp(self, slid: Run) -> None:
        values = measure(slid)  # 0.75 m/s from 4 to 8 s: 0.05 m are passed 1/15 s after the start and before the end
        assert values["onset_time"] == pytest.approx(4.1)
        assert values["arrest_time"] == pytest.approx(7.95)

    def test_thresholds_move_onset_and_arrest(self, slid: Run) -> None:
        values = measure(slid, MetricSettings(onset_threshold=1.0, arrest_tolerance=0.8))
        assert 4.0 + 1.0 / 0.75 < float(values["onset_time"]) <= 4.0 + 1.0 / 0.75 + SAMPLE
        assert 8.0 - 0.8 / 0.75 <= float(values["arrest_time"]) <= 8.0 - 0.8 / 0.75 + SAMPLE

    def test_no_onset_and_no_arrest_without_motion(self) -> None:
        values = measure(synthetic(translation(-0.05)))
        assert {"onset_time", "arrest_time"} <= nan_metrics(values)

    def test_no_arrest_while_still_moving(self) -> None:
        values = measure(synthetic(translation(-3.0), step_ramp(4.0, 20.0)))
        assert values["still_moving"] == 1 and math.isnan(float(values["arrest_time"])) and values["onset_time"] == pytest.approx(4.3)

    def test_unknown_probe_is_refused_by_name(self, slid: Run) -> None:
        with pytest.raises(ValueError, match="'B'.*\\['A'\\]"):
            measure(slid, MetricSettings(probe="B"))


class TestRunout:
    def test_a_block_moved_by_3_m_runs_out_3_m(self, slid: Run) -> None:
        values = measure(slid)
        assert values["runout"] == pytest.approx(3.0, abs=1e-5)
        assert values["runout_over_height"] == pytest.approx(3.0 / 25.0, abs=1e-6)

    def test_the_spacing_does_not_matter(self) -> None:
        values = measure(synthetic(translation(-3.0), overrides={"numerics": {"spacing": 0.5}}))
        assert values["runout"] == pytest.approx(3.0, abs=0.5)

    def test_an_isolated_particle_thrown_ahead_does_not_count(self, slid: Run) -> None:
        crest = int(slid["probe_particle"][0])
        flown = measure(with_final(slid, crest, 20.0, 30.0))
        assert flown["runout"] == pytest.approx(3.0, abs=1e-5)
        landed = measure(with_final(slid, crest, 20.5, 10.5))  # on the apron it belongs to the mass
        assert landed["runout"] == pytest.approx(35.0, abs=1e-5)

    def test_the_apron_and_what_is_heaved_there_is_no_front(self) -> None:
        def heave(scene: object, x: np.ndarray, y: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
            apron = (x > 30) & (x < 50) & (y > 5) & (y < 10)
            return np.where(apron, -1.5, 0.0), np.where(apron, 2.0, 0.0)

        values = measure(synthetic(heave))
        assert values["runout"] == 0.0 and math.isnan(float(values["travel_angle"]))
        assert values["deposit_height"] == pytest.approx(2.0, abs=1e-5)
        assert values["area_moved_100cm"] == 20 * 5

    def test_small_motion_gives_no_front(self) -> None:
        values = measure(synthetic(translation(-0.4)))
        assert values["runout"] == 0.0 and math.isnan(float(values["travel_angle"]))

    def test_material_drawn_back_has_no_negative_runout(self) -> None:
        values = measure(synthetic(translation(2.0)))
        assert values["runout"] == 0.0 and float(values["travel_angle"]) > 60.0

    def test_travel_angle_and_deposit_height(self, slid: Run) -> None:
        values = measure(slid)
        run = 25.0 / math.tan(math.radians(60.0))
        assert values["travel_angle"] == pytest.approx(math.degrees(math.atan2(25.0, run + 3.0)), abs=1e-4)
        assert values["deposit_height"] == pytest.approx(4.0, abs=1e-5)  # the column 2.5 m behind the toe is 4 particles high

    def test_a_sliding_point_and_slides_of_the_field_are_beside_the_run_out(self, slid: Run) -> None:
        """The failed soil keeps 0.1 of 20 degrees: its point runs on level ground beyond the model; debris slides have a mean angle."""
        values, back = measure(slid), 25.0 / math.tan(math.radians(60.0))
        kept = slid.scene.materials[0].residual[1]
        assert values["energy_line_angle"] == pytest.approx(kept)
        assert values["energy_line_runout"] == pytest.approx(25.0 / math.tan(math.radians(kept)) - back)
        volume = float(values["area_moved_50cm"]) * 25.0
        assert values["corominas_angle"] == pytest.approx(math.degrees(math.atan(10.0**-0.012 * volume**-0.105)))
        assert values["corominas_runout"] == pytest.approx(25.0 / math.tan(math.radians(float(values["corominas_angle"]))) - back)

    def test_mean_thickness_of_the_deposit(self, slid: Run) -> None:
        # A wedge of 3 m at 60 degrees: 1.5 m tan(60) thick; columns of 1, 3 and 4 particles over 3 m.
        assert measure(slid)["deposit_thickness"] == pytest.approx(8.0 / 3.0) == pytest.approx(1.5 * math.tan(math.radians(60.0)), rel=0.03)

    def test_no_deposit_on_a_standing_slope(self, standing: Run) -> None:
        values = measure(standing)
        assert values["deposit_height"] == 0.0 and math.isnan(float(values["deposit_thickness"]))

    def test_other_shapes_have_no_runout(self) -> None:
        block = {"geometry": {"shape": "block", "width": 10.0, "height": 5.0}}
        values = measure(synthetic(translation(-3.0), overrides=block))
        assert nan_metrics(values) == {
            "runout", "runout_over_height", "travel_angle", "energy_line_angle", "energy_line_runout", "corominas_angle",
            "corominas_runout", "deposit_height", "deposit_thickness", "first_failure_time", "reached_side_time",
        }  # fmt: skip
        assert values["area_moved_100cm"] == 50.0

    def test_largest_mass_is_the_larger_one_wherever_it_lies(self) -> None:
        x = np.array([0.0, 1.0, 10.0, 11.0, 12.0, 30.0])
        assert largest_mass(x, np.zeros(6), 2.0).tolist() == [False, False, True, True, True, False]
        assert largest_mass(x, np.zeros(6), 9.0).tolist() == [True, True, True, True, True, False]
        assert largest_mass(x, np.zeros(6), 0.5).sum() == 1


class TestSoil:
    def test_area_counts_what_moved_more_than_each_threshold(self) -> None:
        def bands(scene: object, x: np.ndarray, y: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
            return np.select([x < 1, x < 3, x < 6], [2.0, 0.7, 0.2], 0.0), np.zeros_like(x)

        block = {"geometry": {"shape": "block", "width": 10.0, "height": 5.0}, "numerics": {"spacing": 0.5}}
        values = measure(synthetic(bands, overrides=block))
        areas = [values[name] for name in ("area_moved_10cm", "area_moved_50cm", "area_moved_100cm")]
        assert areas == pytest.approx([30.0, 15.0, 5.0])

    def test_first_failure_counts_the_box_and_is_nan_without_failure(self, standing: Run) -> None:
        assert math.isnan(float(measure(standing)["first_failure_time"]))
        failed = copied(standing)
        failed["t_f"][0] = 5.0
        failed["t_f"][-1] = 4.5
        assert failed["kind"][-1] != SOIL and measure(failed)["first_failure_time"] == 4.5

    def test_failed_fraction_and_cost_are_passed_on(self, standing: Run) -> None:
        standing["failed_fraction"][-1] = 0.25
        values = measure(standing)
        assert values["failed_fraction"] == 0.25
        assert (values["wall_time"], values["particle_steps_per_second"]) == (2.0, 3e6)

    def test_peak_speed_leaves_the_gravity_stage_out(self, standing: Run) -> None:
        standing["maximum_speed"][10] = 9.0
        standing["maximum_speed"][-20] = 4.0
        assert measure(standing)["peak_speed"] == 4.0

    def test_area_change_is_that_of_mass_over_density(self, standing: Run) -> None:
        standing["density"][-1] /= 1.05
        assert measure(standing)["area_change"] == pytest.approx(0.05, rel=1e-4)

    def test_outline_area_sees_a_bulge_and_closes_small_gaps(self) -> None:
        x, y = (axis.ravel() + 0.5 for axis in np.meshgrid(np.arange(20.0), np.arange(10.0)))
        full = outline_area(x, y, 1.0)
        gap = (x == 10.5) & (y == 5.5)
        assert full == pytest.approx(200.0, rel=0.05)
        assert outline_area(x[~gap], y[~gap], 1.0) == full
        assert outline_area(1.1 * x, y, 1.0) == pytest.approx(1.1 * full, rel=0.03)

    def test_nearest_neighbour_falls_with_pairing(self, standing: Run) -> None:
        assert measure(standing)["nearest_neighbour_p05"] == pytest.approx(1.0)
        soil = np.flatnonzero(standing["kind"] == SOIL)[::10]
        for particle in soil:
            standing["x"][-1, particle] += 0.75
        assert measure(standing)["nearest_neighbour_p05"] == pytest.approx(0.25, abs=1e-5)

    def test_the_share_of_the_artificial_viscosity(self, standing: Run) -> None:
        samples = standing.trajectory.sizes["sample"]
        standing.trajectory["dissipated_energy"] = ("sample", np.linspace(0.0, 200.0, samples))
        standing.trajectory["viscous_energy"] = ("sample", np.linspace(0.0, 30.0, samples))
        assert measure(standing)["viscous_share"] == pytest.approx(0.15)
        assert math.isnan(measure(standing.trajectory.drop_vars("viscous_energy"))["viscous_share"])

    def test_energy_error_is_the_closing_error_over_the_peak_of_the_energies(self, standing: Run) -> None:
        samples = np.arange(standing.trajectory.sizes["sample"])
        assert measure(standing)["energy_error"] == 0.0
        standing.trajectory["potential_energy"] = ("sample", -100.0 * samples / samples[-1])
        standing.trajectory["dissipated_energy"] = ("sample", 150.0 * samples / samples[-1])
        standing.trajectory["shaking_work"] = ("sample", 45.0 * samples / samples[-1])
        assert measure(standing)["energy_error"] == pytest.approx(5.0 / 250.0)
        standing.trajectory["elastic_energy"] = ("sample", np.full(samples.size, 50.0))  # only a change counts
        assert measure(standing)["energy_error"] == pytest.approx(5.0 / 300.0)


class TestVerdicts:
    @pytest.mark.parametrize(
        ("relative", "expected"),
        [
            (0.0, "stable"),
            (0.00399, "stable"),
            (0.004, "minor"),
            (0.0199, "minor"),
            (0.02, "damaged"),
            (0.0999, "damaged"),
            (0.1, "collapse"),
        ],
    )
    def test_class_limits(self, relative: float, expected: str) -> None:
        assert collapse_class(relative, MetricSettings()) == expected

    @pytest.mark.parametrize(("ux", "expected"), [(-0.09, "stable"), (-0.3, "minor"), (-2.4, "damaged"), (-2.6, "collapse")])
    def test_class_of_a_run_follows_the_permanent_displacement_over_the_height(self, ux: float, expected: str) -> None:
        assert measure(synthetic(translation(ux)))["collapse_class"] == expected

    def test_limits_out_of_order_are_refused_with_their_values(self) -> None:
        with pytest.raises(ValueError, match="stable_limit \\(0.5\\)"):
            MetricSettings(stable_limit=0.5)

    def test_still_moving_by_the_soil_alone(self, slid: Run) -> None:
        mass = float(slid["mass"][slid["kind"] == SOIL].sum())
        assert measure(slid)["still_moving"] == 0
        slid["kinetic_energy"][-3] = 0.5 * mass * 0.049**2
        assert measure(slid)["still_moving"] == 0
        slid["kinetic_energy"][-3] = 0.5 * mass * 0.051**2
        assert measure(slid)["still_moving"] == 1

    def test_a_few_particles_that_roll_on_do_not_keep_a_run_from_rest(self, slid: Run) -> None:
        rolling = copied(slid)
        soil = np.flatnonzero(rolling.soil & (rolling["y0"] > 10.0))  # the debris
        few = soil.size // 100
        rolling["velocity_x"][-1, soil[:few]] = -3.0
        values = measure(rolling)
        assert (values["at_rest"], values["time_to_rest"]) == (1, 0.0)
        assert values["moving_share"] == pytest.approx(few / soil.size)
        rolling["velocity_x"][-1, soil[few]] = -0.051  # one more, just as fast as counts
        assert measure(rolling)["at_rest"] == 0

    def test_a_slide_that_slows_down_is_told_how_long_it_goes_on(self) -> None:
        """Speed 0.0234 m/s2 (20 s - t): below 0.05 m/s from 17.87 s on, of a run that ends at 15 s."""

        def share(time: np.ndarray) -> np.ndarray:
            return 1.0 - (1.0 - np.clip((time - 4.0) / 16.0, 0.0, 1.0)) ** 2

        run = synthetic(translation(-3.0), share)
        moves, time = run["velocity_x"][-1] != 0.0, run["time"]
        run["velocity_x"][-3:, moves] = -(6.0 / 16.0**2 * (20.0 - time[-3:]))[:, None]
        run["probe_velocity_x"][:] = 0.0  # by its places, not by its speed
        values = measure(run)
        assert (values["at_rest"], values["moving_share"]) == (0, 1.0)
        assert values["time_to_rest"] == pytest.approx(2.87 + 0.25, abs=0.01), "the probe's is that of the middle of the window"
        still = copied(run)
        still["probe_displacement_x"][-30:] = -3.0
        assert measure(still)["time_to_rest"] == pytest.approx(2.87, abs=0.01)
        still["velocity_x"][-1] = 0.0
        assert measure(still)["at_rest"] == 1
        run["velocity_x"][-1] = 0.0
        assert (measure(run)["at_rest"], measure(run)["moving_share"]) == (0, 0.0), "what is told of the probe is not final"

    def test_a_speed_is_small_beside_a_large_displacement(self) -> None:
        """0.3 m/s is less than a hundredth of 40 m a second, and more than that of 3 m."""
        for far, at_rest in ((-40.0, 1), (-3.0, 0)):
            run = synthetic(translation(far))
            run["velocity_x"][-1, run["displacement_x"][-1] != 0.0] = -0.3
            assert measure(run)["at_rest"] == at_rest

    def test_what_has_only_begun_is_not_at_rest(self) -> None:
        values = measure(synthetic(translation(-0.4), step_ramp(14.5, 20.0)))
        assert (values["at_rest"], values["moving_share"]) == (0, 1.0) and math.isnan(float(values["time_to_rest"]))

    def test_a_diverged_run_has_a_status_and_a_cost_but_no_results(self) -> None:
        values = measure(synthetic(translation(-3.0), status="diverged"))
        assert (values["status"], values["diverged"], values["still_moving"], values["at_rest"]) == ("diverged", 1, 1, 0)
        assert values["collapse_class"] == "undetermined"
        kept = {"shaking_start", "shaking_end", "time_step_ratio", "wall_time", "particle_steps_per_second"}
        assert nan_metrics(values) == {metric.name for metric in METRICS if metric.dtype == "f8"} - kept

    @pytest.mark.parametrize("status", ["paused", "odd"])
    def test_an_unfinished_run_is_refused(self, status: str) -> None:
        with pytest.raises(ValueError, match=f"status: '{status}'"):
            measure(synthetic(status=status))

    def test_an_unfailed_run_is_measured(self) -> None:
        values = measure(synthetic(status="unfailed"))
        assert (values["status"], values["diverged"], values["collapse_class"]) == ("unfailed", 0, "stable")


def test_synthetic_scene_is_the_papers() -> None:
    scene = make_scene({"scheme": "paper", "name": "paper", "geometry": {"shape": "slope"}})
    assert synthetic().trajectory.sizes["particle"] == 2404 and scene.geometry.toe == (55.0, 10.0)


GROUND: dict[str, Any] = {"shape": "ground_line", "points": [[120, 440], [175, 440], [190, 465], [224, 465]], "base": 430}


class TestGroundLine:
    def test_a_slide_of_3_m_is_that_of_the_plane_slope(self) -> None:
        plane = {"shape": "slope", "slope_angle": math.degrees(math.atan2(25, 15)), "slope_height": 25.0, "base_depth": 10.0}
        theirs = measure(synthetic(translation(-3.0), overrides={"geometry": plane | {"apron_length": 55.0, "crest_length": 34.0}}))
        for turned in (False, True):
            line = {"points": [[-x, y] for x, y in GROUND["points"]], "downhill": "right"} if turned else {}
            own = measure(synthetic(translation(-3.0), overrides={"geometry": GROUND | line}))
            assert own["runout"] == pytest.approx(3.0)
            assert own == pytest.approx(theirs, abs=1e-9, nan_ok=True)

    def test_soil_before_the_toe_is_not_the_slopes(self) -> None:
        valley = GROUND | {"points": [[100, 450], [120, 440], [175, 440], [190, 465], [224, 465]]}

        def other_side(scene: Scene, x: np.ndarray, y: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
            return np.where((x < 20.0) & (y > 10.0), 3.0, 0.0), np.zeros(x.size)

        values = measure(synthetic(other_side, overrides={"geometry": valley}))
        assert values["runout"] == 0.0

    def test_the_deposit_counts_from_the_ground_below_it(self) -> None:
        inclined = GROUND | {"points": [[120, 450], [175, 440], [190, 465], [224, 465]]}
        values = measure(synthetic(overrides={"geometry": inclined}))
        assert 0.0 <= float(values["deposit_height"]) <= 0.5, "half a spacing, where the ground is its own initial line"
