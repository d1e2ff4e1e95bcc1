"""The searches for the limits of a study's slopes: their names and files, and what they found.

A search is named after its limit and ends as the gravity stage that settles the slope (``yield_acceleration_soil.cohesion-20``).
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple, TypeVar

from sph.study.planned import Planned
from sph.study.stages import GRAVITY

YIELD, SAFETY = "yield_acceleration", "factor_of_safety"
SLOPE_LIMITS = (YIELD, SAFETY)
"""The limits of a slope: every study searches the first, the other is searched where it is asked for."""
AnyKey = TypeVar("AnyKey")


def search_name(gravity: str, limit: str = YIELD) -> str:
    """Name of the search for a limit of the slope that a gravity stage settles."""
    return limit + gravity.removeprefix(GRAVITY)


def searched_limit(name: str) -> str | None:
    """The limit that a search with this name looks for; None for the name of no search."""
    return next((limit for limit in SLOPE_LIMITS if name.startswith(limit)), None)


class SlopeSearch(NamedTuple):
    """The search for the yield acceleration of a slope."""

    name: str
    file: str
    scene: Planned


def yield_accelerations(searches: Mapping[AnyKey, SlopeSearch]) -> dict[AnyKey, float]:
    """What searches found, m/s2, by the keys that they are given with: 0 for a slope that does not stand, NaN where one found none.

    ValueError names a file of another slope.
    """
    values = {file: float(scene.read(file).attrs["value"]) for file, scene in {each.file: each.scene for each in searches.values()}.items()}
    return {at: values[search.file] for at, search in searches.items()}
