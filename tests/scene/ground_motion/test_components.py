"""Readers of ESM, AFAD, UNAM, GeoNet and CSMIP: the same three components in every format, which of them is read, and what is refused."""

from __future__ import annotations

import json
import re
from pathlib import Path

import numpy as np
import pytest
from calling import call
from record_files import afad, csmip, esm, geonet, unam

from sph.scene.ground_motion import read_components, read_record
from sph.scene.ground_motion.component import Component, chosen
from sph.scene.ground_motion.record import Record
from sph.scene.schema import load_scene, make_scene

ROOT = Path(__file__).parents[3]
INTERVAL, COUNT = 0.01, 203
TIME = np.arange(COUNT) * INTERVAL
EAST, UP, NORTH = (peak * np.sin(2 * np.pi * frequency * TIME) for peak, frequency in ((2.0, 1.0), (0.5, 5.0), (-1.5, 2.0)))
BEARINGS = {"N90E": EAST, "V": UP, "N00E": NORTH}
TEXTS = {
    "a.txt": afad({"E-W": EAST, "U-D": UP, "N-S": NORTH}, INTERVAL),
    "b.txt": unam(BEARINGS, INTERVAL),
    "b.asa": unam(BEARINGS, INTERVAL),
    "a.V2A": geonet({"S80E": EAST, "Up": UP, "N10E": NORTH}, INTERVAL),
    "a.V1A": geonet({"S80E": EAST, "Up": UP, "N10E": NORTH}, INTERVAL, corrected=False),
    "a.V1": csmip({"90 Deg": EAST, "Up": UP, "360 Deg": NORTH}, INTERVAL, volume=1),
    "a.RAW": csmip({"90 Deg": EAST, "Up": UP, "360 Deg": NORTH}, INTERVAL, volume=1),
    "a.V2": csmip({"H1": EAST, "Up": UP, "H2": NORTH}, INTERVAL),
}
NAMES = {
    "a.txt": "E-W",
    "b.txt": "N90E",
    "b.asa": "n90e",
    "a.V2A": "S80E",
    "a.V1A": "S80E",
    "a.V1": "90  deg",
    "a.RAW": "90 Deg",
    "a.V2": "H1",
}
ROUNDING = {"a.txt": 1e-8, "b.txt": 1e-6, "b.asa": 1e-6, "a.V2A": 1e-4, "a.V1A": 1e-4, "a.V1": 1e-5, "a.RAW": 1e-5, "a.V2": 1e-7}
"""m/s2, from the decimals of each format: GeoNet has 0.1 mm/s2, volume 1 of CSMIP 1e-6 g."""


def written(folder: Path, name: str, text: str | None = None) -> Path:
    path = folder / name
    path.write_text(TEXTS[name] if text is None else text)
    return path


@pytest.mark.parametrize("name", TEXTS)
def test_a_component_is_chosen_by_its_name_or_its_number(tmp_path: Path, name: str) -> None:
    path, close = written(tmp_path, name), {"rtol": 0.0, "atol": ROUNDING[name]}
    for component, wanted in ((NAMES[name], EAST), ("1", EAST), ("3", NORTH)):
        time, horizontal, vertical = read_components(path, component=component)
        np.testing.assert_allclose(time, TIME, atol=1e-12)
        np.testing.assert_allclose(horizontal, wanted, **close)
        np.testing.assert_allclose(vertical, UP, **close)
    np.testing.assert_allclose(read_record(path, component="3").acceleration, NORTH, **close)
    time, vertical = read_components(path, wanted="vertical")
    np.testing.assert_allclose(vertical, UP, **close)


@pytest.mark.parametrize("name", TEXTS)
def test_a_component_that_may_be_another_is_refused(tmp_path: Path, name: str) -> None:
    path = written(tmp_path, name)
    for component, words in (
        (None, ("holds 2 horizontal components", "1: ", "2: ", "3: ", "motion.component", "--component")),
        ("2", ("component: '2'", "vertical component")),
        ("4", ("component: '4' is none of the components",)),
        ("N45E", ("component: 'N45E' is none of the components", "by its name or its number")),
    ):
        with pytest.raises(ValueError) as error:
            read_components(path, component=component)
        for word in (str(path), *words):
            assert word in str(error.value)


