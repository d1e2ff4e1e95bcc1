"""A part of the fuzz that ``fuzz.py`` does: whatever is written is carried out or refused by name."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest
from configurations import changed, keys, section
from hypothesis import HealthCheck, Phase, given, settings
from hypothesis import strategies as st
from inputs import ASSUMPTIONS, COST_ACCURACY, FREE, MODELS, SCENES, SENSITIVITY, STUDY, TRIGGER
from pydantic import BaseModel

from sph.scene.configuration import validated
from tools.reference import key_rows

BASES: dict[str, list[dict[str, Any]]] = {
    "scene": SCENES,
    "study": [STUDY, *FREE],
    "cost-accuracy": [COST_ACCURACY],
    "assumptions": [ASSUMPTIONS],
    "sensitivity": [SENSITIVITY],
    "trigger": [TRIGGER],
    "rule": [{}],
}
plain = settings(max_examples=50, deadline=None, phases=[Phase.reuse, Phase.generate], suppress_health_check=list(HealthCheck))


@pytest.mark.parametrize("examples", [15, pytest.param(150, marks=pytest.mark.long)])
def test_everything_a_user_can_write_is_carried_out_or_refused_by_name(examples: int) -> None:
    """So many examples of every kind, the solver's first steps included."""
    script = Path(__file__).with_name("fuzz.py")
    done = subprocess.run([sys.executable, str(script), "--examples", f"{examples}"], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    counts = {outcome.strip(): int(count.replace(",", "")) for count, outcome in re.findall(r"([\d,]+)  all +(.*)", done.stdout)}
    assert sum(counts.values()) > 0.96 * examples
    # Some 13 % are; chance is worth 5 % of 40.
    assert counts["accepted, run"] > 0.05 * examples, "the examples are refused too often to say anything of what comes after"


@pytest.mark.parametrize("name", MODELS)
@plain
@given(data=st.data())
def test_every_section_takes_or_refuses_anything(name: str, data: st.DataObject) -> None:
    model = MODELS[name]
    anything = st.one_of(section(model), *(changed(model, base, most) for base in BASES[name] for most in (1, 3)))
    try:
        found = validated(model, data.draw(anything), "some.yaml")
    except ValueError as error:
        assert all(line.startswith("some.yaml: ") and line.isprintable() for line in str(error).splitlines())
    else:
        assert validated(model, found.model_dump(), "some.yaml") == found


@pytest.mark.parametrize("name", ["scene", "study", "cost-accuracy", "assumptions", "sensitivity", "trigger", "rule"])
def test_every_documented_key_is_fuzzed(name: str) -> None:
    model: type[BaseModel] = MODELS[name]
    documented = {re.sub(r" \(\w+\)|\[\]", "", row[0]) for row in key_rows(model)}
    fuzzed = {".".join(map(str, path)) for path, _ in keys(model)}
    inside = ("<name>", "geometry.bodies.", "uncertain.correlations.")  # drawn with the mapping or list that holds them
    assert {key for key in documented if not any(part in key for part in inside)} <= fuzzed
