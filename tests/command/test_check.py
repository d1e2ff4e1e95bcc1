"""``sph check``: each warning by a scene that calls for it and one that does not; the drawing."""

from __future__ import annotations

import json
import math
import re
from pathlib import Path
from typing import Any

import matplotlib
import numpy as np
import pytest
import yaml
from calling import call
from matplotlib.backends.backend_agg import FigureCanvasAgg

from cases.limit_analysis import limit_factor
from sph.checks.finding import Finding, finding
from sph.checks.messages import line, words
from sph.checks.scene import MAX_HEIGHT_ERROR, MIN_IN_WAVE, findings, height_error, highest_frequency, in_wave
from sph.checks.stability import stability
from sph.command.check import check, draw, layer_rows, places_of, rows
from sph.figures.scene import FEW
from sph.jobs.exit_codes import REFUSED
from sph.scene.configuration import dotted, merge
from sph.scene.gravity import GRAVITY
from sph.scene.schema import Scene, make_scene
from sph.scene.units import in_both
from sph.solver.time_step import limits, wave_speed_ratio

SOUND: dict[str, Any] = {
    "scheme": "paper",
    "name": "sound",
    "duration": 12.0,
    "geometry": {
        "shape": "ground_line",
        "points": [[100, 440], [160, 440], [180, 460], [220, 460]],
        "base": 430,
    },
    "motion": {"kind": "tapered_sine"},
    "numerics": {"spacing": 1.0, "smoothing_ratio": 1.3, "time_step": 5e-4},
}
"""Nothing to warn of."""


def scene(**settings: Any) -> Scene:
    return make_scene(merge(SOUND, dotted(settings)))


def found(**settings: Any) -> list[Finding]:
    """What limit equilibrium finds, which takes longer, left out."""
    return [each for each in findings(scene(**settings)) if each.counts]


def test_a_sound_scene_has_no_warning() -> None:
    assert [each for each in check(scene()).findings if each.counts] == found() == []
    assert found(**{"coupling.softening": {"slip_at_peak": 1e-3, "width": 3.0}}) == []


@pytest.mark.parametrize(
    ("settings", "code", "what", "key"),
    [
        ({"numerics.spacing": 0.75}, "rows-misfit", "make the slope too high", "numerics.spacing"),
        ({"numerics.spacing": 2.0}, "few-particles", "across the slope's height", "numerics.spacing"),
        (
            {"geometry.points": [[100, 440], [160, 440], [180, 460], [195, 460]]},
            "back-wall",
            "side of the model behind the crest is near",
            "geometry.window",
        ),
        ({"geometry.points": [[140, 440], [160, 440], [180, 460], [220, 460]]}, "little-room", "room for the run-out", "geometry.window"),
        (
            {"coupling.softening": {"slip_at_peak": 1e-3, "width": 2.9}},
            "short-process-zone",
            "width over which slip is averaged is narrow",
            "coupling.softening.width",
        ),
        ({"motion.frequency": 60.0}, "short-waves", "shear waves of 60.1 Hz are too short", "numerics.spacing"),
        ({"duration": 8.0}, "motion-cut-off", "ends before the motion does", "duration"),
        ({"numerics.time_step": 1.25e-3}, "time-step", "time step is near or above its limit", "numerics.adaptive_step"),
        ({"motion.amplitude": 22.0}, "pga-implausible", "horizontal peak acceleration of the ground is implausible", "motion.amplitude"),
        ({"motion.amplitude": 0.06}, "pga-implausible", "horizontal peak acceleration of the ground is implausible", "motion.amplitude"),
        ({"motion.frequency": 15.0}, "sparse-series", "series have too few samples", "outputs.series_interval"),
        ({"walls.layers": 1}, "thin-box", "do not fill the kernel", "walls.layers=2"),
        (
            {"geometry.points": [[100, 440], [160, 440], [180, 460], [220, 460], [300, 430]], "geometry.base": 420},
            "other-slope",
            "falls further to the right than to the left",
            "geometry.downhill=right",
        ),
        ({"geometry.base": 437.0}, "thin-layer", "soil is thin", "numerics.spacing"),
        ({"layers": {"clay": {"region": {"kind": "depth", "top": 3.0, "bottom": 5.0}}}}, "thin-layer", "clay is thin", "numerics.spacing"),
    ],
)
def test_a_warning_says_what_is_measured_and_wanted_and_the_key(settings: dict[str, Any], code: str, what: str, key: str) -> None:
    (one,) = [each for each in found(**settings) if what in words(each).what]
    assert one.code == code and one.severity == "warning"
    assert key in words(one).key and words(one).measured and words(one).wanted
    assert all(part in line(one) for part in (*words(one), one.code, one.severity)) and 0.0 < one.off_by <= 1.0


