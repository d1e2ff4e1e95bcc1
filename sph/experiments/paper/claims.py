"""The paper's twelve claims (abstract and Sec. 4), each decided by a written test on the study.

The verdict is ``holds`` or ``fails``; ``holds, fitted`` and ``true by construction`` where that is no test of the model; ``holds at
least`` where a travel distance is only known to be at least so long, since debris met an end of the box; ``not covered`` if the study lacks
a run that the test needs, or that run diverged; ``not yet`` for a claim that needs more than a grid of runs: the level of motion that
triggers failure is decided by ``decide_trigger`` from the table of critical amplitudes.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Hashable, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
import pandas as pd
import xarray as xr

from sph.checks.after_run import is_bounded
from sph.measures.metrics import COLLAPSE, DAMAGED, MINOR, UNDETERMINED
from sph.scene.configuration import Section, key
from sph.scene.units import Acceleration
from sph.storage.trajectory import Status
from sph.study.dimensions import named
from sph.study.verdicts import AT_LEAST, CONSTRUCTED, FAILS, FITTED, HOLDS, NOT_COVERED, NOT_YET

COLUMNS = ("claim", "statement", "test", "measured", "verdict")

PAPER_S_R = (0.10, 0.25, 0.50)  # Figs. 4 and 6
FAST, SLOW = 100.0, 1.0  # gamma of Figs. 5 and 7, 1/s
GAMMA_S_R = 0.25  # Fig. 5, and Fig. 7 by its text
FIGURE_7_S_R = 0.35  # Fig. 7 by its caption; reported beside the other
NO_TEST = "no independent test of the model, whose elastic solid state of failed soil was chosen because it gives this"
"""Of the claims that decided how the paper is read: docs/model/errata.md."""


class ClaimSettings(Section):
    """Numbers that turn the paper's words into tests; ours, the paper gives none."""

    amplitude: Acceleration = key("amplitude of the shaking at which the claims are tested", "m/s2", "Sec. 3.2", gt=0, le=100, default=6.0)
    fluidised_fraction: float = key("'fluidised' needs at least this fraction of failed soil particles", gt=0, le=1, default=0.5)
    fluidised_runout: float = key("'fluidised' needs at least this run-out over the height of the slope", gt=0, le=100, default=0.5)
    same_instant: float = key("failures within this time happen at the same instant", "s", gt=0, le=10, default=1e-3)
    slight: float = key(
        "'deforms slightly' beside a collapse: at most this share of the collapsed slope's displacement of A", gt=0, lt=1, default=0.2
    )
    most: float = key("share of A's vertical displacement that counts as most of the motion", gt=0, lt=1, default=0.5)
    finished: float = key("share of A's vertical displacement at which the motion has in effect ended", gt=0, le=1, default=0.95)


Verdict = tuple[str, bool | str]
"""What was measured, in words with numbers and units, and whether the claim holds, or a verdict of its own."""
Decide = Callable[[xr.Dataset, ClaimSettings], Verdict]


class Claim(NamedTuple):
    """One claim: number, statement in our words, numeric test, and the function that makes it."""

    number: int
    statement: str
    test: str
    decide: Decide


CLAIMS: list[Claim] = []
"""The paper's, in its order."""


def claim(number: int, statement: str, test: str) -> Callable[[Decide], Decide]:
    """Add a claim that the function decides."""

    def add(decide: Decide) -> Decide:
        CLAIMS.append(Claim(number, statement, test, decide))
        return decide

    return add


def _ratio(S_R: float) -> str:
    return f"{named('S_R').symbol} {S_R:.2f}"


def _rate(gamma: float) -> str:
    return f"{named('gamma').symbol} {gamma:g}"


class NotCovered(Exception):
    """The study has no usable run where a claim needs one."""


