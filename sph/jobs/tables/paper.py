"""The claims of the paper, decided from a study and from the searches for critical intensities."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import pandas as pd
import xarray as xr

from sph.jobs.tables.making import Step
from sph.paper.claims import ClaimSettings, decide_claims, decide_trigger


def claims(study: xr.Dataset, settings: Mapping[str, Any]) -> pd.DataFrame:
    """The claims of the paper, each with the test that decides it, the number measured and the verdict."""
    return decide_claims(study, ClaimSettings(**settings))


def trigger_claim(critical: pd.DataFrame) -> pd.DataFrame:
    """The paper's claim that the method yields the level of motion that triggers failure, decided for every case by the brackets of the
    critical amplitudes.
    """
    return decide_trigger(critical)


STEPS = (
    Step(
        "claims",
        claims,
        {"study": "study.nc"},
        {"claims.csv": "the claims"},
        lambda study: {"settings": study.claims.model_dump()},
    ),
    Step("trigger_claim", trigger_claim, {"critical": "trigger/trigger.csv"}, {"trigger/claim.csv": "the claim on the trigger"}),
)
"""The jobs; a study that is not the paper's has none."""
