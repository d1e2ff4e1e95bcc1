# Purpose: the claims of the paper, decided by a study over exactly its dimensions and by the search for critical amplitudes.
# Inputs:  study.nc; trigger/trigger.csv.
# Outputs: claims.csv; trigger/claim.csv
from sph.experiments.paper import measure as paper


include: "functions/paper.smk"


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
