# Purpose: what the rules of experiments in variants are given.
# Inputs:  their designs, from the catalogue.
# Outputs: functions for the directives of ../variants.smk


def table_of(name):
    """What the tables of such an experiment are made by."""
    return lambda wildcards: {
        "plan": CATALOGUE.design(name).parameters,
        "settings": SETTINGS,
    }


def second_runs(wildcards):
    """The runs of the study at the second spacing, by name: all, or those that decide in what shaking the slope fails."""
    runs = CATALOGUE.design("spacing").second.shared.runs
    if PLAN.repeats_all:
        return runs
    deciding = checkpoints.deciding_runs.get().output[0]
    return {name: runs[name] for name in second_spacing.read_deciding(deciding)}


def named_runs():
    """How the table of the study is laid out, and the names of its runs."""
    return {"names": list(PLAN.study.runs), "layout": PLAN.layout}
