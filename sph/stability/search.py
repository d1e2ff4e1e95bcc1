"""The limit between what stands and what fails, by bracket and bisection."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from typing import NamedTuple

MIN_TOLERANCE = 1e-6
"""Smallest relative width of a bracket; bisection of numbers ends at 1e-16, and a simulation's verdict long before."""
TOLERANCE = 0.005
"""Relative width of a bracket at which a search ends; the extrapolation over two spacings magnifies it up to threefold."""
NEARBY = 1.03
"""Ratio of neighbouring values about one that is near the limit."""


class Trial(NamedTuple):
    """One static test."""

    value: float
    """what was tried: a factor of safety, a strength ratio or an acceleration (m/s2)"""
    stands: bool
    displaced_area: float
    """area of the soil displaced by more than the rule allows, m2"""
    largest_displacement: float
    """m"""
    status: str
    """of the run, see ``sph.storage.trajectory.Status``"""
    wall_time: float
    """s"""


class Search(NamedTuple):
    """The limit found, between the last value that stood and the first that failed (NaN where nothing tried did)."""

    stood: float
    failed: float
    trials: tuple[Trial, ...]

    @property
    def lower(self) -> float:
        """Smaller end of the bracket."""
        return min(self.stood, self.failed)

    @property
    def upper(self) -> float:
        """Larger end of the bracket."""
        return max(self.stood, self.failed)

    @property
    def value(self) -> float:
        """Middle of the bracket."""
        return 0.5 * (self.stood + self.failed)


def around(values: Sequence[float], near: float | None, start: int) -> tuple[Sequence[float], int]:
    """The values of a walk and its start, closer about one that is ``near`` the limit; as they are without it or beyond their ends."""
    if near is None or not min(values) < near < max(values):
        return values, start
    steps = [near * NEARBY**power for power in range(-5, 6)]
    beside = [value for value in values if not steps[0] <= value <= steps[-1] or value in (values[0], values[-1])]
    closer = sorted({*beside, *(value for value in steps if min(values) < value < max(values))}, reverse=values[0] > values[-1])
    return closer, closer.index(near)


def search(
    test: Callable[[float], Trial],
    values: Sequence[float],
    start: int = 0,
    tolerance: float = TOLERANCE,
    smallest: float = 0.0,
    report: Callable[[Trial], None] | None = None,
    known: Mapping[float, Trial] | None = None,
) -> Search:
    """Walk along ``values``, from stable to unstable, until the verdict changes; then bisect.

    The walk begins at index ``start`` and goes towards the unstable end while the tests stand, towards the stable one while they
    fail.  The bracket is closed to ``tolerance`` times its middle, or times ``smallest`` if that is larger.
    Tests whose outcome is ``known``, by value, are not made again.  ValueError for a tolerance below ``MIN_TOLERANCE``.
    """
    if not tolerance >= MIN_TOLERANCE:
        raise ValueError(f"tolerance: {tolerance} must be positive, {MIN_TOLERANCE:g} at least")
    trials: list[Trial] = []

    def stands(value: float) -> bool:
        trials.append((known or {}).get(value) or test(value))
        if report is not None:
            report(trials[-1])
        return trials[-1].stands

    first = stands(values[start])
    ends = {first: values[start], not first: math.nan}
    for value in values[start + 1 :] if first else values[:start][::-1]:
        verdict = stands(value)
        ends[verdict] = value
        if verdict != first:
            break
    while abs(ends[True] - ends[False]) > tolerance * max(0.5 * (ends[True] + ends[False]), smallest):
        middle = 0.5 * (ends[True] + ends[False])
        ends[stands(middle)] = middle
    return Search(ends[True], ends[False], tuple(trials))
