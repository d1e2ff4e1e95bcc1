"""``sph newmark`` and ``sph motion`` on records as recorders leave them: offset, direction, filter, unit."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from record_files import knet
from typer.testing import CliRunner, Result

from sph.command.cli import app
from sph.scene.configuration import validated
from sph.scene.ground_motion.record import Record, processed
from sph.stability.newmark import sliding_block

RATE = 100
TIME = np.arange(4000) / RATE
BURST = 2.0 * np.sin(2 * np.pi * 1.5 * TIME) * np.exp(-(((TIME - 15.0) / 4.0) ** 2))
OFFSET = 58.0 * 8388608 / 2000
"""Counts of 58 gal."""


@pytest.fixture
def recorded(tmp_path: Path) -> Path:
    """A record of K-NET with an offset of 58 gal."""
    path = tmp_path / "AKT0130001010000.EW"
    path.write_text(knet(BURST, RATE, offset=round(OFFSET)))
    return path


def call(*arguments: object) -> Result:
    result = CliRunner().invoke(app, [str(argument) for argument in arguments])
    assert result.exit_code == 0, result.output
    return result


def displacement(*arguments: object) -> float:
    return float(json.loads(call("newmark", *arguments, "--json").stdout)["permanent_displacement"])


def test_an_offset_that_changes_the_displacement_is_told_and_taken_out(recorded: Path) -> None:
    raw, mended = displacement(recorded, "--ay", "0.1g"), displacement(recorded, "--ay", "0.1g", "--baseline", "0")
    assert raw > 2.0 * mended > 0.0
    assert mended == pytest.approx(sliding_block(TIME, BURST, 0.981).permanent, rel=0.01)
    told = call("newmark", recorded, "--ay", "0.1g").stderr
    assert "record-offset" in told and f"{raw:.3g} m, and {mended:.3g} m without the mean of" in told
    assert "record-offset" not in call("newmark", recorded, "--ay", "0.1g", "--baseline", "0").stderr
    # An offset that does nothing to the block is still a drift of the ground, but not one of its displacement.
    strong = call("newmark", recorded, "--ay", "1g").stderr
    assert "drifts" in strong and "the displacement depends" not in strong


def test_both_directions_and_the_larger(tmp_path: Path) -> None:
    path = tmp_path / "one-sided.csv"
    one_sided = np.where(TIME % 4.0 < 0.5, -4.0, 4.0 * 0.5 / 3.5)
    path.write_text("time (s),a (m/s2)\n" + "\n".join(f"{t:.2f},{a:.9g}" for t, a in zip(TIME, one_sided, strict=True)))
    expected = {name: sliding_block(TIME, sign * one_sided, 2.0).permanent for name, sign in (("recorded", 1), ("turned", -1))}
    asked = ("newmark", path, "--ay", "2 m/s2")
    assert displacement(*asked[1:]) == expected["recorded"] == 0.0
    told = call(*asked).stderr
    assert "record-polarity" in told and f"{expected['turned']:.3g} m instead of 0 m" in told
    assert displacement(*asked[1:], "--direction", "turned") == pytest.approx(expected["turned"], rel=1e-6)
    both = json.loads(call(*asked, "--direction", "both", "--json").stdout)
    assert (both["direction"], both["other_displacement"]) == ("turned", 0.0)
    assert both["permanent_displacement"] == pytest.approx(expected["turned"], rel=1e-6) and both["peak_acceleration"] == 4.0
    shown = call(*asked, "--direction", "both")
    assert "reversed, the larger; 0 m with the opposite polarity" in shown.stdout and "record-polarity" not in shown.stderr


def test_the_options_are_those_of_a_scene(recorded: Path) -> None:
    treated = {"baseline": {"degree": 2}, "band_pass": {"low": 0.2, "high": 20.0}}
    made = processed(validated(Record, {"kind": "record", "file": str(recorded), "start": 0.0, **treated}, "record"))
    options = ("--baseline", "2", "--band-pass", "0.2,20")
    assert displacement(recorded, "--ay", "0.05g", *options) == sliding_block(made.time, made.horizontal, 0.05 * 9.81).permanent
    measured = json.loads(call("motion", recorded, *options, "--json").stdout)["horizontal"]
    assert measured["peak_acceleration"] == np.abs(made.horizontal).max() and abs(measured["final_velocity"]) < 1e-9
    raw = call("motion", recorded, "--json")
    assert json.loads(raw.stdout)["horizontal"]["final_velocity"] == pytest.approx(0.58 * 39.99, rel=1e-3)
    assert "record-offset" in raw.stderr and "record-displacement" in raw.stderr


def test_a_record_without_names_needs_a_unit(tmp_path: Path) -> None:
    path = tmp_path / "bare.csv"
    path.write_text("0 0,6\n0.2 0,6\n".replace(",", "."))
    result = CliRunner().invoke(app, ["newmark", str(path), "--ay", "0.3g"])
    assert result.exit_code == 2 and "does not say its unit" in result.stderr and "--unit" in result.stderr
    assert displacement(path, "--ay", "0.3g", "--unit", "g") == pytest.approx(0.5 * 0.6 * 9.81 * 0.2**2, rel=1e-12)
    assert CliRunner().invoke(app, ["motion", str(path)]).exit_code == 2
    assert json.loads(call("motion", path, "--unit", "g", "--json").stdout)["horizontal"]["peak_acceleration"] == pytest.approx(5.886)
    velocity = tmp_path / "velocity.csv"
    velocity.write_text("time (s),velocity\n" + "".join(f"{0.01 * k:.2f},{0.02 * k:.2f}\n" for k in range(50)), encoding="utf-8")
    found = json.loads(call("motion", velocity, "--unit", "m/s", "--json").stdout)["horizontal"]["peak_acceleration"]
    assert found == pytest.approx(2.0, rel=1e-6), "0.02 m/s in 0.01 s"
