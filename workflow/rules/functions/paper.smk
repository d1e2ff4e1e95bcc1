# Purpose: which files the claims of the paper take.
# Inputs:  the study.
# Outputs: functions for the directives of ../paper.smk and ../trigger.smk
from sph.experiments.paper.design import PaperStudy, paper_study


def of_the_paper(file):
    """A file of the paper's study; a refusal for one of which no claims are asked."""

    def checked(wildcards):
        paper_study(PLAN.study, "the claims")
        return file.format(**wildcards)

    return checked


def claim_on_trigger(wildcards):
    """The claim on the trigger, where it is asked."""
    asked = isinstance(PLAN.study, PaperStudy)
    return [f"{PLAN.folder}/trigger/claim.csv"] if asked else []
