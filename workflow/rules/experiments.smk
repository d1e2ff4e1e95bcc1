# Purpose: the experiments of the registry (sph/experiments): a rule for each of their steps and of their targets, such as what a saving of
#          time costs in accuracy (`snakemake --cores 2 cost-accuracy`) or the shaking at which a slope fails (`snakemake --cores 2 trigger`).
# Inputs:  config/<name>.yaml (config: experiments); runs of the catalogue; tables of earlier steps; the sources of analysis and drawing.
# Outputs: results/<name>, or a folder below that of the study: the files that the steps list (STEPS in sph/experiments)
from sph.experiments.registry import EXPERIMENTS
from sph.experiments.variants.design import EARLIER
from sph.experiments.steps import steps

TARGETS = {}  # the experiments that have one, by target


wildcard_constraints:
    **{
        name: values
        for each in EXPERIMENTS.values()
        for name, values in each.wildcards.items()
    },


def at(wildcards):
    """The wildcards of a step, without that of its folder."""
    return {name: value for name, value in wildcards.items() if name != "folder"}


def runs_of(experiment, step, wildcards):
    """The runs of a step, once it is known which they are."""
    design = CATALOGUE.design(experiment.name)
    if name := step.after(design, **at(wildcards)):
        getattr(checkpoints, name).get(**wildcards)
    return list(step.runs(design, **at(wildcards))) if step.runs else []


def input_of(experiment, step, place):
    """The input of a step: files of its experiment's folder, files from elsewhere, and runs."""
    return {name: f"{place}/{file}" for name, file in step.reads.items()} | {
        "runs": lambda wildcards: [
            run.file for run in runs_of(experiment, step, wildcards)
        ]
    }


def params_of(experiment, step):
    """The parameters of a step: which it is, its caption, the sources on which it depends, what it is given, and the scenes of its runs."""

    def of(wildcards):
        given = step.given(CATALOGUE.design(experiment.name), **at(wildcards))
        thresholds = (
            {"settings": PLAN.study.metrics.model_dump()} if step.measures else {}
        )
        scenes = [planned(run.scene) for run in runs_of(experiment, step, wildcards)]
        return thresholds | dict(given), scenes

    return {
        "sources": (DRAWING if step.draws else ANALYSIS)
        + sources(*experiment.sources, without="" if step.draws else FIGURES)
        + SEARCHING * step.searches,
        "step": (experiment.name, step.name),
        "about": step.about,
        **told(of),
    }


def needs_of(experiment, step):
    """What a step reads from elsewhere."""
    return unpack(
        lambda wildcards: step.needs(CATALOGUE.design(experiment.name), **at(wildcards))
    )


def made_by(target):
    """The files of a target."""
    folder = getattr(CATALOGUE.design(TARGETS[target][0].name), "folder", "")
    for each in TARGETS[target]:
        files = (
            each.targets[target](CATALOGUE.design(each.name))
            if each.targets
            else [file for step in steps(each).values() for file in step.writes]
        )
        place = each.folder.format(results=RESULTS, folder=folder)
        yield from (f"{place}/{name}" for file in files for name in written(file))


for experiment in EXPERIMENTS.values():
    place = experiment.folder.format(results=RESULTS, folder="{folder}")
    for target in experiment.targets or [experiment.name]:
        TARGETS.setdefault(target, []).append(experiment)

    for step in steps(experiment).values():
        if step.decides:

            checkpoint:
                """Make the tables from which it follows which runs there are."""
                name:
                    step.name
                input:
                    needs_of(experiment, step),
                    **input_of(experiment, step, place),
                output:
                    list(made(place, experiment.title, step.writes)),
                log:
                    f"{place}/{step.log}",
                params:
                    **params_of(experiment, step),
                script:
                    "../scripts/make.py"

        else:

            rule:
                """Make tables and figures of an experiment."""
                name:
                    step.name
                input:
                    needs_of(experiment, step),
                    **input_of(experiment, step, place),
                output:
                    list(made(place, experiment.title, step.writes)),
                log:
                    f"{place}/{step.log}",
                params:
                    **params_of(experiment, step),
                script:
                    "../scripts/make.py"


for target in TARGETS:

    rule:
        """Tables and figures of an experiment."""
        name:
            target
        input:
            lambda wildcards, target=target: list(made_by(target)),


for earlier, target in EARLIER.items():  # until the release after 0.3

    rule:
        """An earlier name of a target."""
        name:
            earlier
        input:
            lambda wildcards, target=target: list(made_by(target)),
        message:
            f"{earlier} is called {target} now: snakemake --cores 2 {target}"
