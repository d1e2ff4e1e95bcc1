"""Readers of records: the same sine in every format, and what is refused."""

from __future__ import annotations

import itertools
from pathlib import Path

import numpy as np
import pytest
from calling import call
from record_files import at2, cosmos, knet, smc

from sph.scene.ground_motion import read_components, read_record
from sph.scene.ground_motion.direction import Direction
from sph.scene.ground_motion.units import Unit

INTERVAL, RATE = 0.01, 100
TIME = np.arange(1000) * INTERVAL
SINE = 2.0 * np.sin(2 * np.pi * TIME)
TEXTS = {
    "new.AT2": at2(SINE, INTERVAL),
    "old.at2": at2(SINE, INTERVAL, "{n:6d} {dt:8.5f} NPTS, DT"),
    "a.smc": smc(SINE, INTERVAL),
    "none.SMC": smc(SINE, INTERVAL, comments=0),
    "a.V2": cosmos(SINE, INTERVAL),
    "bare.v2c": cosmos(SINE, INTERVAL, "cm/s^2 (4)", "1F15.6", further=False),
    "points.v1": cosmos(SINE, INTERVAL, "cm/sec2. (04) ").replace(",Format", "Format").replace(",  Format", "  Format"),
    "touching.V1": cosmos(SINE, INTERVAL, "cm/sec/sec", "8F10.5"),
    "a.csv": "time (s), ax (cm/s2)\n" + "\n".join(f"{t:.2f},{100 * float(a)!r}" for t, a in zip(TIME, SINE, strict=True)),
    "g.csv": "t [s],g\n" + "\n".join(f"{t:.2f},{float(a) / 9.81!r}" for t, a in zip(TIME, SINE, strict=True)),
}
ROUNDING = 2e-6
"""AT2 has seven digits of g, SMC four decimals of cm/s2."""


@pytest.mark.parametrize("name", TEXTS)
def test_a_sine_in_every_format(tmp_path: Path, name: str) -> None:
    (tmp_path / name).write_text(TEXTS[name])
    time, acceleration = read_record(tmp_path / name)
    np.testing.assert_allclose(time, TIME, atol=1e-12)
    np.testing.assert_allclose(acceleration, SINE, atol=ROUNDING)


@pytest.mark.parametrize("ending", ["EW", "ns", "ew2", "knet"])
def test_a_record_of_k_net_keeps_the_offset_of_its_recorder(tmp_path: Path, ending: str) -> None:
    path = tmp_path / f"AKT0130001010000.{ending}"
    path.write_text(knet(SINE, RATE))
    time, acceleration = read_record(path)
    count = 2000 / 8388608 / 100  # m/s2
    np.testing.assert_allclose(time, TIME, atol=1e-12)
    np.testing.assert_allclose(acceleration, SINE + 1234 * count, atol=0.5001 * count)


def test_the_head_of_a_cosmos_file_needs_no_comma(tmp_path: Path) -> None:
    path = tmp_path / "a.V2"
    path.write_text(cosmos(SINE / 981.0, INTERVAL, "g.     (02)").replace("(02),Format", "(02)Format"))
    assert "units=g.     (02)Format=(" in path.read_text()
    np.testing.assert_allclose(read_record(path).acceleration, SINE, atol=0.5e-5 * 9.81 * 1.001)


@pytest.mark.parametrize("factor", ["2000(gal)/8388608", "3920(gal)/6182761", "7845(gal)/8223790"])
def test_counts_of_k_net_and_kik_net_are_scaled_as_the_head_says(tmp_path: Path, factor: str) -> None:
    """The first counts of AKT013, 11 August 1996, as ObsPy 1.5.1 scales them to m/s2."""
    obspy = {
        "2000(gal)/8388608": [-0.04340410232543945, -0.04290342330932617],
        "3920(gal)/6182761": [-0.11542351386378999, -0.1140920698697556],
        "7845(gal)/8223790": [-0.17366472757694446, -0.17166145414705386],
    }
    path = tmp_path / "AKT0139608110312.EW"
    peak = 105.0 * float(factor.partition("(")[0]) / float(factor.partition("/")[2])
    head, _ = knet(np.zeros(2), RATE, 0).replace("2000(gal)/8388608", factor).replace("(gal)   0.000", f"(gal)   {peak:.3f}").split("Memo.")
    path.write_text(head + "Memo.             A dummy comment\n  -18205   -17995 \n")
    np.testing.assert_allclose(read_record(path).acceleration, obspy[factor], rtol=1e-15)


