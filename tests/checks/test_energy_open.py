"""A run that made or lost energy: by hand-made trajectories whose energy budget is open by a known share."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from calling import call
from synthetic import study_row, synthetic

from sph.checks.after_run import energy_open, found_after, is_open
from sph.checks.messages import words
from sph.experiments.study_row import run_values
from sph.measures.metrics import ENERGY_LIMIT, MetricSettings
from sph.output.run import Run
from sph.page.answer import answer
from sph.page.tables import run_columns
from sph.storage import trajectory


def open_by(share: float) -> Run:
    """A run in which 100 J of potential energy become 100 (1 - share) J of dissipated energy."""
    run = synthetic(overrides={"numerics": {"spacing": 2.5}})
    done = np.linspace(0.0, 1.0, run["sample_time"].size)
    run.trajectory["potential_energy"] = ("sample", -100.0 * done)
    run.trajectory["dissipated_energy"] = ("sample", 100.0 * (1.0 - share) * done)
    run.attrs["particle_steps"] = 6_000_000
    return run


@pytest.mark.parametrize(("share", "told"), [(0.0, False), (0.015, False), (0.025, True)])
def test_energy_that_is_made_or_lost_is_a_finding_from_the_limit_on(share: float, told: bool, tmp_path: Path) -> None:
    """The parts are 100 (2 - share) J at the end, of which the budget lacks 100 share J."""
    run = open_by(share)
    values = run_values(run, MetricSettings(), np.nan)
    assert values["energy_error"] == pytest.approx(share / (2.0 - share))
    assert values["findings"] == "energy-open" * told
    assert [each.code for each in found_after(run)] == ["energy-open"] * told
    trajectory.write(tmp_path / "run.nc", run.trajectory)
    assert ("[energy-open]" in call("metrics", tmp_path / "run.nc").stderr) == told


def test_the_finding_names_the_share_the_limit_and_the_remedy() -> None:
    (found,) = energy_open(0.037)
    assert "3.7 %" in words(found).measured and words(found).wanted.startswith("at most 1 %") and "numerics.spacing" in words(found).key
    assert found.severity == "warning"
    assert not is_open(ENERGY_LIMIT) and is_open(1.001 * ENERGY_LIMIT) and not is_open(np.nan), "a run that diverged has no budget"


def test_the_page_marks_the_run_and_warns() -> None:
    errors = {"4.0": 1e-4, "6.0": 0.037, "8.0": np.nan}
    rows = [study_row("0.10", "100", amplitude, energy_error=error) for amplitude, error in errors.items()]
    table, scene = pd.DataFrame(rows), synthetic(overrides={"numerics": {"spacing": 2.5}}).scene
    (status,) = (column.words for column in run_columns([], "A") if column.heading == "status")
    assert ["energy" in status(row) for row in rows] == [False, True, False]
    warned = [each for each in answer(table, [], scene, "A", lambda pattern: []).warnings if "energy" in each]
    assert len(warned) == 1 and warned[0].startswith("1 of 3 runs have an energy error of more than 1 %")
