"""A record as the motion of a scene: found, embedded, processed, scaled, refused."""

from __future__ import annotations

import json
import os
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml
from calling import call
from record_files import at2, knet
from small_scenes import SLOPE

from sph.experiments.registry import load_study
from sph.page.tables import key_rows
from sph.scene.configuration import merge, read_scene, scene_files
from sph.scene.ground_motion.measures import measure
from sph.scene.ground_motion.record import processed
from sph.scene.ground_motion.spectrum import pseudo_acceleration
from sph.scene.ground_motion.titles import record_title
from sph.scene.loading import make_loading, motion_of
from sph.scene.motion import reference_amplitude
from sph.scene.schema import Scene, load_scene, make_scene, stored_scene
from sph.stability.newmark import sliding_block
from sph.study.baseline import newmark_factor

INTERVAL = 0.005
TIME = np.arange(400) * INTERVAL
BURST = 3.0 * np.sin(2 * np.pi * 4.0 * TIME) * np.sin(np.pi * TIME / 2.0) ** 2
PROCESSED = {"baseline": {}, "band_pass": {"low": 0.5, "high": 50.0}, "trim": {}, "resample": {"interval": 0.01}}
ROUNDING = 2e-6
"""AT2 has seven digits of g."""
VERTICAL = {"file": "records/v.AT2"}


def shaken(**motion: Any) -> dict[str, Any]:
    return SLOPE | {"motion": {"kind": "record", "start": 1.0} | motion}


def written(folder: Path, **motion: Any) -> Path:
    path = folder / "slope.yaml"
    path.write_text(yaml.safe_dump(shaken(file="records/h.AT2", **motion)))
    return path


def test_the_record_lies_beside_the_scene_and_acts_from_its_start_on(records: Path) -> None:
    scene = load_scene(written(records, vertical=VERTICAL))
    loading = make_loading(scene)
    wanted = np.interp(loading.time - 1.0, TIME, BURST, left=0.0, right=0.0)
    np.testing.assert_allclose(loading.ground, wanted, atol=ROUNDING)
    np.testing.assert_allclose(loading.vertical, -0.5 * wanted, atol=ROUNDING)
    assert (scene.motion.start, scene.motion.end) == (1.0, pytest.approx(1.0 + TIME[-1]))
    assert not make_loading(load_scene(written(records))).vertical.any(), "no vertical shaking unless it is wanted"


def test_a_record_of_the_same_size_and_date_is_read_anew(records: Path) -> None:
    """As ``cp -p`` leaves it, within one process."""
    path, record = written(records), records / "records" / "h.AT2"
    before = motion_of(load_scene(path)).peak
    size = record.stat().st_size
    record.write_text(at2(2.0 * BURST, INTERVAL))
    assert record.stat().st_size == size
    for file in (record, records / "records" / "v.AT2"):
        os.utime(file, (1e9, 1e9))
    assert motion_of(load_scene(path)).peak == pytest.approx(2.0 * before, rel=1e-5)
    record.write_text(at2(BURST, INTERVAL))
    os.utime(record, (1e9, 1e9))
    assert motion_of(load_scene(path)).peak == before


