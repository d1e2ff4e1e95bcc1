"""Fixtures of the analysis tests; the builders are in ``synthetic``."""

from __future__ import annotations

import pytest
import xarray as xr
from synthetic import synthetic, translation


@pytest.fixture
def standing() -> xr.Dataset:
    """The paper's slope, shaken without any effect."""
    return synthetic()


@pytest.fixture
def slid() -> xr.Dataset:
    """The paper's slope with all material above the toe moved by 3 m to the left between 4 and 8 s."""
    return synthetic(translation(-3.0))
