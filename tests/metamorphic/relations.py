"""All relations, by their names: those that the modules beside this one register when they are imported."""

from __future__ import annotations

import of_motions
import of_runs
import of_scenes
import of_strength
from relation import RELATIONS

BY_SUBJECT = (of_scenes, of_motions, of_runs, of_strength)
"""The modules that hold them."""
__all__ = ["BY_SUBJECT", "RELATIONS"]
