"""The experiments that the workflow makes and configurations may name."""

from __future__ import annotations

from sph.experiments import assumptions, robustness
from sph.experiments.base import Experiment
from sph.experiments.cost_accuracy import experiment as cost_accuracy

EXPERIMENTS: dict[str, Experiment] = {
    each.name: each
    for each in (
        cost_accuracy.EXPERIMENT,
        cost_accuracy.RESOLUTION,
        assumptions.EXPERIMENT,
        robustness.EXPERIMENT,
    )
}
"""Experiments whose runs stand alone, by name: each is a target of that name (``workflow/rules/experiments.smk``)."""
NAMES = (*EXPERIMENTS, "validation", "sensitivity", "trigger")
"""All that have a file of their own; those of the last three have rules of their own."""
