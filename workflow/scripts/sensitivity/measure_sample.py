"""Measure the runs of a design of the sensitivity analysis."""

from collections.abc import Mapping, Sequence
from typing import Any

import pandas as pd

from sph.experiments.sensitivity.design import Axis, Point, Quantity
from sph.experiments.sensitivity.tables import sample_columns, sample_row
from sph.jobs.log import Job, job_log
from sph.measures.metrics import MetricSettings
from sph.study.planned import Planned
from sph.study.tables import write_csv


def measure_sample(
    paths_to_runs: Sequence[str],
    scenes: Sequence[Planned],
    design: str,
    points: Mapping[str, Point],
    axes: Sequence[Axis],
    quantities: Sequence[Quantity],
    settings: Mapping[str, Any],
    path_to_csv: str,
) -> None:
    """One row a run; paths and planned scenes in the order of the points."""
    columns = sample_columns(axes, quantities)
    chosen = MetricSettings(**settings)
    rows = [
        sample_row(f"{design}/{run}", point, scene.read(path), columns, chosen)
        for (run, point), path, scene in zip(points.items(), paths_to_runs, scenes, strict=True)
    ]
    write_csv(pd.DataFrame(rows), path_to_csv)


if __name__ == "__main__":
    snakemake: Job
    with job_log(snakemake.log[0]):
        measure_sample(
            snakemake.input.runs,
            snakemake.params.scenes,
            snakemake.wildcards.design,
            snakemake.params.points,
            snakemake.params.axes,
            snakemake.params.quantities,
            snakemake.params.settings,
            snakemake.output[0],
        )
