"""A limit of stability without the error of the spacing, from searches at two spacings.

The limit found at a spacing dx is too high, about in proportion to dx (config/validation.yaml, V9, V10, V17 and V18): a slip surface
is a band of some spacings, and the soil beside a face is supported by the kernel's width.  With f at dx and c at r dx the value at
spacing 0 is

    f + (f - c) / (r - 1).

Where that step leads to the unsafe side, the placing of the particles decides, for instance in thin layers; it is then not taken.

The remaining error is an estimate, not a bound: the larger of what two spacings tell and of what slopes with known answers tell.

* Half of that step, for an order of convergence that is not 1, or all of it where it is not taken; half of the brackets' widths as the
  extrapolation magnifies them; and what the rule allows: a slope that slides by delta comes to rest flatter by about delta / H, so that a
  limit by displacement is too high by as much, of the strength.
* Twice the root mean square of the deviations from the references in the validation table (``spread``), of the strength.

A limit of the load may be far more sensitive: an error of x in F is one of x / |d ln F / da| in a yield acceleration.  That is found by a
second search at the coarse spacing, with a strength greater by a tenth.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

from sph.scene.schema import Scene
from sph.stability.safety import DEFAULT_RULE, yield_acceleration
from sph.stability.search import TOLERANCE, Search, Trial
from sph.stability.standing import FailureRule, coarsest_spacing, dividing, slope_height

if TYPE_CHECKING:
    import pandas as pd

RATIO = 2.0
"""Coarse spacing over the scene's own, unless the rule needs a finer one."""
MIN_RATIO = 1.3
"""Of two spacings; closer ones magnify the brackets too much."""
UNASKED_RATIO = 1.5
"""Smallest ratio of the two spacings of a search in a study, which nobody can ask for others."""
STRONGER = 1.1
"""Strength of the search by which the sensitivity of a yield acceleration is found, over that of the soil."""

VALIDATED = Path(__file__).parents[1] / "experiments" / "measured" / "validation.csv"
"""The validation table of this release: a file here, since the library knows no experiment."""

At = tuple[float, float]
"""Where a trial is made: spacing, m, and strength over that of the soil."""


class Extrapolated(NamedTuple):
    """The limit at two spacings and at none."""

    spacings: tuple[float, float]
    """coarse and fine, m"""
    searches: tuple[Search, Search]
    value: float
    """extrapolated to spacing 0; that at the fine spacing where the extrapolation leads to the unsafe side"""
    error: float
    """estimate of what remains, in the value's unit"""
    step_taken: bool
    """False where the value is that at the fine spacing"""
    sensitivity: float
    """change of the value with the logarithm of the strength, in the value's unit: an error of 1 % of F is a hundredth of it"""
    stronger: Search | None = None
    """the search at the coarse spacing by which the sensitivity of a yield acceleration was found"""

    @property
    def trials(self) -> list[tuple[At, Trial]]:
        """Every static test, and where it was made, in order."""
        made: list[tuple[At, Search]] = [((spacing, 1.0), each) for spacing, each in zip(self.spacings, self.searches, strict=True)]
        made += [((self.spacings[0], STRONGER), self.stronger)] if self.stronger else []
        return [(at, trial) for at, each in made for trial in each.trials]

    @property
    def runs(self) -> int:
        """Static tests of all searches."""
        return len(self.trials)

    @property
    def how(self) -> str:
        """How the value was found, in words."""
        return how_found(*self.spacings, self.step_taken)


def how_found(coarse: float, fine: float, step_taken: bool) -> str:
    """How a limit was found from searches at two spacings (m), in words."""
    if step_taken:
        return f"extrapolated from spacings of {coarse:.3g} and {fine:.3g} m"
    return f"the value at a spacing of {fine:.3g} m, since the extrapolation from {coarse:.3g} m would be on the unsafe side"


def extrapolate(coarse: float, fine: float, ratio: float) -> float:
    """Value at spacing 0 from those at two spacings of a ratio, for an error of first order."""
    return fine + (fine - coarse) / (ratio - 1.0)


def to_zero(coarse: Search, fine: Search, ratio: float) -> tuple[float, float, bool]:
    """Value at spacing 0 from searches at two spacings of a ratio, its error by step and brackets, and whether the step is taken."""
    value = extrapolate(coarse.value, fine.value, ratio)
    step = value - fine.value
    taken = not step * (fine.failed - fine.stood) > 0.0  # the limit is no further on the side of what failed
    value, error = (value, 0.5 * abs(step)) if taken else (fine.value, abs(step))
    brackets = 0.5 * (ratio * (fine.upper - fine.lower) + (coarse.upper - coarse.lower)) / (ratio - 1.0)
    return value, error + brackets, taken


