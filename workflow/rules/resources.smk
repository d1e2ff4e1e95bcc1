# Purpose: functions of wildcards that rules share: scenes of stages and runs, what they ask of a cluster, what a design varies.
# Inputs:  the plans of studies and experiments; the factors chosen by the screening and the points of a back-analysis.
# Outputs: functions for the input, resources and params of rules
from sph.experiments.base import Run
from sph.study.cost import Needs, needs

# Run of a name, by the folder of its experiment, whose file of rules puts it here.
RUN_OF = {}


def asked(scene, stage=lambda wildcards: "end"):
    """The resources that a job asks for, by the scene of its wildcards and what is done with it."""
    return {
        name: lambda wildcards, attempt, name=name: getattr(
            needs(scene(wildcards), stage(wildcards), attempt), name
        )
        for name in Needs._fields
    }


def stage_scene(wildcards):
    """The scene of a gravity stage, a pre-failure run, a search or a run, of the plan of its folder."""
    plan, named = PLANS(wildcards.folder), dict(wildcards.items())
    if "run" in named:
        return plan.run_scene(named["run"])
    return plan.stage(
        next(
            named[kind] for kind in ("pre_failure", "gravity", "limit") if kind in named
        )
    )


def experiment_run(wildcards):
    """A run of an experiment."""
    return RUN_OF[wildcards.experiment](wildcards.run)


def asking_run(wildcards):
    """The run by which a job asks for resources: in the sensitivity analysis, where scenes are known late, that of the study's scene."""
    if wildcards.experiment == SENSITIVITY:
        return Run(PLAN.scene())
    return experiment_run(wildcards)


def known_by(design):
    """The file that must be there before the scenes of a design are known: of the factors that matter, or of the points of a back-analysis."""
    if design in ALL_FACTORS:
        return []
    return BACK_POINTS if design == BACK else FACTORS


def varied(design):
    """What a design varies beside those that vary all: the factors that matter, or the points of a back-analysis, once they are known.

    No function of ``input``: Snakemake runs nothing again for a parameter that is made from it.
    """
    if design in ALL_FACTORS:
        return []
    if design == BACK:
        known = checkpoints.back_analysis_points.get().output.points
        return chosen_points(known, DESIGNS().axes)
    return chosen_factors(checkpoints.sensitivity_factors.get().output[0])
