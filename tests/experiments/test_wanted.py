"""What a search asks of a run: classes of damage, lengths and places."""

from __future__ import annotations

import math
from typing import Any

import pytest
from pydantic import TypeAdapter, ValidationError
from synthetic import PAPER

from sph.experiments.trigger.boundaries import Boundary, block_displacement, in_words, place_of, reached, shown, who_reaches_what
from sph.measures.metrics import UNDETERMINED, MetricSettings
from sph.scene.schema import make_scene

RUN = {"collapse_class": "damaged", "runout": 12.0, "displacement_magnitude": 1.5, "road_reached": 0.0, "house_reached": 1.0}
READ: Any = TypeAdapter(Boundary).validate_python


@pytest.mark.parametrize(
    ("wanted", "answer"),
    [
        ("minor", True),
        ("damaged", True),
        ("collapse", False),
        ("runout: 12", True),
        ("runout: 12.1", False),
        ("displacement: 0.1", True),
        ("displacement: 2", False),
        ("runout: road", False),
        ("runout: house", True),
    ],
)
def test_a_run_has_come_to_a_boundary_or_not(wanted: str, answer: bool) -> None:
    assert reached(RUN, wanted) is answer
    assert reached(RUN | {"collapse_class": UNDETERMINED, "runout": math.nan}, wanted) is None


@pytest.mark.parametrize(
    ("wanted", "answer"), [("runout: house", True), ("runout: road", None), ("runout: 12.1", None), ("collapse", False)]
)
def test_braked_debris_does_not_show_that_it_stops_short(wanted: str, answer: bool | None) -> None:
    assert shown(RUN | {"findings": "thin-layer weak-on-strong"}, wanted) is answer
    assert shown(RUN | {"findings": "thin-layer"}, wanted) is bool(answer)


@pytest.mark.parametrize(
    ("written", "read"), [({"runout": "road"}, "runout: road"), ({"displacement": 0.1}, "displacement: 0.1"), ("minor", "minor")]
)
def test_a_boundary_is_written_as_one_key_and_its_value(written: Any, read: str) -> None:
    assert READ(written) == read


@pytest.mark.parametrize("written", ["stable", "gone", {"runout": -1}, {"runout": math.inf}, {"runout": 1, "displacement": 2}, {"x": 1}, 3])
def test_anything_else_is_refused(written: Any) -> None:
    with pytest.raises(ValidationError):
        READ(written)


def test_boundaries_in_words() -> None:
    words = {"collapse": "class collapse", "minor": "class minor or worse", "runout: road": "road reached by debris"}
    words |= {"runout: 20": "a run-out of 20 m", "displacement: 0.1": "a displacement of 0.1 m"}
    assert {wanted: in_words(wanted) for wanted in words} == words
    assert who_reaches_what("runout: road") == ("debris", "road") and who_reaches_what("minor") == ("the slope", "class minor or worse")
    assert [place_of(wanted) for wanted in words] == ["", "", "road", "", ""]


def test_a_sliding_block_has_a_displacement_and_no_run_out() -> None:
    scene = make_scene(PAPER)
    assert block_displacement("displacement: 0.3", scene, MetricSettings()) == 0.3
    assert block_displacement("collapse", scene, MetricSettings()) == pytest.approx(2.5)
    assert math.isnan(block_displacement("runout: 3", scene, MetricSettings()))
