"""What a release needs and the program does not: run from a clone, as ``python -m tools.reference``; no part of the package."""
