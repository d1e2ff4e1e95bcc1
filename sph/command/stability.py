"""What ``sph fos`` and ``sph yield-acceleration`` do and print: each trial when it is done, then the answer, the rule and the bracket."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

import pandas as pd

from sph.scene.configuration import validated
from sph.scene.gravity import GRAVITY
from sph.scene.schema import Scene
from sph.scene.strict_json import to_json
from sph.stability.safety import critical_strength_ratio, factor_of_safety, yield_acceleration
from sph.stability.search import Search, Trial
from sph.stability.standing import FailureRule
from sph.storage.files import whole
from sph.storage.trajectory import Status


class Question(NamedTuple):
    """A limit of stability that the command can find."""

    name: str
    symbol: str
    unit: str
    find: Callable[..., Search]
    text: Callable[[float], str]


def in_g(value: float) -> str:
    """An acceleration (m/s2) in words."""
    return f"{value:.3f} m/s2 ({value / GRAVITY:.3f} g)"


QUESTIONS = {
    "strength": Question("factor of safety", "F", "-", factor_of_safety, "{:.4f}".format),
    "S_R": Question("critical strength ratio", "S_R", "-", critical_strength_ratio, "{:.4f}".format),
    "acceleration": Question("yield acceleration", "a", "m/s2", yield_acceleration, in_g),
}
"""The questions by what is reduced or applied."""


def answer(asked: str, scene: Scene, tolerance: float, rule: dict[str, Any], as_json: bool, out: Path | None) -> None:
    """Search, print and write; ValueError for what is refused."""
    question, used = QUESTIONS[asked], validated(FailureRule, rule, "--rule")
    found = question.find(scene, tolerance, used, None if as_json else lambda trial: print(trial_line(question, trial), flush=True))
    if out is not None:
        with whole(out) as temporary:
            pd.DataFrame(found.trials).to_csv(temporary, index=False)
    print(to_json(record(question, found, used), indent=1) if as_json else "\n".join(lines(question, found, used)))


def trial_line(question: Question, trial: Trial) -> str:
    """One trial in words."""
    verdict = "stands" if trial.stands else "diverged" if trial.status == Status.DIVERGED else "fails"
    return (
        f"{question.symbol} = {question.text(trial.value)}  {verdict}: {trial.displaced_area:.3g} m2 displaced, "
        f"{trial.largest_displacement:.3g} m at most, {trial.wall_time:.1f} s"
    )


def lines(question: Question, found: Search, rule: FailureRule) -> list[str]:
    """The answer, its bracket, the number of runs and the rule."""
    if not found.upper > 0:
        head = f"{question.name}: 0, the slope fails without the load"
    else:
        head = f"{question.name}: {question.text(found.value)}, stands at {found.stood:.4f} and fails at {found.failed:.4f}"
    return [f"{head}; {len(found.trials)} runs", rule.sentence()]


def record(question: Question, found: Search, rule: FailureRule) -> dict[str, Any]:
    """The answer for machines; numbers that are not finite are null."""
    trials = [{name: _finite(value) for name, value in trial._asdict().items()} for trial in found.trials]
    return {
        "quantity": question.name,
        "unit": question.unit,
        "value": found.value,
        "lower": found.lower,
        "upper": found.upper,
        "runs": len(trials),
        "rule": rule.model_dump() | {"text": rule.sentence()},
        "trials": trials,
    }


def _finite(value: Any) -> Any:
    return None if isinstance(value, float) and not math.isfinite(value) else value