def test_a_csv_with_a_vertical_component(tmp_path: Path) -> None:
    path = tmp_path / "two.csv"
    path.write_text("time,ax (g),ay (gal)\n0,0.1,10\n0.5,0.2,20\n")
    for component, wanted in zip(read_components(path), ([0, 0.5], [0.981, 1.962], [0.1, 0.2]), strict=True):
        np.testing.assert_allclose(component, wanted, rtol=1e-12)
    path.write_text("0,1,2\n1,3,4\n")
    np.testing.assert_array_equal(read_components(path, "cm/s2")[2], [0.02, 0.04])


UNITS = {
    "acc_g": 9.81, "acceleration in g": 9.81, "AccG": 9.81, "a(g)": 9.81, "g's": 9.81,
    "ACC (gal) NS": 0.01, "EW_gal": 0.01, "acc cm/s2": 0.01, "acc/cm/s2": 0.01, "acc_cm_s2": 0.01, "Accel_H1 [cm/s/s]": 0.01,
    "Acc. (m/s^2)": 1.0, "acc m s⁻²": 1.0, "a / (m/s²)": 1.0, "acc m per second squared": 1.0, "acc (NS) [gal]": 0.01,
    "PGA in gal's": 0.01, "acc_H1_g": 9.81, "EW 2 (g)": 9.81, "%g": 0.0981, "acc (% g)": 0.0981, "acc (percent g)": 0.0981,
    "acc pct of g": 0.0981,
}  # fmt: skip
"""Names of a column, and one of what is in it in m/s2."""
UNITLESS = [
    "Acceleration", "ax", "NS", "gx", "gX", "HNE", "signal", "acc_h", "acc_max", "level", "AccX_1", "N90E", "E1",
]  # fmt: skip
REFUSED = [
    "acc_mg", "milli-g", "acc (0.01 g)", "acc 10^-2 g", "acc g/100", "acc_2g", "a_g", "acc ft/s2", "acc (in/s2)",
    "acc mm/s2", "acc (m/s)", "acc_counts", "acc (volts)", "acc (NS)", "acc g gal", "displacement", "vel_x",
]  # fmt: skip


@pytest.mark.parametrize("name", UNITS)
def test_a_unit_in_a_name_is_understood_wherever_it_stands(tmp_path: Path, name: str) -> None:
    path = tmp_path / "a.csv"
    path.write_text(f"time,{name}\n0,1\n1,2\n", encoding="utf-8")
    np.testing.assert_allclose(read_record(path).acceleration, [UNITS[name], 2 * UNITS[name]], rtol=1e-12)


@pytest.mark.parametrize("name", UNITLESS)
def test_an_acceleration_without_a_unit_is_in_none_in_silence(tmp_path: Path, name: str) -> None:
    path = tmp_path / "a.csv"
    path.write_text(f"time,{name}\n0,1\n1,2\n")
    with pytest.raises(ValueError, match=rf"a.csv, line 1: '{name}': does not say its unit; .*'ax \(cm/s2\)'.*--unit"):
        read_record(path)
    np.testing.assert_allclose(read_record(path, "gal").acceleration, [0.01, 0.02], rtol=1e-12)


@pytest.mark.parametrize("name", REFUSED)
def test_a_unit_that_is_not_understood_is_refused(tmp_path: Path, name: str) -> None:
    path = tmp_path / "a.csv"
    path.write_text(f"time,{name}\n0,1\n1,2\n")
    with pytest.raises(ValueError) as error:
        read_record(path, "g")
    assert f"{path}, line 1: " in str(error.value) and repr(name) in str(error.value)


@pytest.mark.parametrize(
    ("name", "second"), [("t", 1), ("time_s", 1), ("t/s", 1), ("time_ms", 1000), ("time [ms]", 1000), ("Time (msec)", 1000)]
)
def test_time_is_in_seconds_or_milliseconds(tmp_path: Path, name: str, second: float) -> None:
    path = tmp_path / "a.csv"
    path.write_text(f"{name},NS_g,UD (gal)\n0,1,100\n{0.5 * second},2,100\n")
    for component, wanted in zip(read_components(path), ([0, 0.5], [9.81, 19.62], [1.0, 1.0]), strict=True):
        np.testing.assert_allclose(component, wanted, rtol=1e-12)


