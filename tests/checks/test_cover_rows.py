"""Rows of particles in weak soil on stronger ground: what they do to the run-out is told before a run."""

from __future__ import annotations

from typing import Any

import pandas as pd
import pytest

from sph.checks.after_run import LATE, held, thin_debris
from sph.checks.cover_rows import CLOSE, FACTOR_BY_ROWS, RUN_OUT_BY_ROWS, covers, enough_rows, factor_with, is_late, rows_in_time, run_out
from sph.checks.finding import Finding
from sph.checks.layers import braked
from sph.checks.messages import words
from sph.checks.scene import findings
from sph.scene.configuration import dotted, merge
from sph.scene.schema import Scene, make_scene

SLOPE: dict[str, Any] = {
    "scheme": "paper",
    "name": "cover",
    "geometry": {"shape": "ground_line", "points": [[100, 440], [160, 440], [180, 460], [220, 460]], "base": 430},
    "soil": {"cohesion": 100.0, "friction_angle": 35.0},
    "numerics": {"spacing": 1.0, "smoothing_ratio": 1.3, "time_step": 5e-4, "interfaces": "weaker"},
}
WEAK = {"cohesion": 5.0, "friction_angle": 25.0}


def scene(top: float, bottom: float, **settings: Any) -> Scene:
    layers = {"weak": {"region": {"kind": "depth", "top": top, "bottom": bottom}, "soil": WEAK}}
    return make_scene(merge(SLOPE, {"layers": layers} | dotted(settings)))


def told(made: Scene) -> Finding:
    codes = ("weak-on-strong", "layer-held", "cover-rows", "cover-on-seam", LATE, "thin-layer", "layer-broken")
    (one,) = (each for each in findings(made) if each.code in codes)
    return one


@pytest.mark.parametrize("law", RUN_OUT_BY_ROWS)
def test_more_rows_never_go_less_far(law: str) -> None:
    far = [run_out(law, 0.1 * tenths) for tenths in range(1, 200)]
    assert far == sorted(far) and far[0] == 0.0 and far[-1] <= 1.0
    assert {rows: run_out(law, rows) for rows in RUN_OUT_BY_ROWS[law]} == RUN_OUT_BY_ROWS[law]
    enough = enough_rows(law)
    assert enough is None or run_out(law, enough - 1) < 1.0 - CLOSE <= run_out(law, enough) + 1e-9


def test_more_rows_never_fail_later() -> None:
    late = [factor_with(0.1 * tenths) for tenths in range(1, 200)]
    assert late == sorted(late, reverse=True) and late[-1] >= 1.0
    assert {rows: factor_with(rows) for rows in FACTOR_BY_ROWS} == FACTOR_BY_ROWS
    assert is_late(factor_with(rows_in_time() - 1)) and not is_late(factor_with(rows_in_time())) and rows_in_time() > max(FACTOR_BY_ROWS)


def test_a_cover_of_few_rows_is_told_with_what_it_does_to_the_run_out() -> None:
    """The spacing that it names is enough."""
    made = scene(0.0, 2.0)
    (cover,) = covers(made)
    assert (cover.name, cover.ground, cover.rows, cover.between) == ("weak", "soil", 2.0, False)
    few, enough = told(made), enough_rows()
    assert (few.code, few.severity, words(few).key) == ("weak-on-strong", "warning", "numerics.spacing or seams.weak")
    assert f"2 rows of particles in 2 m, with which debris runs about {run_out('weaker', 2):.0%}" in words(few).measured
    assert f"factor of safety is up to {factor_with(2) - 1.0:.0%} too high" in words(few).measured
    assert (
        enough is not None
        and f"at least {enough} rows for its run-out, with a spacing of at most {2.0 / enough:.3g} m" in words(few).wanted
    )
    assert braked(made) == [few]
    resolved = told(scene(0.0, 2.0, **{"numerics.spacing": 2.0 / enough, "numerics.time_step": 2e-4}))
    assert (resolved.code, resolved.severity) == (LATE, "warning") and "within 12%" in words(resolved).measured
    assert braked(scene(0.0, 2.0, **{"numerics.spacing": 2.0 / enough, "numerics.time_step": 2e-4})) == []
    assert f"about {run_out('weaker', 1.5):.0%}" in words(told(scene(0.0, 1.5))).measured, "between two that were measured"