def test_a_name_of_two_channels_is_refused(tmp_path: Path) -> None:
    path = written(tmp_path, "a.V2", csmip({"90 Deg": EAST, "90  Deg": NORTH}, INTERVAL, azimuths=(90, 90)))
    with pytest.raises(ValueError, match="'90 deg' is more than one of the components"):
        read_components(path, component="90 deg")
    np.testing.assert_allclose(read_components(path, component="2")[1], NORTH, atol=1e-7)
    with pytest.raises(ValueError, match="holds no vertical components"):
        read_components(path, wanted="vertical")


def test_one_horizontal_component_needs_no_choice(tmp_path: Path) -> None:
    path = written(tmp_path, "a.V2", csmip({"Down": UP, "200 Deg": EAST}, INTERVAL, azimuths=(600, 200)))
    np.testing.assert_allclose(read_record(path).acceleration, EAST, atol=1e-7)
    path = written(tmp_path, "b.V2", csmip({"Array 4": EAST, "Array 5": UP}, INTERVAL, azimuths=(45, 500)))  # by azimuth alone
    np.testing.assert_allclose(read_record(path).acceleration, EAST, atol=1e-7)


def test_a_vertical_component_stands_beside_one_as_long_with_the_same_interval(tmp_path: Path) -> None:
    one, up = Component("N-S", "horizontal", 0.01, np.ones(3)), Component("U-D", "vertical", 0.01, np.ones(3))
    for vertical, columns in ((up, 3), (up._replace(interval=0.02), 2), (up._replace(acceleration=np.ones(4)), 2)):
        assert len(chosen(tmp_path / "a.txt", [one, vertical], "horizontal", None)) == columns


def test_the_digits_of_samples(tmp_path: Path) -> None:
    """First samples as they stand in the files: 0.5 gal, 27.5 mm/s2, -0.000116 g, which touch where a column is full."""
    path = written(tmp_path, "a.V1", csmip({"90 Deg": np.array([-0.000116, -1.234567, -1.345678, 0.25]) * 9.81}, 0.005, 1, (90,)))
    assert "-1.234567-1.345678" in path.read_text()
    np.testing.assert_allclose(read_record(path).acceleration, np.array([-0.000116, -1.234567, -1.345678, 0.25]) * 9.81, rtol=1e-14)
    path = written(tmp_path, "a.V2A", geonet({"N10E": np.array([0.0275, -2.3646])}, 0.02))
    np.testing.assert_allclose(read_record(path).acceleration, [0.0275, -2.3646], rtol=1e-14)
    path = written(tmp_path, "a.ASC", esm(np.array([0.00300022, -0.001]), 0.005))
    np.testing.assert_allclose(read_record(path).acceleration, [0.00300022, -0.001], rtol=1e-14)
    path = written(tmp_path, "a.txt", afad({"N-S": np.array([0.005, 1.0]), "E-W": np.zeros(2), "U-D": np.zeros(2)}, 0.01))
    np.testing.assert_allclose(read_record(path, component="N-S").acceleration, [0.005, 1.0], rtol=1e-14)


def test_raw_readings_of_geonet_are_in_the_unit_of_their_header(tmp_path: Path) -> None:
    path = written(tmp_path, "a.V1A", geonet({"N10E": EAST}, INTERVAL, corrected=False, reading=0.5))
    np.testing.assert_allclose(read_record(path).acceleration, EAST, atol=1e-4)


def test_the_interval_of_volume_2_has_the_digits_of_its_reals(tmp_path: Path) -> None:
    path = written(tmp_path, "a.V2", csmip({"90 Deg": EAST}, 1 / 128, azimuths=(90,)))
    assert " 0.008 sec" in path.read_text()
    np.testing.assert_allclose(read_record(path).time[-1], 202 / 128, rtol=1e-12)


@pytest.mark.parametrize(("unit", "size"), [("cm/s^2", 0.01), ("gal", 0.01), ("m/s^2", 1.0), ("g", 9.81)])
def test_the_header_of_an_esm_file_says_its_unit(tmp_path: Path, unit: str, size: float) -> None:
    text = re.sub(r"PGA_CM/S\^2: \S+", "PGA_CM/S^2: ", esm(EAST, INTERVAL, unit))
    path = written(tmp_path, "a.asc", text)
    np.testing.assert_allclose(read_record(path).acceleration, 100.0 * size * EAST, atol=1e-6 * size)
    with pytest.raises(ValueError, match="contradicts"):
        read_record(path, "m/s2" if size < 1 or size > 2 else "g")


@pytest.mark.parametrize("stream", ["HNZ", "HGZ", "U"])
def test_a_vertical_stream_of_esm_is_no_horizontal_motion(tmp_path: Path, stream: str) -> None:
    path = written(tmp_path, "a.ASC", esm(UP, INTERVAL, stream=stream))
    with pytest.raises(ValueError, match=rf"line 7: its stream '{stream}'.*vertical component"):
        read_record(path)
    np.testing.assert_allclose(read_components(path, wanted="vertical")[1], UP, atol=1e-8)