def test_shaking_that_shears_off_level_ground_is_told() -> None:
    # 30 m of soil behind the crest, its lowest particles 29.5 m deep: c / (rho z) + g tan(phi), 1964 kg/m3, 150 kPa, 20 degrees.
    limit = 150e3 / (1964.0 * 29.5) + GRAVITY * np.tan(np.radians(20.0))

    def told(factor: float, **settings: Any) -> list[Finding]:
        shaken = findings(scene(**{"motion.amplitude": factor * limit}, **settings))
        return [each for each in shaken if each.code == "level-ground-fails"]

    assert told(0.99) == [] and len(told(1.01)) == 1
    assert words(told(1.01)[0]).measured == f"{in_both(1.01 * limit)}, where {in_both(limit)} is enough at a depth of 29.5 m"
    # A weak layer is sheared before the base is.
    clay = {"clay": {"region": {"kind": "elevation", "bottom": 445.0, "top": 450.0}, "soil": {"cohesion": 40.0, "friction_angle": 0.0}}}
    (weak,) = told(0.9, layers=clay)
    assert words(weak).measured.endswith("is enough at a depth of 14.5 m") and weak.severity == "note"


def test_whole_rows_have_to_make_the_height_of_a_slope_between_level_ground() -> None:
    def misfit(spacing: float, **settings: Any) -> float:
        slope = scene(**{"numerics.spacing": spacing}, **settings)
        return height_error(slope)

    # Toe and crest lie 10 and 30 m above the base: rows of 0.75 m end at 9.75 and 30 m, those of 1.6 m at 9.6 and 30.4 m.
    assert misfit(1.0) == pytest.approx(0.0, abs=1e-9) and misfit(20.0 / 24) == pytest.approx(0.0, abs=1e-9)
    assert misfit(0.75) == pytest.approx(0.0125) and misfit(1.6) == pytest.approx(0.04)
    (one,) = [each for each in found(**{"numerics.spacing": 0.75}) if each.code == "rows-misfit"]
    assert words(one).measured == "20.25 m for 20 m (+1.2%)" and "a spacing of 0.7407 m" in words(one).wanted
    # A slope that stands on the model's base, without soil before its toe.
    bare = {"shape": "slope", "slope_height": 20.0, "base_depth": 0.0, "apron_length": 40.0, "crest_length": 40.0}
    assert misfit(1.0, geometry=bare) == pytest.approx(0.0, abs=1e-9) and misfit(1.5, geometry=bare) == pytest.approx(-0.025)
    # Ground behind the crest that rises by a quarter of a spacing: 1 m divides the 20 m, and most columns have a row too many all the same.
    rising = {"points": [[100, 442.3], [160, 442.3], [180, 462.3], [190, 462.54], [260, 462.54]]}
    rising |= {"toe_at": [160, 442.3], "crest_at": [180, 462.3]}
    keys = {f"geometry.{name}": value for name, value in rising.items()}
    assert misfit(1.0, **keys) == pytest.approx(0.0221, abs=1e-4)
    (one,) = [each for each in found(**keys) if each.code == "rows-misfit"]
    assert one.numbers["spacing"] == pytest.approx(20.0 / 21) and abs(misfit(20.0 / 21, **keys)) <= MAX_HEIGHT_ERROR
    # Ground that slopes is met by steps, some too high and some too low.
    gentle = {"points": [[100, 436], [160, 442], [180, 462], [260, 472]], "toe_at": [160, 442], "crest_at": [180, 462]}
    assert misfit(0.75, **{f"geometry.{name}": value for name, value in gentle.items()}) == 0.0


def test_shapes_without_a_slope_have_no_toe_to_warn_of() -> None:
    block = {"shape": "block", "width": 30.0, "height": 20.0}
    assert found(geometry=block) == []


RICKER = {"kind": "ricker", "amplitude": 1, "frequency": 4, "peak": 6}


@pytest.mark.parametrize(("motion", "frequency"), [({"kind": "none"}, 0.0), (RICKER, 6.6)])
def test_highest_frequency(motion: dict[str, Any], frequency: float) -> None:
    assert highest_frequency(scene(motion=motion)) == pytest.approx(frequency, abs=0.3)


