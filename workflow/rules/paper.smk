# Purpose: the claims of the paper, decided by a study over exactly its dimensions and by the search for critical amplitudes.
# Inputs:  study.nc; trigger/trigger.csv.
# Outputs: claims.csv; trigger/claim.csv
from sph.experiments.paper import measure as paper
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


rule claims:
    """Decide the claims of the paper."""
    input:
        study=of_the_paper("{folder}/study.nc"),
    output:
        shown("{folder}/claims.csv", "Tables", "the claims"),
    log:
        "{folder}/logs/claims.log",
    params:
        **made_by(
            paper.claims,
            lambda wildcards: {"settings": PLAN.study.claims},
            uses="trigger",
        ),
    script:
        "../scripts/make.py"


rule trigger_claim:
    """Decide the claim on the trigger."""
    input:
        critical=of_the_paper("{folder}/trigger/trigger.csv"),
    output:
        shown("{folder}/trigger/claim.csv", "Tables", "the claim on the trigger"),
    log:
        "{folder}/logs/trigger_claim.log",
    params:
        **made_by(paper.trigger_claim, uses="trigger"),
    script:
        "../scripts/make.py"