def replaced(text: str, old: str, new: str) -> str:
    assert old in text
    return text.replace(old, new, 1)


def without(text: str, line: int) -> str:
    """A text without one of its lines, by its number from 1 on."""
    lines = text.split("\n")
    return "\n".join(lines[: line - 1] + lines[line:])


ASC = esm(EAST, INTERVAL)
PEAK = "/200.00/"
V1, V2, V1A, V2A, AFAD, UNAM = (TEXTS[name] for name in ("a.V1", "a.V2", "a.V1A", "a.V2A", "a.txt", "b.asa"))
BAD = [
    ("a.ASC", replaced(ASC, "NDATA: 203", "NDATA: 204"), "line 5: must hold the 204 samples.*holds 203"),
    ("a.ASC", replaced(ASC, "NDATA: 203", "NDATA: many"), "line 5: NDATA must be a whole number.*many"),
    ("a.ASC", replaced(ASC, "NDATA: 203", "NDATA: 1"), "at least two samples"),
    ("a.ASC", replaced(ASC, "UNITS: cm/s^2", "UNITS: counts"), "line 8: 'counts' is no unit"),
    ("a.ASC", replaced(ASC, "UNITS: cm/s^2", "UNITS: g"), r"line 9: PGA_CM/S\^2 states a peak of 2 m/s2, its samples have 1962"),
    ("a.ASC", replaced(ASC, "DATA_TYPE: ACCELERATION", "DATA_TYPE: VELOCITY"), "line 11: must be a record of acceleration.*VELOCITY"),
    ("a.ASC", replaced(ASC, "INTERVAL_S: 0.010000", "INTERVAL_S: 0"), "interval.*every 0 s"),
    ("a.ASC", without(ASC, 4), "lines 1-12: must be an ESM header.*SAMPLING_INTERVAL_S"),
    ("a.ASC", ASC.partition("USER5: \n")[2], "lines 1-1: must be an ESM header"),
    ("a.ASC", ASC + "x\n", "line 216: must be finite numbers"),
    ("a.ASC", ASC + "nan\n", "line 216: must be finite numbers"),
    ("a.txt", replaced(AFAD, "DATA : 203", "DATA : 204"), "line 13: must hold the 204 samples.*holds 203"),
    ("a.txt", replaced(AFAD, "DATA : 203", "DATA : all"), "line 13: must be as in 'NUMBER OF DATA: 12000'"),
    ("a.txt", replaced(AFAD, "SAMPLING INTERVAL", "SAMPLING RATE"), "line 14: must be as in 'SAMPLING INTERVAL"),
    ("a.txt", replaced(AFAD, "U-D", "N-S"), "line 18: must name the columns, 'N-S E-W U-D'"),
    ("a.txt", AFAD + "1 2\n", "line 222: must be 3 finite numbers"),
    ("a.txt", AFAD + "1 2 nan\n", "line 222: must be 3 finite numbers"),
    ("a.txt", "\n".join(AFAD.split("\n")[:10]), "18 lines of header, has 10"),
    ("b.asa", replaced(UNAM, "/203/203/203", "/204/204/204"), "line 10: must hold the 204 samples.*holds 203"),
    ("b.asa", replaced(UNAM, "/203/203/203", "/203/202/203"), "lines 9 and 10: all channels must have one interval"),
    ("b.asa", replaced(UNAM, "/0.01/0.01/0.01", "/0.01/0.01"), "line 9: must be 3 numbers, one a channel"),
    ("b.asa", replaced(UNAM, PEAK, "/150.00/"), "line 11:.*states a peak of 1.5 m/s2, its samples have 2 m/s2"),
    ("b.asa", replaced(UNAM, "/N90E/V/N00E", "//"), "line 8: must name the channels.*N90E"),
    ("b.asa", replaced(UNAM, "ORIENTACION", "ORIENTATION"), "lines 1-109: must have a line 'ORIENTACION C1-C6'"),
    ("b.asa", replaced(UNAM, "ARCHIVO ESTANDAR", "ARCHIVO"), "lines 1-109: must be the header"),
    ("b.asa", replaced(UNAM, "*\n", "UNIDADES DE LOS DATOS : g\n"), "line 11:.*states a peak of 2 m/s2, its samples have 1962 m/s2"),
    ("b.asa", replaced(UNAM, "*\n", "UNIDADES DE LOS DATOS : cuentas\n"), "line 1: 'cuentas' is no unit of acceleration"),
    ("b.asa", without(UNAM, 60), "line 10: must hold the 203 samples.*holds 202"),
    ("b.asa", UNAM + "1 2\n", "line 313: must be 3 finite numbers"),
    ("a.V2A", replaced(V2A, "203.0000203.0000203.0000", "204.0000203.0000203.0000"), "line 20: must hold the 204 samples.*holds 203"),
    ("a.V2A", replaced(V2A, "203.0000203.0000203.0000", "230.0000203.0000203.0000"), "line 23: the header states 2.02 s, and 230 samples"),
    ("a.V2A", "\n".join(V2A.split("\n")[:40]), "line 20: must hold the 203 samples.*holds 140"),
    ("a.V2A", "\n".join(V2A.split("\n")[:60]), "line 20: states 63 lines of samples, 34 follow"),
    ("a.V2A", "\n".join(V2A.split("\n")[:100]), "line 90: must begin the 26 lines of header"),
    ("a.V2A", replaced(V2A, "mm/s/s", "cm/s/s"), "line 14: must be as in 'Acceleration: peak 2364.6 mm/s/s"),
    ("a.V2A", replaced(V2A, "peak   2000.0", "peak    200.0"), "line 14: the header states a peak of 0.2 m/s2, its samples have 2 m/s2"),
    ("a.V2A", replaced(V2A, "Component S80E", "Direction S80E"), "line 13: must be as in 'Component N10E'"),
    ("a.V2A", replaced(V2A, "  2.0200", "  4.0400"), "line 23: the header states 4.04 s"),
    ("a.V2A", without(V2A, 1), "line 1: must begin the 26 lines of header"),
    ("a.V2A", "\n", "line 1: is empty"),
    ("a.V1A", replaced(V1A, "units of 1.00", "units of 2.00"), "line 14: the header states a peak of 2 m/s2, its samples have 4 m/s2"),
    ("a.V2", replaced(V2, "   203 points of accel", "   204 points of accel"), "line 46: must hold the 204 samples.*holds 203"),
    ("a.V2", replaced(V2, "   203 points of accel", "   202 points of accel"), "line 46: must hold the 202 samples.*holds 203"),
    ("a.V2", replaced(V2, "in cm/sec2.", "in counts."), "line 46: 'in counts.' names no unit"),
    ("a.V2", replaced(V2, "in cm/sec2.", "in g."), "line 18: the header states a peak of 2 m/s2, its samples have 1962"),
    ("a.V2", replaced(V2, "at 0.010 sec", "at 0.020 sec"), "line 46: states an interval of 0.02 s, line 40 of 0.01 s"),
    ("a.V2", replaced(V2, "points of accel data", "numbers"), "line 1: has no line 'n points of accel data"),
    ("a.V2", "\n".join(V2.split("\n")[:60]), "line 46: must hold the 203 samples.*holds 112"),
    ("a.V1", replaced(V1, "Uncorrected", "Response"), "line 1: must begin with .*'Uncorrected accelerogram'"),
    ("a.RAW", replaced(V1, "Uncorrected", "Response"), "line 1: must begin with .*'Uncorrected accelerogram'"),
    ("a.V1", replaced(V1, "0.010 SEC", "0.020 SEC"), "line 12: the header states 2.03 s, and 203 samples every 0.02 s"),
    ("a.V1", replaced(V1, "(UNITS: G)", "(UNITS: G/10)"), "names no unit of acceleration"),
]  # fmt: skip