def test_the_highest_frequency_does_not_depend_on_the_samples_of_the_run() -> None:
    # 20 Hz at every 0.025 s of a long run would be nothing at all.
    settings = {"duration": 5000.0, "motion.frequency": 20.0, "outputs.frame_interval": 25.0, "outputs.series_interval": 0.05}
    assert highest_frequency(scene(**settings)) == pytest.approx(20.1, abs=0.2)
    record = {"kind": "record", "start": 3.0, "data": {"interval": 0.01, "x": np.sin(2 * np.pi * 20 * np.arange(0, 5, 0.01)).tolist()}}
    assert highest_frequency(scene(motion=record, **{"duration": 5000.0, "outputs.frame_interval": 25.0})) == pytest.approx(20.1, abs=0.2)
    assert highest_frequency(scene(**{"duration": 3.0})) == 0.0, "the run ends before the motion"
    assert highest_frequency(scene(motion={"kind": "constant", "amplitude": 1.0, "start": 3.0, "ramp": 0.0})) == 0.0


def test_the_peak_acceleration_is_shown_and_told_where_it_is_implausible(tmp_path: Path) -> None:
    # A record in g that is read as m/s2 beside one that is 9.81 times too large.
    (tmp_path / "a.csv").write_text("t,a (m/s2)\n" + "\n".join(f"{0.01 * n},{353.0 * np.sin(0.1 * n)}" for n in range(600)))
    motion = {"kind": "record", "file": "a.csv", "start": 3.0}
    file = tmp_path / "own.yaml"
    file.write_text(yaml.safe_dump(SOUND | {"motion": motion}))
    for command, *shown in (("check", "PGA "), ("info", "PGA "), ("motion", "(PGA)"), ("newmark", "peak ground acceleration")):
        result = call(command, file, *(["--ay", "1 m/s2"] if command == "newmark" else []))
        assert all(word in result.output for word in (*shown, "36 g (", "warning", "is implausible", "should be 0.01 to 2 g")), (
            result.output
        )
    for command in (("motion",), ("newmark", "--ay", "1m/s2")):
        assert "is implausible" in call(command[0], tmp_path / "a.csv", *command[1:]).stderr
    assert "PGA" in call("check", file, "--set", "motion.amplitude=3").stdout
    assert "is implausible" not in call("check", file, "--set", "motion.amplitude=3").stdout


def test_a_wave_of_eight_smoothing_lengths_travels_some_9_percent_too_slowly() -> None:
    for ratio in (1.3, 2.3):
        made = scene(**{"numerics.smoothing_ratio": ratio})
        speed = made.soil.s_wave_speed
        frequency = speed / (MIN_IN_WAVE * ratio)
        assert in_wave(made, made.soil, frequency) == pytest.approx(MIN_IN_WAVE)
        assert 0.08 < 1.0 - wave_speed_ratio(made, speed / frequency) < 0.10
    assert wave_speed_ratio(scene(), 1000.0) == pytest.approx(1.0, abs=0.02)


def test_the_table() -> None:
    clay = {"clay": {"region": {"kind": "depth", "top": 3.0, "bottom": 5.0}}}
    one, layered = check(scene()), check(scene(layers=clay))
    needed = dict(rows(layered))["rows in clay"]
    assert needed.startswith("2 in 2 m; 4 are needed, with a spacing of at most 0.5 m, with which a run takes ")
    assert not [name for name, _ in rows(one) if name.startswith("rows")]
    text = dict(rows(one))
    assert "toe (160, 440) m, crest (180, 460) m, 20 m high, 1 : 1" in text["slope"]
    assert text["kernel radius"].startswith("2.6 m")
    ((name, count, *_),) = layer_rows(one)
    assert name == "soil" and int(count.replace(",", "")) == one.particles.n_soil
    assert min(limit.seconds for limit in limits(one.scene)) > one.scene.numerics.time_step