@pytest.mark.parametrize("name", ["time (min)", "t_us", "time h", "Sample", "t (0.01 s)"])
def test_other_times_are_refused(tmp_path: Path, name: str) -> None:
    path = tmp_path / "a.csv"
    path.write_text(f"{name},a (g)\n0,1\n1,2\n")
    with pytest.raises(ValueError, match="line 1.*s or ms"):
        read_record(path)


@pytest.mark.parametrize(
    ("title", "size"), [("ACCELERATION (CM/S/S)", 0.01), ("ACCELERATION IN G", 9.81), ("UNITS OF CM/SEC2, 0.1-25 HZ", 0.01)]
)
def test_the_title_of_an_at2_file_says_its_unit(tmp_path: Path, title: str, size: float) -> None:
    path = tmp_path / "a.at2"
    path.write_text(TEXTS["new.AT2"].replace("ACCELERATION TIME SERIES IN UNITS OF G", title))
    np.testing.assert_allclose(read_record(path).acceleration, SINE / 9.81 * size, atol=ROUNDING)
    with pytest.raises(ValueError, match="contradicts"):
        read_record(path, "m/s2")


ENDINGS = {"CR LF": "\r\n", "CR": "\r", "LF": "\n"}


@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "utf-16", "latin-1"])
@pytest.mark.parametrize("ending", ENDINGS)
@pytest.mark.parametrize("name", ["new.AT2", "a.smc", "a.csv", "a.EW"])
def test_other_systems_texts(tmp_path: Path, name: str, ending: str, encoding: str) -> None:
    text = TEXTS.get(name) or knet(SINE, RATE)
    text = text.replace("Nowhere", "Köln").replace("a comment", "Señal").replace("Memo.", "Memo. Zürich")
    (tmp_path / "plain").with_suffix(Path(name).suffix).write_text(text, encoding="utf-8")
    path = tmp_path / name
    path.write_bytes(text.replace("\n", ENDINGS[ending]).encode(encoding))
    for one, other in zip(read_record(path), read_record((tmp_path / "plain").with_suffix(path.suffix)), strict=True):
        np.testing.assert_array_equal(one, other)


def test_numbers_that_touch(tmp_path: Path) -> None:
    # Ten columns are full from -1000 cm/s2 on; exponents may be Fortran's.
    path = tmp_path / "strong.smc"
    path.write_text(smc(np.array([-12.345678, -23.456789, -1e-4]), INTERVAL))
    assert "-1234.5678-2345.6789" in path.read_text()
    np.testing.assert_allclose(read_record(path).acceleration, [-12.345678, -23.456789, -1e-4], atol=1e-6)
    fortran = tmp_path / "fortran.at2"
    fortran.write_text(at2(np.array([9.81, -9.81]), INTERVAL).replace("E+00", "D+00"))
    np.testing.assert_allclose(read_record(fortran).acceleration, [9.81, -9.81])


def replaced(name: str, old: str, new: str) -> tuple[str, str]:
    text = TEXTS.get(name) or knet(SINE, RATE)
    assert old in text
    return name, text.replace(old, new, 1)


