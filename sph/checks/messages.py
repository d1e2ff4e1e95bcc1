"""All that can be found (``MESSAGES``), with its severity and its words: for commands, logs, tables, the page and the reference.

A text has its numbers in braces, as ``str.format``: ``{value:m/s2}`` is an acceleration in m/s2 and g, ``{value:kPa}`` and
``{value:degree}`` have the unit of the keys, ``{value:.3g %}`` is a share in per cent.  Where a code has several texts, a function of the
numbers chooses.
"""

from __future__ import annotations

import math
import string
from collections.abc import Callable, Mapping, Sequence
from enum import StrEnum
from functools import partial
from typing import TYPE_CHECKING, Any, NamedTuple

from sph.checks.cover_rows import EARLY_ON_SEAM, FAR_ON_SEAM, SCATTER, SHORT_ON_SEAM
from sph.scene.gravity import FAILED_AREA, GRAVITY
from sph.scene.units import in_both
from sph.scene.walls import wall_words
from sph.stability.extrapolation import how_found
from sph.stability.slip_search import MAX_FACTOR

if TYPE_CHECKING:
    from sph.checks.finding import Finding

OR = " or "
"""Between the keys of a finding."""


class Severity(StrEnum):
    """How much a finding matters."""

    ERROR = "error"
    """the result will not be the one you want"""
    WARNING = "warning"
    """the result may be unreliable"""
    NOTE = "note"
    """for information; nothing needs to be changed"""


Numbers = Mapping[str, Any]
"""Numbers (``float``) by name, in SI units (angles in radians) or the unit that the name says; names (``str``) as of a status or a layer.

``value`` is what is measured and ``bound`` what it is compared with, 0 or more both.
"""
ERROR, WARNING, NOTE = Severity
Text = str | Callable[[Numbers], str]


class Message(NamedTuple):
    """The severity of a code, or the rule for it, and its texts."""

    severity: Severity | Callable[[Numbers], Severity]
    what: Text  # what is the matter
    measured: Text
    wanted: Text = ""  # what the value should be; one that begins with "to", what the scene should do
    meaning: str = ""  # of the code, for the reference, where it is not just ``what``


error, warning, note = (partial(Message, severity) for severity in Severity)


class Words(NamedTuple):
    """A finding in words; the names are those of ``sph check --json`` and ``preflight.csv``."""

    what: str
    measured: str
    wanted: str
    key: str


class _Units(string.Formatter):
    """Numbers in SI units with the unit in which they are read."""

    def format_field(self, value: Any, format_spec: str) -> Any:
        if format_spec == "m/s2":
            return in_both(value)
        if format_spec == "kPa":
            return f"{value / 1e3:g} kPa"
        if format_spec == "degree":
            return f"{math.degrees(value):g} degree"
        if format_spec.endswith(" %"):
            return f"{100.0 * value:{format_spec[:-2]}} %"
        return super().format_field(value, format_spec)


MORE_ROWS = "more rows of particles in {subject}"
SURER = {
    "record-polarity": "each record in both directions",
    "mobilised-strength": "K0 of {subject} from tests",
    "thin-layer": MORE_ROWS,
    "weak-on-strong": MORE_ROWS,
    "cover-late": MORE_ROWS,
}
"""What would make an answer surer, by the code of a warning that it has."""


# ---------------------------------------------------------------- texts that numbers choose


def _simplified(of: Numbers) -> str:
    part = ", below 1 in {share:.0f %} of it" if of["share"] > 0.0 else ""
    return f"factor of safety {{value:.2f}} at a depth of {{depth:.3g}} m{part}; as level ground, magnitude {{magnitude:g}}, {{peak:m/s2}}"


def limit_text(limit: str, value: float, error: float | None = None) -> str:
    """A limit of a slope, by the code of its finding, with its error where that is given."""
    if limit == "yield-acceleration":
        return in_both(value, error)
    return f"{value:.2f}" if error is None else f"{value:.2f} ± {error:.2f}"


LIMITS = {"factor-of-safety": "factor of safety", "yield-acceleration": "yield acceleration"}
"""What the limits of a slope are called, by the codes of their findings."""
UNKNOWN = {
    "stability": ("the stability of the slope", "not tested: {reason}"),
    "factor-of-safety": ("static factor of safety", "not found: {reason}"),
    "yield-acceleration": ("yield acceleration, pseudo-static", "not found: {reason}"),
    "limit-equilibrium": (
        "limit equilibrium",
        f"no slip surface found with a factor of safety up to {MAX_FACTOR:g} that ends on the ground of the model",
    ),
    "stability of further slopes": ("the stability of further slopes of the study", "not tested, to save time"),
    "limits of further slopes": (
        "factor of safety and yield acceleration of further slopes of the study",
        "not searched, to save time; run sph fos or sph yield-acceleration on the scene or on the file of a run",
    ),
}
"""What is not known and why, by the subject of the finding."""
REASONS = {
    "dilation": "with a dilation angle below the friction angle, SPH gives a lower strength (Davis 1968)",
    "crack": "Spencer's surface ends in a tension crack, where SPH soil can bear tension",
    "thin": "{thin}: few particles across, which makes a layer too strong",
    "spacing": "SPH searches overestimate the factor at coarse spacings",
    "deforms": "without friction, a non-circular surface forces the sliding mass to deform, which the methods of slices ignore",
    "walls": "soil also slides on the walls (walls.friction), which limit equilibrium does not model",
    "lever": "a few per cent of the strength are a large part of a yield acceleration",
}
"""Why a limit by SPH may differ from Spencer's."""
SIDES = {"front": "the end of the box in front of the toe", "back": "the end of the box behind the crest", "over": "the top of a side"}
"""Sides of the box, by their names in the metric ``reached_side``."""
SURFACES = {"bishop": "Bishop's factor of safety", "spencer": "Spencer's factor of safety", "critical": "Spencer's yield acceleration"}


