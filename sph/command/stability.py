"""What ``sph fos`` and ``sph yield-acceleration`` do and print: each trial when it is done, then the answer, its error and the rule."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import pandas as pd

from sph.checks.layers import broken_at
from sph.checks.messages import line
from sph.checks.messages import record as finding_record
from sph.checks.scene import findings
from sph.command.given import read_given
from sph.command.outputs import check_writable
from sph.command.terminal import say
from sph.scene.configuration import validated
from sph.scene.gravity import GRAVITY
from sph.scene.schema import Scene
from sph.scene.strict_json import to_json
from sph.stability.extrapolation import Extrapolated, extrapolated, slips_along_a_plane, spread, two_spacings
from sph.stability.record import SEARCHES, YIELD, Limit
from sph.stability.search import Search, Trial
from sph.stability.standing import FailureRule
from sph.storage.files import whole
from sph.storage.trajectory import Status


def value_words(limit: Limit, value: float) -> str:
    """A value of a limit in words; an acceleration (m/s2) also in g."""
    return f"{value:.3f} m/s2 ({value / GRAVITY:.3f} g)" if limit.unit == "m/s2" else f"{value:.4f}"


def answer(
    asked: str,
    path: Path,
    changes: Mapping[str, Any],
    tolerance: float,
    rule: Mapping[str, Any],
    as_json: bool,
    out: Path | None,
    single: bool = False,
    spacings: Sequence[float] | None = None,
) -> str:
    """Search at two spacings and extrapolate, or at the scene's own alone, for the scene in a file; write the trials, and print each.

    Errors and warnings of the scene are said before, as by ``sph run``, and which layers another spacing breaks.
    """
    scene, inputs = read_given(path, changes)
    if out is not None:
        check_writable(out, inputs)
    limit, used = SEARCHES[asked], validated(FailureRule, rule, "--rule")
    if single and spacings is not None:
        raise ValueError("--single: uses the scene's own spacing, --spacings uses two others; give one of them")
    told = findings(scene)
    if not single:
        told += broken_at(scene, two_spacings(scene, used, spacings))
    say(*(line(each) for each in told if each.counts))

    def report(spacing: float, strength: float, trial: Trial) -> None:
        if not as_json:
            stronger = "" if strength == 1.0 else f", {strength:g} times the strength"
            print(f"{spacing:g} m{stronger}: {trial_line(limit, trial)}", flush=True)

    result: Search | Extrapolated
    if single:
        own = scene.numerics.spacing
        result = limit.find(scene, tolerance, used, lambda trial: report(own, 1.0, trial))
        searches = {own: result}
    else:
        result = extrapolated(limit.find, scene, tolerance, used, report, spacings)
        searches = dict(zip(result.spacings, result.searches, strict=True))
    if out is not None:
        rows = [{"spacing": spacing} | trial._asdict() for spacing, each in searches.items() for trial in each.trials]
        with whole(out) as temporary:
            pd.DataFrame(rows).to_csv(temporary, index=False)
    if as_json:
        return to_json(record(limit, result, searches, used) | {"findings": [finding_record(each) for each in told]}, indent=1)
    remain = remaining(scene, limit, result) if isinstance(result, Extrapolated) else []
    return "\n".join([*lines(limit, searches), *remain, used.sentence()])


def trial_line(limit: Limit, trial: Trial) -> str:
    """One trial in words."""
    verdict = "stands" if trial.stands else "diverged" if trial.status == Status.DIVERGED else "fails"
    return (
        f"{limit.symbol} = {value_words(limit, trial.value)}  {verdict}: {trial.displaced_area:.3g} m2 displaced, "
        f"{trial.largest_displacement:.3g} m at most, {trial.wall_time:.1f} s"
    )


def lines(limit: Limit, searches: Mapping[float, Search]) -> list[str]:
    """What was found at each spacing: the value, its bracket and the number of runs."""
    text = []
    for spacing, search in searches.items():
        if not search.upper > 0:
            head = f"{limit.name} at {spacing:g} m: 0, since the slope fails without the load"
        else:
            value = value_words(limit, search.value)
            head = f"{limit.name} at {spacing:g} m: {value}, stands at {search.stood:.4f} and fails at {search.failed:.4f}"
        text.append(f"{head}; {len(search.trials)} runs")
    return text


def remaining(scene: Scene, limit: Limit, result: Extrapolated) -> list[str]:
    """The extrapolated value and the error that remains."""
    step = "half the step" if result.step_taken else "the whole step"
    kind = "that slip along a plane" if slips_along_a_plane(scene) else "of one soil"
    told = [
        f"{limit.name}: {value_words(limit, result.value)}, {result.how}; remaining error about {value_words(limit, result.error)} "
        f"(at least {spread(slips_along_a_plane(scene)):.1%} of the strength, as validated slopes {kind} deviate; else {step} of the "
        "extrapolation, the brackets, and the displacement that the rule allows)"
    ]
    if limit.by == YIELD:
        told.append(f"a change of 1 % in strength changes the {limit.name} by {value_words(limit, 0.01 * result.sensitivity)}")
    return told


def record(limit: Limit, result: Search | Extrapolated, searches: Mapping[float, Search], rule: FailureRule) -> dict[str, Any]:
    """The answer for machines; numbers that are not finite are null.  Error and sensitivity are null for a single spacing."""
    return {
        "quantity": limit.name,
        "unit": limit.unit,
        "value": result.value,
        "error": result.error if isinstance(result, Extrapolated) else None,
        "sensitivity": result.sensitivity if isinstance(result, Extrapolated) else None,
        "runs": result.runs if isinstance(result, Extrapolated) else len(result.trials),
        "rule": rule.model_dump() | {"text": rule.sentence()},
        "spacings": [
            {
                "spacing": spacing,
                "value": search.value,
                "lower": search.lower,
                "upper": search.upper,
                "trials": [trial._asdict() for trial in search.trials],
            }
            for spacing, search in searches.items()
        ],
    }
