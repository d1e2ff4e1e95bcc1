"""What a search asks of a run: whether it reaches a class or a worse one, or a length or a place."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Annotated, Any, Literal, NamedTuple, get_args

from pydantic import AfterValidator, BeforeValidator

from sph.checks.after_run import is_held
from sph.measures.metrics import CLASSES, COLLAPSE, MetricSettings, class_displacement
from sph.measures.places import REACHED, PlaceName, column_of
from sph.scene.schema import Scene

DamageClass = Literal["minor", "damaged", "collapse"]
assert get_args(DamageClass) == CLASSES[1:]

RUNOUT, DISPLACEMENT = "runout", "displacement"
COLUMNS = {RUNOUT: "runout", DISPLACEMENT: "displacement_magnitude"}
"""Metrics of the lengths that a search can ask for."""


class Bound(NamedTuple):
    """What a metric must reach: a length, or 1 where debris is at a place."""

    quantity: str  # RUNOUT or DISPLACEMENT
    column: str
    least: float  # m; 1 of a place
    place: str  # '' for a length


def bound(wanted: str) -> Bound:
    """The bound of what is not a class, such as 'runout: road', 'runout: 20' or 'displacement: 0.1'; ValueError for anything else."""
    quantity, _, limit = (part.strip() for part in wanted.partition(":"))
    try:
        length = float(limit)
    except ValueError:
        length = math.nan
    if quantity in COLUMNS and 0.0 < length < math.inf:
        return Bound(quantity, COLUMNS[quantity], length, "")
    if quantity == RUNOUT and math.isnan(length) and limit:
        return Bound(quantity, column_of(limit, REACHED), 1.0, limit)
    raise ValueError(
        f"{wanted!r} is none of {', '.join(CLASSES[1:])}, {RUNOUT}: a place of metrics.places or a length above 0 in m, "
        f"{DISPLACEMENT}: a length above 0 in m"
    )


def _written(value: Any) -> Any:
    if isinstance(value, Mapping) and len(value) == 1:
        return ": ".join(map(str, *value.items()))
    return value


def _known(wanted: str) -> str:
    if wanted not in CLASSES[1:]:
        bound(wanted)
    return wanted


Boundary = Annotated[
    str,
    BeforeValidator(
        _written,
        json_schema_input_type=DamageClass | dict[Literal["runout", "displacement"], float | PlaceName],
    ),
    AfterValidator(_known),
]
"""A class of damage, or a length as 'runout: road', written in a file as one key and its value."""


def place_of(wanted: str) -> str:
    """The place that a run must reach; '' where no place is asked for."""
    return "" if wanted in CLASSES else bound(wanted).place


def reached(run: Mapping[Any, Any], wanted: str) -> bool | None:
    """Whether a run, by its metrics, has come to a boundary; None for a diverged run, which is on neither side."""
    name = run["collapse_class"]
    if name not in CLASSES:
        return None
    if wanted in CLASSES:
        return CLASSES.index(name) >= CLASSES.index(wanted)
    limit = bound(wanted)
    return bool(float(run[limit.column]) >= limit.least)


def shown(run: Mapping[Any, Any], wanted: str) -> bool | None:
    """The same, by its row of the points of a search; None also where its debris is braked before a length or a place.

    With more rows of particles that debris might come there.
    """
    verdict = reached(run, wanted)
    return None if verdict is False and wanted not in CLASSES and is_held(run) else verdict


def in_words(wanted: str) -> str:
    """A boundary as a legend names it."""
    if wanted in CLASSES:
        return f"class {wanted}" + ("" if wanted == COLLAPSE else " or worse")
    limit = bound(wanted)
    if limit.place:
        return f"{limit.place} reached by debris"
    return f"a {'run-out' if limit.quantity == RUNOUT else 'displacement'} of {limit.least:g} m"


def who_reaches_what(wanted: str) -> tuple[str, str]:
    """Subject and object of the sentence that a slope comes to a boundary: debris reaches a place, and the slope all else."""
    place = place_of(wanted)
    return ("debris", place) if place else ("the slope", in_words(wanted))


def block_displacement(wanted: str, scene: Scene, settings: MetricSettings) -> float:
    """Displacement (m) of a sliding block at which it comes to a boundary; NaN for a run-out, which a block does not have."""
    if wanted in CLASSES:
        return class_displacement(wanted, scene, settings)
    limit = bound(wanted)
    return limit.least if limit.quantity == DISPLACEMENT else math.nan
