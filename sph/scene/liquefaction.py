"""Liquefaction by empirical laws of the blow count: what cyclic shear does to loose sand, and what strength it then keeps.

(N1)60 is the blow count of the standard penetration test at 60 % energy and 1 atm of overburden, D_r the relative density.  All stresses
are effective.  No law here is fitted to runs.

* Volumetric strain by cyclic shear: Byrne (1991), whose coefficient C1 is 8.7 (N1)60^-1.25 or 7600 D_r^-2.5 with D_r in per cent; the two
  are one with D_r = 15 sqrt((N1)60).
* Overburden: Liao and Whitman (1986).
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


def normalised_blow_count(blow_count: np.ndarray, vertical: np.ndarray) -> np.ndarray:
    """(N1)60 (n,) of N60 (n,) under vertical effective stresses (n,), Pa: Liao and Whitman (1986), at most 1.7 times."""
    return blow_count * np.minimum(np.sqrt(ATMOSPHERE / vertical), 1.7)


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


# ---------------------------------------------------------------- the simplified procedure

LARGEST_RESISTANCE = 2.0
"""Cyclic resistance ratio beyond which none is told: sand with more than 37 blows does not liquefy."""
LARGEST_DEPTH = 20.0
"""Depth to which the factor of stress reduction is known, m."""


def stress_reduction(depth: np.ndarray, magnitude: float) -> np.ndarray:
    """r_d (n,) at depths (n,), m: shear stress of level ground over that of a rigid column (Boulanger and Idriss 2014)."""
    alpha = -1.012 - 1.126 * np.sin(depth / 11.73 + 5.133)
    beta = 0.106 + 0.118 * np.sin(depth / 11.28 + 5.142)
    return np.exp(alpha + beta * magnitude)


def magnitude_factor(magnitude: float, blow_count: float) -> float:
    """Magnitude scaling factor of sand from (N1)60 of clean sand: Boulanger and Idriss (2014)."""
    largest = min(1.09 + (blow_count / 31.5) ** 2, 2.2)
    return 1.0 + (largest - 1.0) * (8.64 * math.exp(-magnitude / 4.0) - 1.325)


def overburden_factor(blow_count: float, vertical: np.ndarray) -> np.ndarray:
    """K_sigma (n,) from (N1)60 of clean sand and vertical effective stress (n,), Pa: Boulanger and Idriss (2014)."""
    rate = min(1.0 / (18.9 - 2.55 * math.sqrt(min(blow_count, 37.0))), 0.3)
    return np.minimum(1.0 - rate * np.log(vertical / ATMOSPHERE), 1.1)


def sand_resistance(blow_count: float, magnitude: float, vertical: np.ndarray) -> np.ndarray:
    """Cyclic resistance ratio (n,) of sand on level ground at a magnitude and under vertical effective stresses (n,), Pa."""
    at_reference = min(cyclic_resistance(blow_count), LARGEST_RESISTANCE)
    return np.minimum(at_reference * magnitude_factor(magnitude, blow_count) * overburden_factor(blow_count, vertical), LARGEST_RESISTANCE)


def clay_resistance(undrained: np.ndarray, magnitude: float, static: float = 0.0) -> np.ndarray:
    """Cyclic resistance ratio (n,) of clay at a magnitude: Boulanger and Idriss (2007).

    From its undrained strength over the vertical effective stress (n,), and the static shear stress over the undrained strength.
    """
    shear_factor = 1.344 - 0.344 / (1.0 - static) ** 0.638
    return 0.96 * 0.83 * undrained * shear_factor * (1.12 * math.exp(-magnitude / 4.0) + 0.828)