@pytest.mark.parametrize(("name", "text", "message"), BAD, ids=[f"{at}-{name}" for at, (name, _, _) in enumerate(BAD)])
def test_damaged_files_are_refused_with_file_and_line(tmp_path: Path, name: str, text: str, message: str) -> None:
    path = written(tmp_path, name, text)
    with pytest.raises(ValueError, match=re.compile(message, re.S)) as error:
        read_components(path, component=None if name == "a.ASC" else "1")
    assert str(path) in str(error.value)


@pytest.mark.parametrize(("name", "quantity"), [("RSN6_ELC180.VT2", "velocity"), ("rsn6_elc180.dt2", "displacement")])
def test_peer_files_of_other_quantities_name_the_one_of_acceleration(tmp_path: Path, name: str, quantity: str) -> None:
    path = written(tmp_path, name, "")
    with pytest.raises(ValueError, match=rf"of {quantity}, .*name the \.AT2 file.*\({Path(name).stem}\.AT2\)"):
        read_components(path)
    result = call("motion", path)
    assert result.exit_code == 2 and "the .AT2 file" in result.stderr


def test_a_text_of_columns_is_read_as_a_csv(tmp_path: Path) -> None:
    path = written(tmp_path, "a.txt", "time (s)  acc (cm/s2)\n0.00  1.5\n0.01 -2.5\n")
    np.testing.assert_allclose(read_record(path).acceleration, [0.015, -0.025], rtol=1e-14)
    path = written(tmp_path, "b.txt", "0.00  1.5\n0.01 -2.5\n")
    np.testing.assert_allclose(read_record(path, "g").acceleration, [1.5 * 9.81, -2.5 * 9.81], rtol=1e-14)
    with pytest.raises(ValueError, match=r"b\.txt, line 1.*does not say its unit"):
        read_record(path)
    with pytest.raises(ValueError, match="component: '1': .*holds one horizontal component"):
        read_record(path, "g", component="1")