def test_the_command_draws_and_warns(tmp_path: Path) -> None:
    file, picture = tmp_path / "own.yaml", tmp_path / "own.png"
    file.write_text(yaml.safe_dump(SOUND))
    shown = call("check", file, "--set", "duration=8", "--plot", picture)
    assert shown.exit_code == 0, shown.output
    assert "warning: the run ends before the motion does: 8 s, should be more than 10 s" in shown.stdout
    assert picture.read_bytes().startswith(b"\x89PNG")
    assert "no warnings" in call("check", file).stdout
    data = json.loads(call("check", file, "--set", "duration=8", "--json").stdout)
    assert [(one["code"], one["severity"], one["key"]) for one in data["findings"]] == [
        ("motion-cut-off", "warning", "duration"),
        ("no-process-zone", "note", "coupling.softening"),
        ("block-not-rigid", "note", ""),
    ]
    assert data["findings"][0]["numbers"] == {"value": 8.0, "bound": 10.0}
    assert call("check", file, "--set", "geometry.base=445").exit_code == REFUSED
    assert call("check", file, "--plot", tmp_path / "nowhere" / "own.png").exit_code == REFUSED


def test_the_alternatives_of_a_study_are_checked_as_well(tmp_path: Path) -> None:
    file, study = tmp_path / "sound.yaml", tmp_path / "study.yaml"
    file.write_text(yaml.safe_dump(SOUND))
    seam = {"region": {"kind": "elevation", "bottom": 500.0, "top": 501.0}, "soil": {"cohesion": 5.0}}
    alternatives = {"stiffer": {"soil": {"cohesion": 200.0}}, "grouted": {"layers": {"seam": seam}}}
    study.write_text(yaml.safe_dump({"alternatives": alternatives}))
    told = call("check", file, "--configfile", study).stdout.splitlines()
    assert "no warnings" in told and "stiffer: no further warnings" in told
    own = next(said for said in told if said.startswith("factor of safety"))
    stronger = next(said for said in told if said.startswith("stiffer: note: limit equilibrium"))
    factor, more = (float(re.search(r"Spencer (\d+\.\d+)", said)[1]) for said in (own, stronger))  # type: ignore[index]
    assert more > 1.2 * factor, "each has its own"
    assert any(said.startswith("grouted: error: no particle lies in seam") for said in told)
    study.write_text(yaml.safe_dump({"alternatives": {"odd": {"soil": {"cohesion": -1.0}}}}))
    refused = call("check", file, "--configfile", study)
    assert refused.exit_code == REFUSED and "alternatives.odd: " in refused.stderr and "soil.cohesion" in refused.stderr


