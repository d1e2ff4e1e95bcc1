"""A scene with a record."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from record_files import at2

INTERVAL = 0.005
TIME = np.arange(400) * INTERVAL


@pytest.fixture
def records(tmp_path: Path) -> Path:
    """Folder with two components of 2 s, a burst of 4 Hz of 3 m/s2 and half as much vertically, upside down."""
    burst = 3.0 * np.sin(2 * np.pi * 4.0 * TIME) * np.sin(np.pi * TIME / 2.0) ** 2
    (tmp_path / "records").mkdir()
    (tmp_path / "records" / "h.AT2").write_text(at2(burst, INTERVAL))
    (tmp_path / "records" / "v.AT2").write_text(at2(-0.5 * burst, INTERVAL))
    return tmp_path
