"""The sliding block against pySLAMMER, the response spectrum against eqsig: programs by others, on the same records."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from sph.scene.ground_motion import read_record
from sph.scene.ground_motion.spectrum import pseudo_acceleration
from sph.stability.newmark import sliding_block

pytestmark = pytest.mark.crosscheck

ROOT = Path(__file__).resolve().parents[2]
SHARED = ROOT.parent / "shared" / "records"
RECORDS = [ROOT / "config" / "motions" / "synthetic.csv", *sorted(SHARED.glob("*.csv"))]
"""The record of this project, and recorded ones where they lie beside it."""
BLOCK_TOLERANCE = 0.03
"""At ratios of yield to peak up to a half."""
PARTS = 4
"""Parts of an interval of the record in which pySLAMMER steps: at a whole one, as recorded, it was off by up to 3.6 %."""
MIN_SLIP = 1e-3
"""Displacement (m) that no slope engineer would tell from none, in which both may differ."""
SPECTRUM_TOLERANCE = 0.02
"""eqsig looks at the oscillators at the samples only, which misses peaks of short periods."""


@pytest.mark.parametrize("ratio", [0.1, 0.3, 0.5])
@pytest.mark.parametrize("path", RECORDS, ids=lambda path: path.stem)
def test_the_sliding_block_is_that_of_pyslammer(path: Path, ratio: float) -> None:
    pyslammer = pytest.importorskip("pyslammer", reason="the extra 'test' installs it")
    time, acceleration = read_record(path)
    limit = ratio * float(np.abs(acceleration).max())
    fine = np.linspace(time[0], time[-1], PARTS * (time.size - 1) + 1)
    interval = float(fine[1] - fine[0])
    # At rest at the end, as the block is by its own rule.
    samples = np.append(np.interp(fine, time, acceleration), np.zeros(round(20.0 / interval)))
    shaking = pyslammer.GroundMotion(samples / pyslammer.G_EARTH, interval)
    for turned in (False, True):
        other = pyslammer.RigidAnalysis(limit / pyslammer.G_EARTH, shaking, inverse=turned)
        own = sliding_block(time, -acceleration if turned else acceleration, limit).permanent
        assert own == pytest.approx(float(other.max_sliding_disp), rel=BLOCK_TOLERANCE, abs=MIN_SLIP)


@pytest.mark.parametrize("path", RECORDS, ids=lambda path: path.stem)
def test_the_spectrum_is_that_of_eqsig(path: Path) -> None:
    eqsig = pytest.importorskip("eqsig", reason="the extra 'test' installs it")
    time, acceleration = read_record(path)
    interval = float(time[1] - time[0])
    periods = np.logspace(np.log10(20.0 * interval), np.log10(4.0), 30)
    own = pseudo_acceleration(acceleration, interval, periods)
    *_, spectral = eqsig.sdof.pseudo_response_spectra(acceleration, interval, periods, xi=0.05)
    np.testing.assert_allclose(own, np.asarray(spectral), rtol=SPECTRUM_TOLERANCE)
