"""Answers from the measured cost-accuracy study: the error to expect of a scene, and the cheapest setting within an error.

The table that was measured for this release is part of the package (``SHIPPED``); without it there is no expectation.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any, NamedTuple

import pandas as pd

from sph.experiments.variants.design import is_mean, scheme, settings_text
from sph.experiments.variants.likeness import unlike
from sph.experiments.variants.table import QUANTITIES, Summary, read_cost_accuracy, summary
from sph.scene.geometry import SLOPES
from sph.scene.names import check_known
from sph.scene.schema import Scene
from sph.scene.scheme import RESOLVED
from sph.scene.strict_json import parse_json
from sph.scene.walls import KINDS
from sph.study.tables import EXPECTED

SHIPPED = Path(__file__).parents[1] / "measured" / "cost-accuracy.csv"
"""Table measured for this release, by ``snakemake cost-accuracy``."""
SHIPPED_RESOLUTION = SHIPPED.with_name("resolution.csv")
"""Table of the scheme for your own slopes, by ``snakemake resolution``."""
NOT_MEASURED_YET = "not measured yet: this release holds no table of the cost-accuracy study; 'snakemake --cores 2 cost-accuracy' makes one"


REMEDY = "run it at a second spacing (second_fidelity of the study, docs/tutorials/own-slope.md)"
"""What to do where no error is known."""


class Expected(NamedTuple):
    """Errors to expect of a scene, from a variant with its scheme: largest relative deviations from the reference, over the cases."""

    displacement: float
    runout: float
    from_baseline: tuple[float, float]  # displacement and run-out against the baseline
    variant: str  # parameter and label
    baseline: str = "the paper's settings"

    def sentence(self) -> str:
        """The expectation in words."""
        other = f", {percent(self.from_baseline[0])} and {percent(self.from_baseline[1])} of {self.baseline}" if self.baseline else ""
        return (
            f"A's displacement within {percent(self.displacement)}, run-out within {percent(self.runout)} of the finest run{other} "
            f"(measured on the slope of the cost-accuracy study, {self.variant})"
        )


class Advice(NamedTuple):
    """A variant of the cost-accuracy study as an answer."""

    variant: Summary
    settings: dict[str, Any]  # scene keys over the scene file
    fits: bool  # False: the best there is


def shipped_table(scheme: str = "paper") -> pd.DataFrame | None:
    """The table measured for this release with a scene's scheme; None while there is none."""
    path = SHIPPED if scheme == "paper" else SHIPPED_RESOLUTION
    return read_cost_accuracy(path) if path.is_file() else None


def expected_error(scene: Scene, table: pd.DataFrame | None = None) -> Expected | None:
    """Errors of the variant with the scheme of a scene; None for a scene unlike the measured slope (``likeness.unlike``), where no
    variant has its scheme, one of its runs diverged, or there is no table.

    ``table`` as from ``read_cost_accuracy``; the shipped one of its scheme by default.
    """
    table = shipped_table(scene.scheme) if table is None else table
    if table is None or unlike(scene):
        return None
    wanted = settings_text(scheme(scene))
    measured = summary(table)
    if scene.scheme == "resolved" and not any(variant.scheme == wanted for variant in measured):
        measured, wanted = _by_rows(scene, measured), ANY_SPACING
    for variant in measured:
        if variant.scheme == wanted and variant.every_case and variant.finished:
            return Expected(
                variant.errors["displacement"],
                variant.errors["runout"],
                (variant.baseline_errors["displacement"], variant.baseline_errors["runout"]),
                variant.name,
                Expected._field_defaults["baseline"] if scene.scheme == "paper" else "",
            )
    return None


class Resolution(NamedTuple):
    """A measured spacing, on the slope of a scene: as many rows of particles over its height."""

    rows: float
    spacing: float  # m
    errors: dict[str, float]  # by quantity
    agrees: bool  # in the class of the reference in every case


def resolutions(scene: Scene, table: pd.DataFrame | None = None) -> list[Resolution]:
    """The measured spacings from coarse to fine, at the scale of a scene's slope; ValueError says why none was measured on one like it.

    ``table`` as from ``read_cost_accuracy``; the shipped one of its scheme by default.
    """
    if others := unlike(scene):
        raise ValueError(f"no error is known for this slope, since {', '.join(others)}; {REMEDY}")
    table = shipped_table(scene.scheme) if table is None else table
    if table is None:
        raise ValueError(NOT_MEASURED_YET)
    measured = [(at, variant) for at, variant in _alike(scene, summary(table)) if variant.every_case and variant.finished]
    if not measured:
        why = of_other_law(scene) if _alike(with_other_law(scene), summary(table)) else "no measured run was computed with its settings"
        raise ValueError(f"no error is known for this slope: {why}; {REMEDY}")
    by_spacing = {at: variant for at, variant in sorted(measured, key=lambda pair: (-pair[0], pair[1].errors["runout"]))}
    height = scene.geometry.crest[1] - scene.geometry.toe[1]
    return [
        Resolution(HEIGHT / at, at * height / HEIGHT, dict(variant.errors), variant.classes_agree == variant.cases)
        for at, variant in by_spacing.items()
    ]


ANY_SPACING = "any"
HEIGHT = 25.0
"""Height of the slope of the resolution study, m."""
ROUNDED = 1e-3
"""By which a spacing that divides a height is rounded as somebody writes it, 0.8333 m for 10 / 12."""


