"""What a release needs and the program does not: run from a clone, as ``python -m tools.reference``; no part of the package."""

import sys
from pathlib import Path

sys.path.append(str(Path(__file__).parents[1] / "tests"))  # for the reference cases
