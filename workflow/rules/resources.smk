# Purpose: functions of wildcards that rules share: what simulations ask of a cluster by their scenes, and what a design varies.
# Inputs:  scenes, as the rules have them in their params; the factors chosen by the screening.
# Outputs: functions for the resources and params of rules
from sph.study.cost import Needs, needs


def asked(scene, stage=lambda wildcards: "end"):
    """The resources that a job asks for, by the scene of its wildcards and what is done with it."""
    return {
        name: lambda wildcards, attempt, name=name: getattr(
            needs(scene(wildcards), stage(wildcards), attempt), name
        )
        for name in Needs._fields
    }


def stage_scene(wildcards):
    """The scene of a gravity stage, a trunk or a run, of the plan of its folder."""
    plan, named = PLANS(wildcards.folder), dict(wildcards.items())
    if "run" in named:
        return plan.run_scene(named["run"])
    return plan.stage(named["trunk"] if "trunk" in named else named["gravity"])


def searched_scene(wildcards):
    """The scene whose yield acceleration is searched."""
    return PLANS(wildcards.folder).slope


def varied(wildcards):
    """Factors that a design varies beside those that vary all: the ones that matter, once they are known.

    No function of ``input``: Snakemake runs nothing again for a parameter that is made from it.
    """
    if wildcards.design in ALL_FACTORS:
        return []
    return chosen_factors(checkpoints.sensitivity_factors.get().output[0])