def _by_rows(scene: Scene, variants: Sequence[Summary]) -> list[Summary]:
    """The finest variant with no more rows of particles over its height than a scene's slope has, if it is computed alike; none where the
    scene is coarser than all."""
    spacing = HEIGHT * scene.numerics.spacing / scene.geometry.slope_height if isinstance(scene.geometry, SLOPES) else math.inf
    no_finer = [(at, variant) for at, variant in _alike(scene, variants) if at >= spacing * (1.0 - ROUNDED)]
    return [min(no_finer, key=lambda pair: pair[0])[1]._replace(scheme=ANY_SPACING)] if no_finer else []


def _alike(scene: Scene, variants: Sequence[Summary]) -> list[tuple[float, Summary]]:
    """The variants, with their spacings (m), of the resolution study that are computed as a scene of a slope is but for spacing, damping,
    softening and how a rigid or an absorbing box lets waves out."""
    if not isinstance(scene.geometry, SLOPES) or scene.coupling.softening is None:
        return []

    def rest(keys: dict[str, Any]) -> str:
        numerics = {name: value for name, value in keys.get("numerics", {}).items() if name not in ("spacing", "lattice_shift")}
        coupling = {name: value for name, value in keys.get("coupling", {}).items() if name != "softening"}
        # The error is that of the moving soil, whether or not the box lets waves out, and each slope has a damping of its own.
        written = keys.get("walls", {})
        walls = written | {name: RESOLVED["walls"][name] for name in ("base", "sides") if name in written and KINDS[written[name]].absorbs}
        return settings_text(keys | {"numerics": numerics, "coupling": coupling, "walls": walls, "damping": None})

    own = rest(scheme(scene))
    return [
        (parse_json(variant.scheme).get("numerics", {}).get("spacing", 1.0), variant)
        for variant in variants
        if rest(parse_json(variant.scheme)) == own
        and variant.changes == "accuracy"
        and not (variant.reference or is_mean(parse_json(variant.scheme)))
    ]


def with_other_law(scene: Scene) -> Scene:
    """A scene with the other law of interfaces between soils."""
    law = "both" if scene.numerics.interfaces == "weaker" else "weaker"
    return scene.model_copy(update={"numerics": scene.numerics.model_copy(update={"interfaces": law})})


def of_other_law(scene: Scene) -> str:
    """Why no error is known where the measured runs have the other law of interfaces."""
    other = with_other_law(scene)
    return f"errors are measured with numerics.interfaces: {other.numerics.interfaces}, and not with {scene.numerics.interfaces}"


def expected_sentence(scene: Scene) -> str:
    """What the shipped table says of a scene, in words, with the reason and the remedy where it says nothing."""
    return ", since ".join(filter(None, expected_words(scene)))


def expected_words(scene: Scene) -> tuple[str, str]:
    """What the shipped table says of a scene, in words; and why it says nothing, with the remedy, where that is known."""
    table = shipped_table(scene.scheme)
    if table is None:
        return NOT_MEASURED_YET, ""
    expected = expected_error(scene, table)
    if expected:
        return expected.sentence(), ""
    if others := unlike(scene):
        return "not known for this slope", f"{', '.join(others)}; {REMEDY}"
    if expected_error(with_other_law(scene), table):
        return "not known", f"{of_other_law(scene)}; {REMEDY}"
    if scene.scheme == "resolved" and isinstance(scene.geometry, SLOPES):
        coarsest = max((at for at, _ in _alike(scene, summary(table))), default=math.inf) / HEIGHT * scene.geometry.slope_height
        if scene.numerics.spacing > coarsest:
            return f"not measured at this spacing: the coarsest spacing measured is {coarsest:.3g} m on a slope of this height", ""
    return "not measured with these numerics", ""


def expected_metrics(scene: Scene) -> dict[str, float]:
    """The columns ``EXPECTED`` of a study's table for a scene, from the shipped table."""
    expected = expected_error(scene)
    errors = (expected.displacement, expected.runout) if expected else (math.nan, math.nan)
    return {row.name: value for row, value in zip(EXPECTED, errors, strict=True)}


def advise(table: pd.DataFrame, error: float, quantities: Sequence[str] = tuple(QUANTITIES)) -> Advice:
    """The cheapest variant whose largest deviation is within an error in every case and whose class agrees; else the most accurate one.

    The reference itself is no answer, nor is a variant that was not run in every case, that changes the model (its errors may cancel
    others), or whose time step exceeded the limit measured on the way.  Raises ValueError for a negative error, an unknown
    quantity and a table without a variant to choose from.
    """
    if not 0 <= error < math.inf:
        raise ValueError(f"error: {error} must be at least 0, for example 0.1 or 10%")
    check_known("quantity", quantities, QUANTITIES)
    variants = summary(table)
    references = {variant.scheme for variant in variants if variant.reference}
    known = [
        variant for variant in variants if variant.sound and variant.scheme not in references and variant.every_case and variant.finished
    ]
    if not known:
        raise ValueError("table: no variant but the reference was run to its end in every case")

    def misses(variant: Summary) -> tuple[bool, float]:
        return variant.classes_agree < variant.cases, max(variant.errors[name] for name in quantities)

    fitting = [variant for variant in known if misses(variant) <= (False, error)]
    chosen = min(fitting, key=lambda variant: variant.cost) if fitting else min(known, key=misses)
    try:
        return Advice(chosen, parse_json(chosen.settings), bool(fitting))
    except ValueError as error:
        raise ValueError(f"table: the settings of {chosen.name}: {error}") from error


def percent(value: float) -> str:
    """A relative error as a percentage with two digits."""
    return f"{100 * value:.2g} %" if abs(value) < 1 else f"{100 * value:.0f} %"
