"""The searches for the limits of a study's slopes: their names and files, and what they found.

A search is named after its limit and ends as the gravity stage that settles the slope (``yield_acceleration_soil.cohesion-20``).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, NamedTuple, TypeVar

from sph.scene.units import in_both
from sph.study.planned import Planned
from sph.study.stages import GRAVITY

YIELD, SAFETY = "yield_acceleration", "factor_of_safety"
SLOPE_LIMITS = (YIELD, SAFETY)
"""The limits of a slope: every study searches the first, the other is searched where it is asked for."""
TEXTS: dict[str, Callable[[float, float], str]] = {YIELD: in_both, SAFETY: "{:.2f} ± {:.2f}".format}
"""A limit with its error in words."""
AnyKey = TypeVar("AnyKey")


def search_name(gravity: str, limit: str = YIELD) -> str:
    """Name of the search for a limit of the slope that a gravity stage settles."""
    return limit + gravity.removeprefix(GRAVITY)


def searched_limit(name: str) -> str | None:
    """The limit that a search with this name looks for; None for the name of no search."""
    return next((limit for limit in SLOPE_LIMITS if name.startswith(limit)), None)


def found_words(facts: Mapping[str, Any]) -> tuple[str, str]:
    """The limit that a search found, with its error, and how, from the attributes of its file; the reason where it found none.

    Searches of earlier versions were at the spacing of the runs alone, and have no error.
    """
    if facts["reason"]:
        return f"not found: {facts['reason']}", ""
    limit, value = str(facts["by"]), float(facts["value"])
    if "error" in facts:
        return TEXTS[limit](value, float(facts["error"])), str(facts["how"])
    return in_both(value) if limit == YIELD else f"{value:.2f}", "at the spacing of the runs alone, which makes slopes too strong"


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
