"""What runs of a study share: the *gravity stage* and the *pre-failure run*, which shakes until the first failure.

Runs share the gravity stage if they agree in every key that acts before the shaking, and the pre-failure run if they agree in all keys
but ``sph.solver.restart.BRANCH_KEYS``.

A stage is named after the dimensions that act in it (``gravity_soil.cohesion-20``, ``pre_failure_soil.cohesion-20_motion.frequency-1``;
over S_R, gamma and amplitude they are ``gravity`` and ``pre_failure_amplitude-6.0``), or, where runs are numbered, after the first run
that needs it.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import NamedTuple

from sph.solver.restart import BRANCH_KEYS, FREE_KEYS, is_among
from sph.study.dimensions import named_point, point_name, scene_key

LATER = ("motion", "early_stop")
"""Sections without effect in the gravity stage."""
GRAVITY, PRE_FAILURE = "gravity", "pre_failure"
IDLE = {GRAVITY: (*BRANCH_KEYS, *FREE_KEYS, *LATER), PRE_FAILURE: BRANCH_KEYS}
"""Keys and sections without effect in a stage, as the solver compares scenes before it continues a stage."""


def acting_in(kind: str, names: Iterable[str]) -> list[str]:
    """The dimensions that act in a kind of stage."""
    return [name for name in names if not is_among(scene_key(name), IDLE[kind])]


def stage_point(name: str, dimensions: Sequence[str]) -> dict[str, str] | None:
    """The values of the dimensions that act in a stage with this name, where names say values; None where there are none."""
    for kind in (GRAVITY, PRE_FAILURE):
        for acting in (acting_in(kind, dimensions), dimensions):
            found = named_point(name.removeprefix(f"{kind}_"), acting)
            if found is not None:
                return found
    return None


class Stages(NamedTuple):
    """What a run continues from: names of the files."""

    gravity: str
    pre_failure: str


class SharedStages:
    """The stages of all runs (points by name); ``stands`` says whether the scene with some of the dimensions set is a scene."""

    def __init__(self, runs: Mapping[str, Mapping[str, str]], numbered: bool, stands: Callable[[Mapping[str, str]], bool]) -> None:
        self._numbered, self._stands = numbered, stands
        self._standing: dict[tuple[tuple[str, str], ...], bool] = {}
        self._numbers: dict[tuple[tuple[str, str], ...], str] = {}
        self.points: dict[str, dict[str, str]] = {}
        """dimensions that each stage sets, by its name"""
        self.gravity_of: dict[str, str] = {}
        """gravity stage of each shared pre-failure run"""
        self.of_runs: dict[str, Stages] = {}
        for name, point in runs.items():
            self.of_runs[name] = found = self.of(name, point)
            self.gravity_of[found.pre_failure] = found.gravity
            for kind, stage in zip((GRAVITY, PRE_FAILURE), found, strict=True):
                self.points.setdefault(stage, self._acting(kind, point))

    def of(self, name: str, point: Mapping[str, str]) -> Stages:
        """The stages of a run, one of the study's or, where runs are not numbered, another."""
        return Stages(self._name(GRAVITY, name, point), self._name(PRE_FAILURE, name, point))

    def _name(self, kind: str, run: str, point: Mapping[str, str]) -> str:
        acting = self._acting(kind, point)
        if not acting:
            return kind
        if self._numbered:
            return f"{kind}_{self._numbers.setdefault(((kind, ''), *acting.items()), run)}"
        return f"{kind}_{point_name(acting)}"

    def _acting(self, kind: str, point: Mapping[str, str]) -> dict[str, str]:
        """The dimensions of a point that act in a stage; all of them where the scene with these alone is refused."""
        acting = {name: point[name] for name in acting_in(kind, point)}
        at = tuple(acting.items())
        if at not in self._standing:
            self._standing[at] = len(acting) == len(point) or self._stands(acting)
        return acting if self._standing[at] else dict(point)
