"""All relations, by their names: those that the modules beside this one register when they are imported."""

from __future__ import annotations

from importlib import import_module

from relation import RELATIONS

BY_SUBJECT = tuple(import_module(name) for name in ("of_scenes", "of_motions", "of_runs", "of_strength"))
"""The modules that hold them.  Their order is that of the relations, by which ``check.py`` draws those that a scene is tried with."""
__all__ = ["BY_SUBJECT", "RELATIONS"]
