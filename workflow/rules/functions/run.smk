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


def rows_of(jobs, rows):
    """The rows of jobs of some rules that simulate, each with the function that gives its row, by their names."""
    for job in jobs:
        for name, row in () if job.is_group() else rows.items():
            if job.rule.name.endswith(name) and row(job.wildcards).by == SIMULATION:
                yield row(job.wildcards)


def short_ones(own, ready):
    """Of what could start now as many as make with a run the work that short ones share."""
    worked = 0.0
    for other in ready:
        worked = (worked or job_cost(own).seconds) + job_cost(other).seconds
        if worked > TOGETHER:
            return
        yield other


def on_the_card(own, ready):
    """What could start now, and what goes on from that, so that one process compiles for all."""
    rows = {"stage": stage_row, "simulate": run_row}
    waiting = list(rows_of(workflow.dag.needrun_jobs(), rows))
    taken, found = {own.file}, list(ready)
    while found and len(taken) < AT_ONCE:
        found = found[: AT_ONCE - len(taken)]
        yield from found
        taken |= {other.file for other in found}
        found = [
            other
            for other in waiting
            if other.parent in taken and other.file not in taken
        ]


def ahead(row, own, rule):
    """What the job of a row goes ahead with, of runs that no job has made yet."""
    if own.by != SIMULATION:
        return []
    ready = (
        other
        for other in rows_of(workflow.dag.ready_jobs, {rule: row})
        if not task(other).made.exists()
    )
    return map(task, (on_the_card if on_card(own) else short_ones)(own, ready))


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
