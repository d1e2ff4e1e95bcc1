"""What a finding is.  All that can be found, with severities and words, is in ``sph.checks.messages``."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass, field, replace
from typing import Any

from sph.checks.messages import MESSAGES, NOTE, Numbers, Severity
from sph.scene.strict_json import to_json


@dataclass(frozen=True)
class Finding:
    """Something that the user of a scene should know before using its results."""

    code: str  # of ``MESSAGES``
    keys: tuple[str, ...] = ()  # of which one is to change, with its value where that is known: ``walls.layers=3``
    subject: str = ""  # the layer, variable or component that it is of, where a scene may have several
    numbers: Numbers = field(default_factory=dict, hash=False)

    @property
    def severity(self) -> Severity:
        """By the numbers, where those of a code differ in it."""
        rule = MESSAGES[self.code].severity
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
        """By which findings are sorted, the most harmful first: severity, distance from what is wanted, place in ``MESSAGES``."""
        return list(Severity).index(self.severity), -self.off_by, list(MESSAGES).index(self.code)


def finding(code: str, *keys: str, subject: str = "", **numbers: Any) -> Finding:
    """A finding with its keys and numbers, those that are None left out; KeyError for an unknown code."""
    if code not in MESSAGES:
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
    """Codes of findings for the attribute ``findings`` of a trajectory: a JSON list, each once, in the order of ``MESSAGES``."""
    there = {each.code for each in findings}
    return to_json([code for code in MESSAGES if code in there])