class Case:
    """One run of the study at the reference amplitude; numbers by the names of ``METRICS``."""

    def __init__(self, study: xr.Dataset, settings: ClaimSettings, S_R: float, gamma: float) -> None:
        self.label = f"{_ratio(S_R)}, {_rate(gamma)}"
        self.S_R = S_R
        try:
            point = study.sel(S_R=S_R, gamma=gamma, amplitude=settings.amplitude, method="nearest", tolerance=1e-9)
        except KeyError:
            raise NotCovered(f"no run with {self.label} at {settings.amplitude:g} m/s²") from None
        status = str(point["status"].item())
        if status == "":
            raise NotCovered(f"no run with {self.label} at {settings.amplitude:g} m/s²")
        if status == Status.DIVERGED:
            raise NotCovered(f"the run with {self.label} at {settings.amplitude:g} m/s² diverged")
        self._point = point

    def __getitem__(self, metric: str) -> float:
        return float(self._point[metric].item())

    @property
    def collapse_class(self) -> str:
        return str(self._point["collapse_class"].item())

    @property
    def bounded(self) -> bool:
        """Whether displacement and run-out are lower bounds, since debris met an end of the box."""
        return is_bounded(str(self._point["reached_side"].item()))

    @property
    def least(self) -> str:
        """What stands before a length of the run in words."""
        return "≥ " * self.bounded

    @property
    def displacement(self) -> str:
        """Permanent displacement of A in words."""
        return f"{self.least}{self['displacement_magnitude']:.2f} m"

    @property
    def runout(self) -> str:
        """Run-out in words."""
        words = f"run-out {self.least}{self['runout']:.1f} m ({self.least}{self['runout_over_height']:.2f} H)"
        return words + ", up to an end of the box" * self.bounded

    @property
    def onset(self) -> float:
        """Onset of the probe's motion, s; infinite if it never moved."""
        return math.inf if math.isnan(self["onset_time"]) else self["onset_time"]

    @property
    def share_after_shaking(self) -> float:
        """Vertical displacement of the probe after the shaking, as in Fig. 7, over that at the end of the run; NaN if it never moved."""
        sinks = self["displacement_vertical"]
        if math.isinf(self.onset) or sinks == 0.0:
            return math.nan
        return (sinks - self["displacement_vertical_end_of_shaking"]) / sinks


def _paper_cases(study: xr.Dataset, settings: ClaimSettings) -> list[Case]:
    return [Case(study, settings, S_R, FAST) for S_R in PAPER_S_R]


def _each(cases: Sequence[Case], text: Callable[[Case], str]) -> str:
    return "; ".join(f"{case.label}: {text(case)}" for case in cases)


def _verdict(holds: bool | str) -> str:
    return holds if isinstance(holds, str) else HOLDS if holds else FAILS


def _time(time: float) -> str:
    return f"{time:.2f} s" if math.isfinite(time) else "never"


@claim(
    1,
    "The smaller S_R, the more the slope deforms (Sec. 4, Fig. 4)",
    "permanent displacement of A, γ 100: S_R 0.10 > 0.25 > 0.50",
)
def _weaker_deforms_more(study: xr.Dataset, settings: ClaimSettings) -> Verdict:
    cases = _paper_cases(study, settings)
    low, middle, high = (case["displacement_magnitude"] for case in cases)
    return f"displacement of A: {_each(cases, lambda case: case.displacement)}", low > middle > high


def _fluidity(case: Case) -> str:
    return f"{case.collapse_class}, {100 * case['failed_fraction']:.0f} % failed, {case.runout}"


@claim(
    2,
    "With S_R 0.10 the slope is fluidised and deforms strongly (Sec. 4, Fig. 4a)",
    "γ 100: class collapse, at least {fluidised_fraction} of the soil failed, run-out at least {fluidised_runout} H",
)
def _fluidised(study: xr.Dataset, settings: ClaimSettings) -> Verdict:
    case = Case(study, settings, PAPER_S_R[0], FAST)
    holds = (
        case.collapse_class == COLLAPSE
        and case["failed_fraction"] >= settings.fluidised_fraction
        and case["runout_over_height"] >= settings.fluidised_runout
    )
    return f"{case.label}: {_fluidity(case)}", holds


@claim(
    3,
    "With S_R 0.50 the slope is not fluidised but deforms slightly (Sec. 4, Fig. 4c)",
    "γ 100: run-out less than {fluidised_runout} H, so what has failed stays where it is, and class minor or damaged, that is permanent "
    "displacement of A neither negligible nor a collapse",
)
def _slight(study: xr.Dataset, settings: ClaimSettings) -> Verdict:
    case = Case(study, settings, PAPER_S_R[2], FAST)
    measured = f"{case.label}: {_fluidity(case)}, displacement of A {case.displacement}"
    return measured, case.collapse_class in (MINOR, DAMAGED) and case["runout_over_height"] < settings.fluidised_runout