def deviations() -> pd.DataFrame:
    """Slopes of the validation table whose factor of safety or strength ratio has a reference: ``case``, ``quantity``, whether they slip
    along a ``plane``, and the relative deviations at the ``coarse`` and the ``fine`` spacing and of the value that a search gives."""
    import pandas as pd  # here, since a run does without it

    table = pd.read_csv(VALIDATED, usecols=["case", "quantity", "kind", "errors"])
    table = table[table["kind"].isin(["factor_of_safety", "infinite_slope_factor", "critical_strength_ratio"])]
    errors = table["errors"].str.split(", ", expand=True).astype(float)
    coarse, fine, zero = (errors[number] for number in range(3))
    unsafe = (zero - fine) * table["kind"].eq("critical_strength_ratio").map({True: -1.0, False: 1.0}) > 0.0
    plane = table["kind"].eq("infinite_slope_factor")
    return table[["case", "quantity"]].assign(plane=plane, coarse=coarse, fine=fine, value=zero.where(~unsafe, fine), step_taken=~unsafe)


@functools.cache
def spread(plane: bool) -> float:
    """Twice the root mean square deviation of the validated slopes that slip along a plane, or of the others."""
    table = deviations()
    return 2.0 * math.sqrt(float((table["value"][table["plane"] == plane] ** 2).mean()))


def slips_along_a_plane(scene: Scene) -> bool:
    """Whether a scene is of the kind of validated slopes that slip along a plane: with layers or seams, or soil that does not dilate.

    Rows of particles beside such a plane hold it back, the more the less they dilate.
    """
    return bool(scene.layers or scene.seams) or any(soil.dilation_angle < soil.friction_angle for soil in scene.soils)


def at_spacing(scene: Scene, spacing: float) -> Scene:
    """A scene at another spacing, m."""
    return scene.model_copy(update={"numerics": scene.numerics.model_copy(update={"spacing": spacing})})


def two_spacings(scene: Scene, rule: FailureRule, asked: Sequence[float] | None = None) -> tuple[float, float]:
    """Coarse and fine spacing (m): those asked for, or the scene's own and one twice as coarse or as coarse as the rule allows.

    Both of the latter are made a little finer where they do not divide the slope's height: an error of the height by rows that do not fit
    would be magnified.
    ValueError for spacings too close to each other, and for a number of them other than two.
    """
    own, height = scene.numerics.spacing, slope_height(scene)
    coarsest = max(min(RATIO * own, coarsest_spacing(scene, rule)), own)
    spacings = [dividing(coarsest, height), dividing(own, height)] if asked is None else sorted(asked, reverse=True)
    if len(spacings) != 2:
        raise ValueError(f"--spacings: {len(spacings)} numbers, must be two")
    coarse, fine = spacings
    if not coarse >= MIN_RATIO * fine > 0.0:
        raise ValueError(
            f"numerics.spacing: {fine:g} m leaves no coarser one to extrapolate from: at most {coarse:g} m for the rule, "
            f"and {MIN_RATIO:g} times {fine:g} m at least; take a finer spacing, or --single for the value at this one"
        )
    return coarse, fine


def unasked_spacings(scene: Scene, finest: float, rule: FailureRule) -> tuple[float, float]:
    """Coarse and fine spacing (m) of a search in a study: ``RATIO`` times ``finest`` and that, where the rule allows the coarse one.

    Where it does not, both are finer.  Both divide the slope's height.
    """
    coarse, height = min(RATIO * finest, coarsest_spacing(scene, rule)), slope_height(scene)
    return dividing(coarse, height), dividing(min(finest, coarse / UNASKED_RATIO), height)


def extrapolated(
    find: Callable[..., Search],
    scene: Scene,
    tolerance: float = TOLERANCE,
    rule: FailureRule = DEFAULT_RULE,
    report: Callable[[float, float, Trial], None] | None = None,
    asked: Sequence[float] | None = None,
    known: Mapping[At, Mapping[float, Trial]] | None = None,
) -> Extrapolated:
    """Search at two spacings by a function of ``sph.stability.safety``; the fine search begins around what the coarse one found.

    The spacings (m) are those of ``two_spacings``; ``report`` gets the spacing, the strength over that of the soil, and each trial.
    Tests whose outcome is ``known``, by where they were made and by value, are not made again.  ValueError as from the searches, and for
    a strength whose error is as large as itself.
    """

    def search(at: At, near: float | None, **options: float) -> Search:
        def tell(trial: Trial) -> None:
            if report is not None:
                report(*at, trial)

        return find(at_spacing(scene, at[0]), tolerance, rule, tell, (known or {}).get(at), near, **options)

    spacings = two_spacings(scene, rule, asked)
    coarse = search((spacings[0], 1.0), None)
    fine = search((spacings[1], 1.0), coarse.value)
    value, error, taken = to_zero(coarse, fine, spacings[0] / spacings[1])
    sensitivity, stronger = abs(value), None
    if find is yield_acceleration:
        stronger = search((spacings[0], STRONGER), coarse.value, stronger=STRONGER)
        sensitivity = (stronger.value - coarse.value) / math.log(STRONGER)
    error = max(error + rule.displacement * sensitivity, spread(slips_along_a_plane(scene)) * sensitivity)
    if find is not yield_acceleration and not value > error:
        raise ValueError(
            f"numerics.spacing: {coarse.value:.3g} at {spacings[0]:.3g} m and {fine.value:.3g} at {spacings[1]:.3g} m are too far apart to "
            "tell the value without the error of the spacing; take a finer spacing, with three rows of particles or more in each layer"
        )
    return Extrapolated(spacings, (coarse, fine), max(value, 0.0), error, taken, sensitivity, stronger)
