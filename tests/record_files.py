"""Records as text in each format, from samples."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

GRAVITY = 9.81
FACTORS = (
    "x 10", "x1000", "*100", "* 0.01", "×10", "x 1E-3", "x 10^-3", "10^3", "10⁻³", "1e-3", "1.0E+02", "/1000", "/ 100", "times 10", "x0.1",
    "·10⁻²", "thousandths", "hundredths", "factor 100", "1000", "0.001", "‰", "milli", "1/100", "9.81",
)  # fmt: skip
"""Factors as people write them into the head of a column."""


def lines_of(values: Sequence[float], form: str, each: int) -> str:
    texts = [form.format(value) for value in values]
    return "\n".join("".join(texts[at : at + each]) for at in range(0, len(texts), each)) + "\n"


def at2(acceleration: np.ndarray, interval: float, head: str = "NPTS= {n:6d}, DT= {dt:8.5f} SEC,", title: str = "UNITS OF G") -> str:
    """PEER: g, five a line."""
    top = f"PEER NGA STRONG MOTION DATABASE RECORD\nMade, 1/1/2000, Nowhere, 0\nACCELERATION TIME SERIES IN {title}\n"
    return top + head.format(n=acceleration.size, dt=interval) + "\n" + lines_of(acceleration / GRAVITY, "{:15.7E}", 5)


def smc(acceleration: np.ndarray, interval: float, comments: int = 2, first: str = "2 CORRECTED ACCELEROGRAM") -> str:
    """USGS: cm/s2, eight a line in ten columns, which may touch."""
    integers, reals = [-32768] * 48, [1.7e38] * 50
    integers[15:17], reals[1] = [comments, acceleration.size], 1.0 / interval
    head = "\n".join([first, *["*"] * 10]) + "\n" + lines_of(integers, "{:10d}", 8) + lines_of(reals, "{:15.7E}", 5)
    return head + "| a comment with 1 2 3\n" * comments + lines_of(100.0 * acceleration, "{:10.4f}", 8)


def knet(acceleration: np.ndarray, rate: int, offset: int = 1234, direction: str = "E-W") -> str:
    """K-NET and KiK-net: counts, eight a line, with the recorder's offset; the peak in the head is that without their mean."""
    counts = np.rint(acceleration * 100.0 / 2000.0 * 8388608).astype(int) + offset
    return f"""Origin Time       2000/01/01 00:00:00
Lat.              38.920
Long.             140.630
Depth. (km)       7
Mag.              5.9
Station Code      AKT013
Station Lat.      39.6069
Station Long.     140.3213
Station Height(m) 34
Record Time       2000/01/01 00:00:39
Sampling Freq(Hz) {rate}Hz
Duration Time(s)  {acceleration.size / rate:.0f}
Dir.              {direction}
Scale Factor      2000(gal)/8388608
Max. Acc. (gal)   {np.abs(counts - counts.mean()).max() * 2000.0 / 8388608:.3f}
Last Correction   2000/01/01 00:00:00
Memo.
""" + lines_of(counts.tolist(), "{:9d}", 8)  # fmt: skip


def cosmos(acceleration: np.ndarray, interval: float, unit: str = "cm/sec2(04)", form: str = "8F10.5", further: bool = True) -> str:
    """COSMOS 1.20, one channel: cm/s2; with ``further`` a history of velocity behind the acceleration, as in files of CESMD."""
    each, width = int(form.split("F")[0]), int(form.split("F")[1].split(".")[0])
    texts = ["Corrected acceleration    (Format v01.20 with 13 text lines) Src: made", *[f"line {n} 1 2 3" for n in range(2, 14)]]
    reals = [-999.0] * 100
    reals[33], reals[61] = 5.0, 1000.0 * interval
    head = "\n".join(texts) + "\n 100 Integer-header values follow on  10 lines, Format=  (10I8)\n" + lines_of([-999] * 100, "{:8d}", 10)
    head += " 100 Real-header values follow on  17 lines, Format=  (6F13.6)\n" + lines_of(reals, "{:13.6f}", 6)
    head += '   1 Comment line(s) follow, each starting with a "|":\n| a comment\n'
    n, seconds = acceleration.size, acceleration.size * interval
    block = f"{n:8d} acceleration pts, approx {seconds:4.0f} secs, units={unit},Format=({form})\n"
    block += lines_of((100.0 * acceleration).tolist(), f"{{:{width}.5f}}", each)
    if further:
        block += f"{n:8d} velocity     pts, approx {seconds:4.0f} secs, units=cm/sec(05),Format=(8F10.5)\n"
        block += lines_of([0.0] * n, "{:10.5f}", 8)
    return head + block + "End-of-data for Chan  1 acceleration\n"


def esm(acceleration: np.ndarray, interval: float, unit: str = "cm/s^2", stream: str = "HNE") -> str:
    """ESM, header DYNA 1.2 in part: a sample a line, cm/s2."""
    values = 100.0 * acceleration
    head = {
        "EVENT_NAME": "MADE", "STATION_NAME": "Nowhere: a town", "LOCATION": "", "SAMPLING_INTERVAL_S": f"{interval:.6f}",
        "NDATA": str(values.size), "DURATION_S": f"{values.size * interval:.3f}", "STREAM": stream, "UNITS": unit,
        "PGA_CM/S^2": f"{np.abs(values).max():.6f}", "HEADER_FORMAT": "DYNA 1.2", "DATA_TYPE": "ACCELERATION", "USER5": "",
    }  # fmt: skip
    return "".join(f"{name}: {value}\n" for name, value in head.items()) + "".join(f"{value:.6f}\n" for value in values)


