# Purpose: functions that rules share: what jobs ask of a cluster, results in the report, steps of experiments, runs that follow from tables.
# Inputs:  the study and the catalogue of its runs (Snakefile).
# Outputs: functions for the directives of rules
from sph.experiments.sensitivity.design import (
    BACK,
    BACK_FILE,
    FACTORS_FILE,
    chosen_factors,
    chosen_points,
)
from sph.jobs.tables.making import steps
from sph.paper.study import FIGURES, paper_study
from sph.study.cost import Needs, needs

OF_PAPER = functools.partial(paper_study, PLAN.study)
PAPER_FIGURES = [f"fig{number}" for number in FIGURES]
TRIGGER, SENSITIVITY = "{folder}/trigger", f"{RESULTS}/sensitivity"
FACTORS, BACK_POINTS = (f"{SENSITIVITY}/{name}" for name in (FACTORS_FILE, BACK_FILE))
ALL_FACTORS = ("morris", "tornado")  # designs that vary every factor


def asked(scene, what):
    """The resources that a job asks for, by functions of its wildcards: its scene and what is done with it."""
    return {
        name: lambda wildcards, attempt, name=name: getattr(
            needs(scene(wildcards), what(wildcards), attempt), name
        )
        for name in Needs._fields
    }


def shown(path, title, label):
    """A result in the report, with what its job makes as caption; without a label it stays out."""
    if not label:
        return path
    return report(
        path,
        caption="../report/about.rst",
        category=title,
        labels={"shows": label},
    )


def made(place, title, files):
    """What a job makes at a place, from the labels of its files: a table as it is named, a figure without suffix as PNG and PDF."""
    for file, label in files.items():
        kinds = [""] if Path(file).suffix else [".png", ".pdf"]
        yield shown(f"{place}/{file}{kinds[0]}", title, label)
        yield from (f"{place}/{file}{kind}" for kind in kinds[1:])


def of_step(experiment, name):
    """Parameters of a step: which it is, its caption, and the sources on which it depends."""
    step = steps(experiment)[name]
    own = sources("jobs/tables/making.py", f"jobs/tables/{experiment}.py")
    own += PAPER * (experiment == "paper") + SEARCHING * step.searches
    return {
        "sources": (DRAWING if step.draws else ANALYSIS) + own,
        "experiment": experiment,
        "step": name,
        "about": step.about,
    }


def figure_runs(wildcards):
    """The runs that a figure shows; a study over other dimensions than the paper's has none of its Figures 4 to 7."""
    if wildcards.figure in PAPER_FIGURES:
        OF_PAPER("Figures 4 to 7")
    return PLAN.figure_runs(wildcards.figure)


def in_trigger(*files):
    """Files in the folder of the searches."""
    return [f"{CATALOGUE.trigger.folder}/trigger/{file}" for file in files]


def earlier_points(wildcards):
    """The points of the round before one, if there is one."""
    number = int(wildcards.round)
    return CATALOGUE.trigger.points(wildcards.search, number - 1) if number else []


def wanted_runs(wildcards):
    """The runs of a round, once it is known what it wants."""
    wanted = checkpoints.want_points.get(**wildcards).output[0]
    return CATALOGUE.trigger.wanted(wanted)


def confirming_runs(wildcards):
    """The runs that confirm brackets, once these are known."""
    wanted = checkpoints.want_confirmation.get(**wildcards).output[0]
    return CATALOGUE.trigger.wanted(wanted, CATALOGUE.trigger.confirm["fidelity"])


def known_by(wildcards):
    """The file that must be there before the runs of a design are known: of the factors that matter, or of the points of a back-analysis."""
    if wildcards.design in ALL_FACTORS:
        return []
    return BACK_POINTS if wildcards.design == BACK else FACTORS


def varied(design):
    """What a design varies beside those that vary all: the factors that matter, or the points of a back-analysis, once they are known."""
    if design in ALL_FACTORS:
        return []
    if design == BACK:
        known = checkpoints.back_analysis_points.get().output.points
        return chosen_points(known, CATALOGUE.sensitivity.axes)
    return chosen_factors(checkpoints.sensitivity_factors.get().output[0])


def sampled_runs(wildcards):
    """The runs of a design, once it is known what it varies."""
    return CATALOGUE.sensitivity.rows(wildcards.design, varied(wildcards.design))
