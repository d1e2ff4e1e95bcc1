"""The cost-accuracy study of the scheme for one's own slopes: what finer particles bring."""

from __future__ import annotations

from sph.experiments.variants.cost_accuracy import READERS as READERS
from sph.experiments.variants.cost_accuracy import TRACE as TRACE
from sph.experiments.variants.cost_accuracy import steps

STEPS = steps("resolution")