LAST = f"{SINE[-1] / 9.81:15.7E}"
BAD = [
    (*replaced("new.AT2", "NPTS=   1000", "NPTS=   1001"), ("1,001 samples", "holds 1,000", "whole")),
    (*replaced("new.AT2", "NPTS=   1000", "NPTS=    999"), ("999 samples", "holds 1,000")),
    (*replaced("new.AT2", "NPTS=   1000", "NPTS=      1"), ("at least two samples", "1")),
    (*replaced("new.AT2", "NPTS=   1000", "NPTS=  1.5e3"), ("line 4", "NPTS= 5372, DT= .0100 SEC", "1.5e3")),
    (*replaced("new.AT2", "DT=", "EVERY"), ("line 4", "NPTS= 5372, DT=")),
    (*replaced("new.AT2", "SEC", "MSEC"), ("line 4", "NPTS= 5372, DT=")),
    (*replaced("new.AT2", "0.01000", "0.00000"), ("interval", "every 0 s")),
    (*replaced("new.AT2", "0.01000", "1e99999"), ("interval", "every inf s")),
    (*replaced("new.AT2", " IN UNITS OF G", ""), ("does not say its unit", "unit: m/s2, cm/s2, gal, g")),
    (*replaced("new.AT2", "OF G", "OF FURLONGS"), ("line 3", "'FURLONGS'", "no unit")),
    (*replaced("new.AT2", "ACCELERATION", "VELOCITY"), ("line 3", "record of acceleration", "VELOCITY")),
    (*replaced("new.AT2", LAST, f"{'NaN':>15}"), ("line 15", "finite numbers")),
    (*replaced("new.AT2", LAST, f"{'Infinity':>15}"), ("line 15", "finite numbers")),
    (*replaced("new.AT2", LAST, f"{'x':>15}"), ("line 15", "finite numbers")),
    ("empty.at2", "", ("line 4", "NPTS")),
    (*replaced("a.smc", "2 CORRECTED ACCELEROGRAM", "3 VELOCITY"), ("line 1", "'2 CORRECTED ACCELEROGRAM'", "3 VELOCITY")),
    (*replaced("a.smc", "      1000", "      1001"), ("1,001 samples", "holds 1,000")),
    (*replaced("a.smc", "    -32768", "    -3276x"), ("line 12", "columns of 10")),
    (*replaced("a.smc", f"{100.0:15.7E}", f"{0.0:15.7E}"), ("interval", "every inf s")),
    ("short.smc", "\n".join(TEXTS["a.smc"].split("\n")[:20]), ("27 lines of headers", "has 20")),
    ("empty.smc", "", ("line 1", "CORRECTED")),
    (*replaced("a.V2", "Corrected", "Response"), ("line 1", "'Corrected acceleration'")),
    (*replaced("a.V2", "Real-header", "Rare-header"), ("not in COSMOS format",)),
    (*replaced("a.V2", "cm/sec2(04)", "counts (50)"), ("line 45", "'counts'", "no unit of acceleration")),
    (*replaced("a.V2", "cm/sec2(04)", "g (04)"), ("line 45", "'g (04)'", "of different units")),
    (*replaced("a.V2", "cm/sec2(04)", "cm/sec2 x 10 (04)"), ("line 45", "'cm/sec2 x 10'", "no unit of acceleration")),
    (*replaced("new.AT2", "OF G", "OF G X 1000"), ("line 3", "'G X 1000'", "no unit", "without a factor")),
    (*replaced("new.AT2", "UNITS OF G", "G / 100"), ("line 3", "/ 100'", "without a factor")),
    (*replaced("a.V2", "    1000 acceleration", "    1001 acceleration"), ("line 171", "finite numbers")),
    (*replaced("a.V2", "velocity     pts", "acceleration pts"), ("holds 2 components", "lines 45, 171")),
    ("unknown.V2", TEXTS["a.V2"].replace("     5.000000", "  -999.000000").replace("    10.000000", "  -999.000000"), ("lines 26-42",)),
    (*replaced("a.csv", "cm/s2", "furlong"), ("line 1", "'ax (furlong)'", "m/s2, cm/s2, gal, g")),
    (*replaced("a.csv", "time (s)", "time (min)"), ("line 1", "'time (min)'", "must be s or ms")),
    (*replaced("a.csv", "ax (cm/s2)", "velocity"), ("line 1", "'velocity': holds velocities by its own words")),
    ("title.csv", "El Centro in g\n0,1\n1,1\n", ("line 1", "names 1 columns", "have 2")),
    ("half.csv", "t,ax (g),ay\n0,1,1\n1,1,1\n", ("line 1: 'ay'", "does not say its unit")),
    (*replaced("a.csv", "0.02,", "0.01,"), ("line 4", "greater than 0.01 s")),
    (*replaced("a.csv", "0.02,", "nan,"), ("line 4", "two finite numbers")),
    ("names.csv", "t,ax (g),ay (g)\n0,1\n1,1\n", ("line 1", "names 3 columns", "have 2")),
    (*replaced("a.EW", "Origin Time", "Origin"), ("lines 1-17", "'Origin Time' to 'Memo.'")),
    (*replaced("a.EW", "Memo.", "Nemo."), ("lines 1-17", "Memo")),
    (*replaced("a.EW", "Time(s)  10", "Time(s)  60"), ("6,000 samples", "lines 11 and 12", "holds 1,000")),
    (*replaced("a.EW", "100Hz", "fast"), ("line 11", "'Sampling Freq(Hz) 100Hz'", "fast")),
    (*replaced("a.EW", "2000(gal)/8388608", "2000(gal)/0"), ("line 14", "scale factor above 0")),
    (*replaced("a.EW", "2000(gal)", "0(gal)"), ("line 14", "scale factor above 0")),
    (*replaced("a.EW", "2000(gal)", "2000(kine)"), ("line 14", "(gal)/8388608")),
    (*replaced("a.EW", "     1234", "    12c34"), ("line 18", "must be numbers")),
    ("empty.EW", "", ("lines 1-17",)),
]


