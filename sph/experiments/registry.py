"""The experiments: every one is a folder here, and a line of ``NAMES``."""

from __future__ import annotations

from importlib import import_module

from sph.experiments.base import Experiment

NAMES = (
    "trade",
    "resolution",
    "limits",
    "extremes",
    "validation",
    "sensitivity",
    "trigger",
    "paper",
)
"""Of their folders."""
EXPERIMENTS: dict[str, Experiment] = {name: import_module(f"{__package__}.{name}.design").EXPERIMENT for name in NAMES}
"""By name; the workflow makes what is listed here (``workflow/rules/experiments.smk``)."""
CONFIGURED = [name for name, each in EXPERIMENTS.items() if each.keys]
"""Those with a file of their own, which a study may name."""
