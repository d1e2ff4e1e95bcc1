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
    """The runs of the study at the second spacing."""
    return CATALOGUE.design("spacing").second.shared.runs