@pytest.mark.parametrize(("name", "text", "words"), BAD, ids=lambda v: v if isinstance(v, str) and len(v) < 20 else "")
def test_bad_records_are_refused_with_file_and_line(tmp_path: Path, name: str, text: str, words: tuple[str, ...]) -> None:
    path = tmp_path / name
    path.write_text(text)
    with pytest.raises(ValueError) as error:
        read_components(path)
    for word in (str(path), *words):
        assert word in str(error.value)


def test_a_unit_is_the_users_only_where_the_file_says_none(tmp_path: Path) -> None:
    path = tmp_path / "a.at2"
    path.write_text(TEXTS["new.AT2"].replace(" IN UNITS OF G", ""))
    np.testing.assert_allclose(read_record(path, "g").acceleration, SINE, atol=ROUNDING)
    np.testing.assert_allclose(read_record(path, "gal").acceleration, SINE / 981, atol=ROUNDING)
    for name in ("new.AT2", "a.smc", "a.csv", "a.V2"):
        path = tmp_path / name
        path.write_text(TEXTS[name])
        with pytest.raises(ValueError, match="unit: m/s2 contradicts"):
            read_record(path, "m/s2")


# ---------------------------------------------------------------- what a file holds, by its own words

ACCELERATION = {"acc (m/s2)": 1.0, "ax m/s2": 1.0, "EW [m/s2]": 1.0, "HNE_m_s2": 1.0, "acc_g": 9.81, "Acc (gal)": 0.01}
BESIDE = {
    "": [0, 1, 2], "index": [1, 2, 3], "Unnamed: 0": [0, 1, 2], "velocity": [7, 8, 9], "v": [7, 8, 9], "disp (m)": [7, 8, 9],
    "temperature": [7, 8, 9],
}  # fmt: skip
"""Columns beside time and acceleration, and what is in them."""


@pytest.mark.parametrize("name", ACCELERATION)
def test_names_decide_which_columns_are_read(tmp_path: Path, name: str) -> None:
    path = tmp_path / "a.csv"
    for beside, mark, order in itertools.product(BESIDE, ",;\t", itertools.permutations(range(3))):
        columns = [("time (s)", [0.0, 0.01, 0.02]), (name, [1.5, -2.5, 3.5]), (beside, BESIDE[beside])]
        placed = [columns[place] for place in order]
        rows = [[title for title, _ in placed], *([str(values[at]) for _, values in placed] for at in range(3))]
        path.write_text(text := "\n".join(mark.join(row) for row in rows))
        time, horizontal, *vertical = read_components(path)
        np.testing.assert_allclose(time, [0.0, 0.01, 0.02], err_msg=text)
        np.testing.assert_allclose(horizontal, ACCELERATION[name] * np.array([1.5, -2.5, 3.5]), rtol=1e-12, err_msg=text)
        assert not vertical, text


@pytest.mark.parametrize(
    ("names", "words"),
    [
        (",acc_g", ("name no columns of time",)),
        ("index,acc", ("name no columns of time",)),
        ("time (s),EW (g),NS (g)", ("'EW (g)', 'NS (g)' may each be the horizontal",)),
        ("EW (g),NS (g)", ("name no columns of time",)),
        ("time,acc 1,acc 2", ("may each be the horizontal",)),
        ("time,ax,ay,az", ("may each be the horizontal",)),
        ("time,az,UD", ("may each be the vertical",)),
        ("t,v,d", ("'v' is no acceleration but a velocity",)),
        ("T (s),PSA (g)", ("spectrum",)),
        ("period (s),Sa (g)", ("name no columns of time",)),
        ("time,pressure", ("not read",)),
        ("time,alpha,beta", ("quantity that is not known",)),
        ("time,t,acc", ("name 2 columns of time",)),
        ("time,UD (g)", ("vertical component", "vertical: {file: ...}")),
        ("time,index", ("name no column of acceleration",)),
    ],
)
def test_names_that_leave_a_choice_or_none_are_refused(tmp_path: Path, names: str, words: tuple[str, ...]) -> None:
    path = tmp_path / "a.csv"
    width = names.count(",") + 1
    path.write_text("\n".join([names, *(",".join([str(0.01 * at)] * width) for at in range(3))]))
    with pytest.raises(ValueError) as error:
        read_components(path)
    for word in (f"{path}, line 1: ", *words):
        assert word in str(error.value)


