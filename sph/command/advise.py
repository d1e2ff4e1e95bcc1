"""What ``sph advise`` prints: a variant of the cost-accuracy study, its cost, and the settings that give it."""

from __future__ import annotations

import math
import shlex
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import pandas as pd
import yaml

from sph.command.given import read_given
from sph.experiments.variants import advice
from sph.experiments.variants.advice import Advice, Resolution, percent
from sph.experiments.variants.design import is_mean
from sph.experiments.variants.table import QUANTITIES, WORDS, against, read_cost_accuracy, summary
from sph.jobs.exit_codes import REFUSED
from sph.scene.configuration import flat, merge
from sph.scene.names import check_known
from sph.scene.schema import make_scene
from sph.scene.scheme import SCHEMES
from sph.study.cost import ON_REFERENCE, cost

MEAN = "mean over one run per lattice: in a study, make numerics.lattice_shift a dimension and put the other keys into the fidelity"


def advise(error: float, scene: Path | None, quantity: str, of: str | None, scheme: str, table: Path | None) -> tuple[str, int]:
    """The cheapest setting within an error, or the spacings of a scene's slope; and the exit code, whether there is one."""
    check_known("--quantity", [quantity], (*QUANTITIES, "both"))
    check_known("--scheme", [scheme], SCHEMES)
    measured = read_cost_accuracy(table) if table else advice.shipped_table(scheme)
    if measured is None:
        raise ValueError(advice.NOT_MEASURED_YET)
    if of is not None:
        measured = against(measured, of)
    wanted = tuple(QUANTITIES) if quantity == "both" else (quantity,)
    if scene is None:
        answer = advice.advise(measured, error, wanted)
        said, fits = lines(answer, error, [WORDS[name] for name in wanted], measured), answer.fits
    elif of is not None:
        raise ValueError(f"--of {of}: has no effect with a scene, whose spacings are compared with the finest run; leave it out")
    else:
        own, _ = read_given(scene, {})
        spacings = advice.resolutions(own, read_cost_accuracy(table) if table else None)
        finer = {each.spacing: make_scene(merge(own.model_dump(), {"numerics": {"spacing": each.spacing}})) for each in spacings}
        said, fits = for_scene(spacings, error, wanted, {spacing: cost(built).seconds for spacing, built in finer.items()})
    return "\n".join(said), 0 if fits else REFUSED


def lines(answer: Advice, error: float, quantities: Sequence[str], table: pd.DataFrame) -> list[str]:
    """Lines of text for an answer; ``quantities`` in words."""
    reference = next(variant for variant in summary(table) if variant.reference)
    asked = f"{' and '.join(quantities)} within {percent(error)} and the collapse class of the reference in every case"
    head = f"cheapest setting with {asked}:" if answer.fits else f"no measured setting has {asked}; the most accurate:"
    errors = ", ".join(f"{WORDS[name]} within {percent(value)}" for name, value in answer.variant.errors.items())
    return [
        head,
        f"  {answer.variant.name}, {answer.variant.cost:.3g} s per run on one core of {table['machine'].iloc[0]}",
        f"  {errors}, against {reference.name} ({reference.cost:.3g} s per run)",
        *([f"  {MEAN}"] if is_mean(answer.settings) else [f"  command line  {options(answer.settings) or 'the scene file as it is'}"]),
        f"  fidelity      {one_line(answer.settings)}",
    ]


def for_scene(
    resolutions: Sequence[Resolution], error: float, quantities: Sequence[str], seconds: Mapping[float, float]
) -> tuple[list[str], bool]:
    """Lines of text on the spacings of a scene's slope, with their computing times (s), and whether one is within an error."""
    fitting = [each for each in resolutions if each.agrees and max(each.errors[name] for name in quantities) <= error]
    head = f"time {ON_REFERENCE} (s)"
    lines = [f"rows over the height  spacing (m)  displacement  run-out  {head}"]
    lines += [
        f"{each.rows:20.3g}  {each.spacing:11.4g}  {percent(each.errors['displacement']):>12}  {percent(each.errors['runout']):>7}"
        f"  {seconds[each.spacing]:{len(head)}.3g}"
        for each in resolutions
    ]
    asked = f"{' and '.join(WORDS[name] for name in quantities)} within {percent(error)}"
    if fitting:
        return [*lines, f"coarsest spacing with {asked}: --set numerics.spacing={fitting[0].spacing:.4g}"], True
    return [*lines, f"no measured spacing has {asked}; use the finest, and compare two (second_fidelity of the study)"], False


def options(settings: Mapping[str, Any]) -> str:
    """Scene keys as options ``--set`` in a shell."""
    return " ".join(f"--set {name}={shlex.quote(one_line(value))}" for name, value in flat(settings).items())


def one_line(value: Any) -> str:
    """A value as YAML on one line."""
    return yaml.safe_dump(value, default_flow_style=True, width=math.inf).removesuffix("...\n").strip()
