# Purpose: functions that rules share: what jobs ask of a cluster and are given, results in the report, sources of steps.
# Inputs:  the study and the catalogue of its runs (Snakefile).
# Outputs: functions for the directives of rules
from sph.study.cost import Needs, needs


def asked(scene, what):
    """The resources that a job asks for, by functions of its wildcards: its scene and what is done with it."""
    return {
        name: lambda wildcards, attempt, name=name: getattr(
            needs(scene(wildcards), what(wildcards), attempt), name
        )
        for name in Needs._fields
    }


def told(of):
    """Parameters of a job: what it is given, by a function of its wildcards, and the digest of that, since Snakemake, which runs a job
    again when its parameters change, leaves out those that are made with the input."""
    return {
        "digest": lambda wildcards: digest(of(wildcards)),
        "given": lambda wildcards, input: of(wildcards),
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
        first, *others = written(file)
        yield shown(f"{place}/{first}", title, label)
        yield from (f"{place}/{other}" for other in others)


def written(file):
    """Names of the files of a table or, without suffix, of a figure."""
    return [file] if Path(file).suffix else [f"{file}.png", f"{file}.pdf"]


def searched_in(part):
    """The searches of the slopes of a part's runs, by run."""
    runs = PLAN.part(part) if PLAN.searches else []
    return {run.id: PLAN.searches[run.id] for run in runs}