def test_lines_with_a_number_sign_are_left_out_or_hold_the_names(tmp_path: Path) -> None:
    path = tmp_path / "a.csv"
    for head in ("# made in May\n\ntime,acc_g\n", "# time,acc_g\n", "# made\n# time,acc_g\n"):
        path.write_text(head + "0,1\n# a gap\n0.01,2\n")
        np.testing.assert_allclose(read_record(path).acceleration, [9.81, 19.62])
    path.write_text("# time,vel,acc_g\n0,5,1\n0.01,6,2\n")
    np.testing.assert_allclose(read_record(path).acceleration, [9.81, 19.62])
    path.write_text("# acceleration in cm/s2\ntime,acc\n0,1\n0.01,2\n")
    with pytest.raises(ValueError, match=r"line 2: 'acc': does not say its unit; write it there, as in 'ax \(cm/s2\)'"):
        read_record(path)
    np.testing.assert_allclose(read_record(path, "gal").acceleration, [0.01, 0.02])


@pytest.mark.parametrize("mark", [";", "\t"])
@pytest.mark.parametrize(
    ("values", "refused"),
    [
        (["998.5", "1,123"], "'1,123' beside line 2: '998.5'"),
        (["998.5", "1,123.4"], "'1,123.4'|1,123.4"),
        (["998", "1,123"], "'1,123': its comma"),
        (["-1,123", "2,456,789"], "'-1,123'"),
        (["1,5", "2.5"], "'1,5' beside"),
        (["998,5", "1,123"], None),
        (["0,998", "1,123"], None),
    ],
)
def test_a_comma_that_may_separate_thousands_is_refused(tmp_path: Path, values: list[str], refused: str | None, mark: str) -> None:
    path = tmp_path / "a.csv"
    path.write_text("time (s);acc (gal)\n".replace(";", mark) + "".join(f"{at}{mark}{value}\n" for at, value in enumerate(values)))
    if refused is None:
        np.testing.assert_allclose(read_record(path).acceleration, [float(value.replace(",", ".")) / 100 for value in values])
        return
    with pytest.raises(ValueError, match=refused):
        read_record(path)


VERTICAL = {
    "a.UD": knet(SINE, RATE, direction="U-D"), "a.ud2": knet(SINE, RATE, direction="6"),
    "RSN6_ELC-UP.AT2": TEXTS["new.AT2"], "ELC-DWN.at2": TEXTS["new.AT2"],
    "x_vert.csv": TEXTS["a.csv"], "x-Z.smc": TEXTS["a.smc"], "TAB-V.V2": TEXTS["a.V2"],
    "head.knet": knet(SINE, RATE, direction="U-D"), "long.knet": knet(SINE, RATE, direction="Up-Down"),
    "up.AT2": TEXTS["new.AT2"], "second.AT2": TEXTS["new.AT2"].replace("Nowhere, 0", "Nowhere, UP"),
    "first.AT2": TEXTS["new.AT2"].replace("Nowhere, 0", "Nowhere, V1"),
    "text.V2": TEXTS["a.V2"].replace("line 8 1 2 3", "Chan  3:  Up          (Sta Chn:  3)"),
    "text.smc": TEXTS["a.smc"].replace("*", "Component = Vertical", 1),
    "column.csv": "time,UD (g)\n0,1\n0.01,2\n",
}  # fmt: skip


@pytest.mark.parametrize("name", VERTICAL)
def test_a_vertical_component_is_no_horizontal_motion(tmp_path: Path, name: str) -> None:
    path = tmp_path / name
    path.write_text(VERTICAL[name])
    for read in (read_record, read_components):
        with pytest.raises(ValueError, match=r"vertical component.*vertical: \{file: \.\.\.\}") as error:
            read(path)
        assert str(path) in str(error.value)
    if "E-W" not in VERTICAL[name]:
        assert len(read_components(path, wanted="vertical")) == 2


@pytest.mark.parametrize("name", ["a.EW", "b.ns2"])
def test_a_horizontal_component_is_no_vertical_motion(tmp_path: Path, name: str) -> None:
    (tmp_path / name).write_text(knet(SINE, RATE))
    with pytest.raises(ValueError, match="horizontal component"):
        read_components(tmp_path / name, wanted="vertical")


SENSORS = {
    "smc": [({13: 0}, "vertical"), ({13: 180}, "vertical"), ({13: 90}, "horizontal"), ({13: -32768}, None)],
    "V2": [({54: 400}, "vertical"), ({54: 401}, "vertical"), ({54: 402}, "vertical"), ({55: 400}, "vertical"), ({54: 1}, "horizontal"),
        ({54: 360}, "horizontal"), ({54: 500}, "horizontal"), ({54: 701}, "horizontal"), ({55: 90}, "horizontal"),
        ({54: 90, 55: 400}, "horizontal"), ({54: 2000}, None), ({}, None)],
}  # fmt: skip
"""Integers of headers by their number, and what they say of the sensor: the tables of the formats."""


