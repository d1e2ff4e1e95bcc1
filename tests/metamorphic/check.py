"""Try relations between answers on many small scenes: ``python tests/metamorphic/check.py --scenes 500 --seed 0``.

Each scene is tried with those relations of ``ALWAYS`` that fit it and with ``EACH`` of the others.  What does not hold is printed with the
number of its scene, and the exit code is 1; ``--only NAME --seed NUMBER --scenes 1`` repeats it, with the scenes.
"""

from __future__ import annotations

import argparse
import os
import sys
import tempfile
import traceback
from collections import Counter
from concurrent.futures import ProcessPoolExecutor
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import yaml
from answers import Case
from relations import RELATIONS

ALWAYS = ("weaker_soil_never_moves_less", "stronger_shaking_never_fails_later")
"""Relations that every scene is tried with, since chance enters them."""
EACH = 4
"""How many of the others a scene is tried with."""


KNOWN = {
    ("weaker_soil_never_moves_less", 246): "debris almost without strength (S_R 0.002) of a slope four particles high: 1.12 to 1.21 m for "
    "c = 6.4 kPa, 1.27 to 1.49 m for 25.7 kPa; not explained",
}
"""Scenes on which a relation is known not to hold, and what was found."""


class Finding(NamedTuple):
    """What became of a relation on a scene."""

    number: int
    relation: str
    failure: str
    """why it does not hold, or empty"""


def try_scene(number: int, only: str | None = None) -> list[Finding]:
    """Try a scene with some of the relations that fit it, or with one."""
    findings = []
    with tempfile.TemporaryDirectory() as folder:
        case = Case(number, Path(folder))
        fitting = [name for name, relation in RELATIONS.items() if relation.fits(case)]
        others = np.random.default_rng([number, 1]).permutation([name for name in fitting if name not in ALWAYS])[:EACH]
        for relation in (RELATIONS[name] for name in fitting if (name == only if only else name in (*ALWAYS, *others))):
            case.others.clear()
            failure = ""
            try:
                relation.check(case)
            except AssertionError as error:
                failure = str(error) or traceback.format_exc(limit=-2)
            except Exception:
                failure = traceback.format_exc(limit=-4)
            if failure and only:
                failure += f"\nthe scene:\n{written(case.data)}the others:\n{written(case.others)}"
            findings.append(Finding(number, relation.name, failure))
    return findings


def written(data: Any) -> str:
    """Data as YAML, in its own order."""
    return yaml.safe_dump(data, sort_keys=False, default_flow_style=None, width=160)


def try_scenes(scenes: int, seed: int, only: str | None = None) -> list[Finding]:
    """Try that many scenes, from a number on, on all cores."""
    with ProcessPoolExecutor(os.cpu_count()) as pool:
        found = pool.map(partial(try_scene, only=only), range(seed, seed + scenes), chunksize=4)
        return [finding for findings in found for finding in findings]


def unexpected(findings: list[Finding]) -> list[Finding]:
    """The failures that are not known."""
    return [finding for finding in findings if finding.failure and (finding.relation, finding.number) not in KNOWN]


def report(findings: list[Finding]) -> str:
    """How often each relation was tried and did not hold, and the first failures of each."""
    tried = Counter(finding.relation for finding in findings)
    failed = unexpected(findings)
    counts = Counter(finding.relation for finding in failed)
    lines = [f"{tried[name]:6,} tried {counts[name]:5,} failed  {name}" for name in RELATIONS if tried[name]]
    lines.append(f"{len(findings):6,} tried {len(failed):5,} failed  in all")
    lines += [
        f"KNOWN {f.relation}, scene {f.number}: {KNOWN[key]}" for f in findings if f.failure and (key := (f.relation, f.number)) in KNOWN
    ]
    for name in counts:
        lines += [f"FAILURE {name}, scene {number}: {failure}" for number, relation, failure in failed if relation == name][:5]
    return "\n".join(lines)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--scenes", type=int, default=500)
    parser.add_argument("--seed", type=int, default=0, help="number of the first scene")
    parser.add_argument("--only", choices=RELATIONS, help="one relation, its failures with their scenes")
    arguments = parser.parse_args()
    findings = try_scenes(arguments.scenes, arguments.seed, arguments.only)
    print(report(findings))
    sys.exit(bool(unexpected(findings)))