def _where_below(numbers: Numbers) -> Severity:
    return WARNING if numbers["value"] < numbers["bound"] else NOTE


def _where_bounded(numbers: Numbers) -> Severity:
    return WARNING if "bound" in numbers else NOTE


def _at(of: Numbers) -> str:
    """The spacing of a test, with that of the runs where it is another."""
    same = math.isclose(of["spacing"], of["run_spacing"], rel_tol=1e-6)
    return "at a spacing of {spacing:.3g} m" + ("" if same else ", where the runs have {run_spacing:.3g} m")


def _displaced(of: Numbers) -> str:
    """The soil that moved in a test, and whether the guard stopped it."""
    return "{displaced_area:.3g} m2 displaced" + (" (diverged)" if of["status"] == "diverged" else "")


def _at_residual(of: Numbers) -> str:
    return f"the slope without shaking, at residual strength{_ratios(of)}"


def _ratios(of: Numbers) -> str:
    """The strength ratios that decide a residual strength; nothing where it is given directly."""
    own = [f"{name.split('.')[1]} {value:g}" for name, value in of.items() if name.startswith("layers.")]
    said = ", ".join(([f"{of['S_R']:g}"] if "S_R" in of else []) + own)
    return f" (strength ratio {said})" if said else ""


def _strength(of: Numbers, soil: str = "") -> str:
    """The strength of a soil, whose name and a dot its numbers begin with; nothing where there is none."""
    cohesion, gradient, angle = (of.get(f"{soil}{name}") for name in ("cohesion", "gradient", "friction_angle"))
    parts = [f"a cohesion of {1e-3 * (cohesion or 0.0):.3g} kPa"] * (cohesion is not None or gradient is not None)
    parts = [f"{part}, growing by {1e-3 * gradient:.3g} kPa/m" if gradient is not None else part for part in parts]
    return listed([*parts, *([f"a friction angle of {math.degrees(angle):.3g} degree"] if angle is not None else [])])


def _stable(of: Numbers) -> str:
    """With which strength of the soil along its surface a slope stands, to three digits."""
    known = _strength(of)
    return "at least 1" + (f", as with {known} in {{subject}}" if known else "")


def _enough(of: Numbers) -> str:
    """With which strength soil does not soften under gravity, or up to which it does."""
    if "soils" not in of:
        return ""
    if "times" in of:
        return f"; {of['times']:g} times the peak strength of {{soils}} is not enough"
    soils = dict.fromkeys(name.rpartition(".")[0] for name in of if "." in name)
    return ", as with " + listed([f"{_strength(of, f'{soil}.')} in {soil}" for soil in soils])


def _mobilised(of: Numbers) -> str:
    depth = " at a depth of {depth:.3g} m with K0 = {K0:.3g}" + (" = nu / (1 - nu)" if "poisson_ratio" in of else "")
    depth += ", {bound:.0f %} or more from {from_depth:.3g} m downwards"
    return "{value:.0f %} of its peak strength" + (depth if "depth" in of else "")


def _less_mobilised(of: Numbers) -> str:
    if "bound" not in of:
        return ""
    if "K0" not in of:
        return "less than {bound:.0f %}, or be computed from a known initial stress"
    held = of["held_K0"]
    return "less than {bound:.0f %}, as with a K0 of " + (
        f"at least {held:.3g} (nu {held / (1.0 + held):.3g})" if held < 1.0 else f"at most {held:.3g}"
    )


def limit_words(of: Finding) -> str:
    """A limit of a slope with its error."""
    return limit_text(of.code, of.numbers["value"], of.numbers["error"])


def limit_how(of: Numbers) -> str:
    """How it was found."""
    return how_found(of["coarse"], of["fine"], bool(of["step_taken"]))


def _limit(code: str) -> Text:
    return lambda of: f"{limit_text(code, of['value'], of['error'])}, {limit_how(of)}"


