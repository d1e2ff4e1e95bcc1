"""Measure the runs of a part of a study."""

from collections.abc import Mapping, Sequence
from typing import Any

from sph.experiments.study_row import run_values
from sph.jobs.log import Job, job_log
from sph.measures.metrics import MetricSettings
from sph.study.dimensions import CASE
from sph.study.planned import Planned
from sph.study.tables import Layout, study_rows, write_csv


def measure_study(
    paths_to_runs: Sequence[str],
    scenes: Sequence[Planned],
    path_to_yield: str | None,
    slope: Planned | None,
    points: Mapping[str, Mapping[str, str]],
    layout: Layout,
    settings: Mapping[str, Any],
    path_to_csv: str,
) -> None:
    """One row a run: its point, as written, and its metrics; planned scenes and ``points``, by the name of the run, in the order of the
    paths.  Where all runs have one ``slope``, its yield acceleration has been searched."""
    chosen = MetricSettings(**settings)
    yields = float(slope.read(path_to_yield).attrs["value"]) if path_to_yield and slope else float("nan")
    rows = []
    for path, scene, (name, point) in zip(paths_to_runs, scenes, points.items(), strict=True):
        row = {**point, **run_values(scene.read(path), chosen, yields)}
        rows.append({CASE: name, **row} if layout.named else row)
    write_csv(study_rows(rows, layout), path_to_csv)


if __name__ == "__main__":
    snakemake: Job
    with job_log(snakemake.log[0]):
        measure_study(
            snakemake.input.runs,
            snakemake.params.scenes,
            snakemake.input.get("yields"),
            snakemake.params.slope,
            snakemake.params.points,
            snakemake.params.layout,
            snakemake.params.settings,
            snakemake.output[0],
        )
