"""Measure the runs of an experiment and write its tables."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import pandas as pd

from sph.experiments.registry import EXPERIMENTS
from sph.jobs.log import Job, job_log
from sph.measures.metrics import MetricSettings
from sph.storage import trajectory
from sph.study.planned import Planned
from sph.study.tables import write_csv


def measure(
    experiment: str,
    parameters: Any,
    paths_to_runs: Mapping[str, str],
    scenes: Mapping[str, Planned],
    settings: Mapping[str, Any],
    paths_to_tables: Sequence[str],
) -> None:
    """The tables of an experiment from its design's parameters; paths and planned scenes by the name of the run."""
    made = EXPERIMENTS[experiment].measure(parameters, lambda name: scenes[name].read(paths_to_runs[name]), MetricSettings(**settings))
    for path in paths_to_tables:
        table = made[Path(path).name]
        if isinstance(table, pd.DataFrame):
            write_csv(table, path)
        else:
            trajectory.write(path, table)


if __name__ == "__main__":
    snakemake: Job
    with job_log(snakemake.log[0]):
        measure(
            snakemake.params.experiment,
            snakemake.params.parameters,
            dict(zip(snakemake.params.scenes, snakemake.input, strict=True)),
            snakemake.params.scenes,
            snakemake.params.settings,
            snakemake.output,
        )