def search_words(facts: Mapping[str, Any]) -> tuple[str, str]:
    """The limit that a search found, with its error, and how, from the attributes of its file; the reason where it found none.

    Searches of earlier versions were at the spacing of the runs alone, and have no error.
    """
    if facts["reason"]:
        return f"not found: {facts['reason']}", ""
    limit, value = str(facts["by"]).replace("_", "-"), float(facts["value"])
    if "error" in facts:
        return limit_text(limit, value, float(facts["error"])), str(facts["how"])
    return limit_text(limit, value), "at the spacing of the runs alone, which makes slopes too strong"


def _surface(of: Numbers, name: str) -> str:
    words = {"line": "not circular"}.get(str(of[f"{name}_surface"]), str(of[f"{name}_surface"]))
    if deep := float(of.get(f"{name}_depth", 0.0)):
        words += f", {deep:.2g} m deep"
    return words if not of[f"{name}_crack"] else f"{words}, with a tension crack of {of[f'{name}_crack']:.2g} m"


def braked_words(of: Finding) -> str:
    """The rows of particles of weak soil that stronger ground brakes, ``weak-on-strong``, or holds, ``layer-held``."""
    rows = of.numbers["value" if of.code == "layer-held" else "rows"]
    return f"{rows:.2g} rows of particles in {of.subject or 'the thinnest soil'}"


def factor_words(of: Numbers) -> str:
    """The factors of safety of both methods of limit equilibrium, and where the surfaces lie."""
    bishop = f"{of['bishop']:.2f} (circle)" if "bishop" in of else "not found"
    return f"Bishop {bishop}, Spencer {of['spencer']:.2f} ({_surface(of, 'spencer')}{within_words(of)[0]})"


def within_words(of: Numbers) -> tuple[str, str]:
    """The factor of safety and the yield acceleration by Spencer's method within a cover, where they are known."""
    factor = f"; within {of['cover']} {of['cover_spencer']:.2f}" if "cover_spencer" in of else ""
    return factor, f"; within {of['cover']} {in_both(of['cover_critical'])}" if "cover_critical" in of else ""


def block_words(of: Numbers) -> str:
    """How far a rigid block slips, and what that does to the slope."""
    return (
        f"with Spencer's yield acceleration of {in_both(of['strength'])} a rigid block slips {of['value']:.3g} m, strength is lost within "
        f"{of['bound']:.3g} m, and at residual strength the factor of safety is {of['residual']:.2f}"
    )


def yield_words(of: Numbers) -> str:
    """The yield acceleration by Spencer's method; 0 for a slope that does not stand."""
    if of["spencer"] <= 1.0:
        return f"Spencer {in_both(0.0)}: the slope does not stand"
    if "critical" not in of:
        return "Spencer: not found"
    return f"Spencer {in_both(of['critical'])} ({_surface(of, 'critical')}{within_words(of)[1]})"


def _reasons(of: Numbers) -> str:
    known = "; ".join(REASONS[name] for name in of["reasons"].split())
    both = f"{limit_text(of['limit'], of['value'], of['error'])} and {limit_text(of['limit'], of['bound'])}"
    return f"{both}: " + (known or "no reason is known: look at both slip surfaces")


def _contradicts(of: Numbers) -> bool:
    """Whether a slope stands by its factor of safety by SPH and does not by Spencer's."""
    return of["limit"] == "factor-of-safety" and of["value"] >= 1.0 > of["bound"]


def listed(names: Sequence[str], last: str = "and") -> str:
    """Names in words: a, b and c."""
    return f" {last} ".join(filter(None, (", ".join(names[:-1]), names[-1])))


def _reaching(of: Numbers) -> str:
    names = [words for name, words in SURFACES.items() if name in of]
    return f"the {'surface' if len(names) == 1 else 'surfaces'} of {listed(names)}"


def _property(of: Numbers) -> str:
    """The property of a soil or seam that a key names."""
    return f"the {of['key'].rsplit('.', 1)[-1].replace('_', ' ')} of {{subject}} is implausible"


def _is_tangent(of: Numbers) -> bool:
    return of["key"].startswith("walls.friction")


def _angle(of: Numbers) -> str:
    if _is_tangent(of):
        return "a tangent, at most {bound:.2g}; " + f"that of {of['value']:g} degrees is {math.tan(math.radians(of['value'])):.3g}"
    angle = math.degrees(of["value"])
    return (
        f"at least {math.degrees(of['bound']):.2g} degree, or 0; {angle:g} rad are {math.degrees(angle):.3g} degree, "
        f"and {angle:g} is the tangent of {math.degrees(math.atan(angle)):.3g} degree"
    )


def _other_face(of: Numbers) -> str:
    if "other_x" not in of:
        return "an edge with gentler ground beyond it, or {subject}_at"
    return "({other_x:.10g}, {other_y:.10g}) m, that of a steeper face, with H = {other_height:.4g} m, if it is the slope that is meant"


def _cover(of: Numbers) -> str:
    return (
        "{rows:.2g} rows of particles in {thickness:.3g} m, with which debris runs about {value:.0%} as far as with fine particles, "
        f"and the factor of safety is up to {of['factor'] - 1.0:.0%} too high"
    )


