"""What a finding of a scene is, and all that can be found (``CODES``)."""

from __future__ import annotations

from collections.abc import Iterable
from enum import StrEnum
from typing import NamedTuple

from sph.scene.strict_json import to_json


class Severity(StrEnum):
    """How much a finding matters."""

    ERROR = "error"
    """the result will not be the one you want"""
    WARNING = "warning"
    """the result may be unreliable"""
    NOTE = "note"
    """for information; nothing needs to be changed"""


class Code(NamedTuple):
    """A kind of finding."""

    severity: Severity
    text: str


ERROR, WARNING, NOTE = Severity
CODES: dict[str, Code] = {
    "fails-unshaken": Code(ERROR, "the slope fails at its peak strength without shaking"),
    "softens-unshaken": Code(ERROR, "soil is at its strength under gravity alone, and softens before the shaking"),
    "fails-softened": Code(ERROR, "the slope stands at its peak strength without shaking, and fails as its soil softens"),
    "stands-unshaken": Code(NOTE, "the slope stands at its peak strength without shaking"),
    "fails-at-residual": Code(NOTE, "without shaking the slope fails at its residual strength: soil that fails keeps moving downslope"),
    "stands-at-residual": Code(NOTE, "without shaking the slope stands at its residual strength: soil that fails comes to rest"),
    "mobilised-strength": Code(
        NOTE,
        "share of its peak strength that a layer mobilises under gravity alone, near the slope or in level ground; a warning from 95 % on",
    ),
    "factor-of-safety": Code(NOTE, "static factor of safety"),
    "yield-acceleration": Code(NOTE, "pseudo-static yield acceleration"),
    "limit-equilibrium": Code(NOTE, "factor of safety and yield acceleration by limit equilibrium: Bishop's and Spencer's methods"),
    "limit-equilibrium-residual": Code(NOTE, "factor of safety by limit equilibrium at the strength that failed soil keeps"),
    "limit-equilibrium-differs": Code(
        NOTE, "the factor of safety by SPH differs by more than 5 % from Spencer's, with the possible reasons"
    ),
    "slip-at-base": Code(WARNING, "a slip surface reaches an absorbing base with the same soil below it"),
    "stability-unknown": Code(NOTE, "the stability of the slope could not be found, with the reason"),
    "record-offset": Code(WARNING, "the record has an offset: a mean acceleration of more than a hundredth of its peak, and it drifts"),
    "record-drift": Code(WARNING, "the ground still moves at the end of the record"),
    "record-displacement": Code(WARNING, "the ground moves implausibly far"),
    "record-sparse": Code(WARNING, "the samples of the record are more than 0.1 s apart: times in another unit, or only every n-th sample"),
    "record-lasting": Code(NOTE, "the ground is left displaced at the end of the record"),
    "record-polarity": Code(NOTE, "with its polarity reversed the record drives a sliding block further"),
    "pga-implausible": Code(WARNING, "the peak acceleration of the ground is implausible: often a mistaken unit"),
    "motion-cut-off": Code(WARNING, "the run ends before the motion does"),
    "block-not-rigid": Code(NOTE, "the slope is too soft to move like the rigid sliding block that its runs are compared with"),
    "damping-off-frequency": Code(WARNING, "the first mode of the ground is damped more than twice as much as the ratio that is given"),
    "vertical-unused": Code(NOTE, "the vertical component does not act on the sliding block"),
    "level-ground-fails": Code(NOTE, "the shaking is so strong that level ground fails in shear as well, up to the sides of the box"),
    "short-waves": Code(WARNING, "the particles do not resolve the highest frequencies of the motion"),
    "sparse-series": Code(WARNING, "the stored series have too few samples of the shaking"),
    "few-particles": Code(WARNING, "few particles across the slope's height"),
    "rows-misfit": Code(WARNING, "the rows of particles make the slope higher or lower than it is"),
    "layer-broken": Code(ERROR, "a layer that is continuous in the scene becomes separate particles, or none at all"),
    "thin-layer": Code(WARNING, "few particles across a layer"),
    "weak-on-strong": Code(WARNING, "weak soil that has failed is braked by stronger soil, so that its run-out is a lower bound"),
    "layer-held": Code(ERROR, "a weak layer between two stronger soils has fewer than two rows of particles, and cannot slide"),
    "cover-rows": Code(NOTE, "weak soil on stronger ground has enough rows of particles for its run-out"),
    "thin-box": Code(WARNING, "the boundary particles do not fill the kernel's support"),
    "short-correlation": Code(WARNING, "strength varies over lengths that the particles do not resolve"),
    "no-process-zone": Code(WARNING, "failure has no length scale, so results depend on the spacing; a note in the paper's scheme"),
    "density-implausible": Code(WARNING, "a density of soil outside 1,000 to 3,000 kg/m3: often a mistaken unit"),
    "stiffness-implausible": Code(WARNING, "a shear-wave velocity outside 30 to 3,500 m/s: often Young's modulus in another unit than kPa"),
    "cohesion-implausible": Code(WARNING, "a cohesion above 1 MPa, or above 0 and below 0.1 kPa: often in Pa or MPa instead of kPa"),
    "angle-implausible": Code(
        WARNING,
        "an angle of friction or dilation above 0 and below 1.2 degrees, or of a slope below 1.6: often in radians, or a tangent; "
        "or a coefficient of wall friction above 1.2: often an angle",
    ),
    "strength-implausible": Code(WARNING, "a friction angle below 5 degrees together with a cohesion below 5 kPa"),
    "soil-not-replaced": Code(WARNING, "the soil is still the placeholder of `sph new`"),
    "rigid-box": Code(WARNING, "a rigid box reflects waves: the slope is shaken harder than on a site where they radiate away"),
    "no-dilation": Code(NOTE, "frictional soil does not dilate: its dilation angle is 0"),
    "own-strength-ratio": Code(
        WARNING, "the study varies an S_R or γ that does not reach layers with one of their own, or an S_R that affects no soil"
    ),
    "short-process-zone": Code(WARNING, "the width over which slip is averaged is narrower than three spacings"),
    "lost-by-time": Code(NOTE, "strength falls with time after failure, however little the soil moves; a warning beside a loss by slip"),
    "progressive-failure": Code(
        WARNING, "slip develops over less than three slope heights, so the shaking at failure may depend on the spacing"
    ),
    "back-wall": Code(WARNING, "the side of the model behind the crest is near"),
    "little-room": Code(WARNING, "little room for the debris between the toe and the side of the model"),
    "debris-at-wall": Code(WARNING, "after the run: failed soil has reached an end of the box, so the box decides how far it goes"),
    "thin-debris": Code(WARNING, "after the run: debris that ran far lies in few rows of particles, so its run-out is not reliable"),
    "energy-open": Code(WARNING, "after the run: its energy budget does not close within the limit, so its results are not reliable"),
    "other-slope": Code(WARNING, "the ground falls further to the other side"),
    "slope-to-side": Code(WARNING, "the slope goes on to a side of the model, whose end is taken for its crest or its toe"),
    "time-step": Code(WARNING, "the time step is near or above its limit"),
}
"""All that can be found, by its code, which stays."""


