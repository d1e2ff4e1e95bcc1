"""What a finding is, and all that can be found (``SEVERITIES``).  Only ``sph.checks.messages`` makes words of one."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field, replace
from enum import StrEnum
from typing import Any

from sph.scene.strict_json import to_json


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


def _where_below(numbers: Numbers) -> Severity:
    return WARNING if numbers["value"] < numbers["bound"] else NOTE


def _where_bounded(numbers: Numbers) -> Severity:
    return WARNING if "bound" in numbers else NOTE


SEVERITIES: dict[str, Severity | Callable[[Numbers], Severity]] = {
    "fails-unshaken": ERROR,
    "softens-unshaken": ERROR,
    "fails-softened": ERROR,
    "stands-unshaken": NOTE,
    "fails-at-residual": NOTE,
    "stands-at-residual": NOTE,
    "mobilised-strength": _where_bounded,
    "factor-of-safety": lambda of: WARNING if of["value"] - of["error"] < 1.0 else NOTE,
    "yield-acceleration": NOTE,
    "limit-equilibrium": NOTE,
    "limit-equilibrium-residual": NOTE,
    "limit-equilibrium-differs": NOTE,
    "slip-at-base": WARNING,
    "stability-unknown": NOTE,
    "record-offset": WARNING,
    "record-drift": WARNING,
    "record-displacement": WARNING,
    "record-sparse": WARNING,
    "record-lasting": NOTE,
    "record-polarity": lambda of: NOTE if "yield_ratio" in of else WARNING,  # of a block chosen here, or of the one that was asked for
    "pga-implausible": WARNING,
    "motion-cut-off": WARNING,
    "block-not-rigid": NOTE,
    "damping-off-frequency": WARNING,
    "vertical-unused": NOTE,
    "level-ground-fails": NOTE,
    "liquefaction": _where_below,
    "cyclic-softening": _where_below,
    "short-waves": WARNING,
    "sparse-series": WARNING,
    "few-particles": WARNING,
    "rows-misfit": WARNING,
    "layer-broken": ERROR,
    "thin-layer": WARNING,
    "weak-on-strong": WARNING,
    "layer-held": ERROR,
    "cover-rows": NOTE,
    "thin-box": WARNING,
    "short-correlation": WARNING,
    "no-process-zone": lambda of: NOTE if of["paper"] else WARNING,
    "density-implausible": WARNING,
    "stiffness-implausible": WARNING,
    "cohesion-implausible": WARNING,
    "angle-implausible": WARNING,
    "strength-implausible": WARNING,
    "soil-not-replaced": WARNING,
    "rigid-box": WARNING,
    "no-dilation": NOTE,
    "own-strength-ratio": WARNING,
    "residual-taken-over": WARNING,
    "short-process-zone": WARNING,
    "lost-by-time": _where_bounded,
    "progressive-failure": WARNING,
    "back-wall": WARNING,
    "little-room": WARNING,
    "debris-at-wall": WARNING,
    "thin-debris": WARNING,
    "energy-open": WARNING,
    "liquefied": NOTE,
    "other-slope": WARNING,
    "slope-to-side": WARNING,
    "time-step": WARNING,
}
"""The severity of all that can be found, or the rule for it, by code; codes stay."""


@dataclass(frozen=True)
class Finding:
    """Something that the user of a scene should know before using its results."""

    code: str  # of ``SEVERITIES``
    keys: tuple[str, ...] = ()  # of which one is to change, with its value where that is known: ``walls.layers=3``
    subject: str = ""  # the layer, variable or component that it is of, where a scene may have several
    numbers: Numbers = field(default_factory=dict, hash=False)

    @property
    def severity(self) -> Severity:
        """By the numbers, where those of a code differ in it."""
        rule = SEVERITIES[self.code]
        return rule if isinstance(rule, Severity) else rule(self.numbers)

    @property
    def counts(self) -> bool:
        """Whether it is more than a note."""
        return self.severity != NOTE

    @property
    def off_by(self) -> float:
        """Distance of the value from its bound over the larger of the two; 1 where it is not a matter of degree."""
        value, bound = (self.numbers.get(name, math.nan) for name in ("value", "bound"))
        if math.isnan(value - bound):
            return 1.0
        return abs(value - bound) / max(value, bound) if value != bound else 0.0

    @property
    def rank(self) -> tuple[int, float, int]:
        """By which findings are sorted, the most harmful first: severity, distance from what is wanted, place in ``SEVERITIES``."""
        return list(Severity).index(self.severity), -self.off_by, list(SEVERITIES).index(self.code)


def finding(code: str, *keys: str, subject: str = "", **numbers: Any) -> Finding:
    """A finding with its keys and numbers, those that are None left out; KeyError for an unknown code."""
    if code not in SEVERITIES:
        raise KeyError(code)
    given = {name: value if isinstance(value, str) else float(value) for name, value in numbers.items() if value is not None}
    return Finding(code, keys, subject, given)


def called(findings: Iterable[Finding], name: str | None) -> list[Finding]:
    """Findings in which the scene's own soil, which is ``soil`` in keys, has its name (``soil.name``); as they are where it has none."""

    def own(value: Any) -> Any:
        return name if value == "soil" else value

    if not name:
        return list(findings)
    return [replace(each, subject=own(each.subject), numbers={key: own(value) for key, value in each.numbers.items()}) for each in findings]


def codes(findings: Iterable[Finding]) -> str:
    """Codes of findings for the attribute ``findings`` of a trajectory: a JSON list, each once, in the order of ``SEVERITIES``."""
    there = {each.code for each in findings}
    return to_json([code for code in SEVERITIES if code in there])
