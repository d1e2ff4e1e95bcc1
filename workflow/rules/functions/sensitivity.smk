# Purpose: what the rules of the sensitivity analysis are given, and its runs, some of which follow from tables of earlier steps.
# Inputs:  its design, from the catalogue; what the checkpoints write.
# Outputs: functions for the directives of ../sensitivity.smk


def chosen_for(wildcards):
    """What a design varies beside those that vary all, once that is known."""
    if wildcards.design in ("sobol", "confirm"):
        checkpoints.sensitivity_factors.get()
    elif wildcards.design == "back":
        checkpoints.back_analysis_points.get()
    return CATALOGUE.sensitivity.chosen(wildcards.design)


def sampled_runs(wildcards):
    """The runs of a design, by number."""
    chosen = chosen_for(wildcards)
    return dict(enumerate(CATALOGUE.sensitivity.rows(wildcards.design, chosen)))


def all_samples(wildcards):
    """The samples of all designs that the configuration asks for."""
    design = CATALOGUE.sensitivity
    asked = ["confirm"] * bool(design.confirmed)
    asked += ["back"] * bool(design.settings.back_analysis)
    return [
        f"{SAMPLED}/samples/{name}.csv"
        for name in ("morris", "tornado", "sobol", *asked)
    ]


def axes(wildcards):
    """What the reading of a sample needs."""
    design = CATALOGUE.sensitivity
    return {"axes": design.axes, "quantities": design.quantities}


def drawn(wildcards):
    """What every figure is given."""
    return {**axes(wildcards), "fidelity": CATALOGUE.sensitivity.fidelities[0]}


def observed(wildcards):
    """What a back-analysis is given."""
    design = CATALOGUE.sensitivity
    seen = {"sought": design.sought, "observations": design.observations}
    return {**axes(wildcards), **seen}