def afad(components: dict[str, np.ndarray], interval: float) -> str:
    """AFAD before 2020: 18 lines, three columns in gal."""
    head = ["STRONG GROUND MOTION RECORDS OF TURKIYE", *[f"LINE {at} : 1" for at in range(2, 13)]]
    count = next(iter(components.values())).size
    head += [f"NUMBER OF DATA : {count}", f"SAMPLING INTERVAL (sec) : {interval}", "RAW PGA VALUES (gal) : 1", "", ""]
    rows = ["".join(f"{100.0 * value:12.6f}" for value in row) for row in zip(*components.values(), strict=True)]
    return "\n".join([*head, " ".join(f"{name:>12}" for name in components), *rows]) + "\n"


def unam(components: dict[str, np.ndarray], interval: float) -> str:
    """UNAM: 109 lines, a column of gal for each channel."""
    columns = list(components.values())
    lists = {
        "ORIENTACION C1-C6 (rumbo;orientacion)": list(components),
        "INTERVALO DE MUESTREO, C1-C6 (s)": [f"{interval}"] * len(columns),
        "NUM. TOTAL DE MUESTRAS, C1-C6": [str(column.size) for column in columns],
        "ACEL. MAX.(Gal), C1-C6": [f"{100.0 * column[np.abs(column).argmax()]:.2f}" for column in columns],
    }
    head = [*["*"] * 6, "ARCHIVO ESTANDAR DE ACELERACION", *[f"{name:45}: /{'/'.join(values)}" for name, values in lists.items()]]
    head += [""] * (108 - len(head)) + ["-" * 60]
    rows = ["".join(f"{100.0 * value:12.4f}" for value in row) for row in zip(*columns, strict=True)]
    return "\n".join([*head, *rows]) + "\n"


def geonet(components: dict[str, np.ndarray], interval: float, corrected: bool = True, reading: float = 1.0) -> str:
    """GeoNet: mm/s2, or raw readings in a multiple of it, ten a line in columns of 8; behind them velocity and displacement, zeros."""
    text = ""
    for name, acceleration in components.items():
        n, values = acceleration.size, 1000.0 * acceleration
        numbers = [0.0] * 100
        numbers[33:36] = [n, n if corrected else 0, n if corrected else 0]
        numbers[63], numbers[65] = (n - 1) * interval, interval
        texts = ["Corrected" if corrected else "Uncorrected", *["text"] * 9]
        texts[0] += " accelerogram 20000101_000000_MADE_20 GNS Science"
        texts += [
            f"Instrument corrected data at {interval:.3f} sec intervals"
            if corrected
            else f"Raw readings in units of {reading:.2f} mm/s/s  at intervals of {interval:.3f} s"
        ]
        peak = values[np.abs(values).argmax()]
        texts += ["filter", f"Component {name}", f"Acceleration:  peak {peak:8.1f} mm/s/s at  0.25 sec", "velocity", "displacement"]
        text += "\n".join(texts) + "\n" + lines_of(numbers, "{:8.4f}", 10) + lines_of((values / reading).tolist(), "{:8.1f}", 10)
        text += 2 * lines_of([0.0] * n, "{:8.1f}", 10) if corrected else ""
    return text


def csmip(components: dict[str, np.ndarray], interval: float, volume: int = 2, azimuths: Sequence[int] = (90, 500, 360)) -> str:
    """CSMIP: volume 1 in g, 8F9.6, or volume 2 in cm/s2 with velocity and displacement behind it."""
    text = ""
    for at, ((name, acceleration), azimuth) in enumerate(zip(components.items(), azimuths, strict=True), 1):
        n, integers, reals = acceleration.size, [0] * 100, [0.0] * (50 if volume == 1 else 100)
        integers[26], first = azimuth, "Uncorrected Accelerogram Data   Processed: 01/01/00"
        texts = [first, *["text"] * 6, f"Chan  {at}:  {name}", *["text"] * 3, f"   Record length = {n * interval:.3f} sec.", "text"]
        if volume == 2:
            reals[60] = interval
            texts = [f"Corrected accelerogram  Chan  {at}:  {name}", *texts]
            texts += ["text"] * 3 + [f"Peak acceleration = {100.0 * np.abs(acceleration).max():9.3f}    cm/sec/sec  at  0.25 sec."]
            texts += ["text"] * (25 - len(texts))
        text += "\n".join(texts) + "\n" + lines_of(integers, "{:5d}", 16) + lines_of(reals, "{:10.7f}", 8)
        form = f"equally spaced at {interval:5.3f} sec"
        if volume == 1:
            text += f"{n} POINTS OF ACCEL DATA {form.upper()}.  (UNITS: G)\n" + lines_of((acceleration / GRAVITY).tolist(), "{:9.6f}", 8)
        else:
            text += f"{n:6d} points of accel data {form}, in cm/sec2. (8f10.6)\n"
            text += lines_of((100.0 * acceleration).tolist(), "{:10.5f}", 8)
            for what in ("veloc data equally spaced, in cm/sec. ", "displ data equally spaced, in cm. "):
                text += f"{n:6d} points of {what} (8f10.6)\n" + lines_of([0.0] * n, "{:10.6f}", 8)
        text += f"/&  ----------  End of data for channel  {at}  ----------\n"
    return text
