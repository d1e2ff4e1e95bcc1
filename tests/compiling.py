"""Importing this makes numba ready to compile and to load compiled code, and reads the sources for their digests: 0.5 s and 1 s."""

from pathlib import Path

import numba

from sph.storage.sources import sources_digest

PACKAGE = Path(__file__).parents[1] / "sph"

numba.njit(lambda number: number)(1)
sources_digest(PACKAGE.rglob("*.py"), PACKAGE)
