"""The claims of the paper, decided from a study and from the searches for critical intensities."""

from __future__ import annotations

import pandas as pd

from sph.experiments.paper.claims import ClaimSettings, decide_claims, decide_trigger
from sph.experiments.trigger.critical import read_critical
from sph.study.tables import read_study


def claims(study: str, settings: ClaimSettings) -> pd.DataFrame:
    """The claims of the paper, each with the test that decides it, the number measured and the verdict."""
    return decide_claims(read_study(study), settings)


def trigger_claim(critical: str) -> pd.DataFrame:
    """The paper's claim that the method yields the level of motion that triggers failure, decided for every case by the brackets of the
    critical amplitudes.
    """
    return decide_trigger(read_critical(critical))
