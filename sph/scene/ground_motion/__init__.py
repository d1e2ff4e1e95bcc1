"""Ground motions as samples: records in files, their processing and measures, and the motion of a scene.

``text``, ``units``, ``direction``                  what all formats share
``columns``                                       columns of a CSV by their names
``comma_separated``, ``untimed``, ``peer``, ``knet``, ``smc``, ``cosmos``, ``esm``  a format each, of one component
``csmip``, ``geonet``, ``afad``, ``unam``         a format each, of several components
``titles``                                        earthquake and station that a file names
``component``                                     which of several components is meant
``record``                                        a record in a scene: the section ``motion`` of kind ``record``
``stochastic``                                    a synthetic motion in place of a record's file
``processing``                                    baseline, band-pass, trim, resampling
``measures``, ``spectrum``                        peaks, Arias intensity, durations; response spectrum

Signs: positive horizontal acceleration of the ground drives soil towards the toe of a scene, positive vertical acceleration points
up and presses soil on the ground.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

import numpy as np

from sph.scene.ground_motion import afad, csmip, knet, unam
from sph.scene.ground_motion.comma_separated import read_csv
from sph.scene.ground_motion.component import Component, chosen
from sph.scene.ground_motion.cosmos import read_cosmos
from sph.scene.ground_motion.direction import Direction, check_name
from sph.scene.ground_motion.esm import read_esm
from sph.scene.ground_motion.geonet import read_geonet
from sph.scene.ground_motion.peer import OTHER_HISTORIES, read_at2
from sph.scene.ground_motion.smc import read_smc
from sph.scene.ground_motion.text import MAX_ACCELERATION as MAX_ACCELERATION
from sph.scene.ground_motion.text import read_lines
from sph.scene.ground_motion.units import Unit
from sph.scene.ground_motion.untimed import read_untimed

SCENES = (".yaml", ".yml")
KNET = tuple(f".{direction}{number}" for direction in ("ew", "ns", "ud") for number in ("", "1", "2")) + (".knet",)
COSMOS = (".v1", ".v2", ".v1c", ".v2c")
READERS = {
    ".csv": read_csv,
    ".txt": read_csv,
    ".at2": read_at2,
    ".smc": read_smc,
    ".asc": read_esm,
    ".th": read_untimed,
    ".acc": read_untimed,
    **dict.fromkeys(KNET, knet.read_knet),
    **dict.fromkeys(COSMOS, read_cosmos),
}
"""Readers of files with one component, by their endings."""
Several = Callable[[Path | str, Unit | None], list[Component]]
"""Reader of the components of a file."""
SEVERAL: dict[str, Several] = {
    ".v1a": read_geonet,
    ".v2a": read_geonet,
    ".raw": csmip.read_csmip,
    ".asa": unam.read_unam,
}
"""Readers of files with several components, by their endings."""
TOP = 7
"""Lines of a file in which its format can be told."""
CONTENTS: dict[str, tuple[tuple[re.Pattern[str], Several], ...]] = {
    ".v1": ((csmip.FIRST, csmip.read_csmip),),
    ".v2": ((csmip.FIRST, csmip.read_csmip),),
    ".txt": ((afad.FIRST, afad.read_afad), (unam.FIRST, unam.read_unam)),
}
"""Formats of several components that share an ending of ``READERS``, by a line that tells them."""
RECORDS = (*READERS, *SEVERAL)
"""Endings of the files that hold a ground motion."""


class GroundMotion(NamedTuple):
    """Horizontal acceleration of the ground, linear between the samples."""

    time: np.ndarray  # (n,) increasing, s
    acceleration: np.ndarray  # (n,) m/s2

    @property
    def peak(self) -> float:
        """Largest absolute acceleration, m/s2."""
        return float(np.abs(self.acceleration).max())

    def scaled(self, peak: float) -> GroundMotion:
        """The same motion with another peak (m/s2); raises ValueError unless both are positive and finite."""
        if self.peak == 0 or not 0 < peak < math.inf:
            raise ValueError(f"peak: {peak} m/s2 for a motion with {self.peak:g} m/s2; both must be positive and finite")
        return self._replace(acceleration=self.acceleration * (peak / self.peak))


def read_record(path: Path | str, unit: Unit | None = None, component: str | None = None) -> GroundMotion:
    """Horizontal motion in a file of one of the formats, a CSV without names with one acceleration.

    ``component`` is that of ``read_components``.  ValueError with file, line and what is expected.
    """
    path = Path(path)
    check_record(path)
    if READERS.get(path.suffix.lower()) is read_csv and _several(path) is None and component is None:
        check_name(path, "horizontal")
        return GroundMotion(*read_csv(path, unit, third=False)[:2])
    return GroundMotion(*read_components(path, unit, component=component)[:2])


def read_components(
    path: Path | str, unit: Unit | None = None, wanted: Direction = "horizontal", component: str | None = None
) -> tuple[np.ndarray, ...]:
    """Time (n,) in s and one or, where the vertical is in the file too, two accelerations (n,) in m/s2, the wanted first.

    ``component`` is the name or the number of the horizontal component in a file that holds several.  ValueError as ``read_record``, and
    for a component of the other direction.
    """
    check_record(Path(path))
    check_name(path, wanted)
    several = _several(path)
    if several is not None:
        return chosen(path, several(path, unit), wanted, component)
    read = READERS[Path(path).suffix.lower()](path, unit, wanted)
    if component is not None:
        raise ValueError(f"component: {component!r}: {path} is of a format that holds one horizontal component; leave it out")
    return read


def in_borehole(path: Path | str) -> bool:
    """Whether a record is, by its own words, of an instrument in a borehole: KiK-net says so."""
    return Path(path).suffix.lower() in KNET and knet.in_borehole(path)


def _several(path: Path | str) -> Several | None:
    """The reader of a file with several components, by its ending or its first lines; None for another file."""
    ending = Path(path).suffix.lower()
    if ending in SEVERAL or ending not in CONTENTS:
        return SEVERAL.get(ending)
    top = read_lines(path)[:TOP]
    return next((reader for mark, reader in CONTENTS[ending] if any(map(mark.match, top))), None)


def check_record(path: Path, others: tuple[str, ...] = ()) -> None:
    """Refuse a file that by its ending is no record, nor one of the ``others``."""
    ending = path.suffix.lower()
    if ending in OTHER_HISTORIES:
        raise ValueError(
            f"{path}: is a PEER file of {OTHER_HISTORIES[ending]}, and one of acceleration is needed: name the .AT2 file of the same "
            f"component ({path.with_suffix('.AT2').name})"
        )
    if ending not in (*RECORDS, *others):
        scene = f"a scene ({', '.join(others)}) or " if others else ""
        raise ValueError(
            f"{path}: must be {scene}a record, by its ending (found {path.suffix!r}): PEER .at2, K-NET and KiK-net .ew .ns .ud or .knet, "
            "SMC .smc, COSMOS .v1 .v2 .v1c .v2c, CSMIP .v1 .v2 .raw, ESM .asc, GeoNet .v1a .v2a, AFAD .txt, UNAM .asa .txt, samples "
            "without times .th .acc, or .csv and .txt; give the file the ending of its format, or write it as .csv below a line "
            "'time (s),acceleration (m/s2)'"
        )