# ---------------------------------------------------------------- in a scene, and on the command line


def section(**keys: object) -> dict[str, object]:
    return {"kind": "record", "start": 0.0, **keys}


def test_a_scene_takes_a_component_and_the_vertical_beside_it(tmp_path: Path) -> None:
    path = str(written(tmp_path, "a.V2"))
    for component in ("H2", 3, "3"):
        record = Record.model_validate(section(file=path, component=component, vertical={}))
        assert record.component == str(component) and record.data is not None and record.data.y is not None
        np.testing.assert_allclose(record.data.x, NORTH, atol=1e-7)
        np.testing.assert_allclose(record.data.y, UP, atol=1e-7)
    again = Record.model_validate(record.model_dump())  # from its samples, without the file
    assert again == record
    east = Record.model_validate(section(file=path, component=1, vertical={"file": path}))
    np.testing.assert_allclose(east.acceleration(TIME), EAST, atol=1e-7)
    np.testing.assert_allclose(east.vertical_acceleration(TIME), UP, atol=1e-7)


@pytest.mark.parametrize(
    ("component", "words"), [(None, "motion.component"), ("Z9", "component: 'Z9' is none"), (True, "component"), ("", "component")]
)
def test_a_scene_without_a_component_of_its_file_is_refused(tmp_path: Path, component: object, words: str) -> None:
    motion = section(file=str(written(tmp_path, "a.V2")), component=component)
    geometry = {"shape": "block", "width": 10.0, "height": 5.0}
    with pytest.raises(ValueError, match=words):
        make_scene({"name": "block", "scheme": "paper", "duration": 5.0, "geometry": geometry, "motion": motion})


def test_commands_take_a_component(tmp_path: Path) -> None:
    path = written(tmp_path, "a.txt")
    for component, peak in (("E-W", EAST), ("3", NORTH)):
        result = call("motion", path, "--component", component, "--json")
        assert result.exit_code == 0, result.output
        found = json.loads(result.stdout)
        assert found["horizontal"]["peak_acceleration"] == pytest.approx(np.abs(peak).max(), abs=1e-7)
        assert found["vertical"]["peak_acceleration"] == pytest.approx(np.abs(UP).max(), abs=1e-7)
    slid = call("newmark", path, "--component", "N-S", "--ay", "0.1 m/s2", "--json")
    assert slid.exit_code == 0 and json.loads(slid.stdout)["peak_acceleration"] == pytest.approx(-1.5, rel=0.01), slid.output
    result = call("motion", path)
    assert result.exit_code == 2 and "--component of a command" in result.stderr
    result = call("motion", ROOT / "config" / "scenes" / "paper.yaml", "--component", "E-W")
    assert result.exit_code == 2 and "--set motion.component=E-W" in result.stderr


def test_a_new_scene_takes_a_component(tmp_path: Path) -> None:
    path = written(tmp_path, "a.V2")
    ground = str(ROOT / "config" / "ground" / "gentle_layered.csv")
    result = call("new", ground, path, "--component", "H2", "--out", tmp_path / "own")
    assert result.exit_code == 0, result.output
    motion = load_scene(tmp_path / "own" / "scene.yaml").motion
    assert isinstance(motion, Record) and motion.component == "H2" and motion.data is not None
    np.testing.assert_allclose(motion.data.x, NORTH, atol=1e-7)
    refused = call("new", ground, path, "--out", tmp_path / "other")
    assert refused.exit_code == 2 and "--component" in refused.stderr and not (tmp_path / "other").exists()