class Finding(NamedTuple):
    """Something that the user of a scene should know before using its results; the names are those of ``sph check --json``."""

    code: str  # of ``CODES``
    severity: str  # of ``Severity``
    what: str
    measured: str
    wanted: str = ""  # what ``measured`` should be; one that begins with "to", what it should do
    key: str = ""  # to change
    subject: str = ""  # the layer, variable or component that it is of, where a scene may have several
    off_by: float = 1.0  # see ``off_by``; 1 also where it is not a matter of degree

    def sentence(self) -> str:
        """The finding in one sentence."""
        should = self.wanted.removeprefix("to ") if self.wanted.startswith("to ") else f"be {self.wanted}"
        wanted = f", should {should}" if self.wanted else ""
        return f"{self.what}: {self.measured}{wanted}" + (f"; change {self.key}" if self.key else "")

    def line(self) -> str:
        """The sentence with severity and code."""
        return f"{self.severity}: {self.sentence()} [{self.code}]"

    @property
    def counts(self) -> bool:
        """Whether it is more than a note."""
        return self.severity != NOTE

    @property
    def rank(self) -> tuple[int, float, int]:
        """By which findings are sorted, the most harmful first: severity, distance from what is wanted, place in ``CODES``."""
        return list(Severity).index(Severity(self.severity)), -self.off_by, list(CODES).index(self.code)


def finding(
    code: str,
    what: str,
    measured: str,
    wanted: str = "",
    key: str = "",
    severity: Severity | None = None,
    subject: str = "",
    off_by: float = 1.0,
) -> Finding:
    """A finding, by default of the severity of its code; KeyError for an unknown code."""
    return Finding(code, str(severity or CODES[code].severity), what, measured, wanted, key, subject, off_by)


def off_by(measured: float, wanted: float) -> float:
    """Distance of a measured value from the wanted one over the larger of the two, both 0 or more: 0 where it is as wanted, 1 at most."""
    return abs(measured - wanted) / max(measured, wanted) if measured != wanted else 0.0


def codes(found: Iterable[Finding]) -> str:
    """Codes of findings for the attribute ``findings`` of a trajectory: a JSON list, each once, in the order of ``CODES``."""
    there = {each.code for each in found}
    return to_json([code for code in CODES if code in there])
