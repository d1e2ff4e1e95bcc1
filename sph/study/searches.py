"""The searches for the limits of a study's slopes, and what they found."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, NamedTuple, TypeVar

from sph.scene.units import in_both
from sph.study.planned import Planned, planned
from sph.study.runs import SAFETY, YIELD, Run

TEXTS: dict[str, Callable[[float, float], str]] = {YIELD: in_both, SAFETY: "{:.2f} ± {:.2f}".format}
"""A limit with its error in words."""
AnyKey = TypeVar("AnyKey")


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
    """The search for a limit of a slope."""

    file: str
    scene: Planned


def slope_searches(searches: Mapping[AnyKey, Run]) -> dict[AnyKey, SlopeSearch]:
    """Searches of the catalogue as measuring needs them; the scene of each is planned once."""
    each = {run.file: run for run in searches.values()}
    known = {file: SlopeSearch(file, planned(run.scene)) for file, run in each.items()}
    return {at: known[run.file] for at, run in searches.items()}


def yield_accelerations(searches: Mapping[AnyKey, SlopeSearch]) -> dict[AnyKey, float]:
    """What searches found, m/s2, by the keys that they are given with: 0 for a slope that does not stand, NaN where one found none.

    ValueError names a file of another slope.
    """
    values = {file: float(scene.read(file).attrs["value"]) for file, scene in {each.file: each.scene for each in searches.values()}.items()}
    return {at: values[search.file] for at, search in searches.items()}
