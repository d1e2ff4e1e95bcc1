"""Records as text in each format, from samples."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

GRAVITY = 9.81


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


def knet(acceleration: np.ndarray, rate: int, offset: int = 1234) -> str:
    """K-NET: counts, eight a line, with the recorder's offset."""
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
Dir.              E-W
Scale Factor      2000(gal)/8388608
Max. Acc. (gal)   4.383
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
