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


if (SPH.parent / "tests" / "cases").is_dir():
    sys.path.append(str(SPH.parent / "tests"))
    from cases import CASES, suite
else:
    CASES = {}  # the library is installed without its tests


@functools.cache
def runs_of_case(case):
    """The runs of a reference case, by file."""
    return {run.file: run for run in suite.runs_of(case).values()}


def case_run(wildcards):
    """The run of a file, or a refusal."""
    file = "results/validation/runs/{case}/{variant}/{level}.nc".format(**wildcards)
    if wildcards.case not in CASES or file not in runs_of_case(wildcards.case):
        raise ValueError(f"{file}: no reference case has such a run")
    return runs_of_case(wildcards.case)[file]


def whole_suite(wildcards):
    """Tables and pictures of all cases, and their runs; a refusal where there are none."""
    if not CASES:
        raise ValueError(
            f"validation: the reference cases are no part of the installed package ({SPH}); run it in a clone of the repository with the "
            "package installed from there (pip install -e .)"
        )
    return {
        "tables": expand("results/validation/cases/{case}.csv", case=CASES),
        "pictures": expand("results/validation/figures/{case}.png", case=CASES),
        "runs": [file for case in CASES for file in runs_of_case(case)],
    }