@pytest.mark.parametrize(("ending", "given", "said"), [(ending, *each) for ending, cases in SENSORS.items() for each in cases])
def test_the_integers_of_headers_tell_a_vertical_sensor(tmp_path: Path, ending: str, given: dict[int, int], said: str | None) -> None:
    lines = TEXTS[f"a.{ending}"].split("\n")
    first = next((at for at, line in enumerate(lines, 1) if "Integer-header" in line), 11)
    each, width = {"smc": (8, 10), "V2": (10, 8)}[ending]
    for number, value in given.items():
        at, place = first + (number - 1) // each, width * ((number - 1) % each)
        lines[at] = lines[at][:place] + f"{value:{width}d}" + lines[at][place + width :]
    path = tmp_path / f"a.{ending}"
    path.write_text("\n".join(lines))
    directions: tuple[Direction, ...] = ("horizontal", "vertical")
    for wanted in directions:
        if said in (None, wanted):
            assert len(read_components(path, wanted=wanted)) == 2
        else:
            with pytest.raises(ValueError, match=rf"the {next(iter(given))}th integer.* a {said} component"):
                read_components(path, wanted=wanted)


@pytest.mark.parametrize(
    "title",
    ["PSEUDO SPECTRAL ACCELERATION IN UNITS OF G", "RESPONSE SPECTRUM (G)", "VELOCITY TIME SERIES IN UNITS OF CM/S", "DISPLACEMENT (CM)"],
)
def test_an_at2_file_of_another_quantity_is_refused(tmp_path: Path, title: str) -> None:
    path = tmp_path / "a.AT2"
    path.write_text(TEXTS["new.AT2"].replace("ACCELERATION TIME SERIES IN UNITS OF G", title))
    with pytest.raises(ValueError, match=f"a.AT2, line 3: .*acceleration.*{title[:6]}"):
        read_record(path)


def real(name: str, at: int, value: float) -> str:
    """A COSMOS text with another value of a real."""
    lines = TEXTS[name].split("\n")
    line = next(index for index, text in enumerate(lines) if "Real-header" in text) + 1 + at // 6
    first = 13 * (at % 6)
    return "\n".join([*lines[:line], lines[line][:first] + f"{value:13.6f}" + lines[line][first + 13 :], *lines[line + 1 :]])


def test_the_interval_of_a_cosmos_file_agrees_with_its_header(tmp_path: Path) -> None:
    path, whole = tmp_path / "a.V2", TEXTS["a.V2"]

    def unknown(recorded: float, length: float = -999.0, line: str = "approx   10 secs") -> str:
        text = whole.replace(f"{10.0:13.6f}", f"{-999.0:13.6f}").replace(f"{5.0:13.6f}", f"{recorded:13.6f}")
        TEXTS["made"] = text
        text = real("made", 62, length)
        del TEXTS["made"]
        return text.replace("approx   10 secs", line, 1)

    for text in (
        unknown(0.01),
        unknown(10.0),
        unknown(0.005, length=10.0),
        unknown(-999.0, length=10.0),
        unknown(-999.0, line="at 0.01 sec"),
        real("a.V2", 62, 10.0),
        real("a.V2", 63, -200.0),
    ):
        path.write_text(text)
        np.testing.assert_allclose(read_record(path).time, TIME, atol=1e-12)
    for text, word in (
        (unknown(0.005), "62nd real"),
        (unknown(5.0), "62nd real"),
        (unknown(-999.0), "62nd real"),
        (unknown(0.01, line=""), "62nd real"),
        (real("a.V2", 61, 0.01), "durations: 10 s"),
        (real("a.V2", 61, 20.0), "durations: 10 s"),
        (real("a.V2", 62, 60.0), "durations: 60 s, 10 s"),
        (real("a.V2", 63, 981.0), "64th real.*9.81 m/s2, its samples have 2 m/s2"),
    ):
        path.write_text(text)
        with pytest.raises(ValueError, match=word):
            read_record(path)


