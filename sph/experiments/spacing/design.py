"""The runs of a study at a second spacing: what the particles change, case by case (``second_fidelity`` of the study)."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

from sph.experiments.base import Experiment
from sph.study.plan import Plan


class Spacing(NamedTuple):
    """A study at its fidelity and at the second one."""

    own: Plan
    second: Plan

    @property
    def spacings(self) -> tuple[float, float]:
        """Spacing of the first run at both, m."""
        first = next(iter(self.own.study.runs.values()))
        own, second = (plan.built(**first).numerics.spacing for plan in self)
        return own, second


def load_spacing(file: str, study: Plan, folders: Sequence[Path] = (Path(),), check: bool = True) -> Spacing:
    """ValueError for a study without a second fidelity, and for two fidelities with one spacing."""
    if study.second is None:
        raise ValueError(
            f"second_fidelity: study {study.study.study!r} names none besides fidelity {study.study.fidelity!r}, so there is nothing to "
            f"compare; it has {', '.join(study.study.fidelities)}"
        )
    found = Spacing(study, study.second)
    if found.spacings[0] == found.spacings[1]:
        raise ValueError(
            f"second_fidelity: {study.study.second_fidelity!r} has the spacing of {study.study.fidelity!r}, {found.spacings[0]:g} m; name "
            "one with another numerics.spacing"
        )
    return found


EXPERIMENT = Experiment("spacing", "Spacing", load_spacing, place="{results}")
"""It has no file of its own: the study names the second fidelity."""
