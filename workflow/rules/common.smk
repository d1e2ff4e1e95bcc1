# Purpose: what rules share: digests of the sources, what jobs ask of a cluster and are given, results in the report.
# Inputs:  the study and the catalogue of its runs (Snakefile).
# Outputs: functions for the directives of rules
from sph.figures import caption as caption_of
from sph.solver.compiled.jit import solver_digest
from sph.study.cost import Needs, needs
from sph.study.planned import contents, digest, planned, sources
from sph.study.preflight import looked_at
from sph.study.runs import SIMULATION

# Snakemake does not see edits in imported modules: what the sources of each stage say to the machine is its parameter.
SOLVER = solver_digest()
SEARCHING = SOLVER + sources("stability/*.py")
FIGURES = "experiments/*/figures*.py"
ANALYSIS = sources(
    *[
        "output/*.py",
        "measures/*.py",
        "checks/*.py",
        "study/*.py",
        "experiments/*.py",
        "experiments/variants/*.py",
    ],
    "experiments/measured/*.csv",
    without=FIGURES,
)
DRAWING = ANALYSIS + sources("figures/*.py") + contents("scene/walls.py")  # labels
PAGE = DRAWING + sources("experiments/*/*.py", "page/*.*")
SETTINGS = PLAN.study.metrics


# One card, unless --resources or a profile says how many jobs may have one at a time.
if PLAN.study.backend != "cpu" and "gpu" not in workflow.global_resources:
    workflow.register_resource("gpu", 1)


def on_card(row):
    """Whether a row is made on a graphics card."""
    return PLAN.study.backend != "cpu" and row.by == SIMULATION


def asked(row):
    """The resources that the job of a row asks for, by a function of its wildcards: its scene and what is done with it."""
    card = {"gpu": lambda wildcards: int(on_card(row(wildcards)))}
    return {
        name: lambda wildcards, attempt, name=name: getattr(
            needs(row(wildcards).built, row(wildcards).needs, attempt), name
        )
        for name in Needs._fields
    } | (card if PLAN.study.backend != "cpu" else {})


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


def runs_in(name):
    """The runs of an experiment that stands alone, by a function of the wildcards."""
    return lambda wildcards: CATALOGUE.design(name).runs


def files(runs):
    """The files of the runs that a function of the wildcards gives by name."""
    return lambda wildcards: [run.file for run in runs(wildcards).values()]


def made_by(
    function,
    given=lambda wildcards: {},
    runs=None,
    draws=False,
    searches=False,
    uses="",
):
    """Parameters of a job of ../scripts/make.py: the function of the library that makes its output, of the job's named inputs and of what
    it is ``given`` and the ``runs`` by name, both by functions of the wildcards; its caption, and the sources on which it depends: those
    of its experiment and of another one that this ``uses``, of the drawing if it ``draws``, of the ``searches`` for limits of slopes.
    """

    def of(wildcards):
        named = runs(wildcards) if runs else None
        scenes = named and {name: planned(run.scene) for name, run in named.items()}
        return given(wildcards), scenes

    topics = [function.__module__.split(".")[2]] + [uses] * bool(uses)
    return {
        "sources": (DRAWING if draws else ANALYSIS)
        + sources(
            *[f"experiments/{topic}/*.py" for topic in topics],
            without="" if draws else FIGURES,
        )
        + SEARCHING * searches,
        "about": caption_of(function),
        "digest": lambda wildcards: digest(of(wildcards)),
        "given": lambda wildcards, input: (function, *of(wildcards)),
    }


def planned_slopes():
    """The scenes of the study that are checked as jobs are given them, by run."""
    return {name: planned(run.scene) for name, run in looked_at(PLAN).items()}


def searched_in(part):
    """The searches of the slopes of a part's runs, by run."""
    runs = PLAN.part(part) if PLAN.searches else []
    return {run.id: PLAN.searches[run.id] for run in runs}