@pytest.mark.parametrize("ending", [".dat", ".sac", ".up", ".mseed", ""])
def test_an_unknown_ending_is_told_the_formats(tmp_path: Path, ending: str) -> None:
    path = tmp_path / f"record{ending}"
    path.write_text(TEXTS["new.AT2"])
    with pytest.raises(ValueError, match=r"PEER \.at2, K-NET.*COSMOS.*\.csv"):
        read_components(path)
    for command in (["motion"], ["newmark", "--ay", "1m/s2"]):
        result = call(command[0], path, *command[1:])
        assert result.exit_code == 2 and ("PEER .at2" in result.stderr or not ending), result.output


@pytest.mark.parametrize(
    ("head", "place", "vertical"),
    [("time (s),T (g)", 1, None), ("t,L (g),V (g)", 1, 2), ("time (s),V (g),L (g)", 2, 1), ("T (s),T (g)", 1, None)],
)
def test_t_is_transverse_beside_a_time_or_l_and_v_vertical(tmp_path: Path, head: str, place: int, vertical: int | None) -> None:
    rows = [(0.01 * at, 0.1 * at, -0.2 * at) for at in range(100)]
    width = head.count(",") + 1
    (tmp_path / "a.csv").write_text("\n".join([head, *(",".join(map(str, row[:width])) for row in rows)]))
    found = read_components(tmp_path / "a.csv")
    for samples, at in zip(found[1:], (place, vertical), strict=False):
        np.testing.assert_allclose(samples, 9.81 * np.array(rows)[:, at or 0])
    for untimed in ("L,T,V", "T (g),L (g)", "T,L"):
        (tmp_path / "b.csv").write_text(untimed + "\n" + "0.1,0.2,0.3\n"[-4 * (untimed.count(",") + 1) :])
        with pytest.raises(ValueError, match=r"b\.csv, line 1: .* name no columns of time"):
            read_components(tmp_path / "b.csv", "g")


SPEED = (1.0 - np.cos(2 * np.pi * TIME)) / np.pi
"""Velocity of the sine, m/s."""
SPEEDS: dict[str, tuple[str, Unit | None]] = {
    "named.csv": ("time (s), velocity (cm/s)\n" + "\n".join(f"{t:.2f},{100 * v:.9g}" for t, v in zip(TIME, SPEED, strict=True)), None),
    "bare.csv": ("\n".join(f"{t:.2f},{v:.9g}" for t, v in zip(TIME, SPEED, strict=True)), "m/s"),
    "counted.txt": ("Rock (Velocity in mps, TS=0.01s)\n1000, 0.01\n" + "\n".join(f"{v:.9g}" for v in SPEED), "m/s"),
}


@pytest.mark.parametrize("name", SPEEDS)
def test_velocities_are_differentiated(tmp_path: Path, name: str) -> None:
    text, unit = SPEEDS[name]
    (tmp_path / name).write_text(text)
    acceleration = read_record(tmp_path / name, unit).acceleration
    # Central differences of a sine are short by (2 pi INTERVAL)^2 / 6; one-sided ones at the ends by more.
    np.testing.assert_allclose(acceleration[1:-1], SINE[1:-1], atol=2.0 * (2 * np.pi * INTERVAL) ** 2 / 5)


@pytest.mark.parametrize(
    ("name", "text", "unit", "message"),
    [
        ("a.csv", "time (s), velocity\n0,0\n0.1,1\n", None, r"'velocity'.*holds velocities by its own words.*m/s, cm/s"),
        ("a.csv", "time (s), velocity (m/s)\n0,0\n0.1,1\n", "g", "holds velocities by its own words"),
        ("a.csv", "time (s), velocity (m/s)\n0,0\n0.1,1\n", "cm/s", "in another unit by its own words"),
        ("a.csv", "time (s), velocity (m/s), displacement (m)\n0,0,0\n1e-5,9999,0\n", None, "velocities are those of more than"),
        ("a.csv", "time (s), acc\n0,0\n0.1,1\n", "m/s", "holds accelerations by its own words or its format"),
        ("a.txt", "Velocity\n2 0.1\n0\n1\n", "m/s2", "holds velocities by its own words"),
        ("a.txt", "Acceleration\n2 0.1\n0\n1\n", "m/s", "holds accelerations by its own words"),
        ("a.at2", at2(SINE, INTERVAL), "m/s", "holds accelerations by its own words or its format"),
    ],
)
def test_what_may_be_velocity_or_acceleration_is_refused(tmp_path: Path, name: str, text: str, unit: Unit | None, message: str) -> None:
    (tmp_path / name).write_text(text)
    with pytest.raises(ValueError, match=message):
        read_record(tmp_path / name, unit)