@claim(
    4,
    "With γ 100 the slope collapses, with γ 1 it deforms slightly (Sec. 4, Fig. 5, at 15 s)",
    "S_R 0.25, end of the run: γ 100 class collapse; γ 1 class minor or damaged, displacement of A at most {slight} of that with γ 100; "
    + NO_TEST,
)
def _fast_loss_collapses(study: xr.Dataset, settings: ClaimSettings) -> Verdict:
    fast, slow = (Case(study, settings, GAMMA_S_R, gamma) for gamma in (FAST, SLOW))
    slight = slow.collapse_class in (MINOR, DAMAGED)
    share = slow["displacement_magnitude"] / fast["displacement_magnitude"] if fast["displacement_magnitude"] > 0.0 else math.inf

    def text(case: Case) -> str:
        return f"{case.collapse_class}, displacement of A {case.displacement}"

    holds = fast.collapse_class == COLLAPSE and slight and share <= settings.slight
    return _each([fast, slow], text) + _beside(study, settings, (FAST, SLOW), text), FITTED if holds else FAILS


@claim(
    5,
    "The instant at which motion can begin is the same for every S_R (Sec. 4, Fig. 6)",
    "time of the first failure, γ 100, S_R 0.10, 0.25, 0.50: spread at most {same_instant} s; the paper says so of A, then that A starts "
    "earlier with S_R 0.10 (claim 6)",
)
def _same_first_failure(study: xr.Dataset, settings: ClaimSettings) -> Verdict:
    cases = _paper_cases(study, settings)
    times = np.array([case["first_failure_time"] for case in cases])
    if np.isnan(times).all():
        raise NotCovered(f"no particle fails at {settings.amplitude:g} m/s²")
    spread = float(np.ptp(times))  # NaN if only some fail
    measured = _each(cases, lambda case: f"{case['first_failure_time']:.4f} s")
    note = "true by construction, S_R acts only after the first failure and the runs branch there from one shared pre-failure run"
    return f"first failure: {measured}; spread {spread:.4f} s ({note})", CONSTRUCTED if spread <= settings.same_instant else FAILS


@claim(
    6,
    "A moves visibly first with S_R 0.10 (Sec. 4, Fig. 6)",
    "onset of the motion of A, γ 100: S_R 0.10 < 0.25 and < 0.50; never moving counts as later",
)
def _weakest_moves_first(study: xr.Dataset, settings: ClaimSettings) -> Verdict:
    cases = _paper_cases(study, settings)
    low, middle, high = (case.onset for case in cases)
    return f"onset of A: {_each(cases, lambda case: _time(case.onset))}", low < min(middle, high)


@claim(
    7,
    "With S_R 0.50 A moves slowest (Sec. 4, Fig. 6)",
    "peak speed of A, γ 100: S_R 0.50 < 0.25 and < 0.10",
)
def _strongest_is_slowest(study: xr.Dataset, settings: ClaimSettings) -> Verdict:
    cases = _paper_cases(study, settings)
    low, middle, high = (case["probe_peak_speed"] for case in cases)
    measured = "peak speed of A: " + _each(cases, lambda case: f"{case['probe_peak_speed']:.2f} m/s")
    return measured, high < min(low, middle)


@claim(
    8,
    "The intermediate S_R, 0.25, lies between the two others (Sec. 4, Fig. 6)",
    "γ 100: displacement and peak speed of A strictly between, onset of its motion between or equal",
)
def _middle_lies_between(study: xr.Dataset, settings: ClaimSettings) -> Verdict:
    cases = _paper_cases(study, settings)
    ordered = [cases[0][name] > cases[1][name] > cases[2][name] for name in ("displacement_magnitude", "probe_peak_speed")] + [
        cases[0].onset <= cases[1].onset <= cases[2].onset
    ]

    def text(case: Case) -> str:
        return f"{case.displacement}, {case['probe_peak_speed']:.2f} m/s, onset {_time(case.onset)}"

    return _each(cases, text), all(ordered)


