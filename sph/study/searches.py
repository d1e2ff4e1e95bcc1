"""The searches for the limits of a study's slopes, and what they found."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple, TypeVar

from sph.study.planned import Planned, planned
from sph.study.runs import PlannedRun

AnyKey = TypeVar("AnyKey")


class SlopeSearch(NamedTuple):
    """The search for a limit of a slope."""

    file: str
    scene: Planned


def slope_searches(searches: Mapping[AnyKey, PlannedRun]) -> dict[AnyKey, SlopeSearch]:
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