def test_rows_that_suffice_for_the_run_out_do_not_show_that_a_cover_stands() -> None:
    """A warning with the rows that are needed, or a seam along the base, which shows that it stands, not how far it goes."""
    late, in_time = told(scene(0.0, 4.0)), rows_in_time()
    assert (late.code, late.severity, late.numbers["value"]) == (LATE, "warning", factor_with(4.0))
    assert "does not show that it stands" in words(late).what and "to see whether it stands, a seam" in words(late).wanted
    assert f"some {in_time} rows, with a spacing of at most {4.0 / in_time:.3g} m (extrapolated)" in words(late).wanted
    seam = {"points": [[100, 436], [160, 436], [180, 456], [220, 456]], "cohesion": 5.0, "friction_angle": 25.0}
    along, below = (scene(0.0, 4.0, **{"seams.base": seam | {"points": [[x, y - deep] for x, y in seam["points"]]}}) for deep in (0, 2))
    on_seam = told(along)
    assert (on_seam.code, on_seam.severity, words(on_seam).key) == ("cover-on-seam", "warning", "seams") and told(below).code == LATE
    assert "too long" in words(on_seam).measured and "without the seam" in words(on_seam).wanted


def test_a_run_that_stands_for_lack_of_rows_is_held_and_one_that_comes_down_is_not() -> None:
    runs = pd.DataFrame({"findings": [LATE, f"x {LATE}", LATE, "cover-rows", "weak-on-strong"], "diverged": 0}).assign(
        collapse_class=["stable", "minor", "collapse", "stable", "collapse"]
    )
    assert [*held(runs)] == [True, True, False, False, True]


def test_thin_debris_of_a_cover_with_enough_rows_is_told_as_its_rows_are() -> None:
    """Before the run and after it the same is said of its run-out; with few rows ``weak-on-strong`` says that it is a lower bound."""
    (thin,), (few,) = (thin_debris(scene(0.0, thickness), 19.0, 2.5) for thickness in (4.0, 2.0))
    assert words(thin).what.endswith("known to some 12% at best, as that of a cover with three rows or more") and thin.counts
    assert words(few).what.endswith("not reliable")


def test_the_scene_s_own_soil_may_be_the_cover() -> None:
    rock = {"rock": {"region": {"kind": "depth", "top": 2.0}, "soil": SLOPE["soil"]}}
    made = make_scene(merge(SLOPE, {"soil": WEAK, "layers": rock}))
    assert [(cover.name, cover.ground, cover.rows) for cover in covers(made)] == [("soil", "rock", pytest.approx(2.0))]
    assert told(made).subject == "soil"


def test_the_former_law_needs_the_present_one() -> None:
    braked = told(scene(0.0, 4.0, **{"numerics.interfaces": "both"}))
    assert (braked.code, words(braked).key) == ("weak-on-strong", "numerics.interfaces") and "weaker" in words(braked).wanted
    solid = told(scene(0.0, 4.0, **{"coupling.gamma": 0.0, "coupling.solid_after_failure": "elastic_plastic"}))
    assert solid.code == "weak-on-strong" and words(solid).key.startswith("coupling."), "soil that stays solid has weights of 1 for ever"


def test_one_row_between_two_strong_soils_is_an_error_with_its_remedies() -> None:
    held = told(scene(4.0, 5.0))
    assert (held.code, held.severity, held.subject) == ("layer-held", "error", "weak")
    assert "a spacing of at most 0.5 m" in words(held).wanted and "numerics.spacing" in words(held).key and "seams.weak" in words(held).key
    slides = told(scene(4.0, 6.0))
    assert slides.code == LATE and "a block on it" in words(slides).measured, "two rows slide"
    (cover,) = covers(scene(4.0, 5.0))
    assert cover.held and cover.short and cover.run_out == 0.0


def test_soil_that_is_not_weaker_or_hardly_lies_on_stronger_soil_is_no_cover() -> None:
    assert covers(scene(0.0, 2.0, **{"soil": {"density": 1600.0} | WEAK})) == []
    assert covers(scene(0.0, 2.0, **{"soil": {"cohesion": 6.0, "friction_angle": 26.0}})) == [], "the slip surface passes through both"
    far = {"kind": "polygon", "points": [[90, 438], [150, 438], [150, 441], [90, 441]]}
    assert covers(make_scene(merge(SLOPE, {"layers": {"weak": {"region": far, "soil": WEAK}}}))) == [], "it lies before the toe"
