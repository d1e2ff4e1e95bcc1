"""Tables and figures of the experiment."""

from __future__ import annotations

from typing import Any

from sph.experiments.trade.measure import READERS as READERS
from sph.experiments.trade.measure import TRACE as TRACE
from sph.experiments.trade.measure import cost_accuracy_steps, cost_accuracy_tables


def measure_resolution(*given: Any) -> Any:
    """What finer particles change, and how much runs scatter: one row per variant and case, with deviations from the finest. Every column
    is defined in docs/reference/files.md.
    """
    return cost_accuracy_tables(*given)


STEPS = cost_accuracy_steps("resolution", measure_resolution)