def _ran(of: Numbers) -> str:
    return (
        "a block on it moves as it should"
        if of.get("between")
        else f"debris on two hillsides ran as far as with more, within {SCATTER:.0%}"
    )


def _in_time(of: Numbers) -> str:
    """The rows, more than were measured, with which weak soil does not fail too late, and the seam that needs none."""
    spacing = f"{of['thickness'] / of['in_time']:.3g} m"
    seam = "or, to see whether it stands, a seam with its strength along its base"
    return f"some {{in_time:g}} rows, with a spacing of at most {spacing} (extrapolated), {seam}"


def _unbraked(of: Numbers) -> str:
    if "enough" in of:
        spacing = f"{of['thickness'] / of['enough']:.3g} m"
        return f"at least {{enough:g}} rows for its run-out, with a spacing of at most {spacing}, and to fail when it should {_in_time(of)}"
    return "computed with numerics.interfaces: weaker" if of["both"] else "free to lose its solid state after failure"


def _reached(of: Numbers) -> str:
    sides = of["sides"].split()
    bounded = ", so displacement and run-out are lower bounds" if {"front", "over"} & set(sides) else ""
    return "failed soil has reached " + " and ".join(SIDES[side] for side in sides) + bounded


MESSAGES: dict[str, Message] = {
    "fails-unshaken": error(
        "the slope does not stand without shaking, so its failure is not due to the earthquake",
        lambda of: f"fails at its peak strength, {_displaced(of)} " + _at(of),
        "to stand",
    ),
    "softens-unshaken": error(
        "soil is at its strength under gravity alone and softens before the shaking, so the result is not due to an earthquake",
        lambda of: "{value:.3g} m2 " + _at(of),
        lambda of: f"at most {FAILED_AREA:g} H2 = {{bound:.3g}} m2{_enough(of)}",
    ),
    "fails-softened": error(
        "without shaking the slope fails as its soil softens, so the result is not due to the earthquake alone",
        lambda of: f"{_displaced(of)} as it softens, " + _at(of),
        lambda of: "to stand" + _enough(of),
    ),
    "stands-unshaken": note(
        "static test of the slope with particles, at peak strength",
        lambda of: "stands " + _at(of),
        meaning="the slope stands at its peak strength without shaking",
    ),
    "fails-at-residual": note(
        _at_residual,
        "does not stand: soil that fails flows until the slope is flatter",
        meaning="without shaking the slope fails at its residual strength: soil that fails keeps moving downslope",
    ),
    "stands-at-residual": note(
        _at_residual,
        "stands: soil that fails comes to rest",
        meaning="without shaking the slope stands at its residual strength: soil that fails comes to rest",
    ),
    "mobilised-strength": Message(
        _where_bounded,
        lambda of: (
            "strength of {subject} mobilised by gravity alone, "
            + ("in level ground at rest (Rankine)" if "depth" in of else "before the shaking")
        ),
        _mobilised,
        _less_mobilised,
        meaning="share of its peak strength that a layer mobilises under gravity alone, near the slope or in level ground; a warning from "
        "95 % on",
    ),
    "factor-of-safety": Message(
        lambda of: WARNING if of["value"] - of["error"] < 1.0 else NOTE,
        "static factor of safety",
        _limit("factor-of-safety"),
        lambda of: "above 1 by more than its error" if of["value"] - of["error"] < 1.0 else "",
    ),
    "yield-acceleration": note(
        "yield acceleration, pseudo-static", _limit("yield-acceleration"), meaning="pseudo-static yield acceleration"
    ),
    "limit-equilibrium": note(
        "limit equilibrium, without a run",
        lambda of: f"{factor_words(of)}; yield acceleration {yield_words(of)}",
        meaning="factor of safety and yield acceleration by limit equilibrium: Bishop's and Spencer's methods",
    ),
    "limit-equilibrium-residual": note(
        lambda of: f"limit equilibrium at the residual strength{_ratios(of)}",
        factor_words,
        meaning="factor of safety by limit equilibrium at the strength that failed soil keeps",
    ),
    "limit-equilibrium-differs": Message(
        lambda of: WARNING if _contradicts(of) else NOTE,
        lambda of: (
            f"the {LIMITS[of['limit']]} by SPH lies {abs(off := of['value'] / of['bound'] - 1.0):.0%} "
            f"{'above' if off > 0.0 else 'below'} Spencer's" + ", by which the slope does not stand" * _contradicts(of)
        ),
        _reasons,
        lambda of: "to agree at a smaller spacing; until it does, trust Spencer's and mend the slope or its strength" * _contradicts(of),
        meaning="the factor of safety by SPH differs by over 5 % from Spencer's, or the yield acceleration by over 20 %, with the "
        "possible reasons; a warning where the slope stands by SPH alone",
    ),
    "block-runs-away": note(
        "by limit equilibrium the slope fails in this shaking, and a run in which it stands has too few rows of particles in the soil that "
        "should slide: take a smaller numerics.spacing",
        block_words,
        meaning="a rigid block with Spencer's yield acceleration slips farther than the soil needs to lose its strength, without which the "
        "slope does not stand",
    ),
    "factor-below-1": warning(
        "by limit equilibrium the slope does not stand without shaking, so that its failure would not be due to the earthquake",
        "a factor of safety of {value:.2f} (Spencer)",
        _stable,
    ),
    "slip-at-base": warning(
        "a slip surface reaches an absorbing base with ground like the lowest soil below it, into which it would go on",
        _reaching,
        "to lie above the base, or end on stiff ground",
    ),
    "probes-off-slide": warning(
        "no probe lies on the body above the critical slip surface, so runs in which it slides alone may be graded as stable",
        "{probes} beside it; the surface comes out at x = {low:.4g} m and {high:.4g} m",
        "a probe between them, which metrics.probe of the study names",
    ),
    "stability-unknown": note(
        lambda of: UNKNOWN[of["subject"]][0],
        lambda of: UNKNOWN[of["subject"]][1],
        lambda of: "to have ground behind the crest, {heights:g} times the slope's height at least" if "heights" in of else "",
        meaning="the stability of the slope could not be found, with the reason",
    ),
    "record-offset": warning(
        lambda of: (
            "the record drifts, and the displacement depends on its mean acceleration"
            if "slip" in of
            else "the record drifts because of an offset of the recorder"
        ),
        lambda of: (
            "{slip:.3g} m, and {slip_without:.3g} m without the mean of {mean:m/s2}"
            if "slip" in of
            else "a mean of {mean:m/s2}, {value:.2g} m/s at its end"
        ),
        lambda of: "equal to within {difference:.0f %}" if "slip" in of else "at most {bound:.2g} m/s",
        meaning="the record has an offset: a mean acceleration of more than a hundredth of its peak, and it drifts",
    ),
    "record-drift": warning(
        "the record drifts",
        "{value:.2g} m/s at its end",
        "at most {bound:.2g} m/s",
        meaning="the ground still moves at the end of the record",
    ),
    "record-displacement": warning(
        "the peak displacement of the ground is implausible",
        "{value:.3g} m",
        "at most {bound:g} m, except beside a fault that broke the surface",
    ),
    "record-sparse": warning(
        "the samples of the record are so far apart that its times may be in another unit",
        "a sample every {value:g} s",
        "at most {bound:g} s; look at its time column",
        meaning="the samples of the record are more than 0.1 s apart: times in another unit, or only every n-th sample",
    ),
    "record-lasting": note(
        "the ground is left displaced at the end of the record", "{value:.2g} m, with a peak displacement of {peak:.2g} m", "near 0"
    ),
    "record-polarity": Message(
        lambda of: NOTE if "yield_ratio" in of else WARNING,  # of a block chosen here, or of the one that was asked for
        "the reversed record drives a sliding block further",
        lambda of: (
            "{reversed:.3g} m instead of {as_recorded:.3g} m"
            + (" for a block with a yield acceleration of {yield_ratio:g} PGA" if "yield_ratio" in of else "")
            + (" for a block with the yield acceleration of the slope, {strength:m/s2}" if "strength" in of else "")
        ),
        lambda of: (
            'to be run in both directions, motion.factor: ["1", "-1"] in the grid'
            if "strength" in of
            else "the larger of the two directions"
        ),
        meaning="with its polarity reversed the record drives a sliding block further",
    ),
    "pga-implausible": warning(
        "the {subject} peak acceleration of the ground is implausible",
        "{value:m/s2}",
        lambda of: f"{of['least'] / GRAVITY:g} to {of['most'] / GRAVITY:g} g; look at the unit of a record",
        meaning="the peak acceleration of the ground is implausible: often a mistaken unit",
    ),
    "motion-cut-off": warning("the run ends before the motion does", "{value:g} s", "more than {bound:.4g} s"),
    "block-not-rigid": note(
        lambda of: (
            "the slope is not rigid under this motion, so a rigid sliding block "
            f"{'underestimates' if of['value'] <= 1.0 else 'does not represent'} its displacement"
        ),
        "a natural period of {period:.2g} s, {value:.2g} times the mean period of the motion",
        "at most {bound:g} for a rigid block (Jibson 2011)",
        meaning="the slope is too soft to move like the rigid sliding block that its runs are compared with",
    ),
    "damping-off-frequency": warning(
        "the first mode of the ground, {frequency:.3g} Hz below the crest edge, is damped more than the ratio that is given",
        "{value:.3g %} instead of {given:.3g %}",
        "at most {bound:.3g %}",
        meaning="the first mode of the ground is damped more than twice as much as the ratio that is given",
    ),
    "soft-bedrock": warning(
        "the bedrock below an absorbing base is softer than the lowest soil",
        "an impedance of {value:.3g} kg/m2/s",
        "at least that of the lowest soil, {bound:.3g} kg/m2/s",
    ),
    "vertical-unused": note(
        "the vertical component of the motion",
        "motion.vertical does not act on the sliding block, which the horizontal component alone drives",
        meaning="the vertical component does not act on the sliding block",
    ),
    "level-ground-fails": note(
        "level ground behind the crest, taken as a rigid column, fails in shear as well",
        "{value:m/s2}, where {bound:m/s2} is enough at a depth of {depth:.3g} m",
        "less, unless the ground is meant to fail as a whole",
    ),
    "liquefaction": Message(
        _where_below,
        lambda of: "{subject} liquefies in the earthquake" if of["value"] < of["bound"] else "{subject} does not liquefy in the earthquake",
        _simplified,
        "at least {bound:g}",
        meaning="least factor of safety of sand against liquefaction (Boulanger and Idriss 2014), with --magnitude",
    ),
    "cyclic-softening": Message(
        _where_below,
        lambda of: "{subject}, clay, softens in the earthquake" if of["value"] < of["bound"] else "{subject}, clay, keeps its strength",
        _simplified,
        "at least {bound:g}; or give its strength after the cycles",
        meaning="least factor of safety of clay against cyclic softening (Boulanger and Idriss 2007), with --magnitude",
    ),
    "short-waves": warning(
        "shear waves of {frequency:.3g} Hz are too short for the particles in {subject}",
        "{value:.2g} smoothing lengths per wave ({wavelength:.3g} m), carried {slower:.0%} too slowly",
        "at least {bound:g} (Kuhlemeyer and Lysmer 1973)",
        meaning="the particles do not resolve the highest frequencies of the motion",
    ),
    "sparse-series": warning(
        "the stored series have too few samples of the shaking",
        "{value:.2g} samples per period at {frequency:.3g} Hz",
        "at least {bound:g}",
    ),
    "few-particles": warning("few particles across the slope's height", "{value:.1f} particles in {height:g} m", "at least {bound:g}"),
    "rows-misfit": warning(
        lambda of: "the rows of particles make the slope too " + ("high" if of["value"] > of["bound"] else "low"),
        lambda of: f"{{value:.4g}} m for {{bound:.4g}} m ({of['value'] / of['bound'] - 1.0:+.1%})",
        "equal, as with a spacing of {spacing:.4g} m, which divides the height",
        meaning="the rows of particles make the slope higher or lower than it is",
    ),
    "layer-broken": error(
        lambda of: "the particles do not resolve {subject} as a continuous layer" if of["particles"] else "no particle lies in {subject}",
        lambda of: (
            "particles in {columns:g} of the {crossed:g} columns that it crosses, {thickness:.3g} m thick at a spacing of {spacing:.3g} m"
            if of["crossed"]
            else "it lies outside the ground, or under later layers"
        ),
        "in every column, which needs a thickness of at least {spacing:.3g} m; or describe it as a seam",
        meaning="a layer that is continuous in the scene becomes separate particles, or none at all",
    ),
    "thin-layer": warning(
        "{subject} is thin",
        lambda of: f"{{value:g}} {'particle' if of['value'] == 1 else 'particles'} across",
        "at least {bound:g}",
        meaning="few particles across a layer",
    ),
    "weak-on-strong": warning(
        lambda of: (
            "{subject}, weak soil that slides on stronger {ground}, is braked, so it fails too late and its run-out is too short"
            if "ground" in of
            else "weak soil that has failed is braked by the stronger soil beside it, so its run-out is too short"
        ),
        lambda of: _cover(of) if "ground" in of else "numerics.interfaces: both, with {rows:g} particles across the thinnest soil",
        _unbraked,
        meaning="weak soil that has failed is braked by stronger soil, so that its run-out is a lower bound",
    ),
    "cover-late": warning(
        "{subject}, weak soil on stronger {ground}, fails too late, so a run in which it stands does not show that it stands",
        lambda of: (
            "{rows:.2g} rows of particles in {thickness:.3g} m, with which the factor of safety is up to "
            f"{of['value'] - 1.0:.0%} too high; once it fails, {_ran(of)}"
        ),
        _in_time,
        meaning="weak soil on stronger ground has rows of particles enough for its run-out, but fails only in too strong a shaking",
    ),
    "layer-held": error(
        "{subject}, weak soil between stronger ones, is held, since the kernel reaches across it",
        "{value:.2g} rows of particles in {thickness:.3g} m",
        lambda of: f"at least {{bound:g}}, with a spacing of at most {of['thickness'] / of['bound']:.3g} m; or describe it as a seam",
        meaning="a weak layer between two stronger soils has fewer than two rows of particles, and cannot slide",
    ),
    "cover-rows": note(
        "{subject}, weak soil on stronger {ground}, has rows enough",
        lambda of: (
            "{rows:.2g} rows of particles in {thickness:.3g} m, with which the factor of safety is up to "
            f"{of['factor'] - 1.0:.0%} too high and {_ran(of)}"
        ),
        meaning="weak soil on stronger ground has enough rows of particles for its run-out and for what sets it off",
    ),
    "cover-on-seam": warning(
        "{subject}, weak soil on stronger {ground}, slides on a seam: a run shows that it stands, not that it fails or how far it goes",
        f"a factor of safety up to {EARLY_ON_SEAM:.0%} too low; run-outs from {SHORT_ON_SEAM:.0%} too short to {FAR_ON_SEAM:.0%} too long, "
        "with ground below the seam",
        "without the seam and with three rows or more, where the run-out is asked",
        meaning="weak soil on stronger ground slides on a seam along its base, where runs show whether it stands, but not how far it goes",
    ),
    "thin-box": warning(
        "the boundary particles do not fill the kernel's support, so stresses beside them alternate from row to row",
        "{value:g} layers",
        "{bound:g}",
    ),
    "lattice-rearranges": note(
        "particles of wet ground that fails may move against their neighbours, so that more of it counts as failed or as moving",
        "a smoothing length of {value:.3g} spacings, where {bound:g} of the cubic spline hold them",
        meaning="wet ground that loses strength by slip has a smoothing length with which its particles rearrange under pressure",
    ),
    "short-correlation": warning(
        "{subject} varies over lengths that the particles do not resolve",
        "correlation length {value:g} m",
        "at least {bound:.3g} m, the kernel's reach",
        meaning="strength varies over lengths that the particles do not resolve",
    ),
    "no-process-zone": Message(
        lambda of: NOTE if of["paper"] else WARNING,
        "soil fails as soon as its stress reaches its strength, so the shaking at which the slope fails depends on the spacing",
        "no softening width",
        "a width, with the slips from a shear test",
    ),
    "density-implausible": warning(
        _property,
        "{key} {value:g} kg/m3",
        "{least:,g} to {most:,g} kg/m3",
        meaning="a density of soil outside 1,000 to 3,000 kg/m3: often a mistaken unit",
    ),
    "stiffness-implausible": warning(
        "the stiffness of {subject} is implausible",
        "{key} {youngs_modulus:kPa}, V_s = {value:.3g} m/s",
        "V_s = {least:,g} to {most:,g} m/s",
        meaning="a shear-wave velocity outside 30 to 3,500 m/s: often Young's modulus in another unit than kPa",
    ),
    "cohesion-implausible": warning(
        _property,
        "{key} {value:kPa}",
        lambda of: (
            "at least {bound:kPa}, or 0; 20 kPa are 0.02 MPa" if of["value"] < of["bound"] else "at most 1,000 kPa; 20 kPa are 20000 Pa"
        ),
        meaning="a cohesion above 1 MPa, or above 0 and below 0.1 kPa: often in Pa or MPa instead of kPa",
    ),
    "angle-implausible": warning(
        lambda of: "the friction of the walls ({subject}) is implausible" if _is_tangent(of) else _property(of),
        lambda of: "{key} {value:g}" if _is_tangent(of) else "{key} {value:degree}",
        _angle,
        meaning="an angle of friction or dilation above 0 and below 1.2 degrees, or of a slope below 1.6: often in radians, or a tangent; "
        "or a coefficient of wall friction above 1.2: often an angle",
    ),
    "strength-implausible": warning(
        "the peak strength of {subject} is implausibly low",
        "{key} {cohesion:kPa} and friction_angle {friction_angle:degree}",
        "at least {least_cohesion:kPa} or at least {least_angle:degree}",
        meaning="a friction angle below 5 degrees together with a cohesion below 5 kPa",
    ),
    "soil-not-replaced": warning(
        "the soil is still the placeholder of sph new",
        lambda of: "its values" if of["values"] else "its title",
        "your soil and a title of your own",
    ),
    "rigid-box": warning(
        "a rigid box reflects waves, so the slope is shaken harder than on a site where they radiate away",
        lambda of: f"base {wall_words(of['base'])}, sides {wall_words(of['sides'])}",
        "absorbing, where waves radiate away",
    ),
    "no-dilation": note(
        "frictional soil does not dilate",
        "0 degrees",
        "the angle from a shear test: 0 in loose soil, a fraction of the friction angle in dense soil",
    ),
    "own-strength-ratio": warning(
        lambda of: (
            "the study varies {subject}, which does not reach all layers"
            if of["layers"]
            else "the study varies {subject}, which affects no soil: runs that differ only in it are identical"
        ),
        lambda of: (
            f"{{layers}} {'keep their' if ',' in of['layers'] else 'keeps its'} own" if of["layers"] else "residual strengths are given"
        ),
        lambda of: (
            "varied too (a dimension {key}), or left out of the layer"
            if of["layers"]
            else "a dimension soil.residual_friction_angle, or no residual strengths"
        ),
        meaning="the study varies an S_R or γ that does not reach layers with one of their own, or an S_R that affects no soil",
    ),
    "residual-taken-over": warning(
        "{subject}, stronger than the main soil at its peak, falls to the same residual strength when it fails",
        "c = {cohesion:kPa}, phi = {friction_angle:degree}",
        "its own: a layer takes over what it does not name",
        meaning="a layer stronger than the main soil has the same residual strength, as one that names none of its own",
    ),
    "short-process-zone": warning(
        "the width over which slip is averaged is narrow, so failure depends on the spacing",
        "{value:.2g} spacings ({width:g} m)",
        "at least {bound:g}",
    ),
    "lost-by-time": Message(
        _where_bounded,
        lambda of: (
            "strength falls with time as well as with slip"
            if "bound" in of
            else "strength falls with time after failure, however little the soil moves; real soil loses it with slip"
        ),
        lambda of: f"gamma = {{value:g}} 1/s, {3.0 / of['value']:.2g} s to lose 95 %",
        lambda of: "{bound:g}" if "bound" in of else "a loss with slip, with the slip at the residual strength from a shear test",
        meaning="strength falls with time after failure, however little the soil moves; a warning beside a loss by slip",
    ),
    "progressive-failure": warning(
        "slip in {subject} develops over a short zone, so the shaking at which the slope fails may depend on the spacing",
        "{value:.3g} m",
        "at least {heights:g} slope heights, {bound:.3g} m; otherwise compare two spacings",
        meaning="slip develops over less than three slope heights, so the shaking at failure may depend on the spacing",
    ),
    "back-wall": warning("the side of the model behind the crest is near", "{value:.3g} m", "at least H = {bound:.3g} m"),
    "little-room": warning(
        "little room for the run-out between the toe and the side of the model",
        "{value:.4g} m",
        "at least {bound:.4g} m, {heights:.2g} H, for the residual strength of the soil",
    ),
    "debris-at-wall": warning(
        _reached,
        "at {time:.3g} s",
        "to stay inside a longer box",
        meaning="after the run: failed soil has reached an end of the box, so the box decides how far it goes",
    ),
    "thin-debris": warning(
        lambda of: (
            "debris that ran {runout:.3g} m is thin, so its run-out is "
            + (f"known to some {SCATTER:.0%} at best, as that of a cover with three rows or more" if "cover" in of else "not reliable")
        ),
        "on average {value:.2g} particles thick in front of the toe",
        lambda of: f"at least {{bound:g}}, better {2.0 * of['bound']:g}",
        meaning="after the run: debris that ran far lies in few rows of particles, so its run-out is not reliable",
    ),
    "energy-open": warning(
        "the energy budget of the run does not close, so its results are not reliable",
        "an error of {value:.2g %} of the sum of its parts",
        "at most {bound:g %}, as with a smaller step or spacing",
    ),
    "liquefied": note(
        "{subject} has liquefied",
        "{share:.0f %} of its sand below water, half of that by {middle:.3g} s, the first at {first:.3g} s",
        meaning="share of the sand of a layer that has liquefied in a run, with water.excess_pressure.liquefaction",
    ),
    "other-slope": warning(
        "the ground falls further to the {other} than to the {downhill}",
        "{bound:.3g} m and {value:.3g} m",
        "the other way round, unless the smaller slope is the one that may fail",
        meaning="the ground falls further to the other side",
    ),
    "slope-to-side": warning(
        "the slope goes on to the side of the model, whose end is taken for its {subject}",
        "({x:.10g}, {y:.10g}) m, H = {height:.4g} m",
        _other_face,
        meaning="the slope goes on to a side of the model, whose end is taken for its crest or its toe",
    ),
    "time-step": warning(
        "the time step is near or above its limit", "{value:.3g} s", "at most {bound:.2g} s, {share:g} of the limit ({limit})"
    ),
}
"""All that can be found, by code; codes stay."""


