"""Liquefaction by empirical laws of the blow count: what cyclic shear does to loose sand, and what strength it then keeps.

(N1)60 is the blow count of the standard penetration test at 60 % energy and 1 atm of overburden, D_r the relative density.  All stresses
are effective.  No law here is fitted to runs.

* Volumetric strain by cyclic shear: Byrne (1991), whose coefficient C1 is 8.7 (N1)60^-1.25 or 7600 D_r^-2.5 with D_r in per cent; the two
  are one with D_r = 15 sqrt((N1)60).
* Fines: Idriss and Boulanger (2008) for the resistance to liquefaction, Seed (1987) for the residual strength.
* Residual strength: Idriss and Boulanger (2008), where void redistribution can matter and where it cannot; Kramer and Wang (2015).
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

ATMOSPHERE = 101.325e3
"""Pa"""
LARGEST_KRAMER_WANG = 15.0
"""Blow count up to which Kramer and Wang's strength holds: their flow slides have no more."""
RATIOS = {"idriss_boulanger": False, "idriss_boulanger_no_redistribution": True}
"""Residual strengths that are ratios to the initial vertical effective stress, and whether void redistribution is excluded."""


def volume_coefficient(blow_count: float) -> float:
    """C1 of Byrne (1991) from (N1)60."""
    return float(8.7 * blow_count**-1.25)


def volume_coefficient_of_density(relative_density: float) -> float:
    """C1 of Byrne (1991) from the relative density, %."""
    return float(7600.0 * relative_density**-2.5)


def blow_count_of_density(relative_density: float) -> float:
    """(N1)60 for a relative density, %, by which both forms of C1 are one."""
    return (relative_density / 15.0) ** 2


def clean_sand(blow_count: float, fines: float) -> float:
    """(N1)60 of the clean sand that liquefies as easily, from that with a fines content, %."""
    return blow_count + math.exp(1.63 + 9.7 / (fines + 0.01) - (15.7 / (fines + 0.01)) ** 2)


def clean_sand_residual(blow_count: float, fines: float) -> float:
    """(N1)60 of the clean sand that keeps as much strength: 1, 2, 4 and 5 more at 10, 25, 50 and 75 % of fines, linear between."""
    return blow_count + float(np.interp(fines, (0.0, 10.0, 25.0, 50.0, 75.0), (0.0, 1.0, 2.0, 4.0, 5.0)))


def residual_ratio(blow_count: float, no_redistribution: bool = False) -> float:
    """Residual strength over the initial vertical effective stress, from (N1)60 of clean sand: Idriss and Boulanger (2008)."""
    ratio = math.exp(blow_count / 16.0 + ((blow_count - 16.0) / 21.2) ** 3 - 3.0)
    return ratio * (1.0 + math.exp(blow_count / 2.4 - 6.6)) if no_redistribution else ratio


def kramer_wang(blow_count: float, vertical: np.ndarray) -> np.ndarray:
    """Residual strength (n,) from (N1)60 and initial vertical effective stress (n,), Pa: Kramer and Wang (2015)."""
    return ATMOSPHERE * np.exp(-8.444 + 0.109 * blow_count + 5.379 * (vertical / ATMOSPHERE) ** 0.1)


STRENGTHS: dict[str, Callable[[float, np.ndarray], np.ndarray]] = {
    **{name: lambda n, vertical, apart=apart: residual_ratio(n, apart) * vertical for name, apart in RATIOS.items()},  # type: ignore[misc]
    "kramer_wang": kramer_wang,
}
"""Residual strength (n,) by the name in scenes, from (N1)60 of clean sand and initial vertical effective stress (n,), Pa."""


def cyclic_resistance(blow_count: float) -> float:
    """Cyclic resistance ratio at magnitude 7.5 and 1 atm on level ground, from (N1)60 of clean sand: Boulanger and Idriss (2014)."""
    n = blow_count
    return math.exp(n / 14.1 + (n / 126.0) ** 2 - (n / 23.6) ** 3 + (n / 25.4) ** 4 - 2.8)
