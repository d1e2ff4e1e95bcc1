# Purpose: simulate every run of the catalogue (sph/jobs/catalogue.py): runs, the stages that they share, searches.
# Inputs:  the scene, with the files of its ground line and motion, and the solver's sources, by their contents.
# Outputs: stages/*.nc and runs/**/*.nc in the folder of a study, of a case of its trigger, or of an experiment
from sph.study.runs import SIMULATION


def asked_of(row):
    """What the job of a row is given."""
    settings = ("until", "by", "extrapolates", "enforce_limit")
    return {"scene": planned(row.scene)} | {
        name: getattr(row, name) for name in settings
    }


for place, name, first in (("stages", "stage", 10), ("runs", "simulate", 0)):
    # The row of a job in the catalogue.
    row_of = lambda wildcards, place=place: CATALOGUE.row(
        f"{wildcards.folder}/{place}/{wildcards.run}.nc"
    )

    rule:
        """Simulate a run or a stage, from the stage that it goes on from; or search a limit of a scene by many runs."""
        name:
            name
        input:
            restart=lambda wildcards, of=row_of: of(wildcards).parent or [],
        output:
            f"{{folder}}/{place}/{{run}}.nc",
        log:
            "{folder}/logs/{run}.log",
        benchmark:
            "{folder}/benchmarks/{run}.tsv"
        priority: first
        resources:
            **asked(
                lambda wildcards, of=row_of: of(wildcards).built,
                lambda wildcards, of=row_of: of(wildcards).needs,
            ),
        params:
            **told(lambda wildcards, of=row_of: asked_of(of(wildcards))),
            sources=lambda wildcards, of=row_of: (
                SOLVER if of(wildcards).by == SIMULATION else SEARCHING
            ),
        script:
            "../scripts/simulate.py"
