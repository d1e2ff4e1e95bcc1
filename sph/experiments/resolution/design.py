"""The experiment (``config/resolution.yaml``)."""

from __future__ import annotations

from sph.experiments.trade.design import cost_accuracy

EXPERIMENT = cost_accuracy("resolution", "Cost and accuracy of the scheme for your own slopes")