def words(of: Finding) -> Words:
    """A finding in words."""
    known = {**of.numbers, "subject": of.subject, "key": of.keys[0] if of.keys else ""}
    message = MESSAGES[of.code]
    texts = (text if isinstance(text, str) else text(known) for text in (message.what, message.measured, message.wanted))
    what, measured, wanted = (_Units().vformat(text, (), known) for text in texts)
    return Words(what, measured, wanted, OR.join(of.keys))


def meaning(code: str) -> str:
    """What a code means, for the reference."""
    message = MESSAGES[code]
    return message.meaning or str(message.what)


def sentence(of: Finding, keys: bool = True) -> str:
    """A finding in one sentence, with the ``keys`` to change."""
    what, measured, wanted, key = words(of)
    should = wanted.removeprefix("to ") if wanted.startswith("to ") else f"be {wanted}"
    return f"{what}: {measured}" + (f", should {should}" if wanted else "") + (f"; change {key}" if key and keys else "")


def surer(of: Finding) -> str:
    """What would make an answer surer that this limits, in words; empty where it is not known."""
    return SURER.get(of.code, "").format(subject=of.subject)


def line(of: Finding) -> str:
    """The sentence with severity and code."""
    return f"{of.severity}: {sentence(of)} [{of.code}]"


def record(of: Finding) -> dict[str, Any]:
    """A finding for machines, as in ``sph check --json``: words, and the numbers of which they are made."""
    said = words(of)._asdict()
    return {"code": of.code, "severity": str(of.severity), **said, "subject": of.subject, "off_by": of.off_by, "numbers": dict(of.numbers)}