def _share_text(case: Case) -> str:
    share = case.share_after_shaking
    if math.isnan(share):
        return "A does not move"
    sinks, at_end_of_shaking = -case["displacement_vertical"], -case["displacement_vertical_end_of_shaking"]
    after = [case[f"displacement_{axis}"] - case[f"displacement_{axis}_end_of_shaking"] for axis in ("horizontal", "vertical")]
    whole = math.hypot(*after) / case["displacement_magnitude"]
    return (
        f"A sinks {at_end_of_shaking:.2f} m by the end of the shaking, {sinks:.2f} m in all, {100 * share:.1f} % after the shaking "
        f"({100 * whole:.1f} % of its displacement, horizontal and vertical)"
    )


@claim(
    9,
    "With γ 1 the slope deforms mostly after the shaking (Sec. 4, Fig. 7)",
    "S_R 0.25: more than {most} of the vertical displacement of A at the end of the run comes after the shaking; " + NO_TEST,
)
def _slow_loss_moves_after(study: xr.Dataset, settings: ClaimSettings) -> Verdict:
    case = Case(study, settings, GAMMA_S_R, SLOW)
    measured = f"{case.label}: {_share_text(case)}" + _beside(study, settings, (SLOW,), _share_text)
    return measured, FITTED if case.share_after_shaking > settings.most else FAILS


@claim(
    10,
    "With γ 100 the deformation begins and ends during the shaking (Sec. 4, Fig. 7)",
    "S_R 0.25: A does not move before the shaking, and at least {finished} of its vertical displacement comes by the end of the shaking",
)
def _fast_loss_moves_within(study: xr.Dataset, settings: ClaimSettings) -> Verdict:
    case = Case(study, settings, GAMMA_S_R, FAST)
    within = case.onset >= case["shaking_start"] and abs(case.share_after_shaking) <= 1.0 - settings.finished

    def text(case: Case) -> str:
        times = f"onset {_time(case.onset)}, arrest {_time(case['arrest_time'])}"
        return f"{_share_text(case)}, {times}, shaking {case['shaking_start']:g} to {case['shaking_end']:g} s"

    return f"{case.label}: {text(case)}" + _beside(study, settings, (FAST,), text), within


def _beside(study: xr.Dataset, settings: ClaimSettings, gammas: Sequence[float], text: Callable[[Case], str]) -> str:
    """The same numbers for the S_R of Fig. 7's caption, where the study has them; they take no part in the verdict."""
    try:
        cases = [Case(study, settings, FIGURE_7_S_R, gamma) for gamma in gammas]
    except NotCovered:
        return ""
    return f"; beside it, {_each(cases, text)}"


@claim(
    11,
    "The method yields the level of motion that triggers failure (abstract)",
    "decided by 'snakemake trigger' in trigger/claim.csv, by a search for the critical amplitude; here the bracket from the study, "
    "by class collapse at γ 100",
)
def _trigger(study: xr.Dataset, settings: ClaimSettings) -> Verdict:
    brackets = [text for S_R in study["S_R"].values if (text := _bracket(study, float(S_R)))]
    if not brackets:
        raise NotCovered(f"the study has no S_R with two amplitudes at {_rate(FAST)}")
    return "from the grid only: " + "; ".join(brackets), NOT_YET


def _bracket(study: xr.Dataset, S_R: float) -> str:
    """Largest amplitude without and smallest with collapse at one S_R; '' with fewer than two finished runs."""
    try:
        line = study["collapse_class"].sel(S_R=S_R).sel(gamma=FAST)
    except KeyError:
        return ""
    classes = {float(a): str(c) for a, c in zip(line["amplitude"].values, line.values, strict=True) if c not in ("", UNDETERMINED)}
    if len(classes) < 2:
        return ""
    collapsed = [amplitude for amplitude, name in classes.items() if name == COLLAPSE]
    standing = [amplitude for amplitude, name in classes.items() if name != COLLAPSE]
    below = f"no collapse up to {max(standing):g} m/s²" if standing else f"collapse already at {min(classes):g} m/s²"
    above = f", collapse from {min(collapsed):g} m/s²" if collapsed and standing else ""
    return f"{_ratio(S_R)}: {below}{above}"


