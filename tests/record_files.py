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
