"""Records of K-NET and KiK-net in ASCII (``.EW``, ``.NS``, ``.UD``, ``.EW1`` ...), by ObsPy's reader.

https://www.kyoshin.bosai.go.jp: 17 lines of head, then counts of the recorder; the scale factor in the head turns them into gal.
They are as recorded: the offset of the recorder is in them, see ``baseline``.
"""

from __future__ import annotations

import io
import warnings
from pathlib import Path

import numpy as np

from sph.scene.extras import of_extra
from sph.scene.ground_motion.direction import Direction, check_direction, direction_of
from sph.scene.ground_motion.text import LARGEST_ACCELERATION, check_head, number, read_lines
from sph.scene.ground_motion.units import Unit, size_of
from sph.scene.units import SIZES

HEAD, RATE, DURATION, DIRECTION, FACTOR = 17, 10, 11, 12, 13
"""Lines of the head; indices of its lines with sampling rate, duration, direction and scale factor."""


def read_knet(path: Path | str, unit: Unit | None = None, wanted: Direction = "horizontal") -> tuple[np.ndarray, ...]:
    """Time (n,) in s from 0 on and acceleration (n,) in m/s2; ValueError with file and line, where there is one."""
    lines = [line.rstrip() for line in read_lines(path)]
    if len(lines) <= HEAD or not lines[0].startswith("Origin Time") or not lines[HEAD - 1].startswith("Memo"):
        raise ValueError(f"{path}, lines 1-{HEAD}: must be a K-NET head, 'Origin Time' to 'Memo.'")
    check_direction(f"{path}, line {DIRECTION + 1}: {lines[DIRECTION]!r}", direction_of(lines[DIRECTION][len("Dir.") :]), wanted)
    for index in range(HEAD, len(lines)):
        if None in map(number, lines[index].split()):
            raise ValueError(f"{path}, line {index + 1}: must be numbers (found {lines[index][:80]!r})")
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # of ObsPy's entry points, and of what is refused below
        obspy = of_extra("obspy", "records")
        try:
            [trace] = obspy.read(io.BytesIO("\n".join(lines).encode("ascii", "replace")), format="KNET")
        except Exception as error:  # its own, and IndexError, ValueError or AttributeError of a damaged head
            raise ValueError(f"{path}, lines 1-{HEAD}: no K-NET head: {error}") from error
    rate, calibration = float(trace.stats.sampling_rate), float(trace.stats.calib)
    seconds = float(trace.stats.knet.duration)
    if not 0 < calibration < np.inf or "(gal)" not in lines[FACTOR]:
        raise ValueError(f"{path}, line {FACTOR + 1}: must be a scale factor in gal (found {lines[FACTOR]!r})")
    check_head(path, trace.stats.npts, 1.0 / rate if rate > 0 else np.inf)
    if abs(trace.stats.npts / rate - seconds) > 1.0:  # durations are in whole seconds
        raise ValueError(
            f"{path}: must hold the {seconds * rate:,.0f} samples that its head announces (lines {RATE + 1} and {DURATION + 1}), "
            f"holds {trace.stats.npts:,}; is it whole?"
        )
    # ObsPy's calibration gives m/s2.
    acceleration = trace.data * (calibration / SIZES["gal"] * size_of(path, SIZES["gal"], unit))
    if not np.abs(acceleration).max() <= LARGEST_ACCELERATION:
        raise ValueError(f"{path}: must be finite accelerations up to {LARGEST_ACCELERATION:g} m/s2")
    return np.arange(trace.stats.npts) / rate, acceleration