@claim(
    12,
    "The method yields the travel distance of the debris (abstract)",
    "every collapsed run of S_R 0.10, 0.25, 0.50 with γ 100 has a run-out above 0 and is not still moving; holds at least: debris "
    "met an end of the box",
)
def _runout_arrests(study: xr.Dataset, settings: ClaimSettings) -> Verdict:
    cases = [case for case in _paper_cases(study, settings) if case.collapse_class == COLLAPSE]
    if not cases:
        raise NotCovered(f"no run with {_rate(FAST)} collapses at {settings.amplitude:g} m/s²")

    def text(case: Case) -> str:
        state = "still moving" if case["still_moving"] else f"at rest, A since {_time(case['arrest_time'])}"
        return f"{case.runout}, {state}"

    holds = all(case["runout"] > 0 and not case["still_moving"] for case in cases)
    return _each(cases, text), AT_LEAST if holds and any(case.bounded for case in cases) else holds


def decide_claims(study: xr.Dataset, settings: ClaimSettings | None = None) -> pd.DataFrame:
    """One row per claim with the columns ``COLUMNS``, from the dataset of a study."""
    settings = settings or ClaimSettings()
    rows = []
    for number, statement, test, decide in CLAIMS:
        try:
            measured, holds = decide(study, settings)
        except NotCovered as reason:
            measured, holds = str(reason), NOT_COVERED
        at = f"at {settings.amplitude:g} m/s²: " if decide is not _trigger else ""
        rows.append((number, statement, at + test.format(**settings.model_dump()), measured, _verdict(holds)))
    return pd.DataFrame(rows, columns=list(COLUMNS))


TRIGGER_TEST = (
    "γ {FAST:g}, S_R {strengths}: the search ends in one bracket of class collapse, not reached below and reached above, "
    "with no diverged run inside and no second change of class above"
)
TRIGGER_COLUMNS = ("claim", "case", *COLUMNS[1:])


def decide_trigger(critical: pd.DataFrame) -> pd.DataFrame:
    """Claim 11, a row per case with the columns ``TRIGGER_COLUMNS``, from the table of critical amplitudes (``experiments.trigger``)."""
    own = next(each for each in CLAIMS if each.decide is _trigger)
    test = TRIGGER_TEST.format(FAST=FAST, strengths=", ".join(f"{S_R:.2f}" for S_R in PAPER_S_R))
    rows = []
    for case, table in critical[critical["collapse_class"] == COLLAPSE].groupby("case", sort=False):
        by_point = {(float(row["S_R"]), float(row["gamma"])): row for row in table.to_dict("records")}
        brackets = [by_point.get((S_R, FAST)) for S_R in PAPER_S_R]
        clear = [row is not None and _clear(row) for row in brackets]
        measured = "; ".join(_critical_text(S_R, row) for S_R, row in zip(PAPER_S_R, brackets, strict=True))
        rows.append((own.number, case, own.statement, test, measured, NOT_COVERED if None in brackets else _verdict(all(clear))))
    return pd.DataFrame(rows, columns=list(TRIGGER_COLUMNS))


def _clear(row: Mapping[Hashable, Any]) -> bool:
    return bool(not math.isnan(row["critical_intensity"]) and row["diverged_inside"] == 0 and row["changes"] == 1)


def _critical_text(S_R: float, row: Mapping[Hashable, Any] | None) -> str:
    if row is None:
        return f"{_ratio(S_R)}: not searched"
    if math.isnan(row["critical_intensity"]):
        end = row["lower"] if math.isnan(row["upper"]) else row["upper"]
        return f"{_ratio(S_R)}: {row['outcome']} amplitude, {end:g} m/s²"
    more = [
        f"{row[name]:g} {text}"
        for name, text in (("diverged_inside", "diverged inside"), ("changes", "changes of class"))
        if row[name] > (name == "changes")
    ]
    still = ["lower end still moving"] if row["lower_still_moving"] else []
    text = f"{_ratio(S_R)}: {row['critical_intensity']:.4g} ± {row['resolution_error']:.3g} m/s²"
    return text + (f" ({', '.join(more + still)})" if more + still else "")
