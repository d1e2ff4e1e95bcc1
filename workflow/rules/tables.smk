# Purpose: tables and figures of the searches for critical intensities, of the sensitivity analysis and of the paper's claims:
#          a rule for each of their steps (sph/jobs/tables) that has files of its own.
# Inputs:  tables in the folder of the experiment; the sources of analysis and drawing.
# Outputs: the files that the steps list
EXPERIMENT_STEPS = {
    "trigger": ("Trigger", TRIGGER, lambda: CATALOGUE.trigger),
    "sensitivity": ("Sensitivity", SENSITIVITY, lambda: CATALOGUE.sensitivity),
    "paper": ("Tables", "{folder}", lambda: OF_PAPER("the claims")),
}


for experiment, (title, place, design) in EXPERIMENT_STEPS.items():
    for step in (step for step in steps(experiment).values() if step.writes):

        rule:
            """Make tables and figures of an experiment."""
            name:
                step.name
            input:
                unpack(lambda wildcards, step=step, of=design: step.needs(of())),
                **{name: f"{place}/{file}" for name, file in step.reads.items()},
            output:
                list(made(place, title, step.writes)),
            log:
                f"{place}/logs/{step.name}.log",
            params:
                **of_step(experiment, step.name),
                given=lambda wildcards, step=step, of=design: step.given(of()),
            script:
                "../scripts/make.py"
