"""Exit codes of jobs and of the command ``sph``; beside them 0, done, and 1, a fault of the program or of its surroundings."""

REFUSED = 2
"""What the user can correct: a scene, a file, the command line."""
DIVERGED = 3
"""Stopped by the guard of the run."""
DIFFERS = 4
"""A result is out of date or altered."""
