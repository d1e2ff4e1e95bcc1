# Purpose: what simulations ask of a cluster, by their scenes.
# Inputs:  scenes, as the rules have them in their params.
# Outputs: functions for the resources of rules
from sph.analysis.cost import Needs, needs


def asked(scene, stage=lambda wildcards: "end"):
    """The resources that a job asks for, by the scene of its wildcards and what is done with it."""
    return {
        name: lambda wildcards, attempt, name=name: getattr(
            needs(scene(wildcards), stage(wildcards), attempt), name
        )
        for name in Needs._fields
    }


def stage_scene(wildcards):
    """The scene of a stage or run: that of its plan, with what its name sets."""
    named = {
        name: wildcards[name] for name in PLAN.study.points if name in wildcards.keys()
    }
    return PLANS(wildcards.folder).scene(**named)