def test_the_record_lies_in_the_working_folder(records: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (records / "scenes").mkdir()
    monkeypatch.chdir(records)
    np.testing.assert_allclose(motion_of(load_scene(written(records / "scenes"))).peak, np.abs(BURST).max(), atol=ROUNDING)


def test_a_record_is_called_as_its_file_says_or_the_scene(records: Path, tmp_path: Path) -> None:
    assert load_scene(written(records)).motion.name == "Made, 1/1/2000, Nowhere, 0"
    assert load_scene(written(records, name="Kobe 1995, KJMA")).motion.name == "Kobe 1995, KJMA"
    esm = "EVENT_NAME: \nEVENT_DATE_YYYYMMDD: 20161030\nSTATION_CODE: NRC\nSTATION_NAME: NORCIA\nSTREAM: HGE\n"
    for text, title in {
        knet(BURST, 100): "2000/01/01 00:00:00, AKT013, E-W",
        esm: "20161030, NORCIA, HGE",
        "# record: Imperial Valley 1940, El Centro\ntime (s), ax (g)\n0,0\n": "Imperial Valley 1940, El Centro",
        "time (s), ax (g)\n0,0\n": None,
    }.items():
        (tmp_path / "one.txt").write_text(text)
        assert record_title(tmp_path / "one.txt") == title


def test_a_validated_scene_needs_no_file(records: Path) -> None:
    # A trajectory holds its scene as JSON and is repeated from it.
    scene = load_scene(written(records, vertical=VERTICAL, trim={}))
    text = scene.model_dump_json()
    assert str(records) not in text and '"file":"h.AT2"' in text and '"file":"v.AT2"' in text
    for name in ("h", "v"):
        (records / "records" / f"{name}.AT2").unlink()
    again = make_scene(json.loads(text))
    assert again == scene == Scene.model_validate_json(text)
    for one, other in zip(make_loading(scene), make_loading(again), strict=True):
        np.testing.assert_array_equal(one, other)


def test_a_scene_with_samples_names_no_folder(records: Path) -> None:
    # A validated scene in a file beside a record of the name: what it holds counts.
    path = written(records)
    scene = load_scene(path)
    (records / "h.AT2").write_text(at2(9.0 * BURST, INTERVAL))
    path.write_text(yaml.safe_dump(scene.model_dump(mode="json")))
    assert load_scene(path) == scene
    assert str(records) not in load_scene(path).model_dump_json()
    key, text, *_ = next(row for row in key_rows(scene) if row[0] == "motion.data.x")
    assert text == "400 values", "the page counts the samples"


def test_a_record_that_has_changed_is_read_again(records: Path) -> None:
    path = written(records)
    assert motion_of(load_scene(path)).peak == pytest.approx(np.abs(BURST).max())
    (records / "records" / "h.AT2").write_text(at2(2.0 * BURST[:300], INTERVAL))
    assert motion_of(load_scene(path)).peak == pytest.approx(2.0 * np.abs(BURST).max())


@pytest.mark.parametrize("factor", [1.0, -1.0])
@pytest.mark.parametrize("sections", [{}, PROCESSED])
def test_the_amplitude_is_the_horizontal_peak_after_processing(records: Path, sections: dict[str, Any], factor: float) -> None:
    as_recorded = processed(load_scene(written(records, vertical=VERTICAL, **sections)).motion)
    scaled = processed(load_scene(written(records, vertical=VERTICAL | {"factor": 2.0}, amplitude=7.0, factor=factor, **sections)).motion)
    ratio = factor * 7.0 / np.abs(as_recorded.horizontal).max()
    assert np.abs(scaled.horizontal).max() == pytest.approx(7.0, rel=1e-12)
    np.testing.assert_allclose(scaled.horizontal, ratio * as_recorded.horizontal, rtol=1e-12)
    np.testing.assert_allclose(scaled.vertical, 2.0 * ratio * as_recorded.vertical, rtol=1e-12)


def test_a_record_is_scaled_to_any_intensity(records: Path) -> None:
    def horizontal(**keys: Any) -> np.ndarray:
        return processed(load_scene(written(records, **keys)).motion).horizontal

    assert measure(horizontal(peak_velocity=0.3), INTERVAL).peak_velocity == pytest.approx(0.3, rel=1e-9)
    assert measure(horizontal(arias_intensity=1.7), INTERVAL).arias_intensity == pytest.approx(1.7, rel=1e-9)
    wanted = horizontal(spectral_acceleration={"period": 0.5, "value": 4.0}, factor=-1.0)
    assert pseudo_acceleration(wanted, INTERVAL, np.array([0.5]))[0] == pytest.approx(4.0, rel=1e-9)
    assert wanted @ BURST < 0.0, "the factor turns it round"
    assert not horizontal(arias_intensity=0.0).any()


def test_a_factor_and_no_amplitude(records: Path) -> None:
    np.testing.assert_allclose(processed(load_scene(written(records, factor=-2.0)).motion).horizontal, -2.0 * BURST, atol=2 * ROUNDING)
    assert not processed(load_scene(written(records, amplitude=0.0)).motion).horizontal.any()


@pytest.mark.parametrize("samples", [200, 399, 401, 600])
def test_components_of_other_lengths_are_cut_or_padded_where_a_key_says_so(records: Path, samples: int) -> None:
    vertical = np.resize(BURST, samples)
    (records / "records" / "v.AT2").write_text(at2(vertical, INTERVAL))
    with pytest.raises(ValueError, match=rf"v.AT2: holds {samples} samples, .*h.AT2 400; set vertical.unequal_length to cut, .* or to pad"):
        load_scene(written(records, vertical=VERTICAL))
    for how, length in (("cut", min(samples, 400)), ("pad", max(samples, 400))):
        data = load_scene(written(records, vertical=VERTICAL | {"unequal_length": how})).motion.data
        for found, recorded in ((data.x, BURST), (data.y, vertical)):
            np.testing.assert_allclose(found, np.pad(recorded, (0, max(0, length - recorded.size)))[:length], atol=ROUNDING)


def test_a_gap_is_named_where_it_is(records: Path) -> None:
    """Samples 0.005 s apart, of which those from 0.5 to 0.6 s and one more are missing."""
    times = np.delete(TIME, [*range(100, 120), 300])
    (records / "gap.csv").write_text("t (s),a (m/s2)\n" + "\n".join(f"{time:.3f},1" for time in times))
    message = (
        r"gap.csv: has a gap of 0.105 s between sample 100, at 0.495 s, and the next, at 0.6 s, and 1 more behind it; .* 0.005 s apart"
    )
    with pytest.raises(ValueError, match=message):
        make_scene(shaken(file=str(records / "gap.csv")))
    for command in (["motion"], ["newmark", "--ay", "1m/s2"]):
        result = call(command[0], records / "gap.csv", *command[1:])
        assert result.exit_code == 2 and "has a gap of 0.105 s between sample 100" in result.stderr


KIK_NET = {str(channel): (f"{name}{1 if channel < 4 else 2}", channel) for channel, name in enumerate(2 * ("NS", "EW", "UD"), 1)}


@pytest.mark.parametrize(("direction", "ending", "channel"), [(direction, *each) for direction, each in KIK_NET.items()])
@pytest.mark.parametrize("plain", [False, True], ids=["own ending", ".knet"])
def test_the_directions_of_kik_net(records: Path, direction: str, ending: str, channel: int, plain: bool) -> None:
    """1 to 3 are NS, EW and UD of the borehole, 4 to 6 those of the surface."""
    path = records / f"ABSH060001010000.{'knet' if plain else ending}"
    path.write_text(knet(BURST[::2], 100, direction=direction))
    if channel in (3, 6):
        with pytest.raises(ValueError, match="vertical component"):
            make_scene(shaken(file=str(path)))
        beside = records / f"a.{'NS1' if channel == 3 else 'NS2'}"
        beside.write_text(knet(BURST[::2], 100, direction=str(channel - 2)))
        assert make_scene(shaken(file=str(beside), vertical={"file": str(path)})).motion.data.y is not None
        other = records / f"b.{'NS2' if channel == 3 else 'NS1'}"
        other.write_text(knet(BURST[::2], 100, direction="4" if channel == 3 else "1"))
        with pytest.raises(ValueError, match=r"vertical.file: .*was recorded in the borehole, .* was not"):
            make_scene(shaken(file=str(other), vertical={"file": str(path)}))
        return
    scene = shaken(file=str(path))
    assert (make_scene(scene).motion.data.instrument == "borehole") == (channel < 4)
    absorbing = merge(scene, {"walls": {"base": "absorbing", "layers": 4}, "gravity": {"initial_stress": "geostatic", "ramp": 0.0}})
    if channel < 4:
        for data in (absorbing, merge(absorbing, {"motion": json.loads(make_scene(scene).motion.model_dump_json())})):
            with pytest.raises(ValueError, match=r"recorded in a borehole.*walls.base: absorbing.*surface \(.EW2, .NS2\).*no_slip"):
                make_scene(data)
    else:
        assert make_scene(absorbing).motion.data.instrument is None


@pytest.mark.parametrize("direction", ["7", "0", "X", ""])
def test_no_direction_of_k_net(records: Path, direction: str) -> None:
    (records / "k.knet").write_text(knet(BURST[::2], 100, direction=direction))
    with pytest.raises(ValueError, match=r"k.knet, line 13: must be a direction, N-S, E-W, U-D or 1 to 6"):
        make_scene(shaken(file=str(records / "k.knet")))


def test_the_peak_in_a_head_of_k_net_is_that_of_its_samples(records: Path) -> None:
    text = knet(BURST[::2], 100, offset=20_000)
    peak = next(line for line in text.split("\n") if line.startswith("Max. Acc."))
    (records / "k.EW").write_text(text.replace(peak, "Max. Acc. (gal)   29.900"))
    with pytest.raises(ValueError, match=r"k.EW, line 15: the head states a peak of 0.299 m/s2, its samples have 2"):
        make_scene(shaken(file=str(records / "k.EW")))


def test_a_trajectorys_record_is_replaced_by_another_file(records: Path) -> None:
    # What `sph run old.nc --set motion.file=...` does: the samples of the old one must not stay.
    import xarray as xr

    from sph.command.given import read_given
    from sph.storage.trajectory import run_attributes

    earlier = xr.Dataset(attrs=run_attributes(load_scene(written(records))))
    other = records / "other.AT2"
    other.write_text(at2(2.0 * BURST, INTERVAL))
    assert read_given(records / "old.nc", {}, earlier)[0].motion.peak == pytest.approx(np.abs(BURST).max())
    assert read_given(records / "old.nc", {"motion": {"file": str(other)}}, earlier)[0].motion.peak == pytest.approx(
        2 * np.abs(BURST).max()
    )


BAD: list[tuple[dict[str, Any], list[str]]] = [
    ({}, ["motion: file: is required"]),
    (
        {"file": "records/h.AT2", "amplitude": 1.0, "peak_velocity": 0.1},
        ["peak_velocity: 0.1 m/s", "amplitude: 1 m/s2"],
    ),
    ({"file": "records/h.AT2", "arias_intensity": 1.0, "factor": 2.0}, ["factor: 2 with arias_intensity: 1 m/s"]),
    ({"file": "absent.at2"}, ["motion: file: 'absent.at2'", "No such file"]),
    ({"file": "records"}, ["records", "is a folder; name a file"]),
    ({"file": "a\0b"}, ["motion: file: ", "null"]),
    ({"file": ""}, ["motion.file: ", "at least 1"]),
    ({"file": 3}, ["motion.file: ", "string", "3"]),
    ({"file": "records/h.AT2", "unit": "furlong"}, ["motion.unit: ", "'m/s2'", "furlong"]),
    ({"file": "records/h.AT2", "unit": "gal"}, ["h.AT2", "contradicts"]),
    ({"file": "records/h.AT2", "vertical": {}}, ["motion: vertical: ", "third column"]),
    ({"file": "records/h.AT2", "vertical": {"file": "absent"}}, ["motion: file: 'absent'", "No such file"]),
    ({"file": "records/h.AT2", "vertical": {"file": "slow.AT2"}}, ["vertical.file", "slow.AT2", "0.02 s", "0.005 s"]),
    ({"file": "records/h.AT2", "vertical": {"file": "late.csv"}}, ["vertical.file", "late.csv: begins at 2 s", "h.AT2 at 0 s"]),
    (
        {"file": "records/h.AT2", "vertical": {"file": "short.AT2"}},
        ["vertical.file", "short.AT2: holds 200 samples", "400", "vertical.unequal_length"],
    ),
    ({"file": "records/h.AT2", "vertical": 3}, ["motion.vertical: "]),
    ({"file": "records/h.AT2", "start": 0.5}, ["motion.start: 0.5 s", "gravity.duration: 1.0 s"]),
    ({"file": "records/h.AT2", "amplitude": 1.0, "factor": 2.0}, ["factor: 2", "amplitude: 1 m/s2", "1 or -1"]),
    ({"file": "still.csv", "amplitude": 1.0}, ["amplitude: 1 m/s2", "is zero throughout"]),
    ({"file": "still.csv", "trim": {}}, ["trim: the record is zero throughout"]),
    ({"file": "uneven.csv"}, ["uneven.csv", "sample 3", "evenly spaced"]),
    ({"file": "records/h.AT2", "band_pass": {"high": 100.0}}, ["band_pass.high: 100 Hz", "100 Hz"]),
    ({"file": "records/h.AT2", "band_pass": {"low": 3.0, "high": 2.0}}, ["motion.band_pass: low: 3 Hz", "high: 2 Hz"]),
    ({"file": "records/h.AT2", "band_pass": {"low": None, "high": None}}, ["motion.band_pass: low and high", "null"]),
    ({"file": "records/h.AT2", "trim": {"start_share": 0.5, "end_share": 0.5}}, ["motion.trim: start_share: 0.5"]),
    ({"file": "records/h.AT2", "resample": {"interval": 0.005 * 2**0.5}}, ["resample.interval: ", "ratio of whole numbers"]),
    ({"data": {"interval": 0.01, "x": [1.0]}}, ["motion.data.x: ", "at least 2"]),
    ({"data": {"interval": 0.01, "x": [1.0, 2.0], "y": [1.0]}}, ["motion.data: ", "y has 1 samples, x has 2"]),
    ({"data": {"interval": 0.01, "x": [1.0, "a"]}}, ["motion.data.x.1: ", "'a'"]),
    ({"data": {"interval": 0.0005, "x": [1.0, 2.0]}}, ["numerics.time_step: 0.001 s", "0.0005 s", "motion.resample.interval"]),
]


@pytest.mark.parametrize(("motion", "words"), BAD, ids=lambda v: ",".join(v) if isinstance(v, dict) else v[0])
def test_bad_sections_are_named(records: Path, motion: dict[str, Any], words: list[str], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(records)
    (records / "slow.AT2").write_text(at2(BURST, 0.02))
    (records / "short.AT2").write_text(at2(BURST[:200], INTERVAL))
    (records / "late.csv").write_text("t,a (m/s2)\n" + "\n".join(f"{t + 2.0:.3f},1" for t in TIME))
    (records / "still.csv").write_text("t,a (m/s2)\n" + "\n".join(f"{t:.3f},0" for t in TIME))
    (records / "uneven.csv").write_text("t,a (m/s2)\n0,1\n0.1,1\n0.12,1\n0.3,1\n")
    with pytest.raises(ValueError) as raised:
        make_scene(shaken(**motion), "some.yaml")
    message = str(raised.value)
    for word in ["some.yaml", *words]:
        assert word in message, f"{word!r} is missing in: {message}"


@pytest.mark.parametrize(("start", "step"), [(1.0, 1e-3), (1.0, 2.5e-3), (1.0, 5e-3), (1.0025, 2.5e-3), (1.0005, 5e-4)])
def test_steps_that_meet_the_samples_feel_the_peak(start: float, step: float) -> None:
    peak = {"interval": 0.005, "x": [0.0, 1.0, -4.0, 1.0, 0.0]}
    scene = make_scene(merge(shaken(data=peak, start=start), {"numerics": {"time_step": step}}))
    assert np.abs(make_loading(scene).ground).max() == pytest.approx(4.0)


@pytest.mark.parametrize(("start", "step", "missed"), [(1.0025, 5e-3, "62.5%"), (1.0, 2e-3 / 1.5, "16.7%")])
@pytest.mark.parametrize("direction", ["x", "y"])
def test_steps_beside_the_samples_are_refused_where_they_miss_the_peak(start: float, step: float, missed: str, direction: str) -> None:
    data = {"interval": 0.005, "x": [0.0] * 5, "y": [0.0] * 5} | {direction: [0.0, 1.0, -4.0, 1.0, 0.0]}
    outputs = {"series_interval": 0.1, "frame_interval": 0.5}
    scene = merge(shaken(data=data, start=start, vertical={}), {"numerics": {"time_step": step}, "outputs": outputs})
    with pytest.raises(ValueError, match=rf"numerics.time_step: .*{missed}.*0.005 s"):
        make_scene(scene)


def test_a_record_that_drifts_is_told(records: Path) -> None:
    (records / "k.EW").write_text(knet(BURST[::2], 100, offset=20_000))
    for arguments, drifts in ((("--set", "motion.baseline={}"), False), ((), True)):
        scene = records / "slope.yaml"
        scene.write_text(yaml.safe_dump(shaken(file="k.EW")))
        for command in (("check",), ("info",), ("motion",), ("newmark", "--ay", "1m/s2")):
            result = call(command[0], scene, *command[1:], *arguments)
            assert ("the record drifts" in result.output) == drifts, result.output
    assert "drifts" in motion(records / "k.EW").stderr
    assert "drifts" in call("newmark", records / "k.EW", "--ay", "1m/s2").stderr


def test_the_sliding_block_says_that_it_feels_no_vertical_component(records: Path) -> None:
    for vertical in (None, VERTICAL):
        result = call("newmark", written(records, vertical=vertical), "--ay", "1m/s2")
        assert result.exit_code == 0 and ("motion.vertical does not act" in result.stderr) == (vertical is not None)


def test_a_record_of_k_net_in_a_scene(records: Path) -> None:
    # The recorder's offset goes with the baseline; without it the ground would run away.
    (records / "k.EW").write_text(knet(BURST[::2], 100, offset=20_000))
    scene = make_scene(shaken(file=str(records / "k.EW"), baseline={"degree": 0}))
    np.testing.assert_allclose(processed(scene.motion).horizontal, BURST[::2], atol=0.02)


# ---------------------------------------------------------------- studies and commands


def study(scene: str) -> dict[str, Any]:
    return {
        "study": "shaken",
        "scene": scene,
        "fidelity": "draft",
        "grid": {"S_R": ["0.10"], "gamma": ["100"], "amplitude": ["2.0", "8.0"]},
        "fidelities": {"draft": {}},
        "figures": {"strengths": ["0.10"], "compared_gammas": ["100"], "compared_strengths": ["0.10"]},
        "claims": {"amplitude": 8.0},
    }


def test_a_study_scales_the_record_and_keeps_its_file(records: Path) -> None:
    plan = load_study(study(str(written(records, vertical=VERTICAL))))
    assert scene_files(plan.scene()) == [str(records / "records" / "h.AT2"), str(records / "records" / "v.AT2")]
    for label in ("2.0", "8.0"):
        mapping = plan.scene(amplitude=label)
        assert "data" not in mapping["motion"] and mapping["motion"]["amplitude"] == float(label)
        assert plan.built(amplitude=label).motion.peak == pytest.approx(float(label))
    assert scene_files(SLOPE) == scene_files(plan.built().model_dump()) == []


def test_the_files_of_a_record_in_an_override_are_looked_for_in_the_working_folder(records: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(records)
    scene = merge(read_scene(written(records)), {"motion": {"file": "records/v.AT2"}})
    assert make_scene(scene).motion.peak == pytest.approx(0.5 * np.abs(BURST).max())


def motion(*arguments: object) -> Any:
    return call("motion", *arguments)


def test_the_command_measures_a_record_and_what_a_scene_makes_of_it(records: Path) -> None:
    found = json.loads(motion(records / "records" / "h.AT2", "--json").stdout)
    assert found["horizontal"]["peak_acceleration"] == pytest.approx(np.abs(BURST).max()) and len(found) == 1
    scene = written(records, vertical=VERTICAL)
    found = json.loads(motion(scene, "--set", "motion.amplitude=6", "--json").stdout)
    assert found["horizontal"]["peak_acceleration"] == pytest.approx(6.0)
    assert found["vertical"]["peak_acceleration"] == pytest.approx(3.0)
    shown = motion(scene, "--plot", records / "m.png")
    assert shown.exit_code == 0 and "Arias" in shown.stdout and (records / "m.png").stat().st_size > 10_000
    assert motion_of(load_scene(scene)).peak == pytest.approx(np.abs(BURST).max())
    assert set(shown.stderr.splitlines()) <= {"sph: reading the motion and measuring it ..."}, "nothing to warn of"
    assert "should be more than 2.995 s" in motion(scene, "--set", "duration=2.5").stderr, "a record that the scene cuts off"


def test_what_the_command_refuses(records: Path) -> None:
    plain = records / "plain.at2"
    plain.write_text(at2(BURST, INTERVAL).replace(" IN UNITS OF G", ""))
    still = records / "still.csv"
    still.write_text("t,a (m/s2)\n0,0\n1,0\n")
    scene = written(records)
    for arguments, word in (
        ((plain,), "does not say its unit"),
        ((plain, "--unit", "feet"), "--unit: 'feet'"),
        ((plain, "--set", "motion.amplitude=2"), "is a record, in which --set has no keys"),
        ((scene, "--unit", "g"), "--unit g"),
        ((still, "--plot", records / "s.png"), "does not move"),
        ((still, "--plot", records / "absent" / "s.png"), "--plot"),
        ((records / "absent.yaml",), "absent.yaml"),
    ):
        result = motion(*arguments)
        assert result.exit_code == 2 and word in result.stderr, result.output
    assert motion(plain, "--unit", "g").exit_code == 0 and motion(still).exit_code == 0


def test_the_sliding_blocks_amplitude_is_that_of_the_record(records: Path) -> None:
    # The amplitude at which the block slips by 5 cm does not depend on how large the record is.
    path = written(records)
    scene, larger = load_scene(path), load_scene(path, {"motion": {"amplitude": 8.0}})
    wanted = newmark_factor(scene, 1.0, 0.05) * reference_amplitude(scene.motion)
    assert newmark_factor(larger, 1.0, 0.05) * 8.0 == pytest.approx(wanted, rel=1e-4)
    block = motion_of(load_scene(path, {"motion": {"amplitude": wanted}}))
    assert sliding_block(block.time, block.acceleration, 1.0).permanent == pytest.approx(0.05, rel=1e-3)


def test_a_folder_and_a_pipe_are_no_records(tmp_path: Path) -> None:
    (tmp_path / "folder.csv").mkdir()
    os.mkfifo(tmp_path / "pipe.csv")  # which would be waited for without end
    for name, what in (("folder.csv", "a folder"), ("pipe.csv", "a device or a pipe")):
        with pytest.raises(ValueError, match=rf"motion: file: .*{name}'.*{what}"):
            make_scene(shaken(file=str(tmp_path / name)))


def test_an_amplitude_that_may_be_meant_in_g_needs_its_unit(records: Path) -> None:
    """The record has 3 m/s2; what is stored has no units, and is read."""
    with pytest.raises(ValueError, match=r"motion.amplitude: 0.35 has no unit.*write 0.35g or '0.35 m/s2'"):
        load_scene(written(records, amplitude=0.35))
    with pytest.raises(ValueError, match="has no unit"):
        load_scene(written(records), {"motion": {"amplitude": "0.35"}})
    for text, wanted in (("0.35g", 3.4335), ("0.35 m/s2", 0.35), (1.2, 1.2), (0, 0.0)):
        scene = load_scene(written(records, amplitude=text))
        assert reference_amplitude(scene.motion) == pytest.approx(wanted)
        assert stored_scene(scene.model_dump(mode="json")) == scene
    study = {"study": "s", "scene": str(written(records)), "fidelity": "own", "fidelities": {"own": {}}}
    for values, fault in ((["0.2", "0.35"], True), ([0.35], True), (["0.2g", "0.35"], False), (["0.35", "2.0"], False)):
        if fault:
            with pytest.raises(ValueError, match="grid.amplitude: 0.35 has no unit"):
                load_study(study | {"grid": {"amplitude": values}})
        else:
            load_study(study | {"grid": {"amplitude": values}})
    with pytest.raises(ValueError, match="slope.yaml: motion.amplitude: 0.35 has no unit"):
        load_study(study | {"scene": str(written(records, amplitude=0.35)), "grid": {"S_R": ["0.5"]}})
