"""Order of convergence with the particle spacing, and the grid-convergence index.

Procedure of Celik et al. (2008), "Procedure for estimation and reporting of uncertainty due to discretization in CFD
applications", J. Fluids Eng. 130, 078001, for spacings whose ratios differ: with the values f1, f2, f3 at the spacings
h1 < h2 < h3, r21 = h2 / h1 and r32 = h3 / h2,

    p = |ln |e32 / e21| + q(p)| / ln r21,   q(p) = ln((r21^p - s) / (r32^p - s)),   s = sign(e32 / e21)     (their Eqs. 3-5)

with e32 = f3 - f2 and e21 = f2 - f1; the extrapolated value is (r21^p f1 - f2) / (r21^p - 1), the index 1.25 e / (r21^p - 1) with
e = |(f1 - f2) / f1|.  For a monotonic sequence this p solves e32 / e21 = r21^p (r32^p - 1) / (r21^p - 1), which rises
with p and is solved by bisection.

Departure from the source: the absolute value, which turns a diverging sequence into a converging one, is not taken, and an
oscillating sequence gets no order; both are said plainly instead.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import pandas as pd
import scipy  # type: ignore[import-untyped]

from sph.storage.trajectory import Variable
from sph.study.tables import ROW, number_column, text_column

SAFETY = 1.25
"""Factor of safety of the index for three spacings."""
ORDERS = (0.5, 3.0)
"""Orders that count as convergence: the scheme's is between 1 and 2; one far outside is a coincidence of three numbers."""
MAX_ORDER = 20.0
QUANTITIES = ("displacement_magnitude", "runout", "onset_after_start")

CONVERGENCE: tuple[Variable, ...] = (
    text_column("quantity", "column of the table"),
    text_column("case", "point of the study"),
    Variable("spacings", ROW, "str", "m", "spacings of the variants, finest first"),
    text_column("values", "values of the quantity at these spacings, in its own unit"),
    number_column("order", "1", "observed order on the three finest spacings; NaN where there is none"),
    number_column("extrapolated", "1", "value extrapolated to spacing 0, in the quantity's unit; NaN without convergence"),
    number_column("gci", "1", "grid-convergence index of the finest value, relative; NaN without convergence"),
    number_column("spread", "1", "range of the three finest values over the absolute value of their mean"),
    text_column("verdict", "the result in words"),
)


class Convergence(NamedTuple):
    """What three spacings say about the limit."""

    order: float
    extrapolated: float
    gci: float
    spread: float
    verdict: str


def observed_convergence(spacings: Sequence[float], values: Sequence[float]) -> Convergence:
    """Order, limit, index and verdict from the three finest of at least three spacings (m) and the values there.

    Raises ValueError for fewer than three, and for spacings that are not positive and different.
    """
    if len(spacings) != len(values) or len(spacings) < 3:
        raise ValueError(f"spacings: {list(spacings)} and values: {list(values)}; convergence needs three of each")
    by_size = sorted(zip(spacings, values, strict=True))[:3]
    h, f = np.array([pair[0] for pair in by_size]), np.array([pair[1] for pair in by_size])
    if not (h > 0).all() or not (np.diff(h) > 0).all():
        raise ValueError(f"spacings: {list(spacings)} must be positive and different")
    spread = float((f.max() - f.min()) / abs(f.mean())) if f.mean() != 0 else math.nan
    moves = f"its three finest values span {100 * spread:.2g} % of their mean"
    none = Convergence(math.nan, math.nan, math.nan, spread, "")
    e21, e32 = f[1] - f[0], f[2] - f[1]
    if e21 == 0 and e32 == 0:
        return none._replace(extrapolated=float(f[0]), gci=0.0, verdict="does not depend on the spacing")
    if e21 == 0 or e32 / e21 <= 0:
        return none._replace(verdict=f"does not converge: it oscillates, {moves}")
    r21, r32 = h[1] / h[0], h[2] / h[1]
    order = _order(e32 / e21, r21, r32)
    if math.isnan(order):
        return none._replace(verdict=f"does not converge: its changes grow as the spacing falls, {moves}")
    if not ORDERS[0] <= order <= ORDERS[1]:
        outside = f"order {order:.2g} lies outside {ORDERS[0]:g} to {ORDERS[1]:g}"
        return none._replace(order=order, verdict=f"does not converge: {outside}, {moves}")
    extrapolated = float((r21**order * f[0] - f[1]) / (r21**order - 1))
    gci = float(SAFETY * abs(e21 / f[0]) / (r21**order - 1)) if f[0] != 0 else math.nan
    verdict = f"converges with order {order:.2g} to {extrapolated:.3g}, the finest value within {100 * gci:.2g} %"
    return Convergence(order, extrapolated, gci, spread, verdict)


def _order(ratio: float, r21: float, r32: float) -> float:
    """Root p of ratio = r21^p (r32^p - 1) / (r21^p - 1), at most ``MAX_ORDER``; NaN where none is positive."""

    def excess(p: float) -> float:
        return p * math.log(r21) + math.log(math.expm1(p * math.log(r32)) / math.expm1(p * math.log(r21))) - math.log(ratio)

    smallest = 1e-6
    if excess(smallest) >= 0:
        return math.nan
    if excess(MAX_ORDER) <= 0:
        return MAX_ORDER
    return float(scipy.optimize.brentq(excess, smallest, MAX_ORDER, xtol=1e-12))


def convergence_table(frame: pd.DataFrame, parameter: str) -> pd.DataFrame:
    """Frame with the columns of ``CONVERGENCE``: every quantity and case on the variants of a parameter that differ in spacing.

    ``frame`` as from ``cost_accuracy_table``.  Runs without the value (diverged, or motion that never began) are left out.
    """
    rows = []
    for quantity in QUANTITIES:
        for case, variants in frame[frame["parameter"] == parameter].groupby("case", sort=False):
            known = variants[np.isfinite(variants[quantity])].sort_values("spacing")
            spacings, values = known["spacing"].tolist(), known[quantity].tolist()
            if len(values) >= 3:
                result = observed_convergence(spacings, values)
            else:
                result = Convergence(*4 * (math.nan,), f"not measured: {len(values)} spacings have a value, three are needed")
            words = (" ".join(f"{each:{form}}" for each in listed) for listed, form in ((spacings, "g"), (values, ".6g")))
            rows.append((quantity, case, *words, *result))
    return pd.DataFrame(rows, columns=[row.name for row in CONVERGENCE])
