# Purpose: what the rules of searches are given, and their runs, which follow from the tables of earlier rounds.
# Inputs:  their design, from the catalogue; what the checkpoints write.
# Outputs: functions for the directives of ../trigger.smk


def wanted_in_round(wildcards):
    """The runs of a round of a search, by number, once it is known which they are."""
    wanted = checkpoints.want_points.get(**wildcards).output[0]
    return dict(enumerate(CATALOGUE.trigger.wanted(wanted)))


def confirming_runs(wildcards):
    """The runs that repeat the ends of brackets, by number, once it is known which these are."""
    ends = checkpoints.want_confirmation.get(**wildcards).output[0]
    fidelity = CATALOGUE.trigger.confirm["fidelity"]
    return dict(enumerate(CATALOGUE.trigger.wanted(ends, fidelity)))


def earlier_points(wildcards):
    """The points of the round before one, if there is one."""
    before = int(wildcards.round) - 1
    return CATALOGUE.trigger.points(wildcards.search, before) if before >= 0 else []


def mapped(wildcards):
    """What every figure of the maps is given."""
    design = CATALOGUE.trigger
    return {"searched": design.dimensions, "note": design.note("maps")}


def brackets(wildcards):
    """What every figure of brackets is given."""
    design = CATALOGUE.trigger
    note = f"{design.note()} · brackets to {design.tolerance}"
    return {"searched": design.dimensions, "note": note}


def searched_files(*names):
    """Files in the folder of the searches, which their configuration decides."""
    return lambda wildcards: [CATALOGUE.trigger.file(name) for name in names]
