# Purpose: what the jobs that simulate are given.
# Inputs:  the rows of the catalogue.
# Outputs: functions for the directives of ../run.smk and of other rules that simulate
from sph.jobs.ahead import AT_ONCE, TOGETHER, Task
from sph.study.cost import job_cost


def asked_of(row):
    """What the job of a row is given; a backend that is not the processor makes other bits."""
    settings = ("until", "by", "extrapolates", "enforce_limit")
    given = {"scene": planned(row.scene)}
    given |= {name: getattr(row, name) for name in settings}
    return given | ({"backend": PLAN.study.backend} if on_card(row) else {})


def stage_row(wildcards):
    """The row of a stage in the catalogue."""
    return CATALOGUE.row(f"{wildcards.folder}/stages/{wildcards.run}.nc")


def run_row(wildcards):
    """The row of a run, or of a search, in the catalogue."""
    return CATALOGUE.row(f"{wildcards.folder}/runs/{wildcards.run}.nc")


def parent_of(row):
    """The stage that a row, by a function of the wildcards, goes on from."""
    return lambda wildcards: row(wildcards).parent or []


def task(row):
    """A row as its job is given it."""
    given = {"backend": "cpu"} | asked_of(row)
    scene, contents = given.pop("scene")
    sources = SOLVER if row.by == SIMULATION else SEARCHING
    decides = digest([asked_of(row), sources])
    return Task(row.file, row.log, row.parent, scene, contents, **given, digest=decides)


def ahead(row, own, rule):
    """What the job of a row goes ahead with: runs of its rule that could start now; on a processor as many as make with it the work that
    short ones share, on a card all up to a number."""
    ready = (
        row(job.wildcards)
        for job in workflow.dag.ready_jobs
        if not job.is_group() and job.rule.name.endswith(rule)
    )
    worked, taken = 0.0, 1
    for other in ready if own.by == SIMULATION else ():
        asked = task(other)
        if other.by != SIMULATION or asked.made.exists():
            continue
        if on_card(own):
            taken += 1
        else:
            worked = (worked or job_cost(own).seconds) + job_cost(other).seconds
        if worked > TOGETHER or taken > AT_ONCE:
            return
        yield asked


def checked(wildcards):
    """The folder with what is found before the runs of the study, for those of both of its fidelities."""
    plans = (PLAN, PLAN.second or PLAN)
    return RESULTS if wildcards.folder in [plan.folder for plan in plans] else None


def simulated(row, rule):
    """Parameters of the job of a row, by a function of the wildcards, in a rule."""

    def given(wildcards, input):
        own = task(row(wildcards))
        return [own] if own.made.exists() else [own, *ahead(row, row(wildcards), rule)]

    return {
        "digest": lambda wildcards: digest(asked_of(row(wildcards))),
        "given": given,
        "sources": lambda wildcards: (
            SOLVER if row(wildcards).by == SIMULATION else SEARCHING
        ),
    }
