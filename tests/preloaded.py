"""Importing this does once, in 4 s, what each fork of ``forked.py`` would do again.

What the Snakefile, the rules and the scripts of jobs import is there, numba is ready to compile and to load compiled code, the sources are
read for their digests, and Snakemake has looked for its plugins.
"""

from importlib import import_module
from pathlib import Path

import numba
from snakemake.cli import get_argument_parser

from sph.storage.sources import sources_digest

PACKAGE = Path(__file__).parents[1] / "sph"

for module in ("figures", "experiments.study_row", "jobs.ahead", "jobs.catalogue", "page.paper", "solver.run", "stability.record"):
    import_module(f"sph.{module}")
for module in ("cases.suite", "nbformat", "smart_open"):
    import_module(module)
get_argument_parser()
numba.njit(lambda number: number)(1)
sources_digest(PACKAGE.rglob("*.py"), PACKAGE)
