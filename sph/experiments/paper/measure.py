"""The claims of the paper, decided from a study and from the searches for critical intensities."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import pandas as pd
import xarray as xr

from sph.experiments.paper.claims import ClaimSettings, decide_claims, decide_trigger
from sph.experiments.paper.design import paper_study
from sph.experiments.paper.figures import FIGURES as FIGURES
from sph.experiments.steps import Step
from sph.experiments.trigger.critical import read_critical
from sph.study.schema import Study
from sph.study.tables import read_study


def claims(study: xr.Dataset, settings: Mapping[str, Any]) -> pd.DataFrame:
    """The claims of the paper, each with the test that decides it, the number measured and the verdict."""
    return decide_claims(study, ClaimSettings(**settings))


def trigger_claim(critical: pd.DataFrame) -> pd.DataFrame:
    """The paper's claim that the method yields the level of motion that triggers failure, decided for every case by the brackets of the
    critical amplitudes.
    """
    return decide_trigger(critical)


def _only_of_the_paper(study: Study) -> dict[str, Any]:
    """ValueError for a study of which no claims are asked."""
    paper_study(study, "the claims")
    return {}


READERS: dict[str, Callable[[str, Mapping[str, Any]], Any]] = {
    "study": lambda path, given: read_study(path),
    "critical": lambda path, given: read_critical(path),
}
STEPS = (
    Step(
        "claims",
        claims,
        {"study": "study.nc"},
        {"claims.csv": "the claims"},
        lambda study: {"settings": study.claims.model_dump()},
        _only_of_the_paper,
    ),
    Step(
        "trigger_claim",
        trigger_claim,
        {"critical": "trigger/trigger.csv"},
        {"trigger/claim.csv": "the claim on the trigger"},
        needs=_only_of_the_paper,
    ),
)
"""The jobs; a study that is not the paper's has none."""