def test_a_study_alone_is_checked_with_its_scene_and_fidelities(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    Path("sound.yaml").write_text(yaml.safe_dump(SOUND))
    fidelities = {"draft": {"numerics": {"spacing": 2.0}}, "own": {}, "unused": {"duration": 8.0}}
    study = {"study": "own", "scene": "sound.yaml", "fidelity": "own", "second_fidelity": "draft", "fidelities": fidelities}
    Path("study.yaml").write_text(yaml.safe_dump(study | {"grid": {"amplitude": ["1.0"]}}))
    for asked in (["study.yaml"], ["--configfile", "study.yaml"]):
        told = call("check", *asked).stdout
        assert "no warnings" in told and "fidelity draft: warning: " in told and "unused" not in told
    missing, other = call("check"), call("info", "study.yaml")
    assert missing.exit_code == REFUSED and "a study, which names its scene" in missing.stderr
    assert other.exit_code == REFUSED and other.stderr.endswith("is a study, where a scene is asked for: give its scene, sound.yaml\n")


@pytest.mark.long
def test_alternatives_are_checked_at_the_fidelities_that_run(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A layer that is thin at the first and broken at the second; what is found at both is told once, of the first."""
    monkeypatch.chdir(tmp_path)
    Path("sound.yaml").write_text(yaml.safe_dump(SOUND))
    clay = {"region": {"kind": "elevation", "bottom": 433.0, "top": 434.5}}
    study = {
        "study": "own",
        "scene": "sound.yaml",
        "alternatives": {"cut": {"layers": {"clay": clay}}, "stiffer": {"soil": {"cohesion": 200.0}}},
    }
    study |= {"fidelity": "fine", "grid": {"amplitude": ["1.0"]}}
    spacings = {"fine": {}, "draft": {"numerics": {"spacing": 2.0}}}

    def told(**keys: Any) -> list[str]:
        Path("study.yaml").write_text(yaml.safe_dump(study | {"fidelities": spacings} | keys))
        lines = call("check", "study.yaml").stdout.splitlines()
        return [said.partition("[")[0] + said.rpartition("[")[2] for said in lines if said.startswith(("cut", "stiffer"))]

    def codes(lines: list[str]) -> list[tuple[str, str]]:
        return [(said.split(": ")[0], said.rpartition(" ")[2].removesuffix("]")) for said in lines if "limit-equilibrium" not in said]

    nothing = ("stiffer", "warnings")
    assert codes(told()) == [("cut", "thin-layer"), nothing]
    assert codes(told(second_fidelity="draft")) == [("cut", "thin-layer"), nothing, ("cut at fidelity draft", "layer-broken")]
    first = codes(told(fidelity="draft"))
    assert first == [("cut at fidelity draft", "layer-broken"), ("stiffer at fidelity draft", "warnings")]


def test_static_tests_are_offered_and_made_of_alternatives_as_well(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    file, study = tmp_path / "sound.yaml", tmp_path / "study.yaml"
    file.write_text(yaml.safe_dump(SOUND))
    study.write_text(yaml.safe_dump({"alternatives": {"stiffer": {"soil": {"cohesion": 200.0}}}}))
    assert re.search(r"--stability tests it, in about \d+ (s|min)", call("check", file, "--configfile", study).stdout.splitlines()[-1])
    monkeypatch.setattr("sph.command.check.stability", lambda scene: [])
    monkeypatch.setattr(
        "sph.command.check.standing", lambda scene: [finding("stands-unshaken", spacing=scene.soil.cohesion, run_spacing=1.0)]
    )
    lines = call("check", file, "--configfile", study, "--stability").stdout.splitlines()
    (tested,) = [said for said in lines if "stands-unshaken" in said]
    assert tested.startswith("stiffer: ") and "at a spacing of 200 m" in tested and not any("--stability" in said for said in lines)


def test_the_motions_of_a_study_are_told_as_they_are_used(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Each at its least and largest amplitude, with what is new of it; the scene's own is not run."""
    monkeypatch.chdir(tmp_path)
    Path("sound.yaml").write_text(yaml.safe_dump(SOUND))
    grid = {"amplitude": ["2.0", "1.0"], "motion.frequency": ["2.0", "60.0"]}
    Path("study.yaml").write_text(yaml.safe_dump({"study": "own", "scene": "sound.yaml", "grid": grid}))
    told = json.loads(call("check", "study.yaml", "--json").stdout)
    slow, fast = "frequency of the motion 2.0 Hz", "frequency of the motion 60.0 Hz"
    assert told["rows"][f"PGA of {slow}"] == "horizontal 1 m/s2 (0.102 g) to horizontal 2 m/s2 (0.204 g)"
    assert "PGA" not in told["rows"] and told["motions"][slow] == []
    assert "short-waves" in {each["code"] for each in told["motions"][fast]}


def test_levels_of_a_record_keep_their_unit(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """0.1g is 0.981 m/s2, which without a unit might be meant in g; ``sph check`` of a study refused it."""
    monkeypatch.chdir(tmp_path)
    Path("quake.csv").write_text("time (s),ax (m/s2)\n" + "\n".join(f"{0.02 * n:.2f},{1.5 * math.sin(0.3 * n):.4f}" for n in range(100)))
    shaken = SOUND | {"duration": 6.0, "motion": {"kind": "record", "file": "quake.csv", "start": 3.0, "baseline": {}}}
    Path("sound.yaml").write_text(yaml.safe_dump(shaken))
    grid = {"amplitude": ["0.1g", "0.2g"], "motion.factor": ["1", "-1"]}
    Path("study.yaml").write_text(yaml.safe_dump({"study": "own", "scene": "sound.yaml", "grid": grid}))
    checked = call("check", "study.yaml", "--json")
    assert checked.exit_code == 0, checked.output
    assert all("0.981 m/s2" in said for name, said in json.loads(checked.stdout)["rows"].items() if name.startswith("PGA of"))


def test_the_alternatives_are_drawn_below_the_scene_as_it_is() -> None:
    figure = draw([check(scene()), check(scene(**{"soil.cohesion": 60.0}))], names=["", "more_cement"])
    assert [part.axes[0].get_title(loc="left") for part in figure.subfigs] == ["sound", "more cement"]


def test_soil_with_a_name_is_called_by_it() -> None:
    fast = {"motion.frequency": 60.0}
    (plain,), (named,) = (
        [each for each in findings(scene(**fast, **name)) if each.code == "short-waves"] for name in ({}, {"soil.name": "tuff"})
    )
    assert words(plain).what.endswith("in soil") and words(named).what.endswith("in tuff") and named.keys == plain.keys


def test_the_command_draws_the_places_of_a_study(tmp_path: Path) -> None:
    file, study, picture = tmp_path / "own.yaml", tmp_path / "study.yaml", tmp_path / "own.png"
    file.write_text(yaml.safe_dump(SOUND))
    study.write_text(yaml.safe_dump({"study": "own", "metrics": {"places": {"road": "12 beyond the toe"}}}))
    loaded = scene()
    assert places_of(study, loaded) == {"road": "12 beyond the toe"}
    assert "road" in {text.get_text() for text in draw([check(loaded)], study).axes[0].texts}
    assert call("check", file, "--plot", picture, "--configfile", study).exit_code == 0 and picture.exists()
    study.write_text(yaml.safe_dump({"metrics": {"places": {"road": "1200 beyond the toe"}}}))
    refused = call("check", file, "--configfile", study)
    assert refused.exit_code == REFUSED and "metrics.places.road: '1200 beyond the toe': must lie within the model" in refused.output
    study.write_text("study: own\n")
    assert places_of(study, loaded) == {}


@pytest.mark.parametrize("spacing", [1.0, 0.5])
def test_the_drawing_shows_the_survey_and_its_layers(spacing: float) -> None:
    clay = {"clay": {"region": {"kind": "elevation", "top": 438.0}}}
    one = check(scene(**{"numerics.spacing": spacing, "numerics.time_step": 1e-4, "layers": clay}))
    n = one.particles.n_soil
    assert (n > FEW) == (spacing == 0.5), "both ways of drawing"
    layer = one.particles.layer[:n]
    assert 0 < np.count_nonzero(layer) < n
    figure = draw([one])
    FigureCanvasAgg(figure).draw()
    texts = "\n".join(text.get_text() for text in figure.findobj(matplotlib.text.Text))
    for word in ("soil", "clay", "elevation (m)", "toe", "crest", "H = 20 m", "A", "160", "440"):
        assert word in texts
    ax = figure.axes[0]
    if n > FEW:
        image = np.ma.masked_invalid(ax.images[0].get_array())
        assert (image.count(), image.sum()) == (n, layer.sum())
    else:
        assert np.array_equal(ax.collections[-1].get_array(), layer)


def test_axes_of_a_slope_that_falls_to_the_right_decrease() -> None:
    turned = [[320 - x, y] for x, y in SOUND["geometry"]["points"]]
    figure = draw([check(scene(**{"geometry.points": turned, "geometry.downhill": "right"}))])
    FigureCanvasAgg(figure).draw()
    ticks = [float(tick.get_text()) for tick in figure.axes[0].get_xticklabels()]
    assert len(ticks) > 3 and ticks == sorted(ticks, reverse=True)
    places = {label: place for label, place in zip(ticks, figure.axes[0].get_xticks(), strict=True)}
    assert all(place == pytest.approx(220 - label) for label, place in places.items())


STEEP: dict[str, Any] = {
    "geometry.points": [[100, 440], [120, 440], [130, 450], [150, 450]],
    "geometry.base": 435,
    "motion": {"kind": "none"},
}
"""A slope of 1 : 1, 10 m high."""


def test_a_slope_that_does_not_stand_is_told_before_any_search() -> None:
    (fails,) = stability(scene(**STEEP, **{"soil.cohesion": 2.0, "numerics.spacing": 1.0}))
    assert (fails.code, fails.severity) == ("fails-unshaken", "error")
    assert words(fails).what == "the slope does not stand without shaking, so its failure is not due to the earthquake"


@pytest.mark.long
def test_the_stability_of_a_slope_is_that_of_limit_analysis() -> None:
    told = {
        each.code: each
        for each in stability(scene(**STEEP, **{"soil.cohesion": 25.0, "soil.friction_angle": 20.0, "numerics.spacing": 0.75}))
    }
    quick = ["limit-equilibrium", "limit-equilibrium-differs"]  # of soil that does not dilate
    named = [
        "stands-unshaken",
        "mobilised-strength",
        "fails-at-residual",
        "limit-equilibrium-residual",
        "factor-of-safety",
        "yield-acceleration",
        *quick,
    ]
    assert list(told) == named[: len(told)] and "limit-equilibrium" in told
    # Soil that does not dilate is some per cent weaker than limit analysis says.
    assert told["factor-of-safety"].numbers["value"] == pytest.approx(limit_factor(45.0, 10.0, 1964.0 * GRAVITY, 25e3, 20.0, 5.0), rel=0.08)
    assert 0.1 < told["yield-acceleration"].numbers["value"] / GRAVITY < 0.6
