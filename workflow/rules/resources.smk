# Purpose: what simulations ask of a cluster, by their scenes.
# Inputs:  scenes, as the rules have them in their params.
# Outputs: functions for the resources of rules
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
