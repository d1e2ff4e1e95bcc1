"""Measure the runs of a part of a study."""

import math
from collections.abc import Mapping, Sequence
from typing import Any

from sph.experiments.study_row import run_values
from sph.jobs.log import Job, job_log
from sph.measures.metrics import MetricSettings
from sph.study.dimensions import CASE
from sph.study.planned import Planned
from sph.study.searches import SlopeSearch, yield_accelerations
from sph.study.tables import Layout, study_rows, write_csv


def measure_study(
    paths_to_runs: Sequence[str],
    path_to_csv: str,
    scenes: Sequence[Planned],
    searches: Mapping[str, SlopeSearch],
    points: Mapping[str, Mapping[str, str]],
    layout: Layout,
    settings: Mapping[str, Any],
) -> None:
    """One row per run: its point, as written, and its metrics; planned scenes and ``points``, by the name of the run, in the order of the
    paths; ``searches`` of the yield accelerations of their slopes, by run, where there are any."""
    chosen = MetricSettings(**settings)
    yields = yield_accelerations(searches)
    rows = []
    for path, scene, (name, point) in zip(paths_to_runs, scenes, points.items(), strict=True):
        row = {**point, **run_values(scene.read(path), chosen, yields.get(name, math.nan))}
        rows.append({CASE: name, **row} if layout.named else row)
    write_csv(study_rows(rows, layout), path_to_csv)


if __name__ == "__main__":
    snakemake: Job
    with job_log(snakemake.log[0]):
        measure_study(snakemake.input.runs, snakemake.output[0], **snakemake.params.given)
